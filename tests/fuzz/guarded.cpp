#include "tests/fuzz/guarded.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define RHORAY_ADDRESS_SANITIZER
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define RHORAY_ADDRESS_SANITIZER
#endif

#ifdef RHORAY_ADDRESS_SANITIZER
extern "C" void __asan_poison_memory_region(const volatile void* start, std::size_t bytes);
extern "C" void __asan_unpoison_memory_region(const volatile void* start, std::size_t bytes);
#endif

namespace rhoray::tests {

#ifdef RHORAY_ADDRESS_SANITIZER

GuardedPadding::GuardedPadding(const formats::PackedFile& file) : file_(file) {
  if (file.arrays().empty()) return;
  const formats::ArrayEntry& first = file.arrays().front();
  start_ = file.bytes(first.name).data() - first.first_byte;
  // The table of checksums stays readable: damaged_blocks uses it in place, where it is mapped.
  for (std::size_t i = 0; i + 1 < file.arrays().size(); ++i) {
    const formats::ArrayEntry& array = file.arrays()[i];
    const std::uint64_t end = array.first_byte + array.byte_count;
    __asan_poison_memory_region(start_ + end, file.arrays()[i + 1].first_byte - end);
  }
}

GuardedPadding::~GuardedPadding() {
  if (start_ != nullptr) __asan_unpoison_memory_region(start_, file_.file_bytes());
}

#else

GuardedPadding::GuardedPadding(const formats::PackedFile& file) : file_(file) {}
GuardedPadding::~GuardedPadding() = default;

#endif

}  // namespace rhoray::tests
