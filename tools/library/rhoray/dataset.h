#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rhoray/array_view.h"
#include "rhoray/export.h"
#include "rhoray/progress.h"
#include "rhoray/types.h"

namespace rhoray::RHORAY_ABI {

/// What a dataset holds. Later versions may add kinds.
enum class DataKind {
  grid,        ///< fields that are trilinear between samples on a lattice
  tetrahedra,  ///< fields that are linear in each cell, and fields with one value per cell
  triangles    ///< a surface
};

/// A scalar field of a dataset.
struct FieldInfo {
  std::string name, unit;  ///< the unit is empty where the source gives none
  ElementType type = ElementType::F32;
  bool is_of_cells = false;                ///< one value per cell, which can only colour surfaces
  std::optional<Interval> range{};         ///< of all finite values; nothing if there are none
  std::uint64_t no_data_count = 0;         ///< NaN and infinite values; a cell with one of them is absent
  std::vector<std::uint64_t> histogram{};  ///< equal bins over the range, the last one closed
  std::map<int, std::string> label_names{};
};

/// A block of a file whose checksum does not match.
struct DamagedBlock {
  std::uint64_t first_byte = 0, byte_count = 0;
};

/// A packed file, memory-mapped or in memory, with all its fields. Immutable. A copy is a handle:
/// it shares everything and costs one atomic increment. The last handle unmaps the file; scenes and
/// ray casters hold handles, so nothing can be destroyed while it is used. Any thread may call any
/// function.
///
/// A mapped file must not be cut short while it is open: reading the lost bytes raises SIGBUS. This
/// library installs no signal handler.
class RHORAY_API Dataset {
 public:
  /// Maps a packed file and checks all that memory safety depends on. It reads the header, 8 bytes
  /// per 64 KiB, and of a mesh all points and cells once. It does not compare checksums
  /// (damaged_blocks).
  ///
  /// Throws ErrorCode::unreadable, invalid (damaged), or unsupported (a newer version; a file that
  /// is not packed, with the command that packs it); ErrorCode::interrupted if stopped while it
  /// reads points and cells.
  static Dataset open(const std::filesystem::path& path, const Watch& watch = {});

  DataKind kind() const;
  std::span<const FieldInfo> fields() const;  ///< fields of points or samples first; none of triangles
  /// Returns the field with this name. Empty: the first field that is not constant, or the first.
  /// Throws ErrorCode::usage for other names and lists those that exist.
  const FieldInfo& field(std::string_view name = {}) const;
  Box3 bounds() const;                         ///< of all cells, world axes; a boundary has those of its mesh
  const std::string& length_unit() const;      ///< of world axes; empty: not given by the source
  std::span<const std::string> notes() const;  ///< changes made while packing or loading, one sentence each
  std::uint64_t id() const;                    ///< of this opened data; never given again in a process

  /// Returns the file with these data, as it was named when it was opened. Data that were packed in
  /// memory have a name too, /proc/PID/fd/N: other programs of the same user can open it while this
  /// dataset exists. A boundary has the name of its mesh.
  /// Throws ErrorCode::usage for the boundary of a mesh in memory, and for arrays that are wrapped
  /// (Memory::wrap), which no other program can read.
  std::filesystem::path path() const;

  /// Returns the outside of a mesh: the triangles that belong to one cell only, with the fields of
  /// their cells. Throws ErrorCode::usage for other kinds, ErrorCode::interrupted if stopped.
  Dataset boundary(const Watch& watch = {}) const;
  /// Returns the surface of the cells that have this label in a field of cells. Throws
  /// ErrorCode::usage for an unknown field, ErrorCode::invalid for a label that no cell has,
  /// ErrorCode::interrupted if stopped.
  Dataset boundary(std::string_view cell_field, int label, const Watch& watch = {}) const;

  /// The arrays of the packed file, in the layout that formats/SPEC.md describes.
  std::vector<std::string> array_names() const;
  /// An array in the mapped file, valid while a handle lives; or the caller's if it is wrapped,
  /// valid as long as the caller keeps it. It must not be written to. Throws ErrorCode::usage for
  /// an unknown name.
  ArrayView array(std::string_view name) const;

  /// Reads every byte once and returns the blocks whose checksum does not match. It may run beside
  /// a render. Wrapped arrays have no checksums. Throws ErrorCode::interrupted if stopped.
  /// @param threads  0: all cores
  std::vector<DamagedBlock> damaged_blocks(unsigned threads = 0, const Watch& watch = {}) const;

  /// Returns the bytes of memory that hold what calls have prepared of these data and keep for the
  /// next one: surfaces and blocks of the last four isovalues of each field, normals, gradients.
  /// The file does not count; boundaries count their own. Waits while something is prepared.
  std::uint64_t prepared_bytes() const;
  /// Frees them, except those that contexts and scratches keep (RenderContext::trim). Changes no
  /// result: a call that needs them, also one that runs, prepares them again. Waits while something
  /// is prepared.
  void drop_prepared() const;

  /// Writes the packed file of a dataset, which may be in memory, to another file. That is complete
  /// or absent, and has the same bytes. Throws ErrorCode::usage for an existing file without
  /// `replace_existing`, for wrapped arrays, and for the boundary of a mesh;
  /// ErrorCode::resource for a full disk or a folder in which no file may be made;
  /// ErrorCode::interrupted if stopped.
  void save(const std::filesystem::path& path, bool replace_existing = false, const Watch& watch = {}) const;

  // Copies only: a moved-from handle would be a handle of nothing.
  Dataset(const Dataset&) = default;
  Dataset& operator=(const Dataset&) = default;
  ~Dataset() = default;

  class RHORAY_INSIDE Implementation;
  explicit Dataset(std::shared_ptr<const Implementation> implementation);  ///< for the library's own sources
  const Implementation& implementation() const { return *implementation_; }

 private:
  std::shared_ptr<const Implementation> implementation_;
};

/// A packed grid of colours for surfaces. A copy is a handle, as with datasets.
class RHORAY_API Texture {
 public:
  /// Maps a packed file of colours. Throws as Dataset::open does.
  static Texture open(const std::filesystem::path& path);

  // Copies only, as with datasets.
  Texture(const Texture&) = default;
  Texture& operator=(const Texture&) = default;
  ~Texture() = default;

  class RHORAY_INSIDE Implementation;
  explicit Texture(std::shared_ptr<const Implementation> implementation);  ///< for the library's own sources
  const Implementation& implementation() const { return *implementation_; }

 private:
  std::shared_ptr<const Implementation> implementation_;
};

}  // namespace rhoray::RHORAY_ABI
