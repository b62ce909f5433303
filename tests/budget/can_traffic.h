// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "hal/include/can_port.h"
#include "tests/budget/motion.h"

// What comes in on a full bus: nothing; frames for others; those with what the node serves in between; broken
// and hostile ones. Nothing of it may command the axis: its ticks are compared with those of a quiet bus.
namespace slipstack::budget {

enum class Traffic : std::uint8_t { kQuiet, kForeign, kServed, kHostile };

inline bool traffic_of(const char* word, Traffic& traffic) {
  constexpr std::array<const char*, 4> kWords = {"quiet ", "foreign ", "served ", "hostile "};
  for (std::size_t i = 0; i < kWords.size(); ++i) {
    if (std::strncmp(word, kWords[i], std::strlen(kWords[i])) != 0) continue;
    traffic = static_cast<Traffic>(i);
    return true;
  }
  return false;
}

inline CanFrame random_frame(Random& random) {
  CanFrame frame;
  frame.id = random.below(0x800);
  frame.extended = random.below(4) == 0;
  frame.remote = random.below(16) == 0;
  frame.length = static_cast<std::uint8_t>(random.below(9));
  for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random.below(256));
  return frame;
}

// Node 5's identifiers, NMT, SYNC and LSS left out.
inline CanFrame foreign_frame(Random& random) {
  CanFrame frame = random_frame(random);
  while (!frame.extended && (frame.id < 0x100 || (frame.id & 0x7F) == 5 || frame.id >= 0x780)) {
    frame.id = random.below(0x800);
  }
  return frame;
}

inline CanFrame frame_of(std::uint32_t id, std::array<std::uint8_t, 8> data, std::uint8_t length = 8) {
  CanFrame frame;
  frame.id = id;
  frame.length = length;
  frame.data = data;
  return frame;
}

// A master at work: uploads expedited, by segments, by block; downloads; SYNC; into pre-operational.
inline CanFrame served_frame(Random& random) {
  switch (random.below(8)) {
    case 0:
      return frame_of(0x605, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0});
    case 1:
      return frame_of(0x605, {0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
    case 2:
      return frame_of(0x605, {0x60, 0, 0, 0, 0, 0, 0, 0});
    case 3:
      return frame_of(0x605, {0xA4, 0x41, 0x21, 0, 127, 0, 0, 0});
    case 4:
      return frame_of(0x605, {0xA3, 0, 0, 0, 0, 0, 0, 0});
    case 5:
      return frame_of(0x605,
                      {0x2B, 0x17, 0x10, 0, static_cast<std::uint8_t>(1 + random.below(200)), 0, 0, 0});
    case 6:
      return frame_of(0x080, {}, 0);
    default:
      return foreign_frame(random);
  }
}

// Good frames with bits flipped or cut, and noise to the node's own identifiers. SDO frames of the control
// word and the modes are left out, and so is NMT: they may stop the axis, and should.
inline CanFrame hostile_frame(Random& random) {
  CanFrame frame = random.below(4) == 0 ? random_frame(random) : served_frame(random);
  if (random.below(2) == 0) frame.id = 0x605;
  if (random.below(3) == 0) {
    frame.data[0] = static_cast<std::uint8_t>((random.below(8) << 5) | random.below(32));
    frame.data[1] = static_cast<std::uint8_t>(random.below(4) * 0x10 + random.below(4));
    frame.data[2] = static_cast<std::uint8_t>(0x10 + random.below(0x14));
  }
  for (std::uint32_t flips = random.below(4); flips > 0; --flips) {
    frame.data[random.below(8)] ^= static_cast<std::uint8_t>(1U << random.below(8));
  }
  if (random.below(16) == 0) frame.length = static_cast<std::uint8_t>(random.below(9));
  const bool profile = frame.id == 0x605 && frame.data[2] == 0x60;
  const bool lss_store = frame.id == 0x7E5 && frame.data[0] == 0x17;
  if (profile || lss_store || frame.id == 0) frame.id = 0x606;
  return frame;
}

inline CanFrame next_frame(Traffic traffic, Random& random) {
  if (traffic == Traffic::kForeign) return foreign_frame(random);
  if (traffic == Traffic::kServed) return served_frame(random);
  return hostile_frame(random);
}

}  // namespace slipstack::budget
