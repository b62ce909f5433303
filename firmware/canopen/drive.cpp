// SPDX-License-Identifier: Apache-2.0
#include "firmware/canopen/drive.h"

#include <bit>

namespace slipstack::canopen {

Drive::Drive(Controller& controller, const TickTiming& timing, TraceBuffer& trace, std::uint32_t serial,
             SignalScaling* scaling, ProgramMemory* programs, AbsoluteEncoder* absolute_encoder,
             AnalogueInputs* analogue, EdgeCapture* edges)
    : controller_(controller),
      serial_(serial),
      scalable_(scaling != nullptr),
      profile_(controller, edges),
      encoder_(absolute_encoder),
      analogue_(controller, analogue),
      model_(controller, scaling, absolute_encoder),
      telemetry_(controller, timing),
      trace_(controller, trace),
      excitation_(controller),
      program_(programs) {}

void Drive::after_tick() {
  trace_.after_tick();
  excitation_.after_tick();
}

void Drive::watch_trial(std::uint32_t now_us, bool reports) {
  program_.watch_trial(now_us, reports, profile_.driving());
}

void Drive::reset(Dictionary& dictionary) {
  dictionary_ = &dictionary;
  profile_.begin_reset(dictionary);
  model_.reset();
  step_reset();
}

void Drive::step(std::uint32_t now_us) {
  controller_.poll();
  analogue_.step();
  step_reset();
  profile_.step();
  excitation_.step(*dictionary_, mode());
  program_.step(now_us, profile_.driving());
}

std::uint16_t Drive::error_code() {
  return profile_.error_code();
}

std::uint32_t Drive::warning() {
  return telemetry_.hunting_warning();
}

bool Drive::enabled() {
  return profile_.driving();
}

void Drive::set_operational(bool operational) {
  profile_.set_operational(operational);
}

std::uint32_t Drive::serial_number() const {
  return serial_;
}

void Drive::connection_lost() {
  profile_.connection_lost();
}

void Drive::unheard() {
  profile_.unheard();
}

void Drive::synchronise(const Pdos& pdos) {
  profile_.synchronise(pdos.took_at_sync(profile_.set_point_row()));
}

std::uint32_t Drive::read(std::size_t row) {
  const Object& object = kObjects[row];
  switch (object.index) {
    case kModelIndex:
      return model_.read(*dictionary_, object.sub);
    case kObserverIndex:
      return telemetry_.read_observer(object.sub, trace_.mean_command_A());
    case kByEffectIndex:
      return telemetry_.read_by_effect(object.sub);
    case kHuntingIndex:
      return telemetry_.read_hunting(object.sub, dictionary_->value(row));
    case kTimingIndex:
      return telemetry_.read_timing(object.sub);
    case kCountersIndex:
      return telemetry_.underruns();
    case kThermalIndex:
      return telemetry_.read_load(object.sub, dictionary_->value(row));
    case kFaultCountsIndex:
      return telemetry_.fault_count(object.sub);
    case kReferenceIndex:
      return controller_.position().referenced() ? 1U : 0U;
    case kDriftIndex:
      return std::bit_cast<std::uint32_t>(controller_.drift_s());
    case kEncoderIndex:
      return encoder_.read(object.sub);
    case kAnalogueIndex:
      return analogue_.temperature();
    case 0x6079:
      return analogue_.bus_voltage();
    case kTraceIndex:
      return trace_.read(*dictionary_, object.sub);
    case kExcitationIndex:
      return excitation_.read(*dictionary_, object.sub);
    case kProgramControlIndex:
    case kProgramIdentityIndex:
    case kFlashStatusIndex:
    case kUpdateIndex:
      return program_.read(object.index, object.sub);
    default:
      return profile_.read(object.index, row);
  }
}

Abort Drive::check_read(std::size_t row) {
  return analogue_.check_read(kObjects[row]);
}

Abort Drive::check(std::size_t row, std::uint32_t value) {
  const Object& object = kObjects[row];
  switch (object.index) {
    case kModelIndex:
      return object.sub == 3 ? model_.apply_checked(*dictionary_, value) : Abort::kNone;
    case kTraceIndex:
      return trace_.check(object.sub);
    case kExcitationIndex:
      return excitation_.check(*dictionary_, object.sub, value, mode());
    case kProgramControlIndex:
      return program_.control(value, profile_.driving());
    case kEncoderIndex:
      return encoder_.check(*dictionary_, object.sub, value);
    case kAnalogueIndex:
      return analogue_.check(object.sub, value);
    case kScalesIndex:
      return scalable_ || value == object.initial ? Abort::kNone : Abort::kUnsupportedAccess;
    default:
      return profile_.check(row, value);
  }
}

void Drive::written(std::size_t row, std::uint32_t value) {
  const Object& object = kObjects[row];
  if (object.index == kExcitationIndex) {
    if (object.sub == 1) excitation_.command(*dictionary_, value);
    return;
  }
  if (object.index == kHuntingIndex) {
    if (object.sub == 9 && value == 1) controller_.forget_hunting();
    return;
  }
  if (object.index != kTraceIndex) return profile_.written(object.index, value);
  if (object.sub == 1) trace_.command(*dictionary_, value);
}

void Drive::commit() {
  profile_.commit();
}

std::uint32_t Drive::tick() const {
  return controller_.ticks();
}

Abort Drive::begin_upload(std::size_t row, std::uint32_t& size) {
  return is_model_image(row) ? ModelStaging::begin_upload(size) : trace_.begin_upload(size);
}

void Drive::upload(std::size_t row, std::uint32_t offset, std::span<std::uint8_t> out) {
  if (is_model_image(row)) return ModelStaging::upload(*dictionary_, offset, out);
  trace_.upload(offset, out);
}

Abort Drive::begin_download(std::size_t row, std::uint32_t size) {
  return is_program_data(row) ? program_.begin() : ModelStaging::begin_download(size);
}

Abort Drive::download(std::size_t row, std::uint32_t offset, std::span<const std::uint8_t> in) {
  return is_program_data(row) ? program_.download(in, profile_.driving()) : model_.download(offset, in);
}

Abort Drive::end_download(std::size_t row, std::uint32_t size) {
  return is_program_data(row) ? program_.end() : model_.end_download(*dictionary_, size);
}

void Drive::step_reset() {
  const bool resetting = model_.resetting();
  model_.step(*dictionary_);
  if (resetting && !model_.resetting()) profile_.end_reset();
}

}  // namespace slipstack::canopen
