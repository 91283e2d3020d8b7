#include "tools/analysis/picture_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/error.h"

namespace rhoray::tools {

namespace {

double difference_of(double a, double b) {
  if (std::isfinite(a) && std::isfinite(b)) return std::abs(a - b);
  const bool is_same = a == b || (std::isnan(a) && std::isnan(b));
  return is_same ? 0 : std::numeric_limits<double>::infinity();
}

/// Pairs the indices of the channels that both pictures have, and notes the other channels.
std::vector<std::pair<std::size_t, std::size_t>> pair_channels(const StoredPicture& a, const StoredPicture& b,
                                                               PictureDifference& difference) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const auto place = [](const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    const std::size_t other = place(b.channels, a.channels[c]);
    if (other == b.channels.size()) {
      difference.only_a.push_back(a.channels[c]);
    } else {
      pairs.emplace_back(c, other);
      difference.channels.push_back(a.channels[c]);
    }
  }
  for (const std::string& name : b.channels)
    if (place(a.channels, name) == a.channels.size()) difference.only_b.push_back(name);
  return pairs;
}

std::string size_text(const StoredPicture& picture) {
  return concat(picture.width, "x", picture.height);
}

}  // namespace

std::string listed(const std::vector<std::string>& channels) {
  std::string text;
  for (const std::string& name : channels) text += concat(text.empty() ? "" : ", ", name);
  return text;
}

std::uint64_t PictureDifference::beyond(double limit) const {
  return static_cast<std::uint64_t>(
      std::ranges::count_if(of_pixel, [&](float size) { return static_cast<double>(size) > limit; }));
}

double PictureDifference::peak_signal_to_noise() const {
  return -20 * std::log10(root_mean_square);
}

PictureDifference difference_of(const StoredPicture& a, const StoredPicture& b, const std::string& name_a,
                                const std::string& name_b) {
  if (a.width != b.width || a.height != b.height)
    throw Error(ErrorCode::invalid,
                concat(name_b, ": found ", size_text(b), " pixels; expected ", size_text(a), ", as in ", name_a));
  PictureDifference difference;
  const auto pairs = pair_channels(a, b, difference);
  if (pairs.empty())
    throw Error(ErrorCode::invalid, concat(name_b, ": found channels ", listed(b.channels), "; expected some of ",
                                           listed(a.channels), ", as in ", name_a));
  const std::size_t pixels = static_cast<std::size_t>(a.width) * static_cast<std::size_t>(a.height);
  difference.of_pixel.resize(pixels);
  double sum = 0, squares = 0;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    for (std::size_t c = 0; c < pairs.size(); ++c) {
      const double at_a = a.numbers[pixel * a.channels.size() + pairs[c].first],
                   at_b = b.numbers[pixel * b.channels.size() + pairs[c].second];
      const double size = difference_of(at_a, at_b);
      sum += size, squares += size * size;
      // Rounded up, so that a difference beyond a limit stays beyond it.
      float stored = static_cast<float>(size);
      if (static_cast<double>(stored) < size) stored = std::nextafter(stored, std::numeric_limits<float>::infinity());
      difference.of_pixel[pixel] = std::max(difference.of_pixel[pixel], stored);
      if (size > difference.largest.size)
        difference.largest = {.size = size,
                              .channel = difference.channels[c],
                              .x = static_cast<int>(pixel % static_cast<std::size_t>(a.width)),
                              .y = static_cast<int>(pixel / static_cast<std::size_t>(a.width)),
                              .a = at_a,
                              .b = at_b};
    }
    difference.differing += difference.of_pixel[pixel] > 0 ? 1 : 0;
  }
  const double count = static_cast<double>(pixels * pairs.size());
  difference.mean = sum / count;
  difference.root_mean_square = std::sqrt(squares / count);
  return difference;
}

}  // namespace rhoray::tools
