// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "hal/include/can_port.h"
#include "workbench/can/client/sdo_client.h"

namespace slipstack::workbench {

/// What a drive says of itself beside its signals.
struct DriveState {
  std::uint32_t statusword = 0;  ///< 6041h
  int mode = 0;                  ///< 6061h
  std::uint32_t error = 0;       ///< 603Fh
  bool referenced = false;       ///< 2012h:05
  bool operator==(const DriveState&) const = default;
};

/// Asks for it: four transfers. Throws UsageError.
DriveState ask_state(SdoClient& drive);

/// The state of a drive, its last emergency, and what happened to it, with the time of day. Not for several
/// threads at once.
class DriveEvents {
 public:
  static constexpr std::size_t kKept = 50;

  /// The drive is there, for the first time or again. `last_error`: the newest entry of 1003h, 0 without.
  void connected(const DriveState& now, std::uint32_t last_error);
  void lost(const std::string& why);
  /// Returns whether anything has changed.
  bool take(const DriveState& now);
  void take_emergency(const CanFrame& frame);

  /// {state, mode, error, error_words, warning, limited, referenced} or null; emergency: {code, words, at_ms,
  /// earlier} or null; happened: [{at_ms, what, kind}], newest first. `at_ms`: since 1970.
  void add_to(nlohmann::json& page) const;

 private:
  struct Entry {
    std::int64_t at_ms;
    std::string what;
    const char* kind;  ///< for the page: note, good, bad
  };
  struct Emergency {
    std::uint16_t code;
    std::int64_t at_ms;
    bool earlier;  ///< than the connection: from the drive's memory
  };
  void note(std::string what, const char* kind);

  std::optional<DriveState> state_;
  std::optional<Emergency> emergency_;
  std::deque<Entry> happened_;
};

}  // namespace slipstack::workbench
