#pragma once

#include <algorithm>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "formats/base/stoppable_mutex.h"

namespace rhoray::render {

/// Keeps what was prepared of one dataset for the isovalues used last. Thread-safe; while one
/// thread prepares, others wait.
template <class Prepared>
class LastIsovalues {
 public:
  /// @param prepare  creates it (a shared pointer) where it is not kept; it may use the memory of
  ///   the oldest, which is dropped first
  /// @param stop  ends the waiting for another thread (ErrorCode::interrupted)
  template <class Prepare>
  std::shared_ptr<const Prepared> of(double isovalue, const std::stop_token& stop, const Prepare& prepare) {
    const StoppableLock lock(mutex_, stop);
    const auto found = std::find_if(last_.begin(), last_.end(), [&](const Entry& e) { return e.isovalue == isovalue; });
    if (found != last_.end()) {
      std::rotate(last_.begin(), found, found + 1);
    } else {
      if (last_.size() == kept) last_.pop_back();
      last_.insert(last_.begin(), Entry{isovalue, prepare()});
    }
    return last_.front().prepared;
  }

  /// Sums of(const Prepared&) over all that is kept, and more(). Nothing is prepared meanwhile.
  template <class Of, class More>
  std::size_t sum(const Of& of, const More& more) {
    const StoppableLock lock(mutex_, {});
    std::size_t total = more();
    for (const Entry& entry : last_) total += of(*entry.prepared);
    return total;
  }
  /// Keeps nothing any more. Calls act() before anything else is prepared.
  template <class Act>
  void clear(const Act& act) {
    std::vector<Entry> dropped;  // freed when others may go on
    const StoppableLock lock(mutex_, {});
    dropped.swap(last_);
    act();
  }

 private:
  struct Entry {
    double isovalue;
    std::shared_ptr<const Prepared> prepared;
  };
  static constexpr std::size_t kept = 4;

  StoppableMutex mutex_;
  std::vector<Entry> last_;  ///< newest first
};

}  // namespace rhoray::render
