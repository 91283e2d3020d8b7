#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace rhoray::render {

/// Keeps the memory of dropped arrays for new ones. While a user drags an isovalue, every picture
/// needs arrays of about the same sizes, and the system would clear new pages for each of them: on
/// two cores, preparing an isovalue of a million tetrahedra took 16 ms without a pool and 4 to 7 ms
/// with one. Any thread may call.
class ArrayPool {
 public:
  struct Memory {
    std::byte* first = nullptr;
    std::size_t bytes = 0;
  };
  static constexpr std::align_val_t alignment{64};

  static Memory allocated(std::size_t bytes) {
    return {static_cast<std::byte*>(::operator new(bytes, alignment)), bytes};
  }
  static void release(const Memory& memory) noexcept { ::operator delete(memory.first, alignment); }

  ArrayPool() { unused_.reserve(most_unused + 1); }
  ArrayPool(const ArrayPool&) = delete;
  ArrayPool& operator=(const ArrayPool&) = delete;
  ~ArrayPool() {
    for (const Memory& memory : unused_) release(memory);
  }

  /// Returns the smallest unused memory of at least `bytes` and at most twice as many, or new
  /// memory.
  Memory take(std::size_t bytes) {
    {
      const std::lock_guard lock(mutex_);
      auto best = unused_.end();
      for (auto it = unused_.begin(); it != unused_.end(); ++it)
        if (it->bytes >= bytes && it->bytes / 2 <= bytes && (best == unused_.end() || it->bytes < best->bytes))
          best = it;
      if (best != unused_.end()) {
        const Memory found = *best;
        unused_.erase(best);
        return found;
      }
    }
    return allocated(bytes + bytes / 8);  // the next array may be a little larger
  }

  void give_back(const Memory& memory) noexcept {
    const std::lock_guard lock(mutex_);
    unused_.push_back(memory);
    if (unused_.size() <= most_unused) return;
    release(unused_.front());
    unused_.erase(unused_.begin());
  }

  std::size_t unused_bytes() {
    const std::lock_guard lock(mutex_);
    std::size_t bytes = 0;
    for (const Memory& memory : unused_) bytes += memory.bytes;
    return bytes;
  }

 private:
  /// The arrays of one isovalue: blocks and fields of facets, and three lists of cells (20 bytes
  /// per facet), which stay here while the facets are in use.
  static constexpr std::size_t most_unused = 5;

  std::mutex mutex_;
  std::vector<Memory> unused_;  ///< oldest first
};

/// An array with memory of a pool, or of its own without a pool. Its elements are not initialized.
template <class T>
class PooledArray {
  static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= static_cast<std::size_t>(ArrayPool::alignment));

 public:
  PooledArray() = default;
  PooledArray(std::shared_ptr<ArrayPool> pool, std::size_t size)
      : pool_(std::move(pool)),
        memory_(pool_ ? pool_->take(size * sizeof(T)) : ArrayPool::allocated(size * sizeof(T))),
        size_(size) {}
  PooledArray(PooledArray&& other) noexcept { *this = std::move(other); }
  PooledArray& operator=(PooledArray&& other) noexcept {
    std::swap(pool_, other.pool_);
    std::swap(memory_, other.memory_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~PooledArray() {
    if (pool_)
      pool_->give_back(memory_);
    else
      ArrayPool::release(memory_);
  }

  std::size_t size() const { return size_; }
  T* data() { return reinterpret_cast<T*>(memory_.first); }
  const T* data() const { return reinterpret_cast<const T*>(memory_.first); }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  std::span<const T> subspan(std::size_t first, std::size_t count) const { return {data() + first, count}; }

 private:
  std::shared_ptr<ArrayPool> pool_{};
  ArrayPool::Memory memory_{};
  std::size_t size_ = 0;
};

}  // namespace rhoray::render
