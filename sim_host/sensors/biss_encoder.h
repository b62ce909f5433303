// SPDX-License-Identifier: Apache-2.0
// An absolute encoder with a BiSS-C interface, as its master sees it clock by clock.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace slipstack::sim {

/// Levels of the line SLO at successive clocks of MA, from what data sheets of such encoders say: high at
/// rest; low from the second rising edge on while the position is processed; a start bit; a CDS bit; the
/// position, highest bit first; two flags that are low when active; six bits of CRC (polynomial 1000011 in
/// binary), inverted; then low until its time-out is over.
class BissEncoder {
 public:
  struct Setup {
    int bits = 32;
    int delay_clocks = 1;       ///< of cable and receivers, whole clocks
    int processing_clocks = 5;  ///< of acknowledge
  };
  struct Fault {
    bool error = false;
    bool warning = false;
    bool unplugged = false;           ///< the receiver's pull-up holds the line high
    bool short_circuit = false;       ///< low
    std::optional<int> flipped = {};  ///< this bit is disturbed: 0 CDS, -1 the start bit before it
    std::optional<int> ends_at = {};  ///< from this bit on the line is low: the supply goes
  };

  explicit BissEncoder(const Setup& setup) : setup_(setup) {}

  /// One cycle: what a master samples that clocks 8 `bytes` times, first level in the highest bit.
  std::vector<std::uint8_t> cycle(std::uint64_t position, const Fault& fault, int bytes) const;

 private:
  Setup setup_;
};

}  // namespace slipstack::sim
