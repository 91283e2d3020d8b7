#include "tools/rhoray/progress_display.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "formats/base/text.h"

namespace rhoray::tools {

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
  phase_ = phase;
  last_shown_ = now;
  return new_phase || style_ != Style::plain;  // plain: one line for each phase
}

void ProgressDisplay::show(std::string_view phase, std::uint64_t done, std::uint64_t total) {
  if (style_ == Style::none || !is_due(phase, total != 0 && done >= total)) return;
  if (style_ == Style::plain) {
    std::fputs(concat(phase, "\n").c_str(), stderr);
  } else if (style_ == Style::json) {
    const nlohmann::json line{{"phase", phase}, {"done", done}, {"total", total}};
    std::fputs((line.dump() + "\n").c_str(), stderr);
  } else {
    constexpr std::size_t width = 30;
    const double share = total == 0 ? 0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
    const auto filled = static_cast<std::size_t>(share * width);
    const std::string bar = total == 0 ? std::string{}
                                       : concat(" [", std::string(filled, '='), std::string(width - filled, ' '), "] ",
                                                static_cast<int>(100 * share), "%");
    std::fputs(concat("\r\033[K", phase, bar).c_str(), stderr);
    bar_is_shown_ = true;
  }
}

preprocess::Progress ProgressDisplay::progress() {
  return [this](std::string_view phase, std::uint64_t done, std::uint64_t total) { show(phase, done, total); };
}

}  // namespace rhoray::tools
