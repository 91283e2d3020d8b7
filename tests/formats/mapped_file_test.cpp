#include "formats/base/mapped_file.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "formats/base/pending_file.h"
#include "formats/intact.h"
#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"
#include "tests/support/temporary_folder.h"

namespace rhoray {
namespace {

using tests::expect_error;
using tests::MemoryFile;

constexpr std::uint64_t page = 4096;

extern "C" void replace_or_die(int, siginfo_t* fault, void*) {
  if (!replace_lost_bytes(fault->si_addr)) ::_exit(99);
}

/// Like a program: the handler is installed for one test.
class LostBytes : public testing::Test {
 protected:
  LostBytes() {
    struct sigaction action {};
    action.sa_sigaction = replace_or_die;
    action.sa_flags = SA_SIGINFO;
    ::sigaction(SIGBUS, &action, &before_);
  }
  ~LostBytes() override { ::sigaction(SIGBUS, &before_, nullptr); }

 private:
  struct sigaction before_ {};
};

std::uint64_t sum(std::span<const std::byte> bytes) {
  std::uint64_t total = 0;
  for (const std::byte byte : bytes) total += std::to_integer<std::uint64_t>(byte);
  return total;
}

TEST_F(LostBytes, are_zeros_from_the_page_on_and_the_file_counts_as_damaged) {
  const MemoryFile file(std::string(8 * page, '\1'));
  const MappedFile mapped(file.descriptor(), 8 * page, "grid.rho");
  EXPECT_EQ(sum(mapped.bytes()), 8 * page);
  EXPECT_NO_THROW(mapped.require_intact());
  file.resize(3 * page);
  EXPECT_FALSE(mapped.is_damaged());
  EXPECT_EQ(sum(mapped.bytes()), 3 * page);
  EXPECT_TRUE(mapped.is_damaged());
  EXPECT_TRUE(any_bytes_lost());
  expect_error(ErrorCode::invalid, "grid.rho: lost bytes while it was read", [&] { mapped.require_intact(); });
  expect_error(ErrorCode::invalid, "grid.rho", [&] { MappedFile::require_intact(mapped.bytes().data() + 5); });
  EXPECT_NO_THROW(require_no_lost_bytes()) << "it was told of before";
}

// The system raises a signal for whole pages only; after the end of file inside a page it reads
// zeros. A file that was cut there was once packed with these zeros and exit code 0.
TEST_F(LostBytes, inside_the_last_page_are_known_by_the_size_of_the_file) {
  const MemoryFile file(std::string(2 * page, '\1')), other(std::string(2 * page, '\1'));
  const MappedFile mapped(file.descriptor(), 2 * page, "short.raw"), told(other.descriptor(), 2 * page, "told.raw");
  file.resize(2 * page - 1);
  other.resize(page + 1);
  EXPECT_EQ(sum(mapped.bytes()), 2 * page - 1);
  expect_error(ErrorCode::invalid, "told.raw: lost bytes", [&] { told.require_intact(); });
  expect_error(ErrorCode::invalid, "short.raw: lost bytes", [] { require_no_lost_bytes(); });
  EXPECT_NO_THROW(require_no_lost_bytes());
}

TEST_F(LostBytes, of_one_file_do_not_damage_another) {
  const MemoryFile file(std::string(2 * page, '\1')), other(std::string(page + 1, '\1'));
  const MappedFile mapped(file.descriptor(), 2 * page, "a"), sound(other.descriptor(), page + 1, "b");
  file.resize(0);
  EXPECT_EQ(sum(mapped.bytes()) + sum(sound.bytes()), page + 1);
  EXPECT_NO_THROW(sound.require_intact());
  EXPECT_NO_THROW(MappedFile::require_intact(sound.bytes().data()));
  expect_error(ErrorCode::invalid, "a: lost bytes", [&] { mapped.require_intact(); });
}

TEST_F(LostBytes, are_told_of_once_and_also_after_the_mapping_is_gone) {
  const MemoryFile file(std::string(page, '\1'));
  std::optional<MappedFile> mapped;
  mapped.emplace(file.descriptor(), page, "gone.nrrd");
  file.resize(0);
  EXPECT_EQ(sum(mapped->bytes()), 0U);
  mapped.reset();
  // may get the same address
  const MappedFile next(MemoryFile(std::string(page, '\1')).descriptor(), page, "next");
  EXPECT_NO_THROW(next.require_intact());
  expect_error(ErrorCode::invalid, "gone.nrrd: lost bytes", [] { require_no_lost_bytes(); });
  EXPECT_NO_THROW(require_no_lost_bytes());
}

/// Results computed from lost bytes are never published.
TEST_F(LostBytes, keep_a_pending_file_from_being_published) {
  const tests::TemporaryFolder folder;
  const MemoryFile file(std::string(page, '\1'));
  const MappedFile mapped(file.descriptor(), page, "input.raw");
  PendingFile output(folder / "output", {});
  file.resize(0);
  EXPECT_EQ(sum(mapped.bytes()), 0U);
  expect_error(ErrorCode::invalid, "input.raw", [&] { output.publish(); });
  EXPECT_FALSE(std::filesystem::exists(folder / "output"));
}

TEST_F(LostBytes, are_replaced_for_many_threads_at_once) {
  constexpr std::uint64_t pages = 64;
  for (int round = 0; round < 20; ++round) {
    const MemoryFile file(std::string(pages * page, '\1'));
    const MappedFile mapped(file.descriptor(), pages * page, "a");
    std::atomic<bool> go{false};
    std::vector<std::thread> readers;
    for (std::uint64_t first = 0; first < 8; ++first)
      readers.emplace_back([&, first] {
        while (!go) {
        }
        for (std::uint64_t p = 0; p < pages; ++p)
          EXPECT_LE(sum(mapped.bytes().subspan((p * 13 + first * 7) % pages * page, page)), page);
        // Other files are mapped and unmapped while handlers walk the list.
        for (int i = 0; i < 20; ++i) const MappedFile passing(file.descriptor(), page, "passing");
      });
    go = true;
    file.resize(0);
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(sum(mapped.bytes()), 0U);
    expect_error(ErrorCode::invalid, "a: lost bytes", [&] { mapped.require_intact(); });
  }
}

/// Only bytes of registered files are replaced.
TEST_F(LostBytes, elsewhere_are_nobodys) {
  EXPECT_FALSE(replace_lost_bytes(nullptr));
  EXPECT_FALSE(replace_lost_bytes(&page));
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const MemoryFile file(std::string(page, '\1'));
    const volatile char* bytes =
        static_cast<const char*>(::mmap(nullptr, page, PROT_READ, MAP_SHARED, file.descriptor(), 0));
    file.resize(0);
    ::_exit(bytes[0]);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 99) << status;
}

TEST_F(LostBytes, of_a_packed_file_are_refused) {
  const MemoryFile memory;
  std::vector<std::uint8_t> values(100 * page, 7);
  formats::PackedFileWriter writer(memory.descriptor(), {.kind = "neutral-test"},
                                   {{.name = "a", .type = formats::ElementType::U8, .shape = {values.size()}}});
  writer.write_all("a", std::span<const std::uint8_t>(values));
  writer.commit();
  const formats::PackedFile file = formats::PackedFile::from_descriptor(memory.descriptor(), "small.rho");
  const std::span<const std::byte> bytes = file.bytes("a");
  EXPECT_EQ(sum(bytes), 7 * values.size());
  EXPECT_NO_THROW(formats::require_intact(file));
  memory.resize(50 * page);
  EXPECT_LT(sum(bytes), 7 * values.size());
  expect_error(ErrorCode::invalid, "small.rho: lost bytes", [&] { formats::require_intact(file); });
}

}  // namespace
}  // namespace rhoray
