// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

// What a drive's numbers mean, in plain words.
namespace slipstack::workbench {

/// The state of the state machine in a statusword (6041h; IEC 61800-7-201, table 30).
std::string state_name(std::uint32_t statusword);

/// The mode of operation (6061h): "profile position"; "mode 4" where this firmware has none of that number.
std::string mode_name(int mode);

/// State and cause of hunting (2202h:02 and :03): what the axis does, and what to do about it.
std::string hunting_words(std::uint32_t state, std::uint32_t cause);

/// What an error code (603Fh, EMCY; docs/can.md) says, and what to look at first; for a code that is not this
/// firmware's "unknown to this program".
std::string error_words(std::uint16_t code);

}  // namespace slipstack::workbench
