// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/live/driven_axis.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include "firmware/canopen/telemetry/trace.h"
#include "workbench/base/cancel.h"
#include "workbench/can/drive/drive_access.h"

namespace slipstack::workbench {

using namespace slipstack::canopen;

namespace {

constexpr int kMostPolls = 20'000;                   // each takes a tick or more
constexpr std::uint32_t kTargetReached = 1U << 10U;  // 6041h (CiA 402)
constexpr std::uint32_t kSetPointTaken = 1U << 12U;
constexpr std::uint32_t kProfilePosition = 1;  // 6060h
constexpr std::uint32_t kCyclicPosition = 8;
constexpr std::uint32_t kShutdown = 0x06;  // 6040h

/// Position units of the profile for each count (docs/can.md, the user's unit).
double counts_per_unit(SdoClient& drive) {
  double ratio = 1.0;
  constexpr std::array<std::pair<std::uint16_t, bool>, 3> kRatios = {
      {{0x608F, true}, {0x6091, true}, {0x6092, false}}};
  for (const auto& [index, upright] : kRatios) {
    const double first = drive.read(index, 1);
    const double second = drive.read(index, 2);
    ratio *= upright ? first / second : second / first;
  }
  return ratio;
}

}  // namespace

DrivenAxis::DrivenAxis(SdoClient& drive) : drive_(drive), resolution_m_(drive.read_real(kAxisIndex, 1)) {
  if (!(resolution_m_ > 0.0)) drive.fail("2000h:01 is no resolution; is it commissioned?");
  if (counts_per_unit(drive) != 1.0) {
    drive.fail("its positions are in a unit of its own (608Fh, 6091h, 6092h); move it by its own master");
  }
  if (is_enabled(drive)) drive.fail("is enabled by another master; disable it first");
  mode_before_ = drive.read(0x6060, 0);
  try {
    drive.write(0x6060, 0, kProfilePosition, 1);
    for (const std::uint32_t word : {kShutdown, 0x07U, 0x0FU}) drive.write(0x6040, 0, word, 2);
    for (int poll = 0; !is_enabled(drive); ++poll) {
      if (poll > kMostPolls) drive.fail("cannot be enabled; see its status");
      throw_if_cancelled();
    }
    begin_ = static_cast<std::int32_t>(drive.read(0x6064, 0));
  } catch (...) {
    drive.try_write(0x6040, 0, kShutdown, 2);
    throw;
  }
}

DrivenAxis::~DrivenAxis() {
  try {
    drive_.try_write(0x6040, 0, kShutdown, 2);
    for (int poll = 0; is_enabled(drive_) && poll < kMostPolls; ++poll) {
    }
    drive_.try_write(0x6060, 0, mode_before_, 1);
  } catch (const std::exception&) {  // the bus is gone; the drive's own supervision stops the axis
  }
}

void DrivenAxis::move_to(double position_m) {
  move_to_place(static_cast<std::int32_t>(begin_ + std::llround(position_m / resolution_m_)));
}

void DrivenAxis::move_to_place(std::int32_t counts) {
  drive_.write(0x607A, 0, static_cast<std::uint32_t>(counts), 4);
  // Not before the drive has taken the set-point is bit 10 that of this one (CiA 402).
  drive_.write(0x6040, 0, 0x3F, 2);
  for (int poll = 0; (drive_.read(0x6041, 0) & kSetPointTaken) == 0; ++poll) {
    if (poll > kMostPolls) drive_.fail("takes no set-point; see its status");
    throw_if_cancelled();
  }
  drive_.write(0x6040, 0, 0x2F, 2);
}

void DrivenAxis::follow_set_points() {
  drive_.write(0x6060, 0, kCyclicPosition, 1);
  for (int poll = 0; drive_.read(0x6061, 0) != kCyclicPosition; ++poll) {
    if (poll > kMostPolls) drive_.fail("does not change to cyclic synchronous position; see its status");
    throw_if_cancelled();
  }
}

bool DrivenAxis::arrives() {
  for (int poll = 0; poll < kMostPolls; ++poll) {
    if ((drive_.read(0x6041, 0) & kTargetReached) != 0) return true;
    if (!is_enabled(drive_)) drive_.fail("was disabled on the way; see its status");
    throw_if_cancelled();
  }
  return false;
}

void move_to_and_fro(SdoClient& drive, double travel_m, int times, const Show& show) {
  DrivenAxis axis(drive);
  for (int leg = 0; leg < 2 * times; ++leg) {
    show(fmt::format("move {} of {}", leg / 2 + 1, times), static_cast<double>(leg) / (2 * times));
    axis.move_to(leg % 2 == 0 ? travel_m : 0.0);
    if (!axis.arrives()) drive.fail("does not arrive; see its status");
  }
}

}  // namespace slipstack::workbench
