#include "preprocess/export/stl_file.h"

#include <array>
#include <cstring>
#include <limits>
#include <string_view>

#include "formats/base/error.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t title_bytes = 80;

template <class T>
void write_number(std::ostream& file, const T& number) {
  file.write(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

StlFile::StlFile(const std::filesystem::path& path, const std::string& name)
    : name_(name.empty() ? path.string() : name), file_(path, name_) {
  std::array<char, title_bytes> title{};
  // must not begin with "solid", which would make it a text file
  constexpr std::string_view text = "rhoray";
  std::memcpy(title.data(), text.data(), text.size());
  file_.write(title.data(), title.size());
  write_number(file_, std::uint32_t{0});
}

void StlFile::add(const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto rounded = [](const Vec3& p) {
    return std::array{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  };
  const std::array corners{rounded(a), rounded(b), rounded(c)};
  if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) return;
  Vec3 normal = (b - a).cross(c - a);
  if (normal.length() > 0) normal.normalize();
  write_number(file_, rounded(normal));
  write_number(file_, corners);
  write_number(file_, std::uint16_t{0});
  ++triangle_count_;
}

std::uint64_t StlFile::finish() {
  if (triangle_count_ > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::unsupported,
                concat(name_, ": ", triangle_count_, " triangles; expected fewer than 2^32 in an STL file"));
  file_.seekp(title_bytes);
  write_number(file_, static_cast<std::uint32_t>(triangle_count_));
  file_.finish();
  return triangle_count_;
}

}  // namespace rhoray::preprocess
