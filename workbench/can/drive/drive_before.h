// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "workbench/can/client/sdo_client.h"

namespace slipstack::workbench {

/// What a drive on the bus held before its commissioning: axis (2000h), what the check of the direction and
/// the set-points need, and the model. It can be put back by a later run of the command too, since it is kept
/// as JSON.
class DriveBefore {
 public:
  /// Reads it from the drive. Throws UsageError.
  explicit DriveBefore(SdoClient& drive);
  /// From what json() gave. Throws nlohmann::json::exception where it is something else.
  explicit DriveBefore(const nlohmann::json& kept);
  nlohmann::json json() const;

  /// Of an object that is part of it.
  std::uint32_t value(std::uint16_t index, std::uint8_t sub) const;
  double real(std::uint16_t index, std::uint8_t sub) const;
  /// The motor is connected the other way round than the drive took it for.
  void set_motor_reversed(bool reversed);

  /// Writes back what differs, but for objects of which `left` is true. Staged, not yet applied. Throws
  /// UsageError; the drive has to be off.
  void restore_objects(SdoClient& drive,
                       const std::function<bool(std::uint16_t index, std::uint8_t sub)>& left) const;
  /// Objects and model, and applies them; a drive that had no model has none applied.
  void restore(SdoClient& drive) const;

 private:
  struct Entry {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
    int bytes = 0;
    std::uint32_t value = 0;
  };
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> model_;
};

}  // namespace slipstack::workbench
