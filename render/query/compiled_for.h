#pragma once

#include <utility>

#include "render/query/machine.h"

/// Plain loops compiled for several machines, for work that gcc vectorises by itself.
///
/// The function is forced inline into one wrapper for each machine (RHORAY_INLINE, and so is
/// everything that its loops call). So no code for one machine can be merged with code for another.
/// Nothing is fused (-ffp-contract=off): where only operations are used that IEEE 754 rounds
/// exactly, every machine computes the same numbers.
namespace rhoray::render {

// gcc keeps to vectors of 256 bits unless told otherwise; clang 14 has no such option.
#if defined(__clang__)
#define RHORAY_TARGET_AVX512 "avx2,fma,bmi2,avx512f,avx512bw,avx512cd,avx512dq,avx512vl"
#else
#define RHORAY_TARGET_AVX512 "avx2,fma,bmi2,avx512f,avx512bw,avx512cd,avx512dq,avx512vl,prefer-vector-width=512"
#endif

namespace compiled {

template <auto function, class... Arguments>
static void plain(Arguments... arguments) {
  function(std::forward<Arguments>(arguments)...);
}

#if defined(__x86_64__)
template <auto function, class... Arguments>
[[gnu::target("avx2,fma,bmi2")]] static void for_avx2(Arguments... arguments) {
  function(std::forward<Arguments>(arguments)...);
}

template <auto function, class... Arguments>
[[gnu::target(RHORAY_TARGET_AVX512)]] static void for_avx512(Arguments... arguments) {
  function(std::forward<Arguments>(arguments)...);
}
#endif

template <auto function, class... Arguments>
constexpr auto choose(void (*)(Arguments...), Machine machine) {
  void (*chosen)(Arguments...) = plain<function, Arguments...>;
#if defined(__x86_64__)
  if (machine == Machine::avx2) chosen = for_avx2<function, Arguments...>;
  if (machine == Machine::avx512) chosen = for_avx512<function, Arguments...>;
#endif
  return chosen;
}

}  // namespace compiled

/// `function`, which must return void, compiled for a machine.
template <auto function>
constexpr auto compiled_for(Machine machine) {
  return compiled::choose<function>(function, machine);
}

}  // namespace rhoray::render
