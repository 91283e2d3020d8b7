#include "preprocess/workers/vdb/scalar_grid.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/File.h>
#include <openvdb/io/GridDescriptor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>

#include "formats/base/library_text.h"
#include "formats/base/nearest_name.h"
#include "preprocess/components.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

[[noreturn]] void refuse_part(const std::filesystem::path& path, const std::string& place, const std::exception& why) {
  note_library_text(why.what());
  refuse_input(path, place, "damaged data", "what OpenVDB can read");
}

/// Calls act() and returns its result. Where OpenVDB throws, the file is damaged at this place.
auto read_part(const std::filesystem::path& path, const std::string& place, const auto& act) -> decltype(act()) {
  try {
    return act();
  } catch (const openvdb::Exception& error) {
    refuse_part(path, place, error);
  } catch (const std::length_error& error) {  // a size that no memory has
    refuse_part(path, place, error);
  } catch (const std::ios_base::failure&) {
    refuse_input(path, place, "its end", "an OpenVDB file with all its grids");
  }
}

/// The first bytes of a file: a magic number and the version of its format.
void check_beginning(const ForeignFile& file) {
  std::uint32_t words[3] = {};  // on disk in little-endian order
  std::memcpy(words, file.bytes().data(), std::min(sizeof words, file.bytes().size()));
  if (words[0] != static_cast<std::uint32_t>(openvdb::OPENVDB_MAGIC))
    refuse_input(file.path(), "byte 0", "another beginning", "that of OpenVDB files");
  if (words[2] > openvdb::OPENVDB_FILE_VERSION)
    refuse_input(file.path(), "byte 8", concat("version ", words[2], " of the format"),
                 concat("at most ", std::uint32_t{openvdb::OPENVDB_FILE_VERSION}), ErrorCode::unsupported);
}

template <class Source, class Target>
void set_active_values(const Source& source, Target& target, auto&& value_of) {
  for (auto on = source.cbeginValueOn(); on; ++on) {
    const auto value = static_cast<typename Target::ValueType>(value_of(*on));
    if (on.isVoxelValue())
      target.tree().setValueOnly(on.getCoord(), value);
    else
      target.fill(on.getBoundingBox(), value, true);
  }
}

/// A grid of another value type: the same active voxels, each with its value as `value_of` has it,
/// and so the background.
template <class Target, class Source>
typename Target::Ptr converted(const Source& source, auto&& value_of) {
  const auto background = static_cast<typename Target::ValueType>(value_of(source.background()));
  const auto target =
      Target::create(std::make_shared<typename Target::TreeType>(source.tree(), background, openvdb::TopologyCopy()));
  target->insertMeta(source);
  target->setTransform(source.transform().copy());
  set_active_values(source, *target, value_of);
  return target;
}

/// 1 where a mask is active, else 0.
openvdb::DoubleGrid::Ptr converted_mask(const openvdb::MaskGrid& source) {
  const auto target = openvdb::DoubleGrid::create(
      std::make_shared<openvdb::DoubleTree>(source.tree(), 0.0, 1.0, openvdb::TopologyCopy()));
  target->insertMeta(source);
  target->setTransform(source.transform().copy());
  return target;
}

double exact_double(std::int64_t value, const std::filesystem::path& path, const std::string& field) {
  constexpr std::int64_t largest = std::int64_t{1} << 53;
  if (value > largest || value < -largest)
    refuse_input(path, concat("grid '", field, "'"), concat("the value ", value),
                 "integers that double precision holds", ErrorCode::unsupported);
  return static_cast<double>(value);
}

/// OpenVDB reads on behind the end of a file and makes up values, so the ends of all grids are
/// compared with it first.
class EndCheck : public openvdb::io::Archive {
 public:
  static void check(const std::filesystem::path& path) { EndCheck().check_grids(path); }

 private:
  void check_grids(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    read_part(path, "header", [&] {
      file.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
      readHeader(file);
      setFormatVersion(file);
      openvdb::MetaMap().readMeta(file);
      const auto file_bytes = static_cast<std::int64_t>(std::filesystem::file_size(path));
      for (std::int32_t left = readGridCount(file); left > 0 && inputHasGridOffsets(); --left) {
        openvdb::io::GridDescriptor grid;
        grid.read(file);
        if (grid.getEndPos() > file_bytes || grid.getEndPos() < file.tellg())
          refuse_input(path, concat("grid '", grid.gridName(), "'"), concat("the end at byte ", grid.getEndPos()),
                       concat("at most ", file_bytes, ", where the file ends"));
        grid.seekToEnd(file);
      }
    });
  }
};

/// Numbers in each voxel of a vector grid.
constexpr int vector_size = 3;

template <class Vector>
double component(const Vector& v, int which) {
  if (which != magnitude_component) return static_cast<double>(v[which]);
  return magnitude_of(std::array{static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])});
}

bool is_vector(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>() || grid.isType<openvdb::Vec3IGrid>();
}

bool is_scalar(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>() || grid.isType<openvdb::Int32Grid>() ||
         grid.isType<openvdb::Int64Grid>() || grid.isType<openvdb::BoolGrid>() || grid.isType<openvdb::MaskGrid>();
}

/// The scalar of a vector grid.
void take_component(ScalarGrid& out, const openvdb::GridBase::Ptr& base, int which) {
  using namespace openvdb;
  const auto take = [&](auto v) { return component(v, which); };
  out.source_type = ElementType::F64;
  if (const auto grid = gridPtrCast<Vec3SGrid>(base)) {
    if (which != magnitude_component) {
      out.source_type = ElementType::F32;
      out.grid = converted<FloatGrid>(*grid, take);
    } else {
      out.grid = converted<DoubleGrid>(*grid, take);
    }
  } else if (const auto doubles = gridPtrCast<Vec3DGrid>(base)) {
    out.grid = converted<DoubleGrid>(*doubles, take);
  } else {
    out.grid = converted<DoubleGrid>(*gridPtrCast<Vec3IGrid>(base), take);
  }
}

void take_scalar(ScalarGrid& out, const openvdb::GridBase::Ptr& base, const std::filesystem::path& path) {
  using namespace openvdb;
  const auto as_it_is = [](auto value) { return static_cast<double>(value); };
  if (const auto floats = gridPtrCast<FloatGrid>(base)) {
    out.source_type = ElementType::F32;
    out.grid = floats;
  } else if (const auto doubles = gridPtrCast<DoubleGrid>(base)) {
    out.source_type = ElementType::F64;
    out.grid = doubles;
  } else if (const auto ints = gridPtrCast<Int32Grid>(base)) {
    out.source_type = ElementType::I32;
    out.grid = converted<DoubleGrid>(*ints, as_it_is);
  } else if (const auto longs = gridPtrCast<Int64Grid>(base)) {
    out.source_type = ElementType::I64;
    out.grid = converted<DoubleGrid>(*longs, [&](std::int64_t value) { return exact_double(value, path, out.name); });
  } else if (const auto bools = gridPtrCast<BoolGrid>(base)) {
    out.source_type = ElementType::U8;
    out.grid = converted<DoubleGrid>(*bools, as_it_is);
  } else {
    out.source_type = ElementType::U8;
    out.grid = converted_mask(*gridPtrCast<MaskGrid>(base));
  }
  if (out.source_type == ElementType::U8)
    out.notes.push_back(concat("true and false of grid '", out.name, "' became 1 and 0"));
}

std::string text_metadata(const openvdb::GridBase& grid, const char* key) {
  const auto text = grid.getMetadata<openvdb::StringMetadata>(key);
  return text ? text->value() : std::string{};
}

void take_frame(ScalarGrid& out, const std::filesystem::path& path) {
  const openvdb::GridBase& grid = out.base();
  const std::string place = concat("grid '", out.name, "'");
  const std::optional<Affine> map = affine_of(grid.transform());
  if (!map)
    refuse_input(path, place, concat("a map of type ", grid.transform().mapType()), "a linear one (no frustum)",
                 ErrorCode::unsupported);
  const double determinant = map->determinant();
  if (determinant == 0 || !std::isfinite(determinant))
    refuse_input(path, place, concat("voxels of volume ", determinant), "axes that span a volume");
  out.world_from_index = *map;
  out.length_unit = text_metadata(grid, length_unit_key);
  out.field_unit = text_metadata(grid, field_unit_key);
}

void take_box(ScalarGrid& out, const std::filesystem::path& path) {
  openvdb::CoordBBox box = out.base().evalActiveVoxelBoundingBox();
  const std::string place = concat("grid '", out.name, "'");
  if (box.empty()) refuse_input(path, place, "no active voxel", "at least one");
  constexpr std::int32_t farthest = 1 << 29;
  for (int axis = 0; axis < 3; ++axis)
    if (box.min()[axis] < -farthest || box.max()[axis] > farthest)
      refuse_input(path, place, concat("active voxels from ", box.min()[axis], " to ", box.max()[axis], " on an axis"),
                   "-2^29 to 2^29", ErrorCode::unsupported);
  if (const auto count = out.base().getMetadata<openvdb::Vec3IMetadata>(sample_count_key)) {
    out.inactive_is_no_data = true;
    box.expand(openvdb::Coord(0));
    for (int axis = 0; axis < 3; ++axis)
      box.max()[axis] = std::max(box.max()[axis], std::clamp(count->value()[axis], 2, farthest) - 1);
  } else {
    box.expand(1);
  }
  out.box = box;
}

/// Voxels that are not active become NaN.
void mark_no_data(ScalarGrid& out) {
  std::visit(
      [](const auto& grid) {
        using Value = typename std::decay_t<decltype(*grid)>::ValueType;
        constexpr Value no_data = std::numeric_limits<Value>::quiet_NaN();
        grid->tree().root().setBackground(no_data, false);
        for (auto off = grid->beginValueOff(); off; ++off) off.setValue(no_data);
      },
      out.grid);
}

std::string in_list(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += concat(list.empty() ? "'" : ", '", name, "'");
  return list;
}

/// What is in a file without scalars, in words.
std::string contents(const std::vector<VdbFile::Entry>& entries) {
  std::string list;
  for (const VdbFile::Entry& entry : entries) {
    const bool is_points = value_type_of(entry).starts_with("ptdataidx");
    list += concat(list.empty() ? "" : ", ", is_points ? "points" : concat("values of type ", value_type_of(entry)),
                   " in grid '", entry.name, "'");
  }
  return list.empty() ? "no grid" : list;
}

struct Choice {
  std::string grid, field;
  std::optional<int> component;
};

Choice choose(const std::vector<VdbFile::Entry>& entries, const std::vector<std::string>& scalars,
              const std::string& field, const std::filesystem::path& path) {
  for (const VdbFile::Entry& entry : entries) {
    if (!entry.grid) continue;
    if (is_scalar(*entry.grid) && (field.empty() || field == entry.name)) return {entry.name, entry.name, {}};
    if (!field.empty() && is_vector(*entry.grid))
      if (const auto which = component_in(field, entry.name, vector_size)) return {entry.name, field, which};
  }
  if (field.empty())
    for (const VdbFile::Entry& entry : entries)
      if (entry.grid && is_vector(*entry.grid))
        return {entry.name, scalar_name(entry.name, vector_size, magnitude_component), magnitude_component};
  const std::string found = contents(entries);
  if (scalars.empty())
    throw Error(ErrorCode::unsupported, concat(path.string(), ": found ", found, "; expected a grid of scalars"));
  throw Error(ErrorCode::usage,
              concat(path.string(), ": found no field '", field, "'; expected one of ", in_list(scalars)),
              did_you_mean(field, scalars));
}

}  // namespace

VdbFile::VdbFile(const std::filesystem::path& path) : path_(path), file_(path.string()) {
  check_beginning(ForeignFile(path));
  openvdb::initialize();
  EndCheck::check(path);
  read_part(path_, "header", [&] { file_.open(false); });
}

std::vector<VdbFile::Entry> VdbFile::entries() {
  std::vector<Entry> list;
  for (auto name = file_.beginName(); name != file_.endName(); ++name) {
    Entry& entry = list.emplace_back();
    entry.name = name.gridName();
    read_part(path_, concat("grid '", entry.name, "'"), [&] {
      try {
        entry.grid = file_.readGridMetadata(entry.name);
      } catch (const openvdb::LookupError&) {  // a type that nobody has registered
      }
    });
  }
  return list;
}

openvdb::GridBase::Ptr VdbFile::read(const std::string& name) {
  return read_part(path_, concat("grid '", name, "'"), [&] { return file_.readGrid(name); });
}

std::string value_type_of(const VdbFile::Entry& entry) {
  return entry.grid ? entry.grid->valueType() : "unknown to OpenVDB";
}

std::vector<std::string> scalars_of(const VdbFile::Entry& entry) {
  if (!entry.grid) return {};
  if (is_scalar(*entry.grid)) return {entry.name};
  if (!is_vector(*entry.grid)) return {};
  return scalars_of(entry.name, vector_size);
}

std::optional<Affine> affine_of(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return std::nullopt;
  const openvdb::Mat4R m = transform.baseMap()->getAffineMap()->getMat4();  // row vectors: p' = p m
  const auto row = [&](int r) { return Vec3(m(r, 0), m(r, 1), m(r, 2)); };
  return Affine{row(0), row(1), row(2), row(3)};
}

ScalarGrid read_scalar_grid(const std::filesystem::path& path, const std::string& field) {
  VdbFile file(path);
  const std::vector<VdbFile::Entry> entries = file.entries();
  ScalarGrid out;
  for (const VdbFile::Entry& entry : entries)
    for (const std::string& name : scalars_of(entry)) out.field_names.push_back(name);
  const Choice choice = choose(entries, out.field_names, field, path);
  out.name = choice.field;
  if (field.empty() && choice.component) {
    std::vector<VectorArray> vectors{{choice.grid, vector_size}};
    for (const VdbFile::Entry& entry : entries)
      if (entry.grid && is_vector(*entry.grid) && entry.name != choice.grid)
        vectors.push_back({entry.name, vector_size});
    out.notes.push_back(note_of_choice(vectors, 0, *choice.component));
  }
  const openvdb::GridBase::Ptr base = file.read(choice.grid);
  if (choice.component)
    take_component(out, base, *choice.component);
  else
    take_scalar(out, base, path);
  take_frame(out, path);
  take_box(out, path);
  if (out.inactive_is_no_data) mark_no_data(out);
  return out;
}

}  // namespace rhoray::preprocess
