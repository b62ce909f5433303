// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/live/drive_events.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "firmware/canopen/objects/friction_objects.h"
#include "workbench/base/text.h"
#include "workbench/can/drive/drive_words.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

constexpr std::uint32_t kWarning = 1U << 7U;  // of the statusword
constexpr std::uint32_t kLimited = 1U << 11U;

std::int64_t now_ms() {
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

std::string code_text(std::uint32_t code) {
  return fmt::format("{:04X}h", code);
}

}  // namespace

DriveState ask_state(SdoClient& drive) {
  DriveState state;
  state.statusword = drive.read(0x6041, 0);
  const auto mode = static_cast<int>(drive.read(0x6061, 0) & 0xFFU);  // INTEGER8
  state.mode = mode < 128 ? mode : mode - 256;
  state.error = drive.read(0x603F, 0);
  state.referenced = drive.read(canopen::kReferenceIndex, 5) != 0;
  return state;
}

void DriveEvents::note(std::string what, const char* kind) {
  happened_.push_front({now_ms(), std::move(what), kind});
  if (happened_.size() > kKept) happened_.pop_back();
}

void DriveEvents::connected(const DriveState& now, std::uint32_t last_error) {
  note(fmt::format("{}: {}, {}", state_ ? "connected again" : "connected", state_name(now.statusword),
                   mode_name(now.mode)),
       "good");
  state_ = now;
  const auto code = static_cast<std::uint16_t>(last_error);
  if (code != 0 && !emergency_) emergency_ = Emergency{code, now_ms(), true};
}

void DriveEvents::lost(const std::string& why) {
  note("lost: " + why, "bad");
}

bool DriveEvents::take(const DriveState& now) {
  if (!state_ || now == *state_) return false;
  const std::string name = state_name(now.statusword);
  if (name != state_name(state_->statusword)) {
    // Why stands in EMCY; a frame may be lost, 603Fh is not.
    const bool fault = now.error != 0 && name.find("fault") != std::string::npos;
    note(fault ? fmt::format("{}, {}: {}", name, code_text(now.error),
                             error_words(static_cast<std::uint16_t>(now.error)))
               : name,
         fault ? "bad" : "note");
  }
  if (now.mode != state_->mode) note("mode: " + mode_name(now.mode), "note");
  if (now.referenced != state_->referenced)
    note(now.referenced ? "referenced: it knows its positions" : "no longer knows its positions", "note");
  state_ = now;
  return true;
}

void DriveEvents::take_emergency(const CanFrame& frame) {
  const auto code = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8);
  if (code == 0) {
    note("EMCY 0000h: an error is gone", "good");
    return;
  }
  emergency_ = Emergency{code, now_ms(), false};
  note(fmt::format("EMCY {}: {}", code_text(code), error_words(code)), "bad");
}

void DriveEvents::add_to(json& page) const {
  page["drive"] = nullptr;
  if (state_) {
    page["drive"] = {
        {"state", state_name(state_->statusword)},
        {"mode", mode_name(state_->mode)},
        {"error", state_->error == 0 ? "" : code_text(state_->error)},
        {"error_words", state_->error == 0 ? "" : error_words(static_cast<std::uint16_t>(state_->error))},
        {"warning", (state_->statusword & kWarning) != 0},
        {"limited", (state_->statusword & kLimited) != 0},
        {"referenced", state_->referenced}};
  }
  page["emergency"] = nullptr;
  if (emergency_) {
    page["emergency"] = {{"code", code_text(emergency_->code)},
                         {"words", error_words(emergency_->code)},
                         {"at_ms", emergency_->at_ms},
                         {"earlier", emergency_->earlier}};
  }
  page["happened"] = json::array();
  for (const Entry& one : happened_) {
    page["happened"].push_back({{"at_ms", one.at_ms}, {"what", printable(one.what)}, {"kind", one.kind}});
  }
}

}  // namespace slipstack::workbench
