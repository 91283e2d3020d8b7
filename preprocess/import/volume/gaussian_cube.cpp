#include <cmath>
#include <cstring>
#include <optional>

#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {
namespace {

/// One axis line of the header: a count, and the step from sample to sample.
struct CubeAxis {
  std::int64_t count = 0;
  Vec3 step;
};

Vec3 three_numbers(WordReader& reader, std::string_view what) {
  const auto x = reader.number<double>(what), y = reader.number<double>(what), z = reader.number<double>(what);
  return {x, y, z};
}

/// Newer writers tell at the end of the line how many values each sample has.
void check_value_count(WordReader& reader) {
  const std::string_view word = trimmed(reader.line());
  if (word.empty()) return;
  const std::optional<std::int64_t> count = parse_number<std::int64_t>(word);
  if (!count) reader.refuse(in_quotes(word), "a number of values for each sample, or nothing");
  if (*count != 1) reader.refuse(concat(*count, " values for each sample"), "1", ErrorCode::unsupported);
}

}  // namespace

// The format: two lines of text; atom count and origin, perhaps a count of values; three axes;
// atoms; if the atom count is negative, a line with the number of orbitals and their numbers; then
// values, the third axis fastest. Lengths are in bohr, or in angstrom if the count of an axis is
// negative.
NeutralVolume read_gaussian_cube(const std::filesystem::path& path, const std::string&) {
  const ForeignFile file(path);
  WordReader reader(file);
  reader.line();
  reader.line();
  const auto atoms = reader.number<std::int64_t>("a number of atoms");
  const Vec3 origin = three_numbers(reader, "an origin");
  check_value_count(reader);
  CubeAxis axes[3];
  bool in_angstrom = false;
  for (CubeAxis& axis : axes) {
    axis.count = reader.number<std::int64_t>("a number of samples");
    in_angstrom = in_angstrom || axis.count < 0;
    axis.count = std::abs(axis.count);
    axis.step = three_numbers(reader, "an axis");
  }
  if (std::abs(atoms) > static_cast<std::int64_t>(reader.bytes_left() / 10))
    reader.refuse(concat(atoms, " atoms"), "as many as the file can hold");
  for (std::int64_t atom = 0; atom < std::abs(atoms); ++atom)
    for (int number = 0; number < 5; ++number) reader.number<double>("an atom");
  if (atoms < 0) {
    const auto orbitals = reader.number<std::int64_t>("a number of orbitals");
    if (orbitals != 1) reader.refuse(concat(orbitals, " orbitals"), "1", ErrorCode::unsupported);
    reader.number<std::int64_t>("an orbital's number");
  }

  NeutralVolume volume;
  volume.type = formats::ElementType::F64;
  volume.sample_count = {axes[0].count, axes[1].count, axes[2].count};
  const std::uint64_t bytes = checked_volume_bytes(path, volume.sample_count, volume.type);
  const Index3& n = volume.sample_count;
  if (bytes / sizeof(double) > reader.bytes_left() / 2 + 1)
    refuse_input(path, "header", concat(n.x, " x ", n.y, " x ", n.z, " samples"), "as many as the file can hold");
  Array<std::byte> samples(bytes);
  for (std::int64_t i = 0; i < n.x; ++i)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t k = 0; k < n.z; ++k) {
        const auto value = reader.number<double>("a value");
        const auto at = static_cast<std::size_t>((k * n.y + j) * n.x + i) * sizeof value;
        std::memcpy(samples.data() + at, &value, sizeof value);
      }
  if (!reader.at_end()) reader.refuse(concat(reader.bytes_left(), " bytes after the values"), "the end of the file");
  set_samples(volume, std::move(samples));
  volume.world_from_grid = {axes[0].step, axes[1].step, axes[2].step, origin};
  volume.length_unit = in_angstrom ? "angstrom" : "bohr";
  volume.field_name = stem_of(path);
  finish_volume(volume, path);
  return volume;
}

}  // namespace rhoray::preprocess
