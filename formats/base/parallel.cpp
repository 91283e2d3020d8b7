#include "formats/base/parallel.h"

#include <sched.h>

#include <atomic>
#include <forward_list>
#include <mutex>

namespace rhoray {
namespace {

std::atomic<unsigned> chosen_limit{0};  ///< 0 = available_cores()
/// threads that loops currently use beside their callers' own
std::atomic<unsigned> threads_lent{0};

/// The right to start one more thread, or nothing when the limit is reached.
class Lent {
 public:
  Lent() {
    unsigned lent = threads_lent.load(std::memory_order_relaxed);
    while (lent + 1 < thread_limit() && !is_there_)
      is_there_ = threads_lent.compare_exchange_weak(lent, lent + 1, std::memory_order_relaxed);
  }
  ~Lent() {
    if (is_there_) threads_lent.fetch_sub(1, std::memory_order_relaxed);
  }
  Lent(Lent&& other) noexcept : is_there_(std::exchange(other.is_there_, false)) {}
  Lent& operator=(Lent&&) = delete;

  explicit operator bool() const { return is_there_; }

 private:
  bool is_there_ = false;
};

/// The exception of the lowest failing piece.
class LowestFailure {
 public:
  void keep(std::size_t piece) {
    const std::lock_guard lock(mutex_);
    if (failure_ && piece_ < piece) return;
    failure_ = std::current_exception();
    piece_ = piece;
  }
  void throw_it() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr failure_;
  std::size_t piece_ = 0;
};

/// A thread of a loop. The destructor joins it. A thread keeps its stack until it is joined, and a
/// recursive loop joins its thread only after the deeper calls. Each new thread therefore first
/// joins the threads whose work has ended, and the system reuses their stacks.
class Helper {
 public:
  /// Throws if there is no memory for a thread, or the system allows none.
  Helper(Lent lent, std::function<void()> work) {
    const std::lock_guard lock(mutex_);
    join_ended();
    unjoined_.push_back(this);
    try {
      thread_ = std::thread([this, lent = std::move(lent), work = std::move(work)] {
        work();
        has_ended_ = true;  // before `lent` allows the next thread
      });
    } catch (...) {
      unjoined_.pop_back();
      throw;
    }
  }
  ~Helper() {
    {
      const std::lock_guard lock(mutex_);
      if (std::erase(unjoined_, this) == 0) return;  // another thread has joined it
    }
    thread_.join();
  }
  Helper(const Helper&) = delete;
  Helper& operator=(const Helper&) = delete;

 private:
  static void join_ended() {
    std::erase_if(unjoined_, [](Helper* helper) {
      if (!helper->has_ended_) return false;
      helper->thread_.join();
      return true;
    });
  }

  static inline std::mutex mutex_;
  static inline std::vector<Helper*> unjoined_;  ///< guarded by mutex_

  std::thread thread_;
  std::atomic<bool> has_ended_{false};
};

/// Threads that are joined even if an exception leaves the scope that started them. Each returns
/// its right to run first.
class Threads {
 public:
  /// Runs `work` on another thread and returns true; returns false if the limit or the system
  /// allows none.
  bool start(std::function<void()> work) {
    Lent lent;
    if (!lent) return false;
    try {
      helpers_.emplace_front(std::move(lent), std::move(work));
    } catch (...) {  // no more threads, or no memory for one
      return false;
    }
    return true;
  }

 private:
  std::forward_list<Helper> helpers_;
};

}  // namespace

unsigned available_cores() {
  static const unsigned cores = [] {
    cpu_set_t allowed;
    const int count = ::sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed) : 0;
    return count > 0 ? static_cast<unsigned>(count) : std::max(1U, std::thread::hardware_concurrency());
  }();
  return cores;
}

unsigned thread_limit() {
  const unsigned limit = chosen_limit.load(std::memory_order_relaxed);
  return limit != 0 ? limit : available_cores();
}

ThreadLimit::ThreadLimit(unsigned threads) : before_(chosen_limit.exchange(threads)) {}

ThreadLimit::~ThreadLimit() {
  chosen_limit.store(before_);
}

namespace parallel_details {

void run_pieces(std::size_t count, unsigned threads,
                const std::function<void(std::size_t piece, unsigned worker)>& run) {
  std::atomic<std::size_t> next{0};
  LowestFailure failure;
  const auto work = [&](unsigned worker) {
    for (std::size_t piece; (piece = next.fetch_add(1, std::memory_order_relaxed)) < count;) {
      try {
        run(piece, worker);
      } catch (...) {
        failure.keep(piece);
        next.store(count, std::memory_order_relaxed);
      }
    }
  };
  {
    Threads others;
    const unsigned allowed = threads != 0 ? std::min(threads, thread_limit()) : thread_limit();
    const std::size_t most = std::min<std::size_t>(count, allowed);
    for (unsigned worker = 1; worker < most && next.load(std::memory_order_relaxed) < count; ++worker)
      if (!others.start([&work, worker] { work(worker); })) break;
    work(0);
  }
  failure.throw_it();
}

void run_both(const std::function<void()>& first, const std::function<void()>& second) {
  LowestFailure failure;
  const auto run = [&](std::size_t which) {
    try {
      (which == 0 ? first : second)();
    } catch (...) {
      failure.keep(which);
    }
  };
  {
    Threads other;
    const bool is_shared = other.start([&run] { run(1); });
    run(0);
    if (!is_shared) run(1);
  }
  failure.throw_it();
}

}  // namespace parallel_details
}  // namespace rhoray
