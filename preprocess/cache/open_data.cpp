#include "preprocess/open_data.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

#include "formats/base/descriptor.h"
#include "formats/base/error.h"
#include "formats/base/word_list.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "preprocess/open_vdb.h"

namespace rhoray::preprocess {

namespace {

namespace fs = std::filesystem;

/// The options of packing, as PackCache::Key holds them.
std::string text_of(const PackOptions& pack) {
  return joined(option_words(pack), " ");
}

OpenedData packed_into_memory(const fs::path& input, const PackOptions& pack, const Progress& progress) {
  const Descriptor memory(::memfd_create("rhoray-packed", MFD_CLOEXEC));
  if (memory.number() < 0)
    throw Error(ErrorCode::resource, concat(input.string(), ": memfd_create: ", std::system_category().message(errno)));
  const PackReport report = preprocess::pack(input, formats::Destination(memory.number()), pack, progress);
  return {.file = formats::PackedFile::from_descriptor(memory.number(), input.string()),
          .was_packed = true,
          .notes = report.notes,
          .sources = report.sources};
}

/// The copy in the cache, or a new one.
OpenedData packed(const fs::path& input, const PackOptions& pack, const OpenOptions& options) {
  std::string not_kept;
  if (options.use_cache) try {
      const PackCache cache(PackCache::default_folder(), options.cache_limit_bytes);
      const PackCache::Key key{.input = input, .options = text_of(pack), .program = options.program};
      std::optional<PackCache::Copy> copy = cache.find(key);
      const bool is_new = !copy;
      if (is_new)
        copy.emplace(cache.add(key, [&](const formats::Destination& destination) {
          return preprocess::pack(input, destination, pack, options.progress);
        }));
      return {.file = copy->file,
              .path = copy->path,
              .was_packed = is_new,
              .not_kept = copy->not_kept,
              .notes = copy->notes,
              .sources = copy->sources};
    } catch (const Error& error) {
      if (error.code() != ErrorCode::resource) throw;
      not_kept = error.what();
    }
  OpenedData opened = packed_into_memory(input, pack, options.progress);
  opened.not_kept = not_kept;
  return opened;
}

/// Names of the fields of a packed file.
std::vector<std::string> fields_of(const formats::PackedFile& file) {
  const std::string& kind = file.description().kind;
  if (kind == formats::TriangleMesh::kind) return {};
  if (kind != "tets") return names_in(formats::BrickGrid(file).description().fields, &formats::FieldSummary::name);
  const formats::TetMesh mesh(file);
  std::vector<std::string> names = names_in(mesh.description().fields, &formats::FieldSummary::name);
  for (const formats::FieldSummary& field : mesh.description().cell_fields) names.push_back(field.name);
  return names;
}

/// The wanted ones that are not there.
std::vector<std::string> missing_in(const std::vector<std::string>& there, const std::vector<std::string>& wanted) {
  std::vector<std::string> missing;
  for (const std::string& name : wanted)
    if (std::find(there.begin(), there.end(), name) == there.end()) missing.push_back(name);
  return missing;
}

/// Whether the file is packed on the fly, or refused by packing.
bool is_packed_here(const fs::path& input, const PackOptions& pack) {
  if (!pack.raw.empty()) return !formats::PackedFile::looks_packed(input);
  if (is_vdb(input)) return pack.color;
  return !formats::PackedFile::looks_packed(input) && input.extension() != ".rho";
}

/// Packs again where packing keeps less than is needed: of a volume it keeps the first field, of a
/// mesh all that stand at points and not those of components.
OpenedData packed_with_fields(const fs::path& input, const OpenOptions& options) {
  PackOptions pack = options.pack;
  pack.fields.clear();
  const auto with_command = [&] {
    pack.command = joined(std::vector{concat("rhoray pack ", input.string()), text_of(pack)}, " ");
    return pack;
  };
  OpenedData opened = packed(input, with_command(), options);
  if (pack.color || !pack.raw.empty()) return opened;  // which have one field, or none
  std::vector<std::string> there = fields_of(opened.file);
  const std::vector<std::string> missing = missing_in(there, options.pack.fields);
  if (there.empty() || missing.empty()) return opened;
  there.insert(there.end(), missing.begin(), missing.end());
  pack.fields = std::move(there);
  OpenedData again = packed(input, with_command(), options);
  again.was_packed = again.was_packed || opened.was_packed;
  return again;
}

}  // namespace

OpenedData open_data(const fs::path& input, const OpenOptions& options) {
  require_input(input);
  if (!is_packed_here(input, options.pack)) {
    refuse_pack_options(input, options.pack);
    if (!is_vdb(input)) return {.file = formats::PackedFile::open(input), .path = input};
    const std::vector<std::string>& fields = options.pack.fields;
    return {.file = open_vdb(input, fields.empty() ? std::string() : fields.front())};
  }
  PackOptions without_fields = options.pack;  // which fields there are is seen after packing
  without_fields.fields.clear();
  check_pack(input, without_fields);
  return packed_with_fields(input, options);
}

void refuse_pack_options(const fs::path& input, PackOptions options) {
  if (is_packed_here(input, options)) return;
  options.fields.clear();
  options.color = false;
  const std::vector<std::string> words = option_words(options);
  if (words.empty()) return;
  const bool vdb = is_vdb(input);
  throw Error(ErrorCode::usage,
              concat(words.front(), ": only for files that are not packed, but ", input.string(),
                     vdb ? " is an OpenVDB file, which is read as it is" : " is a packed file"),
              vdb ? concat("pack it with this option: rhoray pack ", input.string(), " ", joined(words, " "))
                  : "leave it out, or give it when packing");
}

}  // namespace rhoray::preprocess
