#include "preprocess/import/reading/label_names.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "formats/base/text.h"

namespace rhoray::preprocess {
namespace {

/// At most the bytes of a label's name; empty where nothing but spaces is left.
std::string cleaned(std::string_view text) {
  std::string name;
  while (!text.empty()) {
    const std::size_t bytes = formats::first_letter_bytes(text);
    const bool is_control = bytes == 0 && (text[0] == '\x7f' || static_cast<unsigned char>(text[0]) < 0x20);
    const std::string_view letter = bytes != 0 ? text.substr(0, bytes) : is_control ? " " : "\xef\xbf\xbd";
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
    if (name.empty() && letter == " ") continue;
    if (name.size() + letter.size() > formats::longest_label_name_bytes) break;
    name += letter;
  }
  name.resize(name.find_last_not_of(' ') + 1);
  return name;
}

bool is_label(std::int64_t number) {
  return number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max();
}

}  // namespace

formats::LabelNames label_names_from(const GivenNames& given, std::vector<std::string>& notes) {
  formats::LabelNames names;
  std::size_t left_out = 0;
  for (const auto& [label, text] : given) {
    const std::string name = cleaned(text);
    if (name.empty()) continue;
    const bool fits = is_label(label) && names.size() < formats::most_label_names;
    if (!fits || !names.emplace(static_cast<int>(label), name).second) ++left_out;
  }
  if (left_out != 0)
    notes.push_back(concat(count_text(left_out, "name of a label", "names of labels"), " left out; ",
                           formats::most_label_names, " are kept, one for each integer of 32 bits"));
  return names;
}

}  // namespace rhoray::preprocess
