#pragma once

#include <hwy/detect_targets.h>

/// The body of a function that returns a kernel: what `__VA_ARGS__` stands for in the namespace
/// that was compiled for a machine. The baseline is the best that this processor has below AVX2.
/// For sources that are compiled once per machine, in their part that is compiled once.
#define RHORAY_RETURN_ON(machine, ...)   \
  RHORAY_IF_AVX512(machine, __VA_ARGS__) \
  RHORAY_IF_AVX2(machine, __VA_ARGS__)   \
  RHORAY_IF_SSE4(__VA_ARGS__)            \
  static_cast<void>(machine);            \
  return HWY_NAMESPACE::__VA_ARGS__

#if HWY_TARGETS & HWY_AVX3
#define RHORAY_IF_AVX512(machine, ...) \
  if (machine == Machine::avx512) return N_AVX3::__VA_ARGS__;
#else
#define RHORAY_IF_AVX512(machine, ...)
#endif
#if HWY_TARGETS & HWY_AVX2
#define RHORAY_IF_AVX2(machine, ...) \
  if (machine == Machine::avx2) return N_AVX2::__VA_ARGS__;
#else
#define RHORAY_IF_AVX2(machine, ...)
#endif
#if HWY_TARGETS & HWY_SSE4
#define RHORAY_IF_SSE4(...) \
  if (__builtin_cpu_supports("sse4.2")) return N_SSE4::__VA_ARGS__;
#else
#define RHORAY_IF_SSE4(...)
#endif
