#include <algorithm>

#include "formats/base/lower_case.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/keyed_words.h"
#include "preprocess/import/reading/samples.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
namespace fs = std::filesystem;

/// The lines `KEY: words` of a "brick of values" header (VisIt); # starts a comment.
KeyedWords read_header(const ForeignFile& file) {
  if (file.text().substr(0, 4096).find('\0') != std::string_view::npos)
    throw Error(ErrorCode::invalid,
                concat(file.path().string(),
                       ", byte 0: found bytes that are no text; expected lines KEY: value of a BOV header"),
                concat("if these are the samples, describe them with --raw NXxNYxNZ:float32"));
  KeyedWords header(file.path());
  LineReader lines(file);
  while (lines.next()) {
    std::string key(lines.words().front());
    if (key.back() != ':') lines.refuse(in_quotes(key), "KEY: value");
    key.pop_back();
    header.set(key, {lines.words().begin() + 1, lines.words().end()});
  }
  return header;
}

ElementType sample_type(const KeyedWords& header) {
  static constexpr std::pair<std::string_view, ElementType> types[] = {
      {"BYTE", ElementType::U8},   {"CHAR", ElementType::U8},  {"SHORT", ElementType::I16},
      {"INT", ElementType::I32},   {"LONG", ElementType::I64}, {"INT64", ElementType::I64},
      {"FLOAT", ElementType::F32}, {"REAL", ElementType::F32}, {"DOUBLE", ElementType::F64}};
  const std::string name = header.need("DATA_FORMAT");
  const std::string_view singular = std::string_view(name).substr(0, name.size() - (name.back() == 'S' ? 1 : 0));
  const std::optional<ElementType> found = find_in(types, singular);
  if (!found)
    header.refuse("DATA_FORMAT", in_quotes(name), "BYTE, SHORT, INT, LONG, FLOAT or DOUBLE", ErrorCode::unsupported);
  return *found;
}

bool is_big_endian(const KeyedWords& header) {
  const std::string order = header.word("DATA_ENDIAN", "LITTLE");
  if (order != "LITTLE" && order != "BIG") header.refuse("DATA_ENDIAN", in_quotes(order), "LITTLE or BIG");
  return order == "BIG";
}

/// The brick's box is divided by its points, or by its cells, whose centres are then the samples.
/// VisIt's defaults: points, and a box of size 1 at 0.
PointGrid grid_of(const KeyedWords& header, const Index3& samples) {
  std::vector<double> origin = header.numbers<double>({"BRICK_ORIGIN"}, 3);
  std::vector<double> size = header.numbers<double>({"BRICK_SIZE"}, 3);
  if (origin.empty()) origin = {0, 0, 0};
  if (size.empty()) size = {1, 1, 1};
  const std::string centering = header.word("CENTERING", "nodal");
  const bool at_points = lower_case(centering) == "nodal";
  if (!at_points && lower_case(centering) != "zonal")
    header.refuse("CENTERING", in_quotes(centering), "zonal or nodal");
  Vec3 step, first;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const std::int64_t steps = std::max<std::int64_t>(1, samples[axis] - (at_points ? 1 : 0));
    step[axis] = size[a] / static_cast<double>(steps);
    first[axis] = origin[a] + (at_points ? 0 : step[axis] / 2);
  }
  return {samples, axis_parallel(step, first)};
}

}  // namespace

NeutralVolume read_bov(const fs::path& path, const std::string& field) {
  const ForeignFile file(path);
  const KeyedWords header = read_header(file);
  if (header.need("DATA_FILE").find('%') != std::string::npos || header.has("DATA_BRICKLETS"))
    header.refuse("DATA_FILE", "several files", "one", ErrorCode::unsupported);
  const std::vector<std::int64_t> sizes = header.numbers<std::int64_t>({"DATA_SIZE"}, 3);
  const Index3 samples = sizes.empty() ? Index3(0, 0, 0) : Index3(sizes[0], sizes[1], sizes[2]);
  const auto components = header.number<std::uint64_t>("DATA_COMPONENTS", 1);
  if (components < 1 || components > 1024) header.refuse("DATA_COMPONENTS", concat(components), "1 to 1024");
  const ElementType type = sample_type(header);
  const std::uint64_t bytes = checked_volume_bytes(path, samples, type) * components;
  const ForeignFile data(path.parent_path() / header.need("DATA_FILE"));
  const auto source = samples_behind(data.path(), data.bytes(), header.number<std::uint64_t>("BYTE_OFFSET", 0), bytes);
  Array<std::byte> values(source.begin(), source.end());
  make_native(values, formats::element_bytes(type), is_big_endian(header));
  std::vector<GridArray> arrays;
  arrays.push_back({.name = header.word("VARIABLE", stem_of(path)),
                    .type = type,
                    .component_count = static_cast<int>(components),
                    .in_cells = false,
                    .values = std::move(values)});
  return volume_of_field(path, grid_of(header, samples), std::move(arrays), field);
}

}  // namespace rhoray::preprocess
