#include <algorithm>
#include <map>

#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
namespace fs = std::filesystem;

/// The lines `KEY: words` of a "brick of values" header (VisIt); # starts a comment.
class BovHeader {
 public:
  explicit BovHeader(const ForeignFile& file) : path_(file.path()) {
    if (file.text().substr(0, 4096).find('\0') != std::string_view::npos)
      throw Error(
          ErrorCode::invalid,
          concat(path_.string(), ", byte 0: found bytes that are no text; expected lines KEY: value of a BOV header"),
          concat("if these are the samples, describe them with --raw NXxNYxNZ:float32"));
    LineReader lines(file);
    while (lines.next()) {
      std::string key(lines.words().front());
      if (key.back() != ':') lines.refuse(in_quotes(key), "KEY: value");
      key.pop_back();
      values_[key].assign(lines.words().begin() + 1, lines.words().end());
    }
  }

  const fs::path& path() const { return path_; }
  bool has(const std::string& key) const { return values_.count(key) != 0; }
  std::string word(const std::string& key, const std::string& otherwise) const {
    const auto found = values_.find(key);
    return found == values_.end() || found->second.empty() ? otherwise : found->second.front();
  }
  std::string need(const std::string& key) const {
    if (word(key, "").empty()) refuse_input(path_, concat("key ", key), "nothing", "a value");
    return word(key, "");
  }
  template <class T>
  std::array<T, 3> three(const std::string& key, const std::array<T, 3>& otherwise) const {
    if (!has(key)) return otherwise;
    const std::vector<std::string>& words = values_.at(key);
    if (words.size() != 3) refuse_input(path_, concat("key ", key), concat(words.size(), " numbers"), "3");
    std::array<T, 3> numbers;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::optional<T> number = parse_number<T>(words[i]);
      if (!number) refuse_input(path_, concat("key ", key), in_quotes(words[i]), "a number");
      numbers[i] = *number;
    }
    return numbers;
  }
  std::uint64_t count(const std::string& key, std::uint64_t otherwise) const {
    if (!has(key)) return otherwise;
    const std::optional<std::uint64_t> number = parse_number<std::uint64_t>(need(key));
    if (!number) refuse_input(path_, concat("key ", key), in_quotes(need(key)), "a number");
    return *number;
  }

 private:
  fs::path path_;
  std::map<std::string, std::vector<std::string>> values_;
};

ElementType sample_type(const BovHeader& header) {
  static const std::map<std::string, ElementType> types{{"BYTE", ElementType::U8},   {"SHORT", ElementType::I16},
                                                        {"INT", ElementType::I32},   {"LONG", ElementType::I64},
                                                        {"INT64", ElementType::I64}, {"FLOAT", ElementType::F32},
                                                        {"REAL", ElementType::F32},  {"DOUBLE", ElementType::F64}};
  const std::string name = header.need("DATA_FORMAT");
  const auto found = types.find(name);
  if (found == types.end())
    refuse_input(header.path(), "key DATA_FORMAT", in_quotes(name), "BYTE, SHORT, INT, LONG, FLOAT or DOUBLE",
                 ErrorCode::unsupported);
  return found->second;
}

bool is_big_endian(const BovHeader& header) {
  const std::string order = header.word("DATA_ENDIAN", "LITTLE");
  if (order != "LITTLE" && order != "BIG")
    refuse_input(header.path(), "key DATA_ENDIAN", in_quotes(order), "LITTLE or BIG");
  return order == "BIG";
}

/// The brick's box is divided by its points, or by its cells, whose centres are then the samples.
PointGrid grid_of(const BovHeader& header, const Index3& samples) {
  const std::array<double, 3> origin = header.three<double>("BRICK_ORIGIN", {0, 0, 0});
  const std::array<double, 3> unit{static_cast<double>(samples.x), static_cast<double>(samples.y),
                                   static_cast<double>(samples.z)};
  const std::array<double, 3> size = header.three<double>("BRICK_SIZE", unit);
  const std::string centering = header.word("CENTERING", "zonal");
  const bool at_points = centering == "nodal";
  if (!at_points && centering != "zonal")
    refuse_input(header.path(), "key CENTERING", in_quotes(centering), "zonal or nodal");
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
  const BovHeader header(file);
  if (header.need("DATA_FILE").find('%') != std::string::npos || header.has("DATA_BRICKLETS"))
    refuse_input(path, "key DATA_FILE", "several files", "one", ErrorCode::unsupported);
  const std::array<std::int64_t, 3> sizes = header.three<std::int64_t>("DATA_SIZE", {0, 0, 0});
  const Index3 samples(sizes[0], sizes[1], sizes[2]);
  const std::uint64_t components = header.count("DATA_COMPONENTS", 1);
  if (components < 1 || components > 1024) refuse_input(path, "key DATA_COMPONENTS", concat(components), "1 to 1024");
  GridArray array{.name = header.word("VARIABLE", stem_of(path)),
                  .type = sample_type(header),
                  .component_count = static_cast<int>(components),
                  .in_cells = false,
                  .owned = {},
                  .values = {}};
  const std::uint64_t bytes = checked_volume_bytes(path, samples, array.type) * components;
  const ForeignFile data(path.parent_path() / header.need("DATA_FILE"));
  const std::uint64_t skipped = header.count("BYTE_OFFSET", 0), there = data.bytes().size();
  if (skipped > there || bytes > there - skipped)
    refuse_input(data.path(), concat("byte ", there), "the end of the file",
                 concat(bytes, " bytes of samples after the first ", skipped));
  const auto values = data.bytes().subspan(skipped, bytes);
  array.owned.assign(values.begin(), values.end());
  make_native(array.owned, formats::element_bytes(array.type), is_big_endian(header));
  array.values = array.owned;
  std::vector<GridArray> arrays;
  arrays.push_back(std::move(array));
  return volume_of_field(path, grid_of(header, samples), std::move(arrays), field);
}

}  // namespace rhoray::preprocess
