// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: whatever the frames, times, ticks, bus-offs and power cuts, the CANopen node keeps its
// promises (fuzzed_node.h), boots again on what is in its flash, and answers.
//
// The input is a row of steps; the first byte of each says what it is:
//   00 .. 9F  a frame: identifier, length and flags, data
//   A0 .. BF  a poll, so many times 100 us later (the low five bits, squared)
//   C0 .. DF  ticks (the low five bits)
//   E0        power cut and start      E1  bus-off      E2  the port takes no frames      E3  it does again
//   E4        power fails at a byte of the next writing to flash
#include <cstddef>

#include "tests/fuzz/can/fuzzed_node.h"

namespace {

using namespace slipstack;        // NOLINT(google-build-using-namespace)
using namespace slipstack::fuzz;  // NOLINT(google-build-using-namespace)

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}
  bool empty() const { return rest_.empty(); }
  std::uint8_t next() {
    if (rest_.empty()) return 0;
    const std::uint8_t byte = rest_.front();
    rest_ = rest_.subspan(1);
    return byte;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

// Identifiers that mean something to the node; the rest by number.
constexpr std::array<std::uint16_t, 16> kIds = {0x605, 0x605, 0x605, 0x000, 0x080, 0x205, 0x305, 0x405,
                                                0x505, 0x7E5, 0x701, 0x705, 0x085, 0x585, 0x100, 0x7FF};

CanFrame frame_of(std::uint8_t first, Input& input) {
  CanFrame frame;
  const std::uint8_t shape = input.next();
  frame.length = shape & 0x0F;  // beyond 8 too: a driver may be wrong
  frame.extended = (shape & 0x10) != 0;
  frame.remote = (shape & 0x20) != 0;
  frame.id = first < 0x80 ? kIds[first & 0x0F] : (first & 7U) << 8U | input.next();
  for (std::size_t i = 0; i < 8 && i < frame.length; ++i) frame.data[i] = input.next();
  return frame;
}

void step(FuzzedNode& fuzzed, Input& input) {
  const std::uint8_t first = input.next();
  if (first < 0xA0) return fuzzed.send(frame_of(first, input));
  const unsigned low = first & 0x1F;
  if (first < 0xC0) return fuzzed.poll(100 * low * low);
  if (first < 0xE0) return fuzzed.ticks(low);
  switch (first) {
    case 0xE0:
      return fuzzed.power_on();
    case 0xE1:
      fuzzed.port.bus.state = CanBusState::kOff;
      return;
    case 0xE2:
    case 0xE3:
      fuzzed.port.blocked = first == 0xE2;
      return;
    case 0xE4:
      fuzzed.flash.bytes_until_power_fails = std::size_t{16} * input.next();
      return;
    default:
      return fuzzed.poll(100);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzedNode fuzzed;
  Input input(data, size);
  while (!input.empty()) step(fuzzed, input);
  check_dictionary(fuzzed.node().dictionary());
  check_alive(fuzzed);
  // And on whatever its flash holds.
  fuzzed.power_on();
  fuzzed.ticks(3);
  check_dictionary(fuzzed.node().dictionary());
  check_alive(fuzzed);
  return 0;
}
