// SPDX-License-Identifier: Apache-2.0
// Image for the emulator: instructions per call of each observer, over adversarial and random motion.
//
// Counted is what runs from the first instruction of the function to its return, both included, for a call
// that is not inlined: SysTick around the call, less the same around a function that consists of its return
// only. A function of known length is measured first; if that comes out wrong (no -icount shift=10), the
// image ends with status 1.
//
// A word on the command line measures that observer alone, a number behind it so many random steps.
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "hal/mps2/semihosting.h"
#include "hal/mps2/systick.h"
#include "hal/mps2/uart.h"
#include "tests/budget/motion.h"
#include "tests/budget/observers.h"

namespace {

using slipstack::budget::kObservers;
using slipstack::budget::Observer;
using slipstack::budget::RandomMotion;
using namespace slipstack::mps2;

using Step = float (*)(std::int32_t);

constexpr std::uint32_t kRandomSteps = 20000;

struct Count {
  std::uint32_t min = 0xFFFFFFFF;
  std::uint32_t max = 0;
  std::uint64_t total = 0;
  std::uint32_t calls = 0;
  std::uint32_t worked = 0;

  void add(std::uint32_t instructions, bool works) {
    worked += works ? 1 : 0;
    min = instructions < min ? instructions : min;
    max = instructions > max ? instructions : max;
    total += instructions;
    ++calls;
  }
};

__attribute__((naked, noinline)) float only_return(std::int32_t) {
  asm volatile("bx lr");
}

__attribute__((naked, noinline)) float hundred_nops_and_return(std::int32_t) {
  asm volatile(".rept 100 \n nop \n .endr \n bx lr");
}

// SysTick counts from before the call to after it. One copy of this code measures every function.
__attribute__((noinline)) std::uint32_t ticks(Step step, std::int32_t x) {
  const std::uint32_t begin = systick_now();
  const float force_N = step(x);
  const std::uint32_t end = systick_now();
  asm volatile("" ::"t"(force_N));
  return systick_elapsed(begin, end);
}

// 25.6 counts are one instruction; only_return is one as well.
std::uint32_t instructions(Step step, std::int32_t x) {
  static const std::uint32_t overhead = ticks(only_return, 0);
  return ((ticks(step, x) - overhead) * 10 + 128) / 256 + 1;
}

std::uint32_t measure_step(const Observer& observer, std::int32_t x) {
  if (observer.before != nullptr) observer.before(x);
  return instructions(observer.step, x);
}

void measure(const Observer& observer, std::int32_t x, Count& count) {
  const std::uint32_t taken = measure_step(observer, x);
  count.add(taken, observer.works == nullptr || observer.works());
}

void print(const char* name, const char* input, const Count& count) {
  const auto mean_hundredths = static_cast<std::uint32_t>(count.total * 100 / count.calls);
  uart_write("instructions ");
  uart_write(name);
  uart_write(" ");
  uart_write(input);
  uart_write(" ");
  uart_write_unsigned(count.min);
  uart_write(" ");
  uart_write_unsigned(mean_hundredths / 100);
  uart_write(mean_hundredths % 100 < 10 ? ".0" : ".");
  uart_write_unsigned(mean_hundredths % 100);
  uart_write(" ");
  uart_write_unsigned(count.max);
  uart_write(" ");
  uart_write_unsigned(count.calls);
  uart_write(" ");
  uart_write_unsigned(count.worked);
  uart_write("\n");
}

// For every number of loops held and closed: spiral in by `reversals`, then one step out that closes `closed`
// loops, with and without a reversal in that same step, on both sides; and rest, virgin motion, and a full
// stack.
Count measure_adversarial(const Observer& observer) {
  Count count;
  const auto go = [&](std::int32_t x) { measure(observer, x, count); };
  for (std::int32_t side = -1; side <= 1; side += 2) {
    for (std::int32_t reversals = 0; reversals <= 20; ++reversals) {
      for (std::int32_t closed = 0; closed <= 11; ++closed) {
        for (std::int32_t turn = 0; turn <= 1; ++turn) {
          observer.reset(0);
          go(0);
          std::int32_t x = 0;
          for (std::int32_t i = 0; i < reversals; ++i) {
            x = (i % 2 == 0 ? side : -side) * (1000 - 40 * i);
            go(x);
          }
          const std::int32_t inward = x > 0 ? -1 : 1;
          go(x + 2 * inward);
          const std::int32_t direction = turn == 0 ? inward : -inward;
          go(direction * (1000 - 40 * (reversals - 2 * closed)) + direction * 5);
        }
      }
    }
  }
  return count;
}

Count measure_random(const Observer& observer, std::uint32_t steps) {
  Count count;
  RandomMotion motion(0x5EED1234);
  observer.reset(0);
  for (std::uint32_t i = 0; i < steps; ++i) measure(observer, motion.next(), count);
  return count;
}

}  // namespace

int main() {
  systick_start_free();
  const std::uint32_t known = instructions(hundred_nops_and_return, 0);
  if (known != 101) {
    uart_write("calibration: 101 instructions measure as ");
    uart_write_unsigned(known);
    uart_write("; start the emulator with -icount shift=10\n");
    return 1;
  }
  if (!slipstack::budget::set_up_observers()) {
    uart_write("an observer refuses its parameters\n");
    return 1;
  }
  char buffer[128];
  static_cast<void>(command_line(buffer));
  char* const wanted = std::strchr(buffer, ' ');
  std::uint32_t steps = kRandomSteps;
  if (wanted != nullptr) {
    if (char* const number = std::strchr(wanted + 1, ' ')) {
      *number = '\0';
      steps = static_cast<std::uint32_t>(std::strtoul(number + 1, nullptr, 10));
    }
  }
  for (const Observer& observer : kObservers) {
    if (wanted != nullptr && std::strcmp(wanted + 1, observer.name) != 0) continue;
    if (steps == kRandomSteps) print(observer.name, "adversarial", measure_adversarial(observer));
    print(observer.name, "random", measure_random(observer, steps));
  }
  return 0;
}
