#include "tests/render/hostile/mutants.h"

#include <array>
#include <cctype>
#include <cstring>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

#include "formats/base/text.h"
#include "tests/support/resealed.h"

namespace rhoray::tests {
namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t count) {
  // By hand: distributions differ between standard libraries.
  return static_cast<std::size_t>(random() % count);
}

template <class T>
T hostile_number(Random& random, T old) {
  using Limits = std::numeric_limits<T>;
  if constexpr (std::is_floating_point_v<T>) {
    const std::array numbers{T{0},          T{-1},
                             T{1e-30F},     T{1e30F},
                             Limits::max(), Limits::lowest(),
                             Limits::min(), Limits::denorm_min(),
                             -old,          Limits::infinity(),
                             T{2} * old,    -Limits::infinity(),
                             T{1.5F} + old, Limits::quiet_NaN()};
    return numbers[below(random, numbers.size())];
  } else {
    const auto cut = [](std::uint64_t number) { return static_cast<T>(number); };
    const std::uint64_t wide = static_cast<std::uint64_t>(old);
    const std::array numbers{cut(0),
                             cut(1),
                             cut(wide - 1),
                             cut(wide + 1),
                             cut(2 * wide),
                             cut(255),
                             cut(256),
                             cut(257),
                             Limits::max(),
                             Limits::min(),
                             static_cast<T>(Limits::max() - 1),
                             cut((std::uint64_t{1} << 31) - 1),
                             cut(std::uint64_t{1} << 31),
                             cut((std::uint64_t{1} << 32) - 1),
                             cut(std::uint64_t{1} << 32),
                             cut(std::uint64_t{1} << 63)};
    return numbers[below(random, numbers.size())];
  }
}

template <class T>
std::string change_element(Random& random, std::string& data, const ArrayPlace& place) {
  const std::uint64_t count = (place.end - place.begin) / sizeof(T);
  const std::uint64_t element = below(random, count);
  T number;
  char* const at = data.data() + place.begin + element * sizeof(T);
  std::memcpy(&number, at, sizeof number);
  const T changed = hostile_number(random, number);
  std::memcpy(at, &changed, sizeof changed);
  return concat("element ", element, " from ", +number, " to ", +changed);
}

std::string change_element(Random& random, std::string& data, const ArrayPlace& place) {
  const std::string& type = place.type;
  if (type == "F32") return change_element<float>(random, data, place);
  if (type == "F64") return change_element<double>(random, data, place);
  if (type == "U64") return change_element<std::uint64_t>(random, data, place);
  if (type == "U32") return change_element<std::uint32_t>(random, data, place);
  if (type == "I16") return change_element<std::int16_t>(random, data, place);
  if (type == "U8") return change_element<std::uint8_t>(random, data, place);
  throw std::runtime_error("no released file has the type " + type);
}

/// Names of the arrays that do not belong to the envelope itself.
std::vector<std::string> array_names(const Envelope& parts) {
  constexpr std::string_view entry = "\":{\"dtype\"";
  std::vector<std::string> names;
  for (std::size_t at = parts.json.find(entry); at != std::string::npos; at = parts.json.find(entry, at + 1)) {
    const std::size_t begin = parts.json.rfind('"', at - 1) + 1;
    if (parts.json[begin] != '_') names.push_back(parts.json.substr(begin, at - begin));
  }
  return names;
}

std::string change_header(Random& random, Envelope& parts) {
  constexpr std::array numbers{"0",
                               "1",
                               "2",
                               "3",
                               "64",
                               "65",
                               "255",
                               "256",
                               "257",
                               "2147483647",
                               "2147483648",
                               "2147483649",
                               "4294967295",
                               "4294967296",
                               "4294967297",
                               "1048576",
                               "1048577",
                               "9223372036854775807",
                               "9223372036854775808",
                               "18446744073709551615",
                               "-1",
                               "-0.0",
                               "1e-320",
                               "1e-300",
                               "1e30",
                               "1e300",
                               "1.7976931348623157e308"};
  // Most numbers are bins of histograms, which are never used as indices: such a number is chosen
  // one time in eight.
  struct Number {
    std::size_t begin, size;
  };
  std::vector<Number> all, sizes;
  const std::size_t end = parts.json.find("\"},");
  for (std::size_t at = parts.json.find("\"details\""); at < end; ++at) {
    const auto is_part = [&](std::size_t i) {
      return std::isdigit(static_cast<unsigned char>(parts.json[i])) != 0 || parts.json[i] == '.' ||
             parts.json[i] == '-' || parts.json[i] == 'e';
    };
    if (std::isdigit(static_cast<unsigned char>(parts.json[at])) == 0 && parts.json[at] != '-') continue;
    const char before = parts.json[at - 1];
    if (before != ':' && before != ',' && before != '[') continue;
    std::size_t behind = at;
    while (is_part(behind)) ++behind;
    all.push_back({at, behind - at});
    const std::size_t list = parts.json.rfind('[', at);
    if (list == std::string::npos || parts.json.compare(list - 11, 9, "histogram") != 0 ||
        parts.json.find(']', list) < at)
      sizes.push_back(all.back());
    at = behind;
  }
  const std::vector<Number>& taken = below(random, 8) == 0 ? all : sizes;
  const Number number = taken[below(random, taken.size())];
  const std::string old = parts.json.substr(number.begin, number.size),
                    changed = numbers[below(random, numbers.size())];
  const std::size_t context = parts.json.rfind("\\\"", number.begin);
  const std::size_t key = parts.json.rfind("\\\"", context - 1);
  parts.json.replace(number.begin, number.size, changed);
  return concat("details, after ", parts.json.substr(key + 2, context - key - 2), ": ", old, " to ", changed);
}

}  // namespace

Mutant make_mutant(const std::string& file, std::uint64_t index) {
  Random random(index);
  Envelope parts = open_envelope(file);
  Mutant mutant;
  if (index % 3 == 0) {
    mutant.description = change_header(random, parts);
  } else {
    const std::vector<std::string> names = array_names(parts);
    for (std::size_t left = 1 + below(random, 3); left > 0; --left) {
      const std::string& name = names[below(random, names.size())];
      mutant.description +=
          concat(name, ", ", change_element(random, parts.data, place_of(parts, name)), left > 1 ? "; " : "");
    }
  }
  mutant.bytes = seal_again(parts);
  return mutant;
}

}  // namespace rhoray::tests
