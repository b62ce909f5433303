// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/canopen/objects/dictionary.h"
#include "firmware/update/program_writer.h"
#include "firmware/update/trial_watch.h"
#include "hal/include/program_memory.h"

namespace slipstack::canopen {

/// 1F50h, 1F51h, 1F56h, 1F57h (CiA 302-3) and 2410h: a new program over the bus, while the power stage is
/// off. 1F51h = 3 erases the spare slot, 1F50h fills it, 1F51h = 1 starts what is there, on trial.
class ProgramDownload {
 public:
  /// `memory`: of the board; nullptr where programs cannot be replaced.
  explicit ProgramDownload(ProgramMemory* memory) : memory_(memory) {
    if (memory == nullptr) return;
    writer_.emplace(*memory);
    watch_.emplace(*memory);
  }

  /// Once in every poll: erases a page, restarts once the answer to 1F51h is on the bus.
  void step(std::uint32_t now_us, bool driving) {
    if (memory_ == nullptr) return;
    now_us_ = now_us;
    if (driving) restarting_ = false;
    if (restarting_ && now_us - restart_asked_us_ > kAnswer_us) {
      restarting_ = false;
      memory_->restart();
    } else if (!driving && writer_->clearing()) {
      note(writer_->step());
    }
  }

  /// Once in every pass of the main loop: whether the running program, if it is on trial, has reported in.
  void watch_trial(std::uint32_t now_us, bool reports, bool driving) {
    if (memory_ != nullptr) watch_->step(now_us, reports, !driving);
  }

  std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
    if (memory_ == nullptr) return 0;
    switch (index) {
      case kProgramControlIndex:
        return 1;  // started: it answers
      case kProgramIdentityIndex:
        return crc_of(memory_->running());
      case kFlashStatusIndex:
        return (writer_->clearing() ? 1U : 0U) | flash_error() << 1U |
               static_cast<std::uint32_t>(fault_) << 16U;
      default:
        return read_update(sub);
    }
  }

  /// 1F51h is written.
  Abort control(std::uint32_t value, bool driving) {
    if (memory_ == nullptr) return Abort::kUnsupportedAccess;
    if (driving) return not_while_driving();
    switch (value) {
      case 0:
        return Abort::kNone;  // to stop is to have the power stage off
      case 1:
        return start();
      case 2:
        return restart();
      default:
        return abort_of(writer_->clear());
    }
  }

  Abort begin() { return memory_ == nullptr ? Abort::kUnsupportedAccess : abort_of(writer_->begin()); }
  /// The drive may have been enabled since begin().
  Abort download(std::span<const std::uint8_t> in, bool driving) {
    return driving ? not_while_driving() : abort_of(writer_->write(std::as_bytes(in)));
  }
  Abort end() { return abort_of(writer_->finish()); }

 private:
  using Fault = update::UpdateFault;
  static constexpr std::uint32_t kAnswer_us = 50'000;  // ten frames at 10 kbit/s

  Abort start() {
    const Abort code = abort_of(writer_->install());
    return code == Abort::kNone ? restart() : code;
  }
  // No fault of the update: the abort code says it.
  Abort not_while_driving() {
    note(Fault::kNone);
    return Abort::kDeviceState;
  }
  Abort restart() {
    restarting_ = true;
    restart_asked_us_ = now_us_;
    return Abort::kNone;
  }

  void note(Fault fault) { fault_ = fault; }
  Abort abort_of(Fault fault) {
    note(fault);
    switch (fault) {
      case Fault::kNone:
        return Abort::kNone;
      case Fault::kNotCleared:
      case Fault::kOnTrial:
        return Abort::kDeviceState;
      case Fault::kWrongDevice:
        return Abort::kIncompatible;
      case Fault::kTooLarge:
        return Abort::kTooLong;
      case Fault::kCutShort:
        return Abort::kTooShort;
      case Fault::kFlash:
        return Abort::kHardware;
      case Fault::kNoProgram:
        return Abort::kNoData;
      default:
        return Abort::kCannotStore;
    }
  }
  // Error numbers of 1F57h.
  std::uint32_t flash_error() const {
    switch (fault_) {
      case Fault::kNone:
        return 0;
      case Fault::kNoProgram:
        return 1;
      case Fault::kFormat:
        return 2;
      case Fault::kChecksum:
      case Fault::kCutShort:
        return 3;
      case Fault::kNotCleared:
        return 4;
      case Fault::kFlash:
        return 5;
      case Fault::kTooLarge:
      case Fault::kNotForSlot:
        return 6;
      case Fault::kOnTrial:
        return 7;
      default:
        return 63;
    }
  }

  std::uint32_t crc_of(std::size_t slot) const {
    update::ImageHeader header;
    return update::read_header(*memory_, slot, header) ? header.crc : 0;
  }
  std::uint32_t read_update(std::uint8_t sub) {
    const std::size_t spare = writer_->slot();
    switch (sub) {
      case 1:
        return static_cast<std::uint32_t>(memory_->running() + 1);
      case 2:
        return static_cast<std::uint32_t>(watch_->state());
      case 3:
        return static_cast<std::uint32_t>(update::look(*memory_, spare).state);
      case 4:
        return crc_of(spare);
      case 5:
        return memory_->address(spare);
      case 6:
        return memory_->board();
      case 7:
        return writer_->taken();
      case 8:
        return writer_->crc();
      default:
        return static_cast<std::uint32_t>(fault_);
    }
  }

  ProgramMemory* memory_;
  std::optional<update::ProgramWriter> writer_;
  std::optional<update::TrialWatch> watch_;
  Fault fault_ = Fault::kNone;
  bool restarting_ = false;
  std::uint32_t now_us_ = 0;
  std::uint32_t restart_asked_us_ = 0;
};

}  // namespace slipstack::canopen
