#include <cstring>

#include "preprocess/import/reading/byte_stream.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/surface/surface_building.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t title_bytes = 80, triangle_bytes = 50;

/// Recognises a binary file by its length, which must match its count. The title cannot tell,
/// because it may begin with "solid" too.
std::optional<std::uint64_t> binary_triangle_count(std::span<const std::byte> bytes) {
  if (bytes.size() < title_bytes + 4) return std::nullopt;
  std::array<std::byte, 4> raw;
  std::memcpy(raw.data(), bytes.data() + title_bytes, raw.size());
  make_native(raw, raw.size(), false);
  std::uint32_t count;
  std::memcpy(&count, raw.data(), raw.size());
  return count;
}

std::uint64_t bytes_of_triangles(std::uint64_t count) {
  return title_bytes + 4 + count * triangle_bytes;
}

void add_triangle(NeutralSurface& surface, PointMerger& merger, const std::array<std::array<double, 3>, 3>& triangle,
                  const std::filesystem::path& path, const std::string& place) {
  std::array<std::uint64_t, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = merger.position_of(triangle[k]);
  add_facet(surface, corners, path, place);
}

void read_binary(const ForeignFile& file, std::uint64_t count, NeutralSurface& surface) {
  PointMerger merger(surface);
  for (std::uint64_t i = 0; i < count; ++i) {
    std::array<std::byte, 36> raw;  // three corners, after 12 bytes of normal
    std::memcpy(raw.data(), file.bytes().data() + bytes_of_triangles(i) + 12, raw.size());
    make_native(raw, 4, false);
    std::array<float, 9> numbers;
    std::memcpy(numbers.data(), raw.data(), raw.size());
    std::array<std::array<double, 3>, 3> triangle;
    for (std::size_t k = 0; k < 9; ++k) triangle[k / 3][k % 3] = static_cast<double>(numbers[k]);
    add_triangle(surface, merger, triangle, file.path(), concat("triangle ", i));
  }
}

void read_text(const ForeignFile& file, NeutralSurface& surface) {
  PointMerger merger(surface);
  WordReader reader(file);
  const auto expect = [&](std::string_view keyword) {
    const std::string_view found = reader.word(keyword);
    if (found != keyword) reader.refuse(found, keyword);
  };
  while (!reader.at_end()) {  // solids, one after the other
    expect("solid");
    reader.line();  // its name
    while (reader.peek() == "facet") {
      expect("facet");
      expect("normal");
      for (int i = 0; i < 3; ++i) reader.number<double>("a normal");
      expect("outer");
      expect("loop");
      std::array<std::array<double, 3>, 3> triangle;
      for (std::array<double, 3>& corner : triangle) {
        expect("vertex");
        corner = reader.point();
      }
      expect("endloop");
      expect("endfacet");
      add_triangle(surface, merger, triangle, file.path(), concat("byte ", reader.position()));
    }
    expect("endsolid");
    if (reader.bytes_left() > 0) reader.line();  // its name again
  }
}

}  // namespace

NeutralSurface read_stl(const std::filesystem::path& path) {
  const ForeignFile file = unpacked_file(path);
  NeutralSurface surface;
  const std::optional<std::uint64_t> count = binary_triangle_count(file.bytes());
  const std::uint64_t size = file.bytes().size();
  const bool fits = count && bytes_of_triangles(*count) == size;
  if (fits || !file.text().starts_with("solid")) {
    if (!fits && (!count || bytes_of_triangles(*count) > size))
      refuse_input(
          path, concat("byte ", size), "the end of the file",
          count ? concat(bytes_of_triangles(*count), " bytes of ", *count, " triangles") : "solid, or a binary header");
    if (!fits)
      surface.notes.push_back(concat(size - bytes_of_triangles(*count), " bytes after the triangles were left out"));
    read_binary(file, *count, surface);
  } else {
    read_text(file, surface);
  }
  finish_surface(surface, path);
  return surface;
}

}  // namespace rhoray::preprocess
