#include "preprocess/process/child_process.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <thread>

#include "preprocess/process/limits.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/sanitizers.h"

namespace rhoray::preprocess {
namespace {

using tests::expect_refusal;

class Worker : public testing::Test {
 protected:
  void SetUp() override { ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1); }

  static WorkerRequest request(const std::string& verb) {
    WorkerRequest request;
    request.program = "rhoray-test-worker";
    request.doing = "reading bone.vtu";
    request.arguments = {verb};
    return request;
  }
};

void write_numbers(int descriptor, const std::vector<std::uint64_t>& numbers) {
  formats::FileDescription description;
  description.kind = "neutral-test";
  formats::PackedFileWriter writer(
      descriptor, description,
      {{.name = "numbers", .type = formats::ElementType::U64, .shape = {numbers.size()}, .alignment = 64}});
  writer.write_all("numbers", std::span(numbers));
  writer.commit();
}

TEST_F(Worker, hands_over_what_it_made_from_its_input) {
  WorkerRequest square = request("square");
  square.write_input = [](int descriptor) { write_numbers(descriptor, {3, 5, 70'000}); };
  const formats::PackedFile answer = run_worker(square);
  const std::span<const std::uint64_t> numbers = answer.array<std::uint64_t>("numbers", {3});
  EXPECT_THAT(std::vector(numbers.begin(), numbers.end()), testing::ElementsAre(9, 25, 4'900'000'000));
}

TEST_F(Worker, works_beside_itself_from_many_threads) {
  std::vector<std::thread> threads;
  std::array<std::uint64_t, 8> answers{};
  for (std::uint64_t i = 0; i < answers.size(); ++i)
    threads.emplace_back([&, i] {
      WorkerRequest square = request("square");
      square.write_input = [&](int descriptor) { write_numbers(descriptor, {i}); };
      answers[i] = run_worker(square).array<std::uint64_t>("numbers", {1})[0];
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(answers, testing::ElementsAre(0, 1, 4, 9, 16, 25, 36, 49));
}

TEST_F(Worker, keeps_its_chatter_off_our_output) {
  testing::internal::CaptureStdout();
  run_worker(request("print"));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST_F(Worker, passes_a_refusal_on_as_the_same_error) {
  try {
    run_worker(request("refuse"));
    FAIL() << "nothing was refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unsupported);
    EXPECT_STREQ(error.what(), "bone.vtu, cells: found 3 hexahedra; expected linear tetrahedra");
    EXPECT_EQ(error.hint(), "make it tetrahedra");
  }
}

/// A message that quotes a file may contain the mark of progress, and codes for a terminal.
TEST_F(Worker, passes_control_characters_on_as_text) {
  const tests::LibraryText said;
  try {
    run_worker(request("refuse-controls"));
    FAIL() << "nothing was refused";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "bone.mhd, key: found 'a\\x01b\\x1b[31m'; expected c");
    EXPECT_EQ(error.hint(), "try\\x09this");
  }
  EXPECT_THAT(said.lines(), testing::ElementsAre("chatter \1 of a library"));
}

TEST_F(Worker, names_what_it_was_doing_when_a_library_throws) {
  const tests::LibraryText said;
  expect_refusal([] { run_worker(request("throw")); }, ErrorCode::internal, {"reading bone.vtu: failed unexpectedly"});
  EXPECT_THAT(said.lines(), testing::ElementsAre("a library's exception"));
}

TEST_F(Worker, keeps_what_libraries_say_out_of_its_refusals) {
  const tests::LibraryText said;
  for (const char* verb : {"refuse", "segfault", "exit-99"}) try {
      run_worker(request(verb));
      FAIL() << "nothing was refused";
    } catch (const Error& error) {
      for (const char* text : {"a library's chatter", "about to fall", "unexpected"}) {
        EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr(text)));
        EXPECT_THAT(error.hint(), testing::Not(testing::HasSubstr(text)));
      }
    }
  EXPECT_THAT(said.lines(), testing::ElementsAre("a library's chatter", "about to fall", "unexpected"));
}

TEST_F(Worker, turns_a_crash_into_a_sentence) {
  expect_refusal([] { run_worker(request("segfault")); }, ErrorCode::invalid,
                 {"signal 11 (Segmentation fault)", "while reading bone.vtu"});
}

TEST_F(Worker, turns_an_abort_into_a_sentence) {
  expect_refusal([] { run_worker(request("abort")); }, ErrorCode::invalid, {"signal 6", "while reading bone.vtu"});
}

TEST_F(Worker, is_stopped_at_its_time_limit) {
  WorkerRequest loop = request("loop");
  loop.time_limit_s = 0.5;
  expect_refusal([&] { run_worker(loop); }, ErrorCode::resource, {"limit of 0.5 s", "reading bone.vtu"});
}

TEST_F(Worker, is_stopped_at_its_memory_limit) {
  if (tests::sanitized) GTEST_SKIP() << tests::no_limits_of_memory;
  WorkerRequest devour = request("devour");
  devour.memory_limit_bytes = 256 << 20;
  expect_refusal([&] { run_worker(devour); }, ErrorCode::resource, {"reading bone.vtu", "out of memory"});
}

double seconds_of(const std::function<void()>& act) {
  const auto start = std::chrono::steady_clock::now();
  act();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A reader that waits for what never comes: a pipe, or a server that is gone; also one that has
/// nothing more to say.
TEST_F(Worker, is_stopped_when_it_does_nothing) {
  for (const char* verb : {"sleep", "read-a-pipe", "close-and-sleep"}) {
    WorkerRequest idle = request(verb);
    idle.idle_limit_s = 0.5;
    const double took_s = seconds_of([&] {
      expect_refusal([&] { run_worker(idle); }, ErrorCode::resource,
                     {"was stopped while reading bone.vtu", "for 0.5 s it used no CPU time and read or wrote nothing"});
    });
    EXPECT_GE(took_s, 0.5) << verb;
    EXPECT_LT(took_s, 30) << verb;
  }
}

TEST_F(Worker, is_not_stopped_while_it_computes_or_writes_now_and_then) {
  for (const char* verb : {"compute-now-and-then", "write-now-and-then"}) {  // 2.4 s each
    WorkerRequest slow = request(verb);
    slow.idle_limit_s = 1.2;
    EXPECT_EQ(run_worker(slow).array<std::uint64_t>("numbers", {1})[0], 1U) << verb;
  }
}

TEST_F(Worker, has_limits_without_being_asked) {
  WorkerRequest asked = request("limits");
  asked.input_bytes = 1 << 20;
  asked.output_bytes = std::uint64_t{1} << 40;
  const formats::PackedFile answer = run_worker(asked);
  const std::span<const std::uint64_t> limits = answer.array<std::uint64_t>("numbers", {4});
  if (!tests::sanitized) {
    EXPECT_EQ(limits[0], limits_for(asked).memory.rlim_cur);
  }
  EXPECT_GE(limits[1], asked.output_bytes);
  EXPECT_LT(limits[1], 2 * asked.output_bytes);
  EXPECT_EQ(limits[2], most_open_files);
  EXPECT_EQ(limits[3], 0U) << "a crash would leave a core file";
}

TEST_F(Worker, cannot_write_or_open_without_end) {
  WorkerRequest writing = request("answer-without-end");
  writing.memory_limit_bytes = 64 << 20;
  expect_refusal([&] { run_worker(writing); }, ErrorCode::resource, {"File too large"});
  expect_refusal([] { run_worker(request("open-without-end")); }, ErrorCode::resource,
                 {"Too many open files after fewer"});
}

TEST_F(Worker, that_loses_bytes_of_a_file_says_so) {
  expect_refusal([] { run_worker(request("lose-bytes")); }, ErrorCode::invalid,
                 {"signal 7 (Bus error)", "reading bone.vtu", "bytes of a file that it had mapped were gone"});
}

/// An answer is checked once, when it is opened: nothing may change it afterwards.
TEST_F(Worker, hands_over_an_answer_that_nobody_can_change) {
  const formats::PackedFile answer = run_worker(request("limits"));
  bool found = false;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (std::filesystem::read_symlink(entry.path(), gone).string().find("rhoray-output") == std::string::npos) continue;
    found = true;
    EXPECT_LT(::truncate(entry.path().c_str(), 0), 0);
    EXPECT_EQ(errno, EPERM);
  }
  EXPECT_TRUE(found);
}

TEST_F(Worker, tells_its_progress) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> told;
  WorkerRequest working = request("progress");
  working.progress = [&](std::uint64_t done, std::uint64_t total) { told.emplace_back(done, total); };
  run_worker(working);
  EXPECT_THAT(told, testing::ElementsAre(testing::Pair(3, 8), testing::Pair(8, 8)));
}

TEST_F(Worker, is_ended_when_its_progress_is_stopped) {
  struct Stopped {};
  WorkerRequest working = request("progress-and-sleep");
  working.progress = [](std::uint64_t, std::uint64_t) { throw Stopped(); };
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THROW(run_worker(working), Stopped);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST_F(Worker, lies_in_the_scratch_folder_and_keeps_to_anonymous_memory) {
  if (tests::sanitized) GTEST_SKIP() << tests::no_limits_of_memory;
  const tests::TemporaryFolder folder;
  WorkerRequest square = request("square");
  square.scratch_folder = folder.path();
  square.write_input = [](int descriptor) { write_numbers(descriptor, {7}); };
  EXPECT_EQ(run_worker(square).array<std::uint64_t>("numbers", {1})[0], 49U);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));

  WorkerRequest large = request("large-array");  // 256 MiB
  large.memory_limit_bytes = 64 << 20;
  expect_refusal([&] { run_worker(large); }, ErrorCode::resource, {"out of memory"});
  large.scratch_folder = folder.path();
  EXPECT_EQ(run_worker(large).array<std::uint64_t>("numbers", {1})[0], 256U << 20);
  WorkerRequest devour = request("devour");
  devour.memory_limit_bytes = 64 << 20;
  devour.scratch_folder = folder.path();
  expect_refusal([&] { run_worker(devour); }, ErrorCode::resource, {"out of memory"});
}

TEST_F(Worker, may_complain_without_end) {
  expect_refusal([] { run_worker(request("chatter")); }, ErrorCode::invalid, {"the last word"});
}

TEST_F(Worker, is_reported_when_it_breaks_its_promise) {
  expect_refusal([] { run_worker(request("exit-99")); }, ErrorCode::internal, {"code 99 while reading bone.vtu"});
  expect_refusal([] { run_worker(request("nothing")); }, ErrorCode::internal, {"reading bone.vtu", "handed over"});
}

TEST_F(Worker, is_looked_for_where_it_should_be) {
  WorkerRequest missing = request("square");
  missing.program = "rhoray-no-such-worker";
  expect_refusal([&] { run_worker(missing); }, ErrorCode::unsupported, {RHORAY_WORKERS, "rhoray-no-such-worker"});
}

TEST_F(Worker, does_not_inherit_our_open_files) {
  tests::TemporaryFolder folder;
  tests::write_file(folder / "secret", "x");
  const std::uint64_t before = run_worker(request("count-descriptors")).array<std::uint64_t>("numbers", {1})[0];
  WorkerRequest again = request("count-descriptors");
  again.write_input = [](int descriptor) { write_numbers(descriptor, {1}); };
  EXPECT_EQ(run_worker(again).array<std::uint64_t>("numbers", {1})[0], before + 1);
}

/// The child of a process that dies dies with it: no reader is left behind after Ctrl-C.
TEST_F(Worker, dies_with_its_parent) {
  int pipe_ends[2];
  ASSERT_EQ(::pipe(pipe_ends), 0);
  const pid_t parent = ::fork();
  ASSERT_GE(parent, 0);
  if (parent == 0) {  // the pipe's writing end passes on to the worker, which sleeps for a minute
    ::close(pipe_ends[0]);
    try {
      run_worker(request("sleep"));
    } catch (const Error&) {
    }
    ::_exit(0);
  }
  ::close(pipe_ends[1]);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto start = std::chrono::steady_clock::now();
  ::kill(parent, SIGKILL);
  ::waitpid(parent, nullptr, 0);
  char byte;
  EXPECT_EQ(::read(pipe_ends[0], &byte, 1), 0);  // ends once the last holder of the other end is gone
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  ::close(pipe_ends[0]);
}

}  // namespace
}  // namespace rhoray::preprocess
