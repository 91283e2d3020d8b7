#include "preprocess/process/limits.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <ctime>
#include <fstream>
#include <memory_resource>
#include <optional>

#include "preprocess/process/child_process.h"
#include "preprocess/process/memory_cap.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace {

// In the place of the C library's, so that they can fail. The thread sanitizer calls them before it
// is ready itself.
#define RHORAY_CALLED_EARLY __attribute__((no_sanitize("thread")))
bool getting_fails = false, setting_fails = false;

}  // namespace

extern "C" RHORAY_CALLED_EARLY int getrlimit(__rlimit_resource_t resource, rlimit* limit) noexcept {
  if (getting_fails) return errno = EPERM, -1;
  return ::prlimit(0, static_cast<__rlimit_resource>(resource), nullptr, limit);
}

extern "C" RHORAY_CALLED_EARLY int setrlimit(__rlimit_resource_t resource, const rlimit* limit) noexcept {
  if (setting_fails) return errno = EPERM, -1;
  return ::prlimit(0, static_cast<__rlimit_resource>(resource), limit, nullptr);
}

namespace rhoray::preprocess {
namespace {

using tests::expect_error;

constexpr std::uint64_t gibibyte = std::uint64_t{1} << 30;

struct Failing {
  explicit Failing(bool& what) : what_(what) { what_ = true; }
  ~Failing() { what_ = false; }
  bool& what_;
};

TEST(Limits, that_the_system_does_not_tell_or_take_are_errors) {
  const tests::TemporaryFolder folder;
  {
    const Failing failing(getting_fails);
    expect_error(ErrorCode::resource, "getrlimit: Operation not permitted",
                 [&] { MemoryCap(std::uint64_t{1} << 30, folder.path()); });
    expect_error(ErrorCode::internal, "RLIMIT_DATA: Operation not permitted", [] { limits_for(WorkerRequest{}); });
  }
  const Failing failing(setting_fails);
  expect_error(ErrorCode::resource, "setrlimit: Operation not permitted",
               [&] { MemoryCap(std::uint64_t{1} << 30, folder.path()); });
  EXPECT_NE(std::pmr::get_default_resource(), nullptr);
  EXPECT_EQ(std::pmr::get_default_resource(), std::pmr::new_delete_resource()) << "half of the cap was set";
}

TEST(Limits, of_memory_grow_with_the_input_up_to_the_machine) {
  constexpr std::uint64_t machine = 100 * gibibyte;
  EXPECT_EQ(default_memory_limit(1, machine), 8 * gibibyte + 1024);
  EXPECT_EQ(default_memory_limit(1 << 20, machine), 9 * gibibyte);
  EXPECT_EQ(default_memory_limit(gibibyte, machine), 90 * gibibyte);
  EXPECT_EQ(default_memory_limit(0, machine), 90 * gibibyte) << "an input whose size is not known";
  EXPECT_EQ(default_memory_limit(~std::uint64_t{0}, machine), 90 * gibibyte);
  EXPECT_EQ(default_memory_limit(1, 5 * gibibyte), 5 * gibibyte / 10 * 9) << "a small machine";
  EXPECT_GE(default_memory_limit(0, ~std::uint64_t{0}), ~std::uint64_t{0} / 2);
}

TEST(Limits, of_memory_are_those_of_the_control_groups_around) {
  const tests::TemporaryFolder root;
  const auto write = [&](const std::string& group, const char* file, const std::string& text) {
    std::filesystem::create_directories(root / group);
    tests::write_file(root / group / file, text);
  };
  write("a/b", "memory.max", "max\n");
  write("a", "memory.max", "5000000\n");
  write("c", "memory.max", "max\n");
  write("memory/job", "memory.limit_in_bytes", "7000000\n");
  write("memory", "memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(group_memory_limit("0::/a/b\n", root.path()), 5'000'000U);
  EXPECT_EQ(group_memory_limit("0::/c\n", root.path()), std::nullopt);
  EXPECT_EQ(group_memory_limit("0::/none\n", root.path()), std::nullopt);
  EXPECT_EQ(group_memory_limit("", root.path()), std::nullopt);
  EXPECT_EQ(group_memory_limit("5:cpu:/a\n4:pids,memory:/job\n0::/c\n", root.path()), 7'000'000U);
  EXPECT_EQ(group_memory_limit("4:memory:/job\n0::/a/b\n", root.path()), 5'000'000U);
  EXPECT_GT(usable_memory_bytes(), std::uint64_t{64} << 20);
}

TEST(Limits, are_as_asked_for_and_never_above_those_of_this_process) {
  WorkerRequest request;
  request.memory_limit_bytes = 3 * gibibyte;
  request.time_limit_s = 1.5;
  WorkerLimits limits = limits_for(request);
  EXPECT_EQ(limits.memory.rlim_cur, 3 * gibibyte);
  ASSERT_TRUE(limits.time);
  EXPECT_EQ(limits.time->rlim_cur, 2U);
  EXPECT_EQ(limits.core.rlim_max, 0U);

  const pid_t child = ::fork();  // a hard limit is never raised again
  if (child == 0) {
    const rlimit low{100, 100};
    ::setrlimit(RLIMIT_NOFILE, &low);
    ::_exit(limits_for(request).open_files.rlim_max == 100 ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST(Activity, of_a_process_is_told_and_of_one_that_is_gone_is_not) {
  const std::optional<Activity> before = activity_of(::getpid());
  ASSERT_TRUE(before);
  std::ifstream("/proc/self/status").get();
  for (const std::clock_t begin = std::clock(); std::clock() - begin < CLOCKS_PER_SEC / 20;) {
  }
  const std::optional<Activity> after = activity_of(::getpid());
  ASSERT_TRUE(after);
  EXPECT_GT(after->computing_ticks, before->computing_ticks);
  EXPECT_GT(after->read_bytes, before->read_bytes);
  EXPECT_EQ(activity_of(0), std::nullopt);
}

/// The watching process was stopped, and with it time: that counts as one look.
TEST(IdleWatch, counts_only_time_in_which_it_looked) {
  const pid_t child = ::fork();
  if (child == 0)
    for (;;) ::pause();
  IdleWatch watch(child, 8), never(child, 0);
  EXPECT_EQ(watch.pause_ms(), 1000);
  EXPECT_EQ(never.pause_ms(), -1);
  while (activity_of(child) != activity_of(child)) {
  }
  EXPECT_FALSE(watch.is_over(1000)) << "the first look";
  EXPECT_FALSE(watch.is_over(1000));
  EXPECT_FALSE(never.is_over(1e9));
  int looks = 2;
  while (looks < 100 && !watch.is_over(1)) ++looks;
  EXPECT_THAT(looks, testing::AllOf(testing::Ge(7), testing::Le(10)));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

}  // namespace
}  // namespace rhoray::preprocess
