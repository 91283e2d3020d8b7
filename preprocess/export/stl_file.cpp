#include "preprocess/export/stl_file.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

#include "formats/base/error.h"
#include "formats/base/number_text.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t title_bytes = 80;
constexpr const char* precise_formats = "a .vti or a .vtu file stores the data in double precision";

template <class T>
void write_number(std::ostream& file, const T& number) {
  file.write(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

void note_vanished(const StlCounts& triangles, std::vector<std::string>& notes) {
  if (triangles.vanished == 0) return;
  notes.push_back(concat(triangles.vanished, " of ",
                         count_text(triangles.written + triangles.vanished, "triangle", "triangles"),
                         triangles.vanished == 1 ? " is" : " are",
                         " too small for single precision at these coordinates and left out; ", precise_formats));
}

StlFile::StlFile(const std::filesystem::path& path, const std::string& name)
    : name_(name.empty() ? path.string() : name), file_(path, name_) {
  std::array<char, title_bytes> title{};
  // must not begin with "solid", which would make it a text file
  constexpr std::string_view text = "rhoray";
  std::memcpy(title.data(), text.data(), text.size());
  file_.write(title.data(), title.size());
  write_number(file_, std::uint32_t{0});
}

std::array<float, 3> StlFile::in_single_precision(const Vec3& corner) const {
  constexpr double largest = std::numeric_limits<float>::max();
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(corner[axis]) <= largest))  // written so that NaN is refused
      throw Error(
          ErrorCode::unsupported,
          concat(name_, ": found the coordinate ", corner[axis], "; an STL file stores at most ", rounded(largest)),
          precise_formats);
  return {static_cast<float>(corner.x), static_cast<float>(corner.y), static_cast<float>(corner.z)};
}

void StlFile::add(const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array corners{in_single_precision(a), in_single_precision(b), in_single_precision(c)};
  if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
    if (a != b && b != c && c != a) ++triangles_.vanished;
    return;
  }
  Vec3 normal = (b - a).cross(c - a);
  if (normal.length() > 0) normal.normalize();
  write_number(file_, in_single_precision(normal));
  write_number(file_, corners);
  write_number(file_, std::uint16_t{0});
  ++triangles_.written;
}

StlCounts StlFile::finish() {
  if (triangles_.written > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::unsupported,
                concat(name_, ": ", triangles_.written, " triangles; expected fewer than 2^32 in an STL file"));
  if (triangles_.written == 0 && triangles_.vanished > 0)
    throw Error(ErrorCode::unsupported,
                concat(name_, ": no triangle is left, because all ", triangles_.vanished,
                       " are too small for single precision at these coordinates"),
                precise_formats);
  file_.seekp(title_bytes);
  write_number(file_, static_cast<std::uint32_t>(triangles_.written));
  file_.finish();
  return triangles_;
}

}  // namespace rhoray::preprocess
