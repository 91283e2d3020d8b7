#pragma once

#include <cstddef>
#include <filesystem>
#include <memory_resource>

namespace rhoray::preprocess {

/// Memory for large arrays that is stored in a folder. A block of `smallest_block` bytes or more is
/// a mapped file of its own without a name; the system writes out its pages and drops them when it
/// needs their memory. A smaller block comes from the heap. A file's space is freed together with
/// its block. Thread-safe.
///
/// A block that cannot be allocated is an Error (ErrorCode::resource) with the folder and the
/// reason.
class ScratchMemory : public std::pmr::memory_resource {
 public:
  static constexpr std::size_t smallest_block = std::size_t{1} << 20;

  explicit ScratchMemory(std::filesystem::path folder) : folder_(std::move(folder)) {}

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void* block, std::size_t bytes, std::size_t alignment) override;
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::filesystem::path folder_;
};

}  // namespace rhoray::preprocess
