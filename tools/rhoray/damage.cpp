#include "tools/rhoray/damage.h"

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "formats/base/word_list.h"

namespace rhoray::tools {

std::vector<std::string> arrays_touched(const formats::PackedFile& file, const formats::DamagedBlock& block) {
  std::vector<std::string> names;
  for (const formats::ArrayEntry& entry : file.arrays())
    if (entry.first_byte < block.first_byte + block.byte_count &&
        block.first_byte < entry.first_byte + entry.byte_count)
      names.push_back(entry.name);
  return names;
}

std::string damage_text(const formats::PackedFile& file, const formats::DamagedBlock& block) {
  const std::vector<std::string> names = arrays_touched(file, block);
  const std::string what =
      names.empty() ? "padding only" : concat(names.size() == 1 ? "array " : "arrays ", joined(names));
  return concat("bytes ", block.first_byte, " to ", block.first_byte + block.byte_count - 1, " are damaged (", what,
                ")");
}

namespace {

/// Whether the file is the packed copy of another file, under whose name it is open.
bool is_copy(const formats::PackedFile& file) {
  const std::filesystem::path name = file.name();
  return !formats::PackedFile::looks_packed(name) && name.extension() != ".rho";
}

}  // namespace

std::string packed_name(const formats::PackedFile& file) {
  return is_copy(file) ? concat("the packed copy of ", file.name()) : file.name();
}

std::string damage_hint(const formats::PackedFile& file) {
  return is_copy(file) ? "`rhoray cache --clear` removes it"
                       : concat("`rhoray verify ", file.name(), "` lists all blocks");
}

void refuse_damage(const formats::PackedFile& file, unsigned threads, const Watch& watch) {
  const std::vector<formats::DamagedBlock> blocks = file.damaged_blocks(threads, watch);
  if (!blocks.empty())
    throw Error(ErrorCode::invalid, concat(packed_name(file), ": ", damage_text(file, blocks.front())),
                damage_hint(file));
}

}  // namespace rhoray::tools
