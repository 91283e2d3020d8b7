#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

namespace rhoray::tools {

/// Exchanges lines with the program that started this one, over two pipes. Nobody waits for a
/// program that does not read.
class LineExchange {
 public:
  struct Listener {
    /// Takes a line without its end; one that is too long is cut. What it returns is written,
    /// unless it is empty.
    std::function<std::string(std::string_view)> answer;
    std::function<void()> ended;  ///< the other side has closed its pipe
  };

  /// @param in, out  descriptors, which are not closed
  /// @param listener  called on another thread
  LineExchange(int in, int out, Listener listener);
  LineExchange(const LineExchange&) = delete;
  LineExchange& operator=(const LineExchange&) = delete;
  ~LineExchange();

  /// Writes a line soon, after those that wait. If 64 wait, the oldest that is no state is dropped.
  void write(std::string line);
  /// The same, but an earlier state that waits is dropped: only the newest matters.
  void write_state(std::string line);

 private:
  struct Line {
    std::string text;
    bool is_state = false;
  };

  void add(Line line);
  void read_lines(const std::stop_token& stop);
  void write_lines(const std::stop_token& stop);

  const int in_, out_;
  const Listener listener_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Line> waiting_;
  std::jthread reader_, writer_;  ///< last: they use the others
};

}  // namespace rhoray::tools
