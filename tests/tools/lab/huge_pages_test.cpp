#include "tools/lab/huge_pages.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

TEST(HugePages, take_a_mappings_place_without_changing_a_byte) {
  constexpr std::size_t size = (std::size_t{5} << 20) + 4096;
  std::string content(size, '\0');
  for (std::size_t i = 0; i < size; ++i) content[i] = static_cast<char>(i * 7 + i / 4096);
  const TemporaryFolder folder;
  write_file(folder / "data", content);
  const int file = ::open((folder / "data").c_str(), O_RDONLY);
  ASSERT_GE(file, 0);
  void* const mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
  ASSERT_NE(mapped, MAP_FAILED);
  ::close(file);
  const std::span bytes(static_cast<const std::byte*>(mapped), size);
  const std::size_t huge = study::move_to_huge_pages(bytes.subspan(4321, 99));
  EXPECT_EQ(huge % (2 << 20), 0U);
  EXPECT_LE(huge, size);
  EXPECT_TRUE(std::memcmp(mapped, content.data(), size) == 0);
  // The memory no longer belongs to the file: later writes to the file have no effect on it.
  std::fstream(folder / "data", std::ios::in | std::ios::out | std::ios::binary) << "other";
  EXPECT_TRUE(std::memcmp(mapped, content.data(), size) == 0);
  EXPECT_EQ(::munmap(mapped, size), 0);
}

}  // namespace
}  // namespace rhoray::tests
