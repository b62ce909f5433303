// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slipstack {

/// A homing method of IEC 61800-7-201 (6098h), as the steps that lead to its home position. Signs are
/// directions of motion: 1 towards higher counts, -1 towards lower ones, 0: no such step.
///
///   search until the switch (or the end stop) is there; from a limit switch the search for a home switch
///   goes on the other way
///   leave the switch; where it becomes inactive
///   enter it again; where it becomes active
///   go on to the first index from there
///
/// or, on a scale with coded marks, search until three of them say where its zero is.
///
/// The last of them is where the home position is.
struct HomingMethod {
  enum class Sensor : std::uint8_t {
    kNone,
    kNegativeLimit,
    kPositiveLimit,
    kHomeSwitch,
    kEndStop,
    kCodedMarks
  };
  std::int8_t number = 0;
  Sensor sensor = Sensor::kNone;
  std::int16_t search = 0;
  std::int16_t leave = 0;
  std::int16_t enter = 0;
  std::int16_t index = 0;
};

namespace detail {

/// Methods 7 to 10 and their mirror images 11 to 14; 23 to 30 are the same without index. `edge`: 0 left of
/// the switch on the side where the search begins, 1 the same edge from outside, 2 the far edge from outside,
/// 3 beyond the far edge.
constexpr HomingMethod home_switch_method(int number, int first, bool with_index) {
  const int search = number - first < 4 ? 1 : -1;
  const int edge = (number - first) % 4;
  const int leave = edge < 2 ? -search : search;
  const int enter = edge == 1 || edge == 2 ? -leave : 0;
  const int last = enter != 0 ? enter : leave;
  return {static_cast<std::int8_t>(number),  HomingMethod::Sensor::kHomeSwitch,
          static_cast<std::int16_t>(search), static_cast<std::int16_t>(leave),
          static_cast<std::int16_t>(enter),  static_cast<std::int16_t>(with_index ? last : 0)};
}

}  // namespace detail

/// Every method there is, in the order of 60E3h. Negative ones are those of the manufacturer: coded marks;
/// end stop, seen by the current that the axis needs to press against it.
inline constexpr auto kHomingMethods = [] {
  using Sensor = HomingMethod::Sensor;
  std::array<HomingMethod, 30> methods{};
  std::size_t size = 0;
  for (const HomingMethod& method : std::to_array<HomingMethod>({
           {-6, Sensor::kCodedMarks, -1, 0, 0, 0},
           {-5, Sensor::kCodedMarks, 1, 0, 0, 0},
           {-4, Sensor::kEndStop, -1, 0, 0, 0},
           {-3, Sensor::kEndStop, 1, 0, 0, 0},
           {-2, Sensor::kEndStop, -1, 0, 0, 1},
           {-1, Sensor::kEndStop, 1, 0, 0, -1},
           {1, Sensor::kNegativeLimit, -1, 1, 0, 1},
           {2, Sensor::kPositiveLimit, 1, -1, 0, -1},
       })) {
    methods[size++] = method;
  }
  for (int number = 7; number <= 14; ++number) methods[size++] = detail::home_switch_method(number, 7, true);
  methods[size++] = {17, Sensor::kNegativeLimit, -1, 1, 0, 0};
  methods[size++] = {18, Sensor::kPositiveLimit, 1, -1, 0, 0};
  for (int number = 23; number <= 30; ++number)
    methods[size++] = detail::home_switch_method(number, 23, false);
  methods[size++] = {33, Sensor::kNone, 0, 0, 0, -1};
  methods[size++] = {34, Sensor::kNone, 0, 0, 0, 1};
  methods[size++] = {35};  // where the axis is; 37 is the newer number
  methods[size++] = {37};
  return methods;
}();

/// Null where there is no such method.
constexpr const HomingMethod* find_homing_method(std::int32_t number) {
  for (const HomingMethod& method : kHomingMethods) {
    if (method.number == number) return &method;
  }
  return nullptr;
}

}  // namespace slipstack
