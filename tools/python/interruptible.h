#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <utility>

namespace rhoray::python {

/// Calls act(stop token) on another thread, without the GIL, and heeds Ctrl+C meanwhile: signals
/// are looked at every 50 ms. What act throws is rethrown here.
template <class Act>
void run_interruptible(const Act& act) {
  std::stop_source stop;
  std::exception_ptr failure;
  std::optional<pybind11::error_already_set> interrupt;
  {
    const pybind11::gil_scoped_release release;
    std::mutex guard;
    std::condition_variable ended;
    bool has_ended = false;
    const std::jthread worker([&] {
      try {
        act(stop.get_token());
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(guard);
      has_ended = true;
      ended.notify_one();
    });
    std::unique_lock lock(guard);
    while (!ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return has_ended; })) {
      if (interrupt) continue;
      lock.unlock();  // the worker may need the GIL, for a callback, before it can end
      {
        const pybind11::gil_scoped_acquire acquire;
        if (PyErr_CheckSignals() != 0) interrupt.emplace();
      }
      if (interrupt) stop.request_stop();
      lock.lock();
    }
  }
  if (interrupt) throw std::move(*interrupt);
  if (failure) std::rethrow_exception(failure);
}

/// The same, and returns what act returns.
template <class Act>
auto interruptible(const Act& act) {
  using Result = std::invoke_result_t<const Act&, std::stop_token>;
  if constexpr (std::is_void_v<Result>) {
    run_interruptible(act);
  } else {
    std::optional<Result> result;
    run_interruptible([&](const std::stop_token& stop) { result.emplace(act(stop)); });
    return *std::move(result);
  }
}

}  // namespace rhoray::python
