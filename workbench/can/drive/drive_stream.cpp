// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/drive_stream.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <utility>

#include "firmware/canopen/telemetry/trace.h"
#include "workbench/can/drive/drive_access.h"

namespace slipstack::workbench {

using namespace slipstack::canopen;

namespace {

constexpr std::uint32_t kPositionError = 0x22000720U;
constexpr std::uint32_t kResidual = 0x22000320U;
constexpr std::uint32_t kId = 0x7FF;

}  // namespace

/// Throws UsageError where a parameter of the drive is not plausible, so that no log can be written.
void check_axis(const SdoClient& drive, double tick_s, double resolution_m, double constant) {
  if (tick_s > 1e-6 && tick_s < 1.0 && resolution_m > 0.0 && resolution_m < 1.0 && std::isfinite(constant))
    return;
  drive.fail(
      fmt::format("tick {} s, encoder {} m, motor constant {} N/A (2000h:01 to :03) are none of an axis; is "
                  "it commissioned?",
                  tick_s, resolution_m, constant));
}

DriveStream::DriveStream(SdoClient& drive, double rate_Hz, With with, BesideStream beside)
    : drive_(drive),
      observed_(with == With::observer),
      beside_(std::move(beside)),
      changed_(drive, beside_.owed) {
  axis_.rate_Hz = rate_Hz;
  axis_.tick_s = drive.read_real(kAxisIndex, 2);
  axis_.resolution_m = drive.read_real(kAxisIndex, 1);
  axis_.constant_N_per_A = drive.read_real(kAxisIndex, 3);
  limit_A_ = drive.read_real(kAxisIndex, 9);
  check_axis(drive, axis_.tick_s, axis_.resolution_m, axis_.constant_N_per_A);
  axis_.mass_kg = model_mass_kg(drive);
  axis_.hash = drive.read(kModelIndex, 2);
  require_motion_mapping();
  const std::uint32_t cob3 = drive.read(0x1802, 1);
  const std::uint32_t cob4 = drive.read(0x1803, 1);
  changed_.set(0x1802, 1, cob3 | kInvalidPdo, 4);
  changed_.set(0x1802, 2, 1, 1);
  changed_.set(0x1006, 0, static_cast<std::uint32_t>(std::lround(1e6 / rate_Hz)), 4);
  if (observed_) {
    changed_.set(0x1803, 1, cob4 | kInvalidPdo, 4);
    changed_.set(0x1803, 2, 1, 1);
    changed_.set(0x1A03, 0, 0, 1);
    changed_.set(0x1A03, 1, kPositionError, 4);
    changed_.set(0x1A03, 2, kResidual, 4);
    changed_.set(0x1A03, 0, 2, 1);
    changed_.set(0x1803, 1, cob4 & ~kInvalidPdo, 4);
  }
  changed_.set(0x1802, 1, cob3 & ~kInvalidPdo, 4);
  id3_ = cob3 & kId;
  id4_ = observed_ ? cob4 & kId : id3_;
  changed_.set(0x1005, 0, kProducesSync | (drive.read(0x1005, 0) & kId), 4);
  if (beside_.message) {
    drive.listen_also_to({id3_, id4_, kEmergencyId + drive.node(), kErrorControlId + drive.node()});
  } else {
    drive.listen_also_to({id3_, id4_});
  }
  drive.nmt(1);
}

void DriveStream::require_motion_mapping() {
  std::uint8_t sub = 0;
  for (const std::uint32_t entry : kMotionMapping) {
    if (drive_.read(0x1A02, ++sub) == entry && drive_.read(0x1A02, 0) == std::size(kMotionMapping)) continue;
    drive_.fail(
        "TPDO 3 maps something else than tick, position and current; restore it (1011h:02) or record the "
        "trace (--trace)");
  }
}

void DriveStream::take_motion(const CanFrame& frame) {
  StreamSample sample;
  sample.tick = next_.tick;
  read_motion(frame, limit_A_, sample);
  sample.stamp_s = drive_.link().stamp_s();
  next_ = sample;
}

std::optional<StreamSample> DriveStream::next(int timeout_ms) {
  CanFrame frame;
  while (drive_.link().receive(frame, timeout_ms)) {
    if (is_frame(frame, id3_, 8)) {
      take_motion(frame);
      pending_ = observed_;
      if (!observed_) return next_;
    } else if (pending_ && is_frame(frame, id4_, 8)) {
      pending_ = false;
      next_.error_m = value_at<float>(frame, 0);
      next_.residual_N = value_at<float>(frame, 4);
      return next_;
    } else if (beside_.message &&
               (frame.id == kEmergencyId + drive_.node() || frame.id == kErrorControlId + drive_.node())) {
      beside_.message(frame);
    }
  }
  return {};
}

}  // namespace slipstack::workbench
