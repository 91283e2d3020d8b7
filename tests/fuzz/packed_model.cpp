#include "tests/fuzz/packed_model.h"

#include <array>
#include <cstring>

#include "formats/base/text.h"
#include "tests/support/resealed.h"

namespace rhoray::tests {

using Json = nlohmann::ordered_json;

std::size_t type_bytes(std::string_view type) {
  constexpr std::array<std::string_view, 10> types{"U8", "I8", "U16", "I16", "U32", "I32", "F32", "U64", "I64", "F64"};
  constexpr std::array<std::size_t, 10> bytes{1, 1, 2, 2, 4, 4, 4, 8, 8, 8};
  for (std::size_t i = 0; i < types.size(); ++i)
    if (types[i] == type) return bytes[i];
  return 0;
}

namespace {

/// Parses one entry of the header; nothing unless it conforms to SPEC.md.
std::optional<PackedModel::Array> array_of(const std::string& name, const Json& entry, std::string_view data) {
  const auto is_list_of_numbers = [](const Json& list) {
    if (!list.is_array()) return false;
    for (const Json& number : list)
      if (!number.is_number_unsigned()) return false;
    return true;
  };
  if (!entry.is_object() || !entry.contains("dtype") || !entry["dtype"].is_string()) return std::nullopt;
  if (!entry.contains("shape") || !is_list_of_numbers(entry["shape"])) return std::nullopt;
  if (!entry.contains("data_offsets") || !is_list_of_numbers(entry["data_offsets"])) return std::nullopt;
  const Json& offsets = entry["data_offsets"];
  if (offsets.size() != 2) return std::nullopt;
  const std::uint64_t first = offsets[0], last = offsets[1];
  if (first > last || last > data.size()) return std::nullopt;
  return PackedModel::Array{name, entry["dtype"], entry["shape"], std::string(data.substr(first, last - first))};
}

}  // namespace

std::optional<PackedModel> model_of(std::string_view file) {
  constexpr std::size_t length_bytes = 8, seal_bytes = 64;
  std::uint64_t text_bytes = 0;
  if (file.size() < length_bytes + seal_bytes) return std::nullopt;
  std::memcpy(&text_bytes, file.data(), length_bytes);
  if (text_bytes > file.size() - length_bytes) return std::nullopt;
  const Json header = Json::parse(file.substr(length_bytes, text_bytes), nullptr, false);
  if (!header.is_object() || !header.contains("__metadata__") || !header["__metadata__"].is_object())
    return std::nullopt;

  PackedModel model;
  const std::string_view data = file.substr(length_bytes + text_bytes);
  for (const auto& [name, entry] : header.items()) {
    if (name == "__metadata__") {
      model.metadata = entry;
      continue;
    }
    if (name == "_sum" || name == "_seal" || name.starts_with("_pad.")) continue;
    std::optional<PackedModel::Array> array = array_of(name, entry, data);
    if (!array) return std::nullopt;
    model.arrays.push_back(std::move(*array));
  }
  const Json details = model.metadata.value("details", Json());
  model.details = details.is_string() ? Json::parse(details.get<std::string>(), nullptr, false) : Json();
  return model;
}

std::string file_of(const PackedModel& model) {
  constexpr std::size_t small = 64, page = 4096, block = 65536;
  Json metadata = model.metadata;
  if (!model.details.is_discarded() && !model.details.is_null())
    metadata["details"] = model.details.dump(-1, ' ', false, Json::error_handler_t::replace);
  Envelope parts;
  Json header{{"__metadata__", metadata}};
  const auto declare = [&](const std::string& name, const std::string& type, const Json& shape, std::size_t bytes) {
    header[name] = {
        {"dtype", type}, {"shape", shape}, {"data_offsets", {parts.data.size(), parts.data.size() + bytes}}};
  };
  std::size_t pad_count = 0;
  const auto pad = [&](std::size_t alignment, std::size_t least) {
    const std::size_t wanted = (parts.data.size() + least + alignment - 1) / alignment * alignment;
    const std::size_t bytes = wanted - parts.data.size();
    if (bytes == 0) return;
    declare(concat("_pad.", pad_count++), "U8", Json::array({bytes}), bytes);
    parts.data.append(bytes, '\0');
  };
  for (const PackedModel::Array& array : model.arrays) {
    const bool is_of_bricks = array.name.ends_with("samples") || array.name == "texels";
    pad(is_of_bricks ? page : small, parts.data.empty() ? 0 : small);
    declare(array.name, array.type, array.shape, array.bytes.size());
    parts.data += array.bytes;
  }
  pad(small, small);
  const std::size_t sum_count = (parts.data.size() + block - 1) / block;
  const std::size_t data_bytes = parts.data.size();
  declare("_sum", "U64", Json::array({sum_count}), 8 * sum_count);
  header["_seal"] = {{"dtype", "U8"},
                     {"shape", {small}},
                     {"data_offsets", {data_bytes + 8 * sum_count, data_bytes + 8 * sum_count + small}}};
  parts.json = header.dump(-1, ' ', false, Json::error_handler_t::replace);
  return seal_again(parts);
}

}  // namespace rhoray::tests
