#include "tools/view/line_exchange.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <utility>

#include "tools/view/client_message.h"

namespace rhoray::tools {

namespace {

constexpr int pause_ms = 100;  ///< between looks at the stop token
constexpr std::size_t most_lines = 64;
constexpr std::size_t longest_line = view_limits::message_bytes + 1;  ///< one more is refused as too long

/// Waits until the descriptor is ready; false when the thread shall end.
bool is_ready(int descriptor, short events, const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    pollfd waiting{.fd = descriptor, .events = events, .revents = 0};
    if (::poll(&waiting, 1, pause_ms) > 0) return true;
  }
  return false;
}

}  // namespace

LineExchange::LineExchange(int in, int out, Listener listener)
    : in_(in),
      out_(out),
      listener_(std::move(listener)),
      reader_([this](const std::stop_token& stop) { read_lines(stop); }),
      writer_([this](const std::stop_token& stop) { write_lines(stop); }) {}

LineExchange::~LineExchange() {
  reader_.request_stop();
  writer_.request_stop();
}

void LineExchange::write(std::string line) {
  add({.text = std::move(line)});
}

void LineExchange::write_state(std::string line) {
  add({.text = std::move(line), .is_state = true});
}

void LineExchange::add(Line line) {
  const std::lock_guard lock(mutex_);
  if (line.is_state || waiting_.size() >= most_lines) {
    const auto dropped = std::find_if(waiting_.begin(), waiting_.end(),
                                      [&](const Line& each) { return each.is_state == line.is_state; });
    if (dropped != waiting_.end()) waiting_.erase(dropped);
  }
  waiting_.push_back(std::move(line));
  changed_.notify_one();
}

void LineExchange::read_lines(const std::stop_token& stop) {
  std::string line;
  std::array<char, 4096> bytes{};
  while (is_ready(in_, POLLIN, stop)) {
    const ssize_t count = ::read(in_, bytes.data(), bytes.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count <= 0) return listener_.ended();
    for (const char letter : std::string_view(bytes.data(), static_cast<std::size_t>(count)))
      if (letter == '\n') {
        if (std::string answer = listener_.answer(line); !answer.empty()) write(std::move(answer));
        line.clear();
      } else if (line.size() < longest_line) {
        line += letter;
      }
  }
}

void LineExchange::write_lines(const std::stop_token& stop) {
  for (;;) {
    std::string line;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return !waiting_.empty(); })) return;
      line = std::move(waiting_.front().text);
      waiting_.pop_front();
    }
    line += '\n';
    for (std::string_view rest = line; !rest.empty();) {
      if (!is_ready(out_, POLLOUT, stop)) return;
      // At most PIPE_BUF bytes: a pipe that is ready takes them at once.
      const ssize_t count = ::write(out_, rest.data(), std::min<std::size_t>(rest.size(), PIPE_BUF));
      if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (count < 0) return;  // nobody reads any more; the other pipe ends, too
      rest.remove_prefix(static_cast<std::size_t>(count));
    }
  }
}

}  // namespace rhoray::tools
