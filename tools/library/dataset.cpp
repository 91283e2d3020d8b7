#include "tools/library/dataset.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <span>
#include <system_error>

#include "formats/base/nearest_name.h"
#include "formats/base/pending_file.h"
#include "formats/base/stopping.h"
#include "formats/base/word_list.h"
#include "formats/triangle_mesh.h"
#include "tools/library/arrays.h"
#include "tools/library/guarded.h"
#include "tools/library/plain_types.h"

namespace rhoray::v0_1 {

namespace {

/// The space of world axes for files that say which is theirs, as for `rhoray render`.
constexpr formats::Space world_space = formats::Space::ras;

FieldInfo info_of(const formats::FieldSummary& field, bool is_of_cells) {
  FieldInfo info{.name = field.name,
                 .unit = field.unit,
                 .type = static_cast<ElementType>(field.type),
                 .is_of_cells = is_of_cells,
                 .no_data_count = field.no_data_count,
                 .histogram = field.histogram};
  if (!field.range.is_empty()) info.range = Interval{field.range.lo, field.range.hi};
  for (const auto& [label, name] : field.label_names) info.label_names.emplace(static_cast<int>(label), name);
  return info;
}

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

bool varies(const FieldInfo& field) {
  return !field.is_of_cells && field.range && field.range->lo < field.range->hi;
}

/// Refuses a file that is not packed, with the command that packs it.
formats::PackedFile open_packed(const std::filesystem::path& path) {
  std::error_code ignored;  // what is wrong with the name is said below
  if (std::filesystem::is_regular_file(path, ignored) && !formats::PackedFile::looks_packed(path) &&
      path.extension() != ".rho")
    throw v0_1::Error(v0_1::ErrorCode::unsupported, concat(path.string(), ": is not a packed file"),
                      concat("pack it first: rhoray pack ", path.string(), " -o ", path.stem().string(), ".rho"));
  return formats::PackedFile::open(path);
}

}  // namespace

Dataset::Implementation::Implementation(render::Dataset first, Descriptor memory, inside::Origin origin)
    : first_(std::move(first)), memory_(std::move(memory)), origin_(std::move(origin)), id_(next_id()) {
  for (const formats::FieldSummary& field : first_.point_fields()) fields_.push_back(info_of(field, false));
  for (const formats::FieldSummary& field : first_.cell_fields()) fields_.push_back(info_of(field, true));
}

const FieldInfo& Dataset::Implementation::field(std::string_view name) const {
  if (fields_.empty()) inside::refuse(first_.file().name(), ": a surface has no fields");
  if (name.empty()) {
    const auto first = std::find_if(fields_.begin(), fields_.end(), varies);
    return first == fields_.end() ? fields_.front() : *first;
  }
  for (const FieldInfo& field : fields_)
    if (field.name == name) return field;
  std::vector<std::string> names;
  for (const FieldInfo& field : fields_) names.push_back(field.name);
  throw v0_1::Error(v0_1::ErrorCode::usage,
                    concat(first_.file().name(), ": no field '", name, "'; it has ", joined(names)),
                    did_you_mean(std::string(name), names));
}

void Dataset::Implementation::require_whole_file(std::string_view call) const {
  if (origin_.is_wrapped)
    throw v0_1::Error(v0_1::ErrorCode::usage, concat(call, ": the samples are wrapped, so they are in no file"),
                      "pack the arrays with Memory::copy");
}

render::Dataset Dataset::Implementation::of(std::string_view name, const rhoray::Watch& watch) const {
  if (first_.is_surface()) return first_;
  const std::string field(name.empty() ? std::string_view(this->field({}).name) : name);
  if (field == first_.field().name) return first_;
  const StoppableLock lock(guard_, watch.stop);
  if (const auto known = loaded_.find(field); known != loaded_.end()) return known->second;
  return loaded_.emplace(field, render::Dataset::load(first_.file(), field, first_.space(), watch)).first->second;
}

Dataset inside::handle_of(const render::Dataset& dataset, Origin origin) {
  return Dataset(std::make_shared<const Dataset::Implementation>(dataset, Descriptor(), std::move(origin)));
}

Dataset::Dataset(std::shared_ptr<const Implementation> implementation) : implementation_(std::move(implementation)) {}

Dataset inside::opened(const std::filesystem::path& path, const rhoray::Watch& watch) {
  return handle_of(render::Dataset::load(open_packed(path), {}, world_space, watch));
}

Dataset Dataset::open(const std::filesystem::path& path, const Watch& watch) {
  return inside::guarded([&] { return inside::opened(path, inside::inside_of(watch)); });
}

DataKind Dataset::kind() const {
  const render::Dataset& first = implementation_->first();
  return first.is_surface() ? DataKind::triangles : first.is_mesh() ? DataKind::tetrahedra : DataKind::grid;
}

std::span<const FieldInfo> Dataset::fields() const {
  return implementation_->fields();
}

const FieldInfo& Dataset::field(std::string_view name) const {
  return implementation_->field(name);
}

Box3 Dataset::bounds() const {
  return inside::guarded([&] { return inside::outside_of(implementation_->first().bounds()); });
}

const std::string& Dataset::length_unit() const {
  return implementation_->first().length_unit();
}

std::span<const std::string> Dataset::notes() const {
  return implementation_->first().notes();
}

std::uint64_t Dataset::id() const {
  return implementation_->id();
}

std::filesystem::path Dataset::path() const {
  implementation_->require_whole_file("path");
  const Descriptor& memory = implementation_->memory();
  if (memory.number() >= 0) return concat("/proc/", ::getpid(), "/fd/", memory.number());
  if (implementation_->is_in_memory())
    inside::refuse("path: this is the boundary of a mesh in memory; expected the mesh itself");
  return implementation_->first().file().name();
}

Dataset Dataset::boundary(const Watch& watch) const {
  return inside::guarded([&] {
    return inside::handle_of(implementation_->first().boundary(inside::inside_of(watch)),
                             {.is_in_memory = implementation_->is_in_memory()});
  });
}

Dataset Dataset::boundary(std::string_view cell_field, int label, const Watch& watch) const {
  return inside::guarded([&] {
    const inside::MeshPart part{std::string(cell_field), label};
    return inside::handle_of(implementation_->first().boundary(part.field, label, {}, inside::inside_of(watch)),
                             {.is_in_memory = implementation_->is_in_memory(), .part = part});
  });
}

std::vector<std::string> Dataset::array_names() const {
  std::vector<std::string> names;
  for (const formats::ArrayEntry& entry : implementation_->first().file().arrays()) names.push_back(entry.name);
  return names;
}

ArrayView Dataset::array(std::string_view name) const {
  return inside::guarded([&] {
    const formats::PackedFile& file = implementation_->first().file();
    if (!file.has(name)) inside::refuse(file.name(), ": no array '", name, "'; it has ", joined(array_names()));
    const formats::ArrayEntry& entry = file.entry(name);
    std::vector<std::int64_t> shape(entry.shape.begin(), entry.shape.end()), strides(shape.size());
    const auto type = static_cast<ElementType>(entry.type);
    auto stride = static_cast<std::int64_t>(formats::element_bytes(inside::inside_of(type)));
    for (std::size_t axis = shape.size(); axis-- > 0; stride *= shape[axis]) strides[axis] = stride;
    return ArrayView(file.bytes(name).data(), type, shape, strides);
  });
}

std::vector<DamagedBlock> Dataset::damaged_blocks(unsigned threads, const Watch& watch) const {
  return inside::guarded([&] {
    std::vector<DamagedBlock> blocks;
    for (const formats::DamagedBlock& block :
         implementation_->first().file().damaged_blocks(threads, inside::inside_of(watch)))
      blocks.push_back({.first_byte = block.first_byte, .byte_count = block.byte_count});
    return blocks;
  });
}

std::uint64_t Dataset::prepared_bytes() const {
  return inside::guarded([&] {
    std::uint64_t bytes = 0;
    implementation_->for_each_loaded([&](const render::Dataset& dataset) { bytes += dataset.prepared_bytes(); });
    return bytes;
  });
}

void Dataset::drop_prepared() const {
  inside::guarded([&] { implementation_->for_each_loaded([](const render::Dataset& data) { data.drop_prepared(); }); });
}

namespace {

/// All bytes of a packed file, which is mapped as a whole.
std::span<const std::byte> bytes_of(const formats::PackedFile& file) {
  const formats::ArrayEntry& array = file.arrays().front();
  return {file.bytes(array.name).data() - array.first_byte, file.file_bytes()};
}

}  // namespace

void Dataset::save(const std::filesystem::path& path, bool replace_existing, const Watch& watch) const {
  inside::guarded([&] {
    implementation_->require_whole_file("save");
    const formats::PackedFile& file = implementation_->first().file();
    if (kind() == DataKind::triangles && file.description().kind != formats::TriangleMesh::kind)
      inside::refuse("save: this is the boundary of a mesh; expected the mesh itself");
    const std::span<const std::byte> bytes = bytes_of(file);
    PendingFile output(path, {.replace_existing = replace_existing});
    output.reserve(bytes.size());
    const rhoray::Watch watched = inside::inside_of(watch);
    ProgressMeter meter(watched.progress, "writing (bytes)", bytes.size());
    constexpr std::size_t piece = 1 << 22;  // bytes between two looks for a stop request
    for (std::size_t first = 0; first < bytes.size(); first += piece) {
      end_if_stopped(watched.stop);
      const std::size_t count = std::min(piece, bytes.size() - first);
      output.write(first, bytes.subspan(first, count));
      meter.add(count);
    }
    output.publish();
  });
}

Texture::Texture(std::shared_ptr<const Implementation> implementation) : implementation_(std::move(implementation)) {}

Texture Texture::open(const std::filesystem::path& path) {
  return inside::guarded([&] {
    return Texture(std::make_shared<const Implementation>(render::Texture::load(open_packed(path), world_space)));
  });
}

}  // namespace rhoray::v0_1
