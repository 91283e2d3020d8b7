#include "tools/rhoray/cli/progress_display.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "formats/base/number_text.h"
#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

std::string rate_text(double rate, const std::string& counted) {
  if (counted == "bytes") return bytes_text(static_cast<std::uint64_t>(rate)) + "/s";
  constexpr std::string_view prefixes[] = {"", " k", " M", " G"};
  std::size_t prefix = 0;
  for (; rate >= 1000 && prefix + 1 < std::size(prefixes); ++prefix) rate /= 1000;
  return concat(rounded(rate, 3), prefixes[prefix], " ", counted, "/s");
}

std::string time_text(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::ceil(std::min(seconds, 1e9)));
  if (whole < 60) return concat(whole, " s");
  if (whole < 3600) return concat(whole / 60, " min ", whole % 60, " s");
  return concat(whole / 3600, " h ", whole % 3600 / 60, " min");
}

}  // namespace

Pace pace_of(std::string_view phase, std::uint64_t done, std::uint64_t total, double elapsed_s) {
  constexpr double shortest_s = 0.2;  // before, a rate says little
  Pace pace{.what = std::string(phase), .counted = {}};
  if (const std::size_t open = phase.rfind(" ("); open != phase.npos && phase.ends_with(')')) {
    pace.what = phase.substr(0, open);
    pace.counted = phase.substr(open + 2, phase.size() - open - 3);
  }
  if (total != 0) pace.share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  if (elapsed_s < shortest_s || done == 0) return pace;
  pace.rate_per_s = static_cast<double>(done) / elapsed_s;
  if (total > done) pace.seconds_left = static_cast<double>(total - done) / pace.rate_per_s;
  return pace;
}

std::string bar_text(const Pace& pace) {
  constexpr std::size_t width = 30;
  std::string text = pace.what;
  if (pace.share > 0) {
    const auto filled = static_cast<std::size_t>(pace.share * width);
    text += concat(" [", std::string(filled, '='), std::string(width - filled, ' '), "] ",
                   static_cast<int>(100 * pace.share), "%");
  }
  if (pace.rate_per_s > 0 && !pace.counted.empty()) text += ", " + rate_text(pace.rate_per_s, pace.counted);
  if (pace.seconds_left > 0) text += concat(", ", time_text(pace.seconds_left), " left");
  return text;
}

ProgressDisplay::ProgressDisplay(const CommonOptions& common) {
  const std::string& word = common.progress;
  if (common.quiet || word == "none")
    style_ = Style::none;
  else if (word == "bar" || (word == "auto" && ::isatty(STDERR_FILENO) == 1))
    style_ = Style::bar;
  else if (word == "plain")
    style_ = Style::plain;
  else if (word == "json")
    style_ = Style::json;
}

ProgressDisplay::~ProgressDisplay() {
  clear();
}

void ProgressDisplay::clear() {
  if (bar_is_shown_) std::fputs("\r\033[K", stderr);
  bar_is_shown_ = false;
}

bool ProgressDisplay::is_due(std::string_view phase, bool finished) {
  const auto now = std::chrono::steady_clock::now();
  const bool new_phase = phase != phase_;
  if (!new_phase && !finished && now - last_shown_ < std::chrono::milliseconds(100)) return false;
  if (new_phase) phase_begin_ = now;
  phase_ = phase;
  last_shown_ = now;
  return new_phase || style_ != Style::plain;  // plain: one line for each phase
}

void ProgressDisplay::show(std::string_view phase, std::uint64_t done, std::uint64_t total) {
  if (style_ == Style::none || !is_due(phase, total != 0 && done >= total)) return;
  const std::chrono::duration<double> elapsed = last_shown_ - phase_begin_;
  const Pace pace = pace_of(phase, done, total, elapsed.count());
  if (style_ == Style::plain) {
    std::fputs((pace.what + "\n").c_str(), stderr);
  } else if (style_ == Style::json) {
    const nlohmann::json line{
        {"phase", pace.what}, {"counted", pace.counted},       {"done", done},
        {"total", total},     {"rate_per_s", pace.rate_per_s}, {"seconds_left", pace.seconds_left}};
    std::fputs((line.dump() + "\n").c_str(), stderr);
  } else {
    std::fputs(("\r\033[K" + bar_text(pace)).c_str(), stderr);
    bar_is_shown_ = true;
  }
}

Progress ProgressDisplay::progress() {
  return [this](std::string_view phase, std::uint64_t done, std::uint64_t total) { show(phase, done, total); };
}

}  // namespace rhoray::tools
