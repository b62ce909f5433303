// SPDX-License-Identifier: Apache-2.0
// An image that uses the heap, and therefore must not link (check_no_heap.py).
#include <cstdlib>
#include <new>

namespace {
volatile std::size_t wanted = 16;
}

int main() {
#if defined(HEAP_PROBE_MALLOC)
  void* volatile memory = std::malloc(wanted);
#else
  void* volatile memory = ::operator new(wanted, std::nothrow);
#endif
  return memory == nullptr ? 1 : 0;
}
