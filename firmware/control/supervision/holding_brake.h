// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace slipstack {

/// Time that the holding brake takes: before operation is enabled, current on, it opens; at the end of every
/// stop, at standstill and with current on, it closes. Without a brake both times are zero.
class HoldingBrake {
 public:
  /// Whether it is to be open while current flows.
  bool is_open() const { return closing_ticks_ == 0; }
  bool opening() const { return opening_; }

  /// One tick of opening. True when it is open.
  bool open(std::int32_t ticks_to_open) {
    if (!opening_) opening_ticks_ = 0;
    opening_ = true;
    if (opening_ticks_++ < ticks_to_open) return false;
    opening_ = false;
    return true;
  }
  void stop_opening() { opening_ = false; }

  /// One tick of closing. True when it is closed.
  bool close(std::int32_t ticks_to_close) { return ++closing_ticks_ > ticks_to_close; }

  /// Neither opens nor closes.
  void rest() {
    opening_ = false;
    closing_ticks_ = 0;
  }

 private:
  bool opening_ = false;
  std::int32_t opening_ticks_ = 0;
  std::int32_t closing_ticks_ = 0;
};

}  // namespace slipstack
