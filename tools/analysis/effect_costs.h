#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "render/resolved_scene.h"

namespace rhoray::tools {

/// A scene without one of the effects that it uses.
struct WithoutEffect {
  std::string_view effect;  ///< as in "antialiasing"
  render::ResolvedScene plan;
};

/// For each effect that a scene uses and that can be left out, the scene without it. The cost of an
/// effect is the time that the picture without it saves. It can be negative: clipping removes work.
std::vector<WithoutEffect> without_each_effect(const render::ResolvedScene& plan);

/// Milliseconds that each effect of a scene costs. The caller traces the pictures and tells how
/// long each took: the whole picture and the pictures without one effect, in turns, each twice. The
/// smaller time counts, because other work on the machine only adds to it.
class EffectTimes {
 public:
  struct Cost {
    std::string_view effect;
    double ms;
  };

  explicit EffectTimes(const render::ResolvedScene& plan);

  bool is_done() const { return next_ == turns * variants_.size(); }
  render::ResolvedScene& next() { return variants_[next_ % variants_.size()].plan; }  ///< to be traced
  void took(double ms);                                                               ///< the last `next`
  double whole_ms() const { return least_ms_[0]; }
  std::vector<Cost> costs() const;

 private:
  static constexpr std::size_t turns = 2;

  std::vector<WithoutEffect> variants_;  ///< the whole picture first
  std::vector<double> least_ms_;
  std::size_t next_ = 0;
};

}  // namespace rhoray::tools
