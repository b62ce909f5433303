// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>

namespace slipstack::workbench {

// Loops compiled three times: for vectors of 2, of 4 and of 8 doubles, of which the widest that this machine
// has is run. Products and sums are neither contracted nor reordered (CMakeLists.txt), so the results are the
// same, bit for bit, on every machine.

#if defined(__x86_64__)
template <class Work>
[[gnu::target("avx2"), gnu::flatten]] void run_by_4(Work& work) {
  work();
}
template <class Work>
[[gnu::target("avx2,avx512f,avx512dq,avx512vl"), gnu::flatten]] void run_by_8(Work& work) {
  work();
}
inline int widest_vector() {
  if (__builtin_cpu_supports("avx2") == 0) return 2;
  const bool eight = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                     __builtin_cpu_supports("avx512vl") != 0;
  return eight ? 8 : 4;
}
#endif

/// Calls `work` compiled for the widest vectors of this machine. What it calls must be known to the compiler.
template <class Work>
void run_wide(Work&& work) {
#if defined(__x86_64__)
  static const int kWidest = widest_vector();
  if (kWidest == 8) return run_by_8(work);
  if (kWidest == 4) return run_by_4(work);
#endif
  work();
}

/// Four doubles that the compiler adds and multiplies together: in one vector, or in two where vectors are of
/// two.
using FourDoubles [[gnu::vector_size(32)]] = double;

/// Loads four doubles, which need not be aligned.
[[gnu::always_inline]] inline void load(FourDoubles& four, const double* from) {
  std::memcpy(&four, from, sizeof(four));
}

/// The sum of `length` products, for use within run_wide(). Sixteen partial sums, since each addition waits
/// for the one before it.
[[gnu::always_inline]] inline double dot_product(const double* one, const double* other, std::size_t length) {
  FourDoubles partial[4] = {};
  std::size_t k = 0;
  for (; k + 16 <= length; k += 16) {
    for (std::size_t p = 0; p < 4; ++p) {
      FourDoubles factor, value;
      load(factor, one + k + 4 * p);
      load(value, other + k + 4 * p);
      partial[p] += factor * value;
    }
  }
  const FourDoubles four = (partial[0] + partial[1]) + (partial[2] + partial[3]);
  double sum = (four[0] + four[1]) + (four[2] + four[3]);
  for (; k < length; ++k) sum += one[k] * other[k];
  return sum;
}

}  // namespace slipstack::workbench
