// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/drive/cyclic_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

#include "firmware/canopen/objects/object_table.h"
#include "firmware/control/current/current_limit.h"
#include "workbench/can/drive/drive_access.h"

namespace slipstack::workbench {
namespace {

using canopen::kInvalidPdo;

constexpr std::uint32_t kNoRemote = 0x40000000;  // bit 30 of a TPDO
constexpr std::uint8_t kStateEvery = 10;         // SYNCs
constexpr std::int64_t kAfterMotion = 3;         // periods by which the reference is behind a set-point
constexpr int kLongestStart = 3000;              // SYNCs until the stream is followed
constexpr std::int64_t kWatchEvery = 64;         // SYNCs
constexpr std::size_t kSilence_ms = 1000;
constexpr std::uint32_t kLimitSwitches = 3;    // of the digital inputs (60FDh)
constexpr std::uint32_t kFollows = 1U << 12U;  // of the statusword

void map(SdoClient& drive, std::uint16_t mapping, std::span<const std::uint32_t> entries) {
  drive.write(mapping, 0, 0, 1);
  std::uint8_t sub = 0;
  for (const std::uint32_t entry : entries) drive.write(mapping, ++sub, entry, 4);
  drive.write(mapping, 0, sub, 1);
}

CanFrame set_point_frame(std::uint32_t id, std::int32_t counts) {
  CanFrame frame;
  frame.id = id;
  frame.length = 4;
  std::memcpy(frame.data.data(), &counts, sizeof counts);
  return frame;
}

}  // namespace

void CyclicStream::configure() {
  const std::uint32_t node = drive_.node();
  sync_id_ = drive_.read(0x1005, 0) & 0x7FF;
  drive_.write(0x1005, 0, sync_id_, 4);
  set_point_id_ = 0x400 + node;
  state_id_ = 0x180 + node;
  sample_id_ = 0x380 + node;
  error_id_ = 0x480 + node;
  for (std::uint16_t n = 0; n < 4; ++n) {
    const auto index = static_cast<std::uint16_t>(0x1800 + n);
    drive_.write(index, 1, drive_.read(index, 1) | kInvalidPdo, 4);
  }
  drive_.write(0x1402, 1, set_point_id_ | kInvalidPdo, 4);
  drive_.write(0x1402, 2, 1, 1);
  map(drive_, 0x1602, std::array{0x607A0020U});
  drive_.write(0x1402, 1, set_point_id_, 4);
  map(drive_, 0x1A00, std::array{0x60410010U, 0x22000A10U, 0x60FD0020U});
  map(drive_, 0x1A02, kMotionMapping);
  map(drive_, 0x1A03, std::array{0x22000720U, 0x22000920U});
  struct Transmit {
    std::uint16_t index;
    std::uint32_t id;
    std::uint8_t type;
  };
  for (const Transmit& pdo : {Transmit{0x1800, state_id_, kStateEvery}, Transmit{0x1802, sample_id_, 1},
                              Transmit{0x1803, error_id_, 1}}) {
    drive_.write(pdo.index, 1, pdo.id | kNoRemote | kInvalidPdo, 4);
    drive_.write(pdo.index, 2, pdo.type, 1);
    drive_.write(pdo.index, 1, pdo.id | kNoRemote, 4);
  }
  drive_.write(0x1006, 0, static_cast<std::uint32_t>(1000 * period_ms_), 4);
  drive_.write(0x60C2, 1, static_cast<std::uint32_t>(period_ms_), 1);
  drive_.write(0x60C2, 2, 0xFD, 1);  // 10^-3 s
  drive_.nmt(1);
}

StreamedMotion CyclicStream::follow(const std::vector<std::int32_t>& set_points, double limit_A,
                                    double tick_s, const std::function<void(double fraction)>& watch) {
  const double period_ticks = 1e-3 * period_ms_ / tick_s;
  StreamedMotion motion;
  motion.samples.reserve(set_points.size() + kAfterMotion);
  SyncSample now;
  bool sampled = false;  // the first of the two frames of this SYNC has come
  bool begun = false;
  bool follows = false;
  int waited = 0;
  std::int64_t first_tick = 0;
  std::size_t states = 0;
  std::size_t limited = 0;
  std::optional<bool> began_off;  // every limit switch
  drive_.listen_also_to({state_id_, sample_id_, error_id_});
  drive_.write(0x1005, 0, kProducesSync | sync_id_, 4);
  CanFrame frame;
  while (!motion.disabled) {
    if (!drive_.link().receive(frame, kSilence_ms)) drive_.fail("sends no samples any more");
    if (is_frame(frame, state_id_, 8)) {
      const auto word = value_at<std::uint16_t>(frame, 0);
      motion.disabled = (word & 0x6FU) != 0x27U;
      follows = (word & kFollows) != 0;
      const bool on_switch = (value_at<std::uint32_t>(frame, 4) & kLimitSwitches) != 0;
      if (begun) ++states;
      if (begun && (value_at<std::uint16_t>(frame, 2) & kLimitCurrent) != 0) ++limited;
      if (!began_off) began_off = !on_switch;
      // The set-points after it would have to be caught up with.
      if (on_switch && *began_off) break;
    } else if (is_frame(frame, sample_id_, 8)) {
      read_motion(frame, limit_A, now);
      sampled = true;
      if (!begun && follows) {
        begun = true;
        first_tick = now.tick;
      }
      if (!begun && ++waited > kLongestStart) drive_.fail("does not take up the stream of set-points");
      // By the drive's time, so that lost frames delay nothing.
      const auto period = begun ? std::llround(static_cast<double>(now.tick - first_tick) / period_ticks) + 1
                                : std::int64_t{0};
      if (period > static_cast<std::int64_t>(set_points.size()) + kAfterMotion) break;
      const auto place = std::min(static_cast<std::size_t>(period), set_points.size() - 1);
      drive_.link().send(set_point_frame(set_point_id_, set_points[place]));
      if (watch && period % kWatchEvery == 0)
        watch(static_cast<double>(place) / static_cast<double>(set_points.size()));
    } else if (is_frame(frame, error_id_, 8) && sampled) {
      sampled = false;
      now.error_m = static_cast<double>(value_at<float>(frame, 0));
      now.reference_counts = value_at<std::int32_t>(frame, 4);
      if (begun) motion.samples.push_back(now);
    }
  }
  // Held by a mode in which no set-point is due; then silence.
  if (!motion.disabled) drive_.write(0x6060, 0, 1, 1);
  drive_.write(0x1005, 0, sync_id_, 4);
  drive_.listen_also_to({});
  motion.limited_share = states == 0 ? 0.0 : static_cast<double>(limited) / static_cast<double>(states);
  return motion;
}

}  // namespace slipstack::workbench
