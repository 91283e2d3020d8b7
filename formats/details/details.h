#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/affine.h"
#include "formats/base/interval.h"
#include "formats/field_summary.h"
#include "formats/macro_levels.h"
#include "formats/packed_file.h"
#include "formats/provenance.h"

/// Reads and writes the JSON text `details` of a packed file; shared by grids and meshes.
namespace rhoray::formats::details {

using Json = nlohmann::ordered_json;

/// Parses a file's details. Refuses text that is not one JSON object, duplicate keys, and more than
/// eight levels.
Json parse(const PackedFile& file);

/// One object of the details, read strictly. Refuses a missing key, and a value with another type
/// or out of its limits; the error names the key. Ignores keys that nobody reads. Refers to the
/// Json and the file that it was made from.
class Reader {
 public:
  Reader(const Json& object, std::string_view file, std::string place);

  bool has(const std::string& key) const;  ///< for optional keys
  Reader object(const std::string& key) const;
  std::vector<Reader> objects(const std::string& key) const;
  std::string text(const std::string& key) const;
  std::uint64_t count(const std::string& key, std::uint64_t smallest = 0,
                      std::uint64_t largest = std::numeric_limits<std::int64_t>::max()) const;
  std::vector<std::uint64_t> counts(const std::string& key) const;
  // Finite numbers:
  double number(const std::string& key, double smallest) const;
  std::vector<double> numbers(const std::string& key, std::size_t count, double smallest) const;
  Vec3 vector(const std::string& key) const;
  Index3 index(const std::string& key, std::int64_t smallest, std::int64_t largest) const;
  Interval<double> interval(const std::string& key) const;  ///< null: empty
  ElementType element_type(const std::string& key) const;
  LabelNames label_names(const std::string& key) const;

  [[noreturn]] void refuse_value(const std::string& key, std::string_view expected) const;

 private:
  const Json& value(const std::string& key, std::string_view expected) const;
  std::string place(const std::string& key) const;

  const Json& object_;
  std::string_view file_;
  std::string place_;
};

// Numbers are written so that they read back to the same bits. JSON cannot represent a number that
// is not finite: it is refused (ErrorCode::invalid, named by `what`).
Json number_json(double number, std::string_view what);
Json vector_json(const Vec3& vector, std::string_view what);
Json index_json(const Index3& index);
Json field_json(const FieldSummary& field);
Json macro_json(const MacroShape& shape);
Json provenance_json(const Provenance& provenance);
/// replaces bytes that are not UTF-8 by the replacement character
std::string dump(const Json& json);

FieldSummary read_field(const Reader& reader);
MacroShape read_macro(const Reader& reader, const Index3& leaf_count);
Provenance read_provenance(const Reader& reader);

/// Largest number of samples or leaf cells per axis. It keeps allocations per axis small, whatever
/// a file claims.
inline constexpr std::int64_t largest_axis = std::int64_t{1} << 20;

}  // namespace rhoray::formats::details
