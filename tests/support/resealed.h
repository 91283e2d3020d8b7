#pragma once

#include <xxhash.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

/// Packed files with valid checksums around changed content, as an attacker would write them.
/// Follows SPEC.md with independent code, so that it also checks ours.
namespace rhoray::tests {

struct Envelope {
  std::string json;  ///< without the trailing spaces
  std::string data;  ///< the data area before "_sum"
};

inline Envelope open_envelope(const std::string& file) {
  std::uint64_t text_bytes = 0;
  std::memcpy(&text_bytes, file.data(), 8);
  Envelope parts{file.substr(8, text_bytes), {}};
  parts.json.erase(parts.json.find_last_not_of(' ') + 1);
  // The table of sums and the seal follow the data: d bytes of data in ceil(d / 65536) blocks of 8
  // bytes, and 64.
  const std::uint64_t rest = file.size() - 8 - text_bytes - 64;
  std::uint64_t data_bytes = 0;
  while (data_bytes + 8 * ((data_bytes + 65535) / 65536) != rest) ++data_bytes;
  parts.data = file.substr(8 + text_bytes, data_bytes);
  return parts;
}

inline std::string seal_again(const Envelope& parts) {
  const auto append = [](std::string& to, const auto& value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const auto append_sum = [&](std::string& to, std::string_view bytes) {
    const XXH128_hash_t sum = XXH3_128bits(bytes.data(), bytes.size());
    append(to, sum.low64);
    append(to, sum.high64);
  };
  std::string header;
  append(header, std::uint64_t{(8 + parts.json.size() + 4095) / 4096 * 4096 - 8});
  header += parts.json;
  header.resize((header.size() + 4095) / 4096 * 4096, ' ');

  std::string sums;
  for (std::size_t at = 0; at < parts.data.size(); at += 65536) {
    const std::string_view block = std::string_view(parts.data).substr(at, 65536);
    append(sums, std::uint64_t{XXH3_64bits(block.data(), block.size())});
  }
  std::string seal("\x89RHO\r\n\x1a\n", 8);
  append(seal, std::uint64_t{header.size() + parts.data.size() + sums.size() + 64});
  append(seal, std::uint64_t{65536});
  append_sum(seal, header);
  append_sum(seal, sums);
  append(seal, std::uint64_t{XXH3_64bits(seal.data(), seal.size())});
  return header + parts.data + sums + seal;
}

/// A file with `from` replaced by `to` in its header text, sealed again. Throws when `from` is
/// missing, so that a test never runs on an unchanged file.
inline std::string with_header_change(const std::string& file, std::string_view from, std::string_view to) {
  Envelope parts = open_envelope(file);
  const std::size_t at = parts.json.find(from);
  if (at == std::string::npos) throw std::runtime_error("not in the header: " + std::string(from));
  parts.json.replace(at, from.size(), to);
  return seal_again(parts);
}

/// A file with `bytes` written at an offset of its data area, sealed again.
inline std::string with_data_change(const std::string& file, std::uint64_t at, std::string_view bytes) {
  Envelope parts = open_envelope(file);
  parts.data.replace(at, bytes.size(), bytes);
  return seal_again(parts);
}

/// Position of one array in the data area.
struct ArrayPlace {
  std::string type;
  std::uint64_t begin = 0, end = 0;
};

/// The array of that name. Throws when the header does not contain it.
inline ArrayPlace place_of(const Envelope& parts, const std::string& name) {
  const std::size_t entry = parts.json.find("\"" + name + "\":{\"dtype\":\"");
  if (entry == std::string::npos) throw std::runtime_error("no array " + name);
  const std::size_t type = entry + name.size() + 13;
  const std::size_t offsets = parts.json.find("\"data_offsets\":[", type) + 16;
  std::size_t read = 0;
  ArrayPlace place;
  place.type = parts.json.substr(type, parts.json.find('"', type) - type);
  place.begin = std::stoull(parts.json.substr(offsets), &read);
  place.end = std::stoull(parts.json.substr(offsets + read + 1));
  return place;
}

/// Appends `bytes` to an array and updates the header; the caller must update the array's shape.
/// The size of `bytes` is a multiple of 64, so that all later arrays keep their alignment.
inline void append_to_array(Envelope& parts, const std::string& name, std::string_view bytes) {
  if (bytes.size() % 64 != 0) throw std::runtime_error("not a multiple of 64 bytes");
  const ArrayPlace place = place_of(parts, name);
  const std::string key = "\"data_offsets\":[";
  for (std::size_t at = parts.json.find(key); at != std::string::npos; at = parts.json.find(key, at)) {
    at += key.size();
    std::size_t first_digits = 0, second_digits = 0;
    std::uint64_t begin = std::stoull(parts.json.substr(at), &first_digits);
    std::uint64_t end = std::stoull(parts.json.substr(at + first_digits + 1), &second_digits);
    if (begin >= place.end) begin += bytes.size();
    if (end >= place.end) end += bytes.size();
    parts.json.replace(at, first_digits + 1 + second_digits, std::to_string(begin) + "," + std::to_string(end));
  }
  parts.data.insert(place.end, bytes);
}

}  // namespace rhoray::tests
