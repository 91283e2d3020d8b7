#include "tests/fuzz/packed_mutator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <random>
#include <string>

#include "tests/fuzz/harness.h"
#include "tests/fuzz/packed_model.h"
#include "tests/support/resealed.h"

namespace rhoray::tests {
namespace {

using Json = nlohmann::ordered_json;
using Array = PackedModel::Array;

constexpr std::array<std::uint64_t, 22> odd_counts{
    0,     1,     2,          3,          7,          8,          127,        128,        255,        256,       257,
    65535, 65536, 0x7fffffff, 0x80000000, 0xffffffff, 1ULL << 32, 1ULL << 53, 1ULL << 62, 1ULL << 63, ~0ULL - 1, ~0ULL};
constexpr std::array<double, 15> odd_numbers{0,     -0.0,   1,      -1,     0.5,  1e-300, 5e-324, 1e-45,
                                             1e300, -1e300, 3.4e38, 3.5e38, 1e15, 1e9,    -1e9};

/// Random numbers with a seed for each mutation, so that the driver can repeat it.
class Dice {
 public:
  explicit Dice(unsigned seed) : numbers_(seed) {}

  std::size_t below(std::size_t count) { return count == 0 ? 0 : numbers_() % count; }
  bool once_in(std::size_t count) { return below(count) == 0; }
  template <class List>
  const auto& one_of(const List& list) {
    return list[below(std::size(list))];
  }

 private:
  std::minstd_rand numbers_;
};

std::uint64_t changed_count(Dice& dice, std::uint64_t count) {
  switch (dice.below(8)) {
    case 0:
      return count + 1;
    case 1:
      return count - 1;
    case 2:
      return 2 * count;
    case 3:
      return count / 2;
    case 4:
      return count + dice.below(600);
    case 5:
      return dice.below(2 * count + 2);
    default:
      return dice.one_of(odd_counts);
  }
}

double changed_number(Dice& dice, double number) {
  switch (dice.below(6)) {
    case 0:
      return -number;
    case 1:
      return 2 * number;
    case 2:
      return number / 3;
    case 3:
      return std::nextafter(number, dice.once_in(2) ? 1e308 : -1e308);
    case 4:
      return number + static_cast<double>(dice.below(7)) - 3;
    default:
      return dice.one_of(odd_numbers);
  }
}

// ---- metadata

void collect(Json& node, std::vector<Json*>& all) {
  all.push_back(&node);
  if (node.is_structured())
    for (Json& child : node) collect(child, all);
}

void change_list(Dice& dice, Json& list) {
  if (list.empty()) {
    list.push_back(dice.one_of(odd_counts));
    return;
  }
  const std::size_t at = dice.below(list.size());
  const Json element = list[at];
  if (dice.once_in(2))
    list.erase(at);
  else
    list.push_back(element);
}

void change_node(Dice& dice, Json& node) {
  constexpr std::array texts{"",    "U8",    "I16",    "F32", "F64",  "U32", "grid", "tets",   "surface",
                             "vdb", "curve", "colors", "x",   "auto", "mm",  "1.4",  "1.9999", "cell-clusters"};
  if (node.is_number_unsigned())
    node = changed_count(dice, node.get<std::uint64_t>());
  else if (node.is_number())
    node = changed_number(dice, node.get<double>());
  else if (node.is_string())
    node = dice.once_in(8) ? std::string(300, 'n') : std::string(dice.one_of(texts));
  else if (node.is_array())
    change_list(dice, node);
  else if (node.is_object() && !node.empty() && dice.once_in(4))
    node.erase(std::next(node.begin(), static_cast<std::ptrdiff_t>(dice.below(node.size()))).key());
}

void change_metadata(Dice& dice, PackedModel& model) {
  std::vector<Json*> nodes;
  if (!model.details.is_discarded() && !dice.once_in(20))
    collect(model.details, nodes);
  else
    for (Json& value : model.metadata) nodes.push_back(&value);
  if (nodes.empty()) return;
  Json& node = *nodes[dice.below(nodes.size())];
  if (dice.once_in(6))
    node = *nodes[dice.below(nodes.size())];  // from another position
  else
    change_node(dice, node);
}

// ---- elements

template <class T>
T changed_element(Dice& dice, T value) {
  using Limits = std::numeric_limits<T>;
  if (dice.once_in(3)) {
    const std::array<T, 6> ends{Limits::max(), Limits::lowest(), Limits::infinity(), Limits::quiet_NaN(), T{0}, T{1}};
    return dice.one_of(ends);
  }
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(changed_number(dice, static_cast<double>(value)));
  } else {
    return static_cast<T>(changed_count(dice, static_cast<std::uint64_t>(value)));
  }
}

/// Calls act(T{}) for the element type of that name.
template <class Act>
void with_type(std::string_view type, Act&& act) {
  if (type == "U8") return act(std::uint8_t{});
  if (type == "I8") return act(std::int8_t{});
  if (type == "U16") return act(std::uint16_t{});
  if (type == "I16") return act(std::int16_t{});
  if (type == "U32") return act(std::uint32_t{});
  if (type == "I32") return act(std::int32_t{});
  if (type == "U64") return act(std::uint64_t{});
  if (type == "I64") return act(std::int64_t{});
  if (type == "F32") return act(float{});
  if (type == "F64") return act(double{});
}

template <class T>
T element(const Array& array, std::size_t at) {
  T value{};
  std::memcpy(&value, array.bytes.data() + at * sizeof(T), sizeof(T));
  return value;
}

template <class T>
void put(Array& array, std::size_t at, T value) {
  std::memcpy(array.bytes.data() + at * sizeof(T), &value, sizeof(T));
}

/// Changes one element, a few, or a run of them.
void change_elements(Dice& dice, Array& array) {
  with_type(array.type, [&]<class T>(T) {
    const std::size_t count = array.bytes.size() / sizeof(T);
    if (count == 0) return;
    const std::size_t kind = dice.below(6), at = dice.once_in(4) ? count - 1 : dice.below(count);
    if (kind == 0) {
      const std::size_t run = 1 + dice.below(count - at);
      const T value = changed_element(dice, element<T>(array, at));
      for (std::size_t i = at; i < at + run; ++i) put(array, i, value);
    } else if (kind == 1) {
      const std::size_t other = dice.below(count);
      const T value = element<T>(array, at);
      put(array, at, element<T>(array, other));
      put(array, other, value);
    } else if (kind == 2) {
      put(array, at, element<T>(array, dice.below(count)));
    } else {
      const std::size_t few = kind == 3 ? 1 + dice.below(8) : 1;
      for (std::size_t i = 0; i < few; ++i) {
        const std::size_t place = i == 0 ? at : dice.below(count);
        put(array, place, changed_element(dice, element<T>(array, place)));
      }
    }
  });
}

// ---- sizes

/// Sets the number of bytes to what type and shape require, by repeating the old ones.
void fit_bytes(Array& array, std::size_t most) {
  std::uint64_t bytes = type_bytes(array.type);
  for (const std::uint64_t size : array.shape) {
    // Left as it is: the reader refuses it.
    if (size != 0 && bytes > most / size) return;
    bytes *= size;
  }
  const std::string old = array.bytes.empty() ? std::string(8, '\0') : array.bytes;
  array.bytes.resize(bytes);
  for (std::size_t at = 0; at < bytes; at += old.size())
    array.bytes.replace(at, std::min<std::size_t>(old.size(), bytes - at), old, 0,
                        std::min<std::size_t>(old.size(), bytes - at));
}

void replace_counts(Json& node, std::uint64_t from, std::uint64_t to) {
  if (node.is_number_unsigned() && node.get<std::uint64_t>() == from) node = to;
  if (node.is_structured())
    for (Json& child : node) replace_counts(child, from, to);
}

/// Gives an axis of an array another size. Mostly also changes everything that has the same number:
/// other arrays, the metadata, and the last element of lists of offsets.
void change_size(Dice& dice, PackedModel& model, std::size_t most_bytes) {
  Array& chosen = model.arrays[dice.below(model.arrays.size())];
  if (chosen.shape.empty()) return;
  std::uint64_t& size = chosen.shape[dice.below(chosen.shape.size())];
  const std::uint64_t from = size, to = changed_count(dice, from);
  const bool alone = dice.once_in(5);
  if (alone) {
    size = to;
  } else {
    for (Array& array : model.arrays) std::replace(array.shape.begin(), array.shape.end(), from, to);
    if (!model.details.is_discarded()) replace_counts(model.details, from, to);
  }
  for (Array& array : model.arrays) {
    fit_bytes(array, most_bytes);
    if (alone) continue;
    with_type(array.type, [&]<class T>(T) {
      const std::size_t count = array.bytes.size() / sizeof(T);
      if constexpr (sizeof(T) == 8 && std::is_unsigned_v<T>)
        if (count > 0 && element<T>(array, count - 1) == from) put<T>(array, count - 1, to);
    });
  }
}

void change_type(Dice& dice, PackedModel& model, std::size_t most_bytes) {
  constexpr std::array types{"U8", "I8", "U16", "I16", "U32", "I32", "U64", "I64", "F32", "F64"};
  Array& array = model.arrays[dice.below(model.arrays.size())];
  const std::string from = array.type, to = dice.one_of(types);
  array.type = to;
  fit_bytes(array, most_bytes);
  if (dice.once_in(2) || model.details.is_discarded()) return;
  std::vector<Json*> nodes;  // a field's type and the arrays that hold it
  collect(model.details, nodes);
  for (Json* node : nodes)
    if (node->is_string() && *node == from) *node = to;
  for (Array& other : model.arrays)
    if (other.type == from) {
      other.type = to;
      fit_bytes(other, most_bytes);
    }
}

/// Exchanges the content of two arrays, removes one, or adds one again under another name.
void change_arrays(Dice& dice, PackedModel& model) {
  const std::size_t at = dice.below(model.arrays.size());
  if (dice.once_in(3)) {
    model.arrays.erase(model.arrays.begin() + static_cast<std::ptrdiff_t>(at));
  } else if (dice.once_in(2)) {
    std::swap(model.arrays[at].bytes, model.arrays[dice.below(model.arrays.size())].bytes);
  } else {
    constexpr std::array names{"cell_ids", "point_ranks", "triangle_ids", "axis.0", "bricks", "macro.3", "field.2"};
    Array copy = model.arrays[at];
    copy.name = dice.one_of(names);
    model.arrays.push_back(std::move(copy));
  }
}

/// Changes bytes of one array with the driver's mutation, which knows which changes reached new
/// code.
void change_bytes(Array& array) {
  if (array.bytes.empty()) return;
  const std::size_t size = array.bytes.size();
  std::string changed = array.bytes;
  const std::size_t new_size = LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(changed.data()), size, size);
  std::copy_n(changed.begin(), std::min(size, new_size), array.bytes.begin());
}

void mutate_model(Dice& dice, PackedModel& model, std::size_t most_bytes) {
  if (model.arrays.empty()) return change_metadata(dice, model);
  switch (dice.below(12)) {
    case 0:
    case 1:
    case 2:
      return change_metadata(dice, model);
    case 3:
    case 4:
    case 5:
    case 6:
      return change_elements(dice, model.arrays[dice.below(model.arrays.size())]);
    case 7:
    case 8:
      return change_size(dice, model, most_bytes);
    case 9:
      return change_type(dice, model, most_bytes);
    case 10:
      return change_arrays(dice, model);
    default:
      return change_bytes(model.arrays[dice.below(model.arrays.size())]);
  }
}

/// Returns the file with its header text changed by the driver, sealed again.
std::optional<std::string> with_other_text(const std::string& file) {
  constexpr std::size_t smallest = 4096 + 64;
  std::uint64_t text_bytes = 0;
  if (file.size() < smallest) return std::nullopt;
  std::memcpy(&text_bytes, file.data(), sizeof text_bytes);
  if (text_bytes > file.size() - 8 - 64) return std::nullopt;
  Envelope parts;
  parts.json = file.substr(8, text_bytes);
  parts.json.erase(parts.json.find_last_not_of(' ') + 1);
  const std::size_t rest = file.size() - 8 - text_bytes - 64, blocks = rest / (65536 + 8) + 1;
  if (rest < 8 * blocks) return std::nullopt;
  parts.data = file.substr(8 + text_bytes, rest - 8 * blocks);
  const std::size_t before = parts.json.size();
  parts.json.resize(before + 64);
  parts.json.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(parts.json.data()), before, parts.json.size()));
  return seal_again(parts);
}

}  // namespace

std::size_t mutate_packed(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                          const MutationOptions& options) {
  Dice dice(seed);
  const std::string file(reinterpret_cast<const char*>(data), size);
  if (options.header_text_too && dice.once_in(8)) return LLVMFuzzerMutate(data, size, max_size);
  std::optional<std::string> changed;
  if (options.header_text_too && dice.once_in(3)) {
    changed = with_other_text(file);
  } else if (std::optional<PackedModel> model = model_of(file)) {
    const std::size_t acts = dice.once_in(3) ? 1 + dice.below(4) : 1;
    for (std::size_t act = 0; act < acts; ++act) mutate_model(dice, *model, max_size / 2);
    changed = file_of(*model);
  }
  if (!changed || changed->size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, changed->data(), changed->size());
  return changed->size();
}

}  // namespace rhoray::tests
