#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/library_text.h"
#include "preprocess/neutral.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// Collects the lines that libraries print while it lives.
class LibraryText {
 public:
  LibraryText() {
    set_library_text_sink([this](const std::string& line) { lines_.push_back(line); });
  }
  LibraryText(const LibraryText&) = delete;
  LibraryText& operator=(const LibraryText&) = delete;
  ~LibraryText() { set_library_text_sink({}); }

  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

/// A lattice whose sizes differ and whose values say where they stand, so that any swap of axes is
/// seen.
inline constexpr std::int64_t size_x = 3, size_y = 4, size_z = 5;
inline constexpr std::size_t value_count = size_x * size_y * size_z;

inline int value_at(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<int>(i + 10 * j + 30 * k);
}

template <class T>
std::vector<T> known_values() {
  std::vector<T> values;
  for (std::int64_t k = 0; k < size_z; ++k)
    for (std::int64_t j = 0; j < size_y; ++j)
      for (std::int64_t i = 0; i < size_x; ++i) values.push_back(static_cast<T>(value_at(i, j, k)));
  return values;
}

template <class T>
std::string bytes_of_values(const std::vector<T>& values, bool big_endian = false) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  if (big_endian)
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(T))
      std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                   bytes.begin() + static_cast<std::ptrdiff_t>(at + sizeof(T)));
  return bytes;
}

inline std::string values_in_text() {
  std::string text;
  for (const int value : known_values<int>()) text += concat(value, "\n");
  return text;
}

inline std::vector<double> values_of(const preprocess::NeutralVolume& volume) {
  std::vector<double> values;
  formats::with_element_type(volume.type, [&]<class T>(T) {
    for (std::size_t at = 0; at + sizeof(T) <= volume.samples.size(); at += sizeof(T)) {
      T value;
      std::memcpy(&value, volume.samples.data() + at, sizeof value);
      values.push_back(static_cast<double>(value));
    }
  });
  return values;
}

/// The known values, as numbers of type T hold them.
template <class T>
void expect_values(const preprocess::NeutralVolume& volume, formats::ElementType type) {
  EXPECT_EQ(volume.sample_count, Index3(size_x, size_y, size_z));
  EXPECT_EQ(formats::element_name(volume.type), formats::element_name(type));
  const std::vector<T> values = known_values<T>();
  EXPECT_EQ(values_of(volume), std::vector<double>(values.begin(), values.end()));
}

inline void expect_known_values(const preprocess::NeutralVolume& volume, formats::ElementType type) {
  expect_values<double>(volume, type);
}

/// Axes along x, y, z with this spacing.
inline Affine axis_parallel_map(const Vec3& spacing, const Vec3& origin) {
  return {{spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z}, origin};
}

inline void expect_near(const Vec3& found, const Vec3& expected, double tolerance = 1e-12) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

inline void expect_map(const Affine& found, const Affine& expected, double tolerance = 1e-12) {
  expect_near(found.x_axis, expected.x_axis, tolerance);
  expect_near(found.y_axis, expected.y_axis, tolerance);
  expect_near(found.z_axis, expected.z_axis, tolerance);
  expect_near(found.origin, expected.origin, tolerance);
}

/// The act must throw an Error of this kind whose message contains every one of the words.
inline void expect_refusal(const std::function<void()>& act, ErrorCode error_code,
                           const std::vector<std::string>& words) {
  try {
    act();
    ADD_FAILURE() << "nothing was refused; expected " << testing::PrintToString(words);
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(error_code)) << error.what();
    for (const std::string& word : words) EXPECT_THAT(std::string(error.what()), testing::HasSubstr(word));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
}

struct Beginnings {
  std::size_t stride = 1;  ///< every which one, beside the last 20
  bool is_text = false;    ///< cuts inside a number are left out: a number without its last digits is still a number
};

/// Puts every proper beginning of the content into a file of this name; each must be refused as an
/// Error that names the file, or pass `is_complete`. Returns how many passed.
inline int check_every_beginning(const std::filesystem::path& path, const std::string& content,
                                 const std::function<bool()>& is_complete, const Beginnings& which = {}) {
  int passed = 0;
  for (std::size_t size = 0; size < content.size(); ++size) {
    if (size % which.stride != 0 && size + 20 < content.size()) continue;
    const auto is_digit = [&](std::size_t at) {
      return (content[at] >= '0' && content[at] <= '9') || content[at] == '.';
    };
    if (which.is_text && size > 0 && is_digit(size - 1) && is_digit(size)) continue;
    write_file(path, std::string_view(content).substr(0, size));
    try {
      const bool complete = is_complete();
      EXPECT_TRUE(complete) << "the first " << size << " of " << content.size() << " bytes were read as something else";
      passed += complete ? 1 : 0;
    } catch (const Error& error) {
      EXPECT_THAT(std::string(error.what()), testing::HasSubstr(path.filename().string()));
    }
  }
  write_file(path, content);
  return passed;
}

}  // namespace rhoray::tests
