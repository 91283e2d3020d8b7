#include "preprocess/workers/vdb/facts.h"

#include <algorithm>

#include "formats/format_error.h"
#include "preprocess/import/reading/numbers.h"

namespace rhoray::preprocess {
namespace {

constexpr const char* facts_kind = "vdb-facts";
constexpr const char* facts_array = "texts";

/// Texts one after the other, each with a NUL at its end.
class Writing {
 public:
  void add(const std::string& text) {
    bytes_.insert(bytes_.end(), text.c_str(), text.c_str() + std::char_traits<char>::length(text.c_str()) + 1);
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void add(T number) { add(concat(number)); }
  void add(const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) add(v[axis]);
  }
  void add(const Index3& index) {
    for (int axis = 0; axis < 3; ++axis) add(index[axis]);
  }

  void write(int descriptor) const {
    formats::FileDescription description;
    description.kind = facts_kind;
    formats::PackedFileWriter writer(
        descriptor, description, {{.name = facts_array, .type = formats::ElementType::U8, .shape = {bytes_.size()}}});
    writer.write_all(facts_array, std::span<const std::uint8_t>(bytes_));
    writer.commit();
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

class Taking {
 public:
  explicit Taking(const formats::PackedFile& file) : file_(file) {
    if (file.description().kind != facts_kind)
      formats::refuse(file.name(), "header", file.description().kind, facts_kind);
    left_ = file.array<std::uint8_t>(facts_array, {0});
  }

  std::string text() {
    const auto end = std::find(left_.begin(), left_.end(), 0);
    if (end == left_.end()) refuse("the end", "more texts");
    std::string text(left_.begin(), end);
    left_ = left_.subspan(text.size() + 1);
    return text;
  }
  template <class T>
  T number() {
    const std::string found = text();
    const std::optional<T> value = parse_number<T>(found);
    if (!value) refuse(found, "a number");
    return *value;
  }
  std::size_t count() {
    const auto found = number<std::uint64_t>();
    if (found > left_.size()) refuse(concat(found), "no more than there are texts");
    return static_cast<std::size_t>(found);
  }
  Vec3 vector() {
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = number<double>();
    return v;
  }
  Index3 index() {
    Index3 v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = number<std::int64_t>();
    return v;
  }

 private:
  [[noreturn]] void refuse(const std::string& found, const char* expected) const {
    formats::refuse(file_.name(), concat("array '", facts_array, "'"), found, expected);
  }

  const formats::PackedFile& file_;
  std::span<const std::uint8_t> left_;
};

void add_field(Writing& out, const formats::FieldSummary& field) {
  out.add(field.name);
  out.add(field.unit);
  out.add(static_cast<int>(field.type));
  out.add(field.range.lo);
  out.add(field.range.hi);
  out.add(field.no_data_count);
  out.add(field.histogram.size());
  for (const std::uint64_t count : field.histogram) out.add(count);
}

formats::FieldSummary take_field(Taking& in) {
  formats::FieldSummary field;
  field.name = in.text();
  field.unit = in.text();
  const auto type = in.number<unsigned>();
  field.type = static_cast<formats::ElementType>(std::min(type, static_cast<unsigned>(formats::ElementType::F64)));
  field.range.lo = in.number<double>();
  field.range.hi = in.number<double>();
  field.no_data_count = in.number<std::uint64_t>();
  for (std::size_t bin = in.count(); bin != 0; --bin) field.histogram.push_back(in.number<std::uint64_t>());
  return field;
}

}  // namespace

void send(const std::vector<VdbGridFacts>& grids, int descriptor) {
  Writing out;
  out.add(grids.size());
  for (const VdbGridFacts& grid : grids) {
    for (const std::string* text : {&grid.name, &grid.value_type, &grid.grid_class, &grid.map_type}) out.add(*text);
    out.add(grid.world_from_index ? 1 : 0);
    if (grid.world_from_index)
      for (const Vec3& column : {grid.world_from_index->x_axis, grid.world_from_index->y_axis,
                                 grid.world_from_index->z_axis, grid.world_from_index->origin})
        out.add(column);
    out.add(grid.active_voxel_count);
    out.add(grid.first_active);
    out.add(grid.last_active);
    out.add(grid.metadata.size());
    for (const auto& [key, value] : grid.metadata) {
      out.add(key);
      out.add(value);
    }
    out.add(grid.field ? 1 : 0);
    if (!grid.field) continue;
    out.add(grid.background.value_or(0));
    add_field(out, *grid.field);
  }
  out.write(descriptor);
}

std::vector<VdbGridFacts> take_facts(const formats::PackedFile& file) {
  Taking in(file);
  std::vector<VdbGridFacts> grids;
  for (std::size_t left = in.count(); left != 0; --left) {
    VdbGridFacts& grid = grids.emplace_back();
    for (std::string* text : {&grid.name, &grid.value_type, &grid.grid_class, &grid.map_type}) *text = in.text();
    if (in.number<int>() == 1) {
      const Vec3 x = in.vector(), y = in.vector(), z = in.vector();
      grid.world_from_index = Affine{x, y, z, in.vector()};
    }
    grid.active_voxel_count = in.number<std::uint64_t>();
    grid.first_active = in.index();
    grid.last_active = in.index();
    for (std::size_t rows = in.count(); rows != 0; --rows) {
      const std::string key = in.text();
      grid.metadata.emplace_back(key, in.text());
    }
    if (in.number<int>() != 1) continue;
    grid.background = in.number<double>();
    grid.field = take_field(in);
  }
  return grids;
}

}  // namespace rhoray::preprocess
