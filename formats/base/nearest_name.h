#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace rhoray {

/// Letters to insert, drop, change, or exchange with their neighbour, to make one word of the
/// other; case counts.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that was probably meant: one that `word` begins (three letters or more), or the
/// one at the smallest edit distance, ignoring case, if that is at most a third of the word's
/// length (but one letter in any case). The first of equals; nothing when none is near.
std::optional<std::string> nearest(std::string_view word, std::span<const std::string> candidates);

/// "did you mean bone.vtu?", or nothing when no candidate is near: for the hint of an Error.
std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

}  // namespace rhoray
