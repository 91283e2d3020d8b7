#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// A packed file taken apart, for tests that change it and reassemble it. Follows SPEC.md with its
/// own code.
namespace rhoray::tests {

struct PackedModel {
  struct Array {
    std::string name;
    std::string type;
    std::vector<std::uint64_t> shape;
    std::string bytes;  ///< may disagree with type and shape
  };

  nlohmann::ordered_json metadata;  ///< "__metadata__", an object of texts
  nlohmann::ordered_json details;   ///< parsed text "details"; discarded if it is not JSON
  std::vector<Array> arrays;        ///< without padding, checksums and seal
};

/// Bytes of an element; 0 for a type that does not exist.
std::size_t type_bytes(std::string_view type);

/// Returns nothing for files that cannot be taken apart, such as damaged ones.
std::optional<PackedModel> model_of(std::string_view file);

/// Returns the file, sealed. The arrays start at multiples of 64, those of bricks at multiples of
/// 4096, with at least 64 bytes between one array and the next.
std::string file_of(const PackedModel& model);

}  // namespace rhoray::tests
