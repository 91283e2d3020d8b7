#pragma once

#include "render/method.h"
#include "render/query/machine.h"

/// What the choices of SIMD kernels have in common.
namespace rhoray::render::wide {

/// True for the methods by which SIMD kernels find first crossings.
inline bool has_wide_crossings(const Method& method) {
  const bool is_float =
      method.precision == Method::Precision::float32 &&
      (method.algorithm == Method::Algorithm::direct || method.algorithm == Method::Algorithm::preview);
  return is_float || method.algorithm == Method::Algorithm::certified;
}

/// The result of kernel_of.operator()<machine>(), a pointer; null for `scalar`, which has no SIMD
/// kernels.
template <class KernelOf>
auto kernel_on(Machine machine, const KernelOf& kernel_of)
    -> decltype(kernel_of.template operator()<Machine::baseline>()) {
  switch (machine) {
    case Machine::scalar:
      break;
    case Machine::baseline:
      return kernel_of.template operator()<Machine::baseline>();
    case Machine::avx2:
      return kernel_of.template operator()<Machine::avx2>();
    case Machine::avx512:
      return kernel_of.template operator()<Machine::avx512>();
  }
  return nullptr;
}

}  // namespace rhoray::render::wide
