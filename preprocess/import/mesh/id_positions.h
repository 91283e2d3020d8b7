#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Maps a file's own ids to indices. Ids may be consecutive or in any order, with gaps.
class IdPositions {
 public:
  /// ids[i] is the id of index i.
  explicit IdPositions(const Array<std::uint64_t>& ids) : first_(ids.empty() ? 0 : ids.front()), count_(ids.size()) {
    bool consecutive = true;
    for (std::size_t i = 0; i < ids.size() && consecutive; ++i) consecutive = ids[i] == first_ + i;
    if (consecutive) return;
    sorted_.reserve(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) sorted_.emplace_back(ids[i], i);
    std::sort(sorted_.begin(), sorted_.end());
  }

  std::optional<std::uint64_t> find(std::uint64_t id) const {
    if (sorted_.empty()) return id - first_ < count_ ? std::optional(id - first_) : std::nullopt;
    const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair<std::uint64_t, std::uint64_t>(id, 0));
    return found != sorted_.end() && found->first == id ? std::optional(found->second) : std::nullopt;
  }

  /// An id that occurs twice, if there is one.
  std::optional<std::uint64_t> repeated() const {
    const auto found = std::adjacent_find(sorted_.begin(), sorted_.end(),
                                          [](const auto& a, const auto& b) { return a.first == b.first; });
    return found == sorted_.end() ? std::nullopt : std::optional(found->first);
  }

 private:
  std::uint64_t first_ = 0, count_ = 0;
  Array<std::pair<std::uint64_t, std::uint64_t>> sorted_;  ///< (id, index); empty: consecutive
};

}  // namespace rhoray::preprocess
