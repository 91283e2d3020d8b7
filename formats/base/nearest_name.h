#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace rhoray {

/// Number of edits that turn one word into the other: insert, drop or change a letter, or exchange
/// two neighbours. Case-sensitive.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Returns the candidate that was probably meant, ignoring case: one that starts with `word` (three
/// letters or more), or the one at the smallest edit distance. That distance may be at most a third
/// of the word's length, but one letter is always allowed. Returns the first among equals; nothing
/// when no candidate is close enough.
std::optional<std::string> nearest(std::string_view word, std::span<const std::string> candidates);

/// "did you mean bone.vtu?" for the hint of an Error; empty when no candidate is close enough.
std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

}  // namespace rhoray
