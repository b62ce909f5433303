// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "workbench/can/client/sdo_client.h"
#include "workbench/can/drive/motion_frame.h"

namespace slipstack::workbench {

/// What a drive sent at one SYNC. All of the same tick.
struct SyncSample : MotionSample {
  double error_m = 0.0;  ///< of the reference
  std::int32_t reference_counts = 0;
};

/// A motion of which there is a set-point at each SYNC, and what came of it. It ends where a limit switch
/// becomes active.
struct StreamedMotion {
  std::vector<SyncSample> samples;  ///< from the first set-point on
  double limited_share = 0.0;       ///< of the time, at the limit of the current
  bool disabled = false;            ///< the drive has left operation enabled
};

/// What is asked of a streamed motion, in commissioning and for a plan alike.
inline constexpr std::uint32_t kStreamTimeOut_ms = 500;  ///< 2403h; a stream that ends brakes by itself
inline constexpr double kMostLost = 0.01;                ///< of a motion's samples
inline constexpr double kArrived_m = 20e-6;              ///< of a reference that followed its set-points

/// Cyclic synchronous position over PDOs. The drive produces SYNC, so that its samples keep its own time, and
/// each of them asks for the next set-point: one that the master is late with is lost, and the others stay in
/// their place (docs/can.md).
class CyclicStream {
 public:
  CyclicStream(SdoClient& drive, int period_ms) : drive_(drive), period_ms_(period_ms) {}

  /// Maps and enables the PDOs that are needed, and disables the others; the drive has to be off. Throws
  /// UsageError.
  void configure();
  /// Runs a drive that is enabled in mode 8 along set-points (counts from position zero), which begin where
  /// its reference rests. `limit_A`: 2000h:09. `watch` is told now and then how much of it is done. Throws
  /// UsageError where the drive no longer answers or does not take up the stream, and what `watch` throws:
  /// the drive then brakes by itself.
  StreamedMotion follow(const std::vector<std::int32_t>& set_points, double limit_A, double tick_s,
                        const std::function<void(double fraction)>& watch = {});
  int period_ms() const { return period_ms_; }

 private:
  SdoClient& drive_;
  int period_ms_;
  std::uint32_t sync_id_ = 0x80;
  std::uint32_t set_point_id_ = 0;
  std::uint32_t state_id_ = 0;
  std::uint32_t sample_id_ = 0;
  std::uint32_t error_id_ = 0;
};

}  // namespace slipstack::workbench
