#include "preprocess/import/vtk/vtk_errors.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {

class VtkErrors::Window : public vtkOutputWindow {
 public:
  static Window* New();
  vtkTypeMacro(Window, vtkOutputWindow);

  void DisplayErrorText(const char* text) override { keep(text); }
  void DisplayText(const char*) override {}
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  void keep_in(std::string* first) { first_ = first; }

 private:
  /// Converts "ERROR: In FILE, line N\nCLASS (ADDRESS): message" to "message", in one line.
  void keep(std::string text) {
    if (first_ == nullptr || !first_->empty()) return;
    if (const std::size_t begin = text.find("): "); begin != std::string::npos) text.erase(0, begin + 3);
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (text.ends_with(' ')) text.pop_back();
    *first_ = text.empty() ? "no reason given" : text;
  }

  std::string* first_ = nullptr;
};
vtkStandardNewMacro(VtkErrors::Window);

VtkErrors::VtkErrors() : before_(vtkOutputWindow::GetInstance()) {
  // otherwise VTK prints each error a second time
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  const auto window = vtkSmartPointer<Window>::New();
  window->keep_in(&first_);
  vtkOutputWindow::SetInstance(window);
}

VtkErrors::~VtkErrors() {
  vtkOutputWindow::SetInstance(before_);
}

void VtkErrors::check(const std::filesystem::path& path) const {
  if (!first_.empty()) throw Error(ErrorCode::invalid, concat(path.string(), ": VTK cannot read it: ", first_));
}

namespace {

/// The text between the quotes after `name=`, searched from `from` on; moves `from` behind it.
std::optional<std::string_view> attribute(std::string_view text, std::string_view name, std::size_t& from) {
  for (std::size_t at = from; (at = text.find(name, at)) != std::string_view::npos; at += name.size()) {
    std::size_t open = text.find_first_not_of(" \t\r\n", at + name.size());
    if (open == std::string_view::npos || text[open] != '=') continue;
    open = text.find_first_not_of(" \t\r\n", open + 1);
    if (open == std::string_view::npos || (text[open] != '"' && text[open] != '\'')) continue;
    const std::size_t close = text.find(text[open], open + 1);
    if (close == std::string_view::npos) return std::nullopt;
    from = close;
    return text.substr(open + 1, close - open - 1);
  }
  return std::nullopt;
}

void check_count(const ForeignFile& file, std::string_view name, std::uint64_t count) {
  // No compressor of VTK stores a point, cell or sample in less than 1/4096 byte; ten times that to
  // be safe.
  constexpr std::uint64_t most_per_byte = 40960;
  if (count / most_per_byte > file.bytes().size())
    refuse_input(file.path(), concat("attribute ", name), concat(count, " in ", file.bytes().size(), " bytes"),
                 "a number that the file can hold");
}

/// Calls act(element) for the text of each opening tag `<name ...` in the file, outside appended
/// data.
template <class Act>
void for_each_tag(std::string_view text, std::string_view name, Act&& act) {
  const std::string_view opening = "<AppendedData";
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string_view::npos; ++at) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with(opening)) return;
    if (rest.starts_with(name)) act(rest.substr(0, std::min(rest.find('>'), rest.size())));
  }
}

std::uint64_t check_count_in(const ForeignFile& file, std::string_view element, std::string_view name) {
  std::size_t from = 0;
  const std::optional<std::string_view> text = attribute(element, name, from);
  if (!text) return 0;
  const std::optional<std::uint64_t> count = parse_number<std::uint64_t>(*text);
  if (!count) refuse_input(file.path(), concat("attribute ", name), in_quotes(*text), "a number");
  check_count(file, name, *count);
  return *count;
}

/// First and last point along each axis.
struct Extent {
  std::array<std::int64_t, 3> first, last;

  /// Number of steps between points along an axis; 1 for a single layer, so that flat grids have a
  /// size too.
  std::uint64_t steps(std::size_t axis) const {
    return static_cast<std::uint64_t>(std::max<std::int64_t>(last[axis] - first[axis], 1));
  }
  std::int64_t end(std::size_t axis) const { return first[axis] + static_cast<std::int64_t>(steps(axis)); }
  bool overlaps(const Extent& other) const {
    bool result = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      result = result && first[axis] < other.end(axis) && other.first[axis] < end(axis);
    return result;
  }
  std::optional<std::uint64_t> cells() const { return checked_product({steps(0), steps(1), steps(2)}); }
  std::optional<std::uint64_t> points() const {
    const auto count = [&](std::size_t axis) { return static_cast<std::uint64_t>(last[axis] - first[axis] + 1); };
    return checked_product({count(0), count(1), count(2)});
  }
};

std::optional<Extent> extent_in(const ForeignFile& file, std::string_view element, std::string_view name) {
  std::size_t from = 0;
  const std::optional<std::string_view> text = attribute(element, name, from);
  if (!text) return std::nullopt;
  const std::string place = concat("attribute ", name);
  Extent extent{};
  std::size_t at = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::int64_t* end : {&extent.first[axis], &extent.last[axis]}) {
      at = std::min(text->find_first_not_of(" \t\r\n", at), text->size());
      const std::size_t stop = std::min(text->find_first_of(" \t\r\n", at), text->size());
      const std::optional<std::int32_t> number = parse_number<std::int32_t>(text->substr(at, stop - at));
      if (!number) refuse_input(file.path(), place, in_quotes(*text), "six numbers");
      *end = *number;
      at = stop;
    }
    if (extent.last[axis] < extent.first[axis])
      refuse_input(file.path(), place, in_quotes(*text), "first <= last on each axis");
  }
  const std::optional<std::uint64_t> points = extent.points();
  if (!points) refuse_input(file.path(), place, in_quotes(*text), "a size that fits in memory");
  check_count(file, name, *points);
  return extent;
}

/// VTK leaves points that no piece covers uninitialised. So pieces must fill the whole, without
/// overlap.
void check_cover(const ForeignFile& file, const Extent& whole, const std::vector<Extent>& pieces) {
  const auto refuse = [&] {
    refuse_input(file.path(), "attribute Extent", concat(pieces.size(), " pieces that do not make up WholeExtent"),
                 "pieces that cover it once");
  };
  std::uint64_t sum = 0;
  for (const Extent& piece : pieces) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (piece.first[axis] < whole.first[axis] || piece.last[axis] > whole.last[axis]) refuse();
    sum += *piece.cells();
    if (sum > *whole.cells()) refuse();
  }
  if (sum != *whole.cells()) refuse();
  for (std::size_t a = 0; a < pieces.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (pieces[a].overlaps(pieces[b])) refuse();
}

}  // namespace

VtkXmlCounts check_vtk_xml(const std::filesystem::path& path, std::string_view kind) {
  const ForeignFile file(path);
  const std::string_view head = file.text().substr(0, 64 << 10);
  std::size_t at = head.find("<VTKFile");
  if (at == std::string_view::npos) refuse_input(path, "byte 0", "no element VTKFile", "a VTK XML file");
  const std::optional<std::string_view> found = attribute(head, "type", at);
  if (!found) refuse_input(path, "element VTKFile", "no attribute type", kind);
  if (*found != kind) refuse_input(path, "element VTKFile", in_quotes(*found), kind, ErrorCode::unsupported);
  const std::optional<Extent> whole = extent_in(file, head, "WholeExtent");
  std::vector<Extent> pieces;
  VtkXmlCounts counts;
  for_each_tag(file.text(), "<Piece", [&](std::string_view piece) {
    counts.points += check_count_in(file, piece, "NumberOfPoints");
    counts.cells += check_count_in(file, piece, "NumberOfCells");
    if (const std::optional<Extent> extent = extent_in(file, piece, "Extent")) pieces.push_back(*extent);
  });
  // VTK allocates an array before it reads any number of it.
  for_each_tag(file.text(), "<DataArray", [&](std::string_view array) {
    const std::uint64_t components = check_count_in(file, array, "NumberOfComponents");
    const std::uint64_t tuples = std::max<std::uint64_t>({counts.points, counts.cells, 1});
    if (components > std::numeric_limits<std::uint64_t>::max() / tuples)
      refuse_input(path, "attribute NumberOfComponents", concat(components), "a size that fits 64 bits");
    check_packed_size(path, components * tuples, file.bytes().size());
  });
  if (whole) check_cover(file, *whole, pieces);
  return counts;
}

}  // namespace rhoray::preprocess
