#pragma once

#include <array>
#include <cfenv>
#include <span>

namespace rhoray::tests {

/// A floating-point environment that a host program, or a library in it, may have set for its
/// threads.
struct HostFloatingPoint {
  const char* name;
  int rounding = FE_TONEAREST;
  bool flushes_results = false;   ///< FTZ: denormal results become zero
  bool flushes_operands = false;  ///< DAZ: denormal operands count as zero
};

/// All environments except the default one.
inline std::span<const HostFloatingPoint> host_environments() {
  static constexpr std::array environments {
#if defined(__x86_64__)
    HostFloatingPoint{.name = "FTZ", .flushes_results = true},
        HostFloatingPoint{.name = "DAZ", .flushes_operands = true},
        HostFloatingPoint{.name = "FTZ and DAZ", .flushes_results = true, .flushes_operands = true},
        HostFloatingPoint{
            .name = "FTZ, DAZ, upward", .rounding = FE_UPWARD, .flushes_results = true, .flushes_operands = true},
#endif
        HostFloatingPoint{.name = "upward", .rounding = FE_UPWARD},
        HostFloatingPoint{.name = "downward", .rounding = FE_DOWNWARD}, HostFloatingPoint {
      .name = "toward zero", .rounding = FE_TOWARDZERO
    }
  };
  return environments;
}

/// Sets an environment for the calling thread while it lives.
class InHostFloatingPoint {
 public:
  explicit InHostFloatingPoint(const HostFloatingPoint& set) : set_(set) {
    std::fegetenv(&before_);
    std::fesetround(set.rounding);
#if defined(__x86_64__)
    constexpr unsigned ftz = 0x8000, daz = 0x0040;
    __builtin_ia32_ldmxcsr((__builtin_ia32_stmxcsr() & ~(ftz | daz)) | (set.flushes_results ? ftz : 0) |
                           (set.flushes_operands ? daz : 0));
#endif
  }
  InHostFloatingPoint(const InHostFloatingPoint&) = delete;
  InHostFloatingPoint& operator=(const InHostFloatingPoint&) = delete;
  ~InHostFloatingPoint() {
    std::fesetenv(&before_);
  }

  /// True if the thread still has this environment.
  bool is_kept() const {
#if defined(__x86_64__)
    const unsigned word = __builtin_ia32_stmxcsr();
    if (((word & 0x8000) != 0) != set_.flushes_results || ((word & 0x0040) != 0) != set_.flushes_operands) return false;
    // nearest, downward, upward, toward zero
    constexpr unsigned of_sse[] = {0x0000, 0x2000, 0x4000, 0x6000};
    const unsigned expected = set_.rounding == FE_TONEAREST  ? of_sse[0]
                              : set_.rounding == FE_DOWNWARD ? of_sse[1]
                              : set_.rounding == FE_UPWARD   ? of_sse[2]
                                                             : of_sse[3];
    if ((word & 0x6000) != expected) return false;
#endif
    return std::fegetround() == set_.rounding;
  }

 private:
  HostFloatingPoint set_;
  std::fenv_t before_;
};

}  // namespace rhoray::tests
