#include "tools/view/line_exchange.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <chrono>

#include "formats/base/text.h"

namespace rhoray::tests {
namespace {

/// Both ends of a pipe.
struct Pipe {
  Pipe() { EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0); }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    close(0);
    close(1);
  }
  void close(int end) {
    if (ends[end] >= 0) ::close(ends[end]);
    ends[end] = -1;
  }
  void write(const std::string& text) const {
    EXPECT_EQ(::write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  std::string line() const {
    std::string text;
    char letter = 0;
    while (::read(ends[0], &letter, 1) == 1 && letter != '\n') text += letter;
    return text;
  }

  int ends[2] = {-1, -1};
};

TEST(LineExchange, answers_lines_and_notices_the_end) {
  Pipe in, out;
  std::atomic<bool> has_ended = false;
  tools::LineExchange exchange(in.ends[0], out.ends[1],
                               {.answer = [](std::string_view line) { return concat(line.size(), " letters"); },
                                .ended = [&] { has_ended = true, has_ended.notify_all(); }});
  in.write("abc\nab");
  EXPECT_EQ(out.line(), "3 letters");
  in.write("cd\n\n");
  EXPECT_EQ(out.line(), "4 letters");
  EXPECT_EQ(out.line(), "0 letters");
  in.write(std::string(60000, 'x'));
  in.write(std::string(60000, 'x') + "\n");
  EXPECT_EQ(out.line(), "65537 letters") << "one more than a message may have, so that it is refused";
  EXPECT_FALSE(has_ended);
  in.close(1);
  has_ended.wait(false);
  EXPECT_TRUE(has_ended);
}

/// An exchange whose writer waits, until the pipe is read.
struct FullExchange {
  FullExchange() {
    exchange.write(filling);
    for (int held = 0; held < static_cast<int>(filling.size());) ::ioctl(out.ends[0], FIONREAD, &held);
  }

  Pipe in, out;
  std::string filling = std::string(static_cast<std::size_t>(::fcntl(out.ends[1], F_GETPIPE_SZ)), 'x');
  tools::LineExchange exchange{
      in.ends[0], out.ends[1], {.answer = [](std::string_view) { return std::string(); }, .ended = [] {}}};
};

TEST(LineExchange, does_not_wait_for_a_program_that_does_not_read) {
  FullExchange full;
  for (int i = 0; i < 100000; ++i) full.exchange.write_state(concat("state ", i));
  for (int i = 0; i < 1000; ++i) full.exchange.write(concat("line ", i));
  EXPECT_EQ(full.out.line(), full.filling);
  EXPECT_EQ(full.out.line(), "state 99999") << "only the newest state";
  for (int i = 937; i < 1000; ++i) EXPECT_EQ(full.out.line(), concat("line ", i)) << "64 lines are kept";
  full.exchange.write(full.filling + full.filling);  // nobody reads it, and the end does not wait for it
}

TEST(LineExchange, writes_an_error_after_the_state_that_it_is_about) {
  FullExchange full;
  full.exchange.write_state("what is refused");
  full.exchange.write("its error");
  EXPECT_EQ(full.out.line(), full.filling);
  EXPECT_EQ(full.out.line(), "what is refused");
  EXPECT_EQ(full.out.line(), "its error");
}

TEST(LineExchange, writes_a_newer_state_after_the_error_of_an_older_one) {
  FullExchange full;
  full.exchange.write_state("what is refused");
  full.exchange.write("its error");
  full.exchange.write_state("what is right");
  EXPECT_EQ(full.out.line(), full.filling);
  EXPECT_EQ(full.out.line(), "its error");
  EXPECT_EQ(full.out.line(), "what is right");
}

}  // namespace
}  // namespace rhoray::tests
