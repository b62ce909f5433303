// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "tests/can/bench.h"

namespace slipstack::can {

/// A drive on an axis with limit switches, a home switch, index marks and mechanical stops, commanded over
/// the bus. Where things stand is known to the test alone.
class HomingAxis : public Bench {
 public:
  static constexpr double kFast_mps = 0.1;
  static constexpr double kSlow_mps = 0.01;

  explicit HomingAxis(double start_m, bool absolute = false) {
    stroke_m = axis.stroke_m;
    loop->switches = sim::Switches{
        .negative_m = 0.02, .positive_m = stroke_m - 0.02, .home_begin_m = 0.1, .home_end_m = 0.112};
    loop->marks = sim::ReferenceMarks{.first_m = 0.0043, .distance_m = 0.015};
    loop->stops = sim::EndStops{.negative_m = 0.0, .positive_m = stroke_m};
    loop->plant.reset(start_m);
    loop->step();  // the encoder counts from somewhere
    for (std::uint8_t sub = 1; sub <= 8; ++sub) {
      EXPECT_EQ(write(0x2010, sub, sim::Switches::kWiring[sub], sub < 7 ? 1 : 2), 0U);
    }
    EXPECT_EQ(write(0x2012, 1, absolute ? 1 : 0, 1), 0U);
    configure();
    EXPECT_EQ(write(0x6099, 1, counts(kFast_mps), 4), 0U);
    EXPECT_EQ(write(0x6099, 2, counts(kSlow_mps), 4), 0U);
    EXPECT_EQ(write(0x609A, 0, counts(2.0), 4), 0U);
    EXPECT_EQ(write(0x60A4, 1, counts(200.0), 4), 0U);
  }

  std::uint32_t counts(double metres) const {
    return static_cast<std::uint32_t>(std::llround(metres / axis.encoder_resolution_m));
  }
  double x_m() { return loop->plant.position_m(); }
  /// Where on the rail the drive says that zero is.
  double zero_m() { return x_m() - static_cast<double>(read_signed(0x6064, 0)) * axis.encoder_resolution_m; }

  std::uint32_t choose(int method) {
    return write(0x6098, 0, static_cast<std::uint8_t>(static_cast<std::int8_t>(method)), 1);
  }
  /// Starts, and runs until it ends; the bits 10, 12 and 13 of the statusword at the end.
  std::uint32_t home(int method, double longest_s = 60.0) {
    EXPECT_EQ(choose(method), 0U);
    enable(6);
    return start(longest_s);
  }
  std::uint32_t start(double longest_s = 60.0) {
    EXPECT_EQ(write(0x6040, 0, 0x1F, 2), 0U);
    return until_end(longest_s);
  }
  std::uint32_t until_end(double longest_s) {
    std::uint32_t bits = 0;
    for (int ms = 0; ms < static_cast<int>(longest_s * 1e3); ms += 5) {
      run_ms(5);
      bits = status();
      lowest_m = std::min(lowest_m, x_m());
      highest_m = std::max(highest_m, x_m());
      if ((bits & kEnd) != 0 && (bits & kReached) != 0) break;
    }
    run_ms(200);  // at rest
    return status();
  }
  std::uint32_t status() { return read(0x6041, 0) & (kReached | kAttained | kError); }
  bool referenced() { return (read(0x6041, 0) & 0x8000U) != 0; }

  static constexpr std::uint32_t kReached = 1U << 10;
  static constexpr std::uint32_t kAttained = 1U << 12;
  static constexpr std::uint32_t kError = 1U << 13;
  static constexpr std::uint32_t kEnd = kAttained | kError;
  static constexpr std::uint32_t kDone = kAttained | kReached;

  double stroke_m = 0.0;
  double lowest_m = 1e9;
  double highest_m = -1e9;
};

}  // namespace slipstack::can
