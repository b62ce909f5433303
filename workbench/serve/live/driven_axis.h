// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "workbench/can/commands/master.h"

namespace slipstack::workbench {

/// A drive in profile position mode, enabled while this lives, with its own limits. For an axis in whose way
/// nothing stands. However it ends, cancelled too, the drive is disabled and its mode is restored. Throws
/// UsageError where the drive refuses, and where a position of its profile is another unit than a count.
class DrivenAxis {
 public:
  explicit DrivenAxis(SdoClient& drive);
  ~DrivenAxis();
  DrivenAxis(const DrivenAxis&) = delete;
  DrivenAxis& operator=(const DrivenAxis&) = delete;

  double resolution_m() const { return resolution_m_; }
  /// A set-point that takes effect at once, from where the axis was enabled.
  void move_to(double position_m);
  /// The same for a place in the drive's own counts.
  void move_to_place(std::int32_t counts);
  /// Cyclic synchronous position from here on, for a stream of set-points. Throws UsageError where the drive
  /// does not take the mode.
  void follow_set_points();
  /// Waits until the target is reached; false after a generous time.
  bool arrives();

 private:
  SdoClient& drive_;
  double resolution_m_ = 0.0;
  std::uint32_t mode_before_ = 0;
  std::int32_t begin_ = 0;
};

/// Moves the axis by `travel_m` and back so many times, at the drive's own profile velocity, and disables it.
void move_to_and_fro(SdoClient& drive, double travel_m, int times, const Show& show);

}  // namespace slipstack::workbench
