#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/io/Archive.h>

#include <cmath>
#include <cstring>

#include "formats/base/error.h"
#include "formats/base/library_text.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export/output_stream.h"
#include "preprocess/workers/vdb/hand_out.h"

namespace rhoray::preprocess {
namespace {

/// Integers of at most 16 bits and floats fit single precision.
template <class T>
using GridFor = std::conditional_t<std::is_same_v<T, float> || sizeof(T) < 4, openvdb::FloatGrid, openvdb::DoubleGrid>;

template <class T>
bool is_data(T value) {
  return !std::is_floating_point_v<T> || std::isfinite(static_cast<double>(value));
}

/// Calls act(block of at most 8^3 samples that make one leaf node) for all of them.
template <class Act>
void for_each_leaf_block(const Index3& count, Act&& act) {
  constexpr std::int64_t edge = 8;
  const auto last = [&](std::int64_t first, int axis) {
    return static_cast<std::int32_t>(std::min(first + edge, count[axis]) - 1);
  };
  const auto low = [](std::int64_t first) { return static_cast<std::int32_t>(first); };
  for (std::int64_t k = 0; k < count.z; k += edge)
    for (std::int64_t j = 0; j < count.y; j += edge)
      for (std::int64_t i = 0; i < count.x; i += edge)
        act(openvdb::CoordBBox({low(i), low(j), low(k)}, {last(i, 0), last(j, 1), last(k, 2)}));
}

template <class T>
typename GridFor<T>::Ptr tree_of(const GridSamples<T>& samples) {
  using Grid = GridFor<T>;
  using Value = typename Grid::ValueType;
  const auto grid = Grid::create(Value(0));
  for_each_leaf_block(samples.sample_count(), [&](const openvdb::CoordBBox& block) {
    typename Grid::TreeType::LeafNodeType* leaf = nullptr;
    for (auto at = block.begin(); at; ++at) {
      const T value = samples.at((*at).x(), (*at).y(), (*at).z());
      if (!is_data(value)) continue;
      if (leaf == nullptr) leaf = grid->tree().touchLeaf(block.min());
      leaf->setValueOn(*at, static_cast<Value>(value));
    }
  });
  grid->tree().prune();  // what is the same all over a node becomes a tile
  return grid;
}

/// Refuses axes that OpenVDB cannot invert (ErrorCode::unsupported).
void set_frame(openvdb::GridBase& grid, const Affine& map, const std::filesystem::path& output) {
  const Vec3 rows[] = {map.x_axis, map.y_axis, map.z_axis, map.origin};
  openvdb::Mat4R matrix = openvdb::Mat4R::identity();  // row vectors: p' = p m
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 3; ++c) matrix(r, c) = rows[r][c];
  try {
    grid.setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  } catch (const openvdb::ArithmeticError& error) {
    note_library_text(error.what());
    throw Error(ErrorCode::unsupported,
                concat(output.string(), ": the axes are too short, or too near to one plane, for OpenVDB"),
                "a .rho or a .vti file stores them");
  }
}

template <class T>
typename GridFor<T>::Ptr grid_of(const GridSamples<T>& samples, const formats::GridDescription& description,
                                 const std::filesystem::path& output) {
  const auto grid = tree_of(samples);
  set_frame(*grid, description.world_from_grid, output);
  grid->setName(samples.field().name);
  grid->setCreator("rhoray");
  const Index3& n = samples.sample_count();
  grid->insertMeta(sample_count_key,
                   openvdb::Vec3IMetadata({static_cast<std::int32_t>(n.x), static_cast<std::int32_t>(n.y),
                                           static_cast<std::int32_t>(n.z)}));
  const auto add_text = [&](const char* key, const std::string& text) {
    if (!text.empty()) grid->insertMeta(key, openvdb::StringMetadata(text));
  };
  add_text(length_unit_key, description.length_unit);
  add_text(field_unit_key, samples.field().unit);
  return grid;
}

[[noreturn]] void refuse_written(const std::filesystem::path& output, const std::string& found) {
  throw Error(ErrorCode::resource,
              concat(output.string(), ": found ", found, " when reading it back; expected what was written"));
}

[[noreturn]] void refuse_to_write(const std::filesystem::path& output, const char* library, const std::exception& why) {
  note_library_text(why.what());
  throw Error(ErrorCode::resource, concat(output.string(), ": ", library, " cannot write it"),
              concat("-v prints the reason that ", library, " gives"));
}

openvdb::GridBase::Ptr read_back(const std::filesystem::path& output, const std::string& field) {
  try {
    return VdbFile(output).read(field);
  } catch (const Error& error) {  // nobody gave us this file
    throw Error(ErrorCode::resource, concat("what was written cannot be read back: ", error.what()));
  }
}

template <class T>
void compare(const GridFor<T>& grid, const GridSamples<T>& samples, const std::filesystem::path& output) {
  using Value = typename GridFor<T>::ValueType;
  const auto accessor = grid.getConstAccessor();
  for_each_leaf_block(samples.sample_count(), [&](const openvdb::CoordBBox& block) {
    for (auto at = block.begin(); at; ++at) {
      const T value = samples.at((*at).x(), (*at).y(), (*at).z());
      Value found;
      const bool is_active = accessor.probeValue(*at, found);
      if (is_active != is_data(value) || (is_active && found != static_cast<Value>(value)))
        refuse_written(output, "another value");
    }
  });
}

/// What openvdb::io::File writes, into a stream that does not lose the reason of a failure.
class SeekableArchive : public openvdb::io::Archive {
 public:
  void write_to(std::ostream& out, const openvdb::GridPtrVec& grids) const { write(out, grids, /*seekable=*/true); }
};

template <class T>
void write_openvdb(const typename GridFor<T>::Ptr& grid, const GridSamples<T>& samples,
                   const std::filesystem::path& output) {
  OutputStream file(output);
  try {
    SeekableArchive().write_to(file, {grid});
    file.finish();
  } catch (const openvdb::Exception& error) {
    file.check();
    refuse_to_write(output, "OpenVDB", error);
  }
  const auto read = openvdb::gridPtrCast<GridFor<T>>(read_back(output, samples.field().name));
  if (!read || affine_of(read->transform()) != affine_of(grid->transform())) refuse_written(output, "another grid");
  compare(*read, samples, output);
}

template <class T>
void write_nanovdb(const typename GridFor<T>::Ptr& grid, const std::filesystem::path& output) {
  const auto handle = nanovdb::openToNanoVDB(*grid, nanovdb::StatsMode::All, nanovdb::ChecksumMode::Full);
  OutputStream file(output);
  try {
    nanovdb::io::writeGrid(file, handle);
    file.finish();
    const auto read = nanovdb::io::readGrid(output.string());
    if (read.size() != handle.size() || std::memcmp(read.data(), handle.data(), handle.size()) != 0)
      refuse_written(output, "other bytes");
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    file.check();
    refuse_to_write(output, "NanoVDB", error);
  }
}

}  // namespace

std::uint64_t write_vdb(const std::filesystem::path& packed, const std::string& field,
                        const std::filesystem::path& output, bool as_nanovdb) {
  openvdb::initialize();
  const OpenedGrid opened = open_grid(packed, field);
  with_samples(opened, [&]<class T>(const GridSamples<T>& samples) {
    const auto grid = grid_of(samples, opened.description(), output);
    if (as_nanovdb)
      write_nanovdb<T>(grid, output);
    else
      write_openvdb<T>(grid, samples, output);
  });
  return std::filesystem::file_size(output);
}

}  // namespace rhoray::preprocess
