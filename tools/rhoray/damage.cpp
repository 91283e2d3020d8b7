#include "tools/rhoray/damage.h"

#include "formats/base/text.h"

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
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  const std::string what = names.empty() ? "padding only" : concat(names.size() == 1 ? "array " : "arrays ", list);
  return concat("bytes ", block.first_byte, " to ", block.first_byte + block.byte_count - 1, " are damaged (", what,
                ")");
}

}  // namespace rhoray::tools
