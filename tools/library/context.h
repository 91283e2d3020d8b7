#pragma once

#include <sys/types.h>

#include <atomic>
#include <memory>

#include "render/render.h"
#include "rhoray/context.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

class RenderContext::Implementation {
 public:
  explicit Implementation(const ContextOptions& options);

  /// Calls act(render::RenderContext&), as `guarded` does. Refuses a second call meanwhile, a
  /// forked process, and every call after a defect of the library was found.
  template <class Act>
  decltype(auto) call(Act&& act) {
    begin();
    const End end{*this};
    try {
      return inside::guarded([&] { return act(*context_); });
    } catch (const v0_1::Error& error) {
      if (error.code() == v0_1::ErrorCode::internal) is_broken_ = true;
      throw;
    }
  }

  /// Frees the memory that is kept between calls.
  void trim();

  unsigned threads() const { return threads_; }
  render::Machine machine() const { return machine_; }

  render::Framebuffer whole;  ///< of a picture of which a window is rendered

 private:
  struct End {
    Implementation& context;
    ~End() { context.is_busy_.clear(); }
  };
  void begin();

  unsigned threads_;
  render::Machine machine_;
  pid_t process_;
  render::Arena arena_;
  std::unique_ptr<render::RenderContext> context_;
  std::atomic_flag is_busy_;
  bool is_broken_ = false;
};

}  // namespace rhoray::v0_1
