// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "workbench/can/commands/master.h"
#include "workbench/can/drive/drive_access.h"
#include "workbench/can/drive/motion_frame.h"

namespace slipstack::workbench {

/// What a log of the stream says of the axis.
struct StreamedAxis {
  double rate_Hz = 0.0;
  double tick_s = 0.0;
  double resolution_m = 0.0;
  double constant_N_per_A = 0.0;
  double mass_kg = 0.0;    ///< of the model that runs
  std::uint32_t hash = 0;  ///< of the same
};

/// The values of one tick.
struct StreamSample : MotionSample {
  double stamp_s = 0.0;     ///< of the frame; 0: the bus has none
  float error_m = 0.0F;     ///< reference less position (2200h:07); with the observer only
  float residual_N = 0.0F;  ///< what the model does not explain (2200h:03); with the observer only
};

/// What one wants who watches for long, beside the samples.
struct BesideStream {
  /// What could not be restored at the end of an earlier stream, since the bus was gone.
  std::vector<RestoredObjects::Before>* owed = nullptr;
  /// Called by DriveStream::next() for EMCY and boot-up or heartbeat of the drive.
  std::function<void(const CanFrame&)> message = {};
};

/// The drive as SYNC producer that sends TPDO 3 (tick, position, current) with each SYNC, and with the
/// observer TPDO 4 too, mapped to position error and residual. The communication objects are restored at the
/// end. While it lives nothing else may receive from the link of `drive`. Cost on the bus: 3 frames a sample
/// with the observer, about 330 bits; 2 without. Throws UsageError, one line.
class DriveStream {
 public:
  enum class With : std::uint8_t { motion, observer };
  DriveStream(SdoClient& drive, double rate_Hz, With with, BesideStream beside = {});

  /// The next sample, or none within this time.
  std::optional<StreamSample> next(int timeout_ms);
  const StreamedAxis& axis() const { return axis_; }

 private:
  void require_motion_mapping();
  void take_motion(const CanFrame& frame);

  SdoClient& drive_;
  bool observed_;
  BesideStream beside_;
  StreamedAxis axis_;
  double limit_A_ = 0.0;
  std::uint32_t id3_ = 0;
  std::uint32_t id4_ = 0;
  StreamSample next_;
  bool pending_ = false;  ///< next_ waits for TPDO 4
  RestoredObjects changed_;
};

/// Throws UsageError where a parameter of the drive is not plausible, so that no log can be written.
void check_axis(const SdoClient& drive, double tick_s, double resolution_m, double constant);

/// The log of a stream. Samples that are missing are counted in its head; it is then `sampling: irregular`.
Recording recording_of(const StreamedAxis& axis, const std::vector<StreamSample>& samples);

}  // namespace slipstack::workbench
