// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>

#include "firmware/canopen/application.h"
#include "firmware/canopen/model/model_staging.h"
#include "firmware/canopen/node.h"
#include "firmware/canopen/objects/analogue_objects.h"
#include "firmware/canopen/objects/encoder_objects.h"
#include "firmware/canopen/objects/excitation_objects.h"
#include "firmware/canopen/objects/trace_objects.h"
#include "firmware/canopen/profile/drive_profile.h"
#include "firmware/canopen/services/program_download.h"
#include "firmware/canopen/telemetry/telemetry.h"

namespace slipstack::canopen {

/// The application of the node: the drive profile, the friction model, telemetry and the trace, each with its
/// objects. Runs in the main loop; reaches the tick only through what the controller offers for that.
class Drive final : public Application {
 public:
  /// `scaling`: of the board's signals; a board that has none keeps 2500h at its defaults. `programs`: of a
  /// board whose firmware can be replaced over the bus. `absolute_encoder`: of a board that can read one.
  /// `analogue`: of a board with inputs for temperature or DC link voltage.
  Drive(Controller& controller, const TickTiming& timing, TraceBuffer& trace, std::uint32_t serial,
        SignalScaling* scaling = nullptr, ProgramMemory* programs = nullptr,
        AbsoluteEncoder* absolute_encoder = nullptr, AnalogueInputs* analogue = nullptr)
      : controller_(controller),
        serial_(serial),
        scalable_(scaling != nullptr),
        profile_(controller),
        encoder_(absolute_encoder),
        analogue_(controller, analogue),
        model_(controller, scaling, absolute_encoder),
        telemetry_(controller, timing),
        trace_(controller, trace),
        excitation_(controller),
        program_(programs) {}

  /// From the tick's interrupt, behind the tick.
  void after_tick() {
    trace_.after_tick();
    excitation_.after_tick();
  }

  /// Once in every pass of the main loop. `reports`: the node takes part in the bus.
  void watch_trial(std::uint32_t now_us, bool reports) {
    program_.watch_trial(now_us, reports, profile_.driving());
  }

  ParameterStatus last_apply() const { return model_.last_status(); }

  // ---- what communication means ----

  void reset(Dictionary& dictionary) override {
    dictionary_ = &dictionary;
    profile_.begin_reset(dictionary);
    model_.reset();
    step_reset();
  }
  void step(std::uint32_t now_us) override {
    controller_.poll();
    analogue_.step();
    step_reset();
    profile_.step();
    excitation_.step(*dictionary_, mode());
    program_.step(now_us, profile_.driving());
  }
  std::uint16_t error_code() override { return profile_.error_code(); }
  bool enabled() override { return profile_.driving(); }
  void set_operational(bool operational) override { profile_.set_operational(operational); }
  std::uint32_t serial_number() const override { return serial_; }
  void connection_lost() override { profile_.connection_lost(); }
  void unheard() override { profile_.unheard(); }
  void synchronise(const Pdos& pdos) override {
    profile_.synchronise(pdos.took_at_sync(profile_.set_point_row()));
  }

  // ---- objects ----

  std::uint32_t read(std::size_t row) override {
    const Object& object = kObjects[row];
    switch (object.index) {
      case kModelIndex:
        return model_.read(*dictionary_, object.sub);
      case kObserverIndex:
        return telemetry_.read_observer(object.sub, trace_.mean_command_A());
      case kByEffectIndex:
        return telemetry_.read_by_effect(object.sub);
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

  Abort check_read(std::size_t row) override { return analogue_.check_read(kObjects[row]); }

  Abort check(std::size_t row, std::uint32_t value) override {
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

  void written(std::size_t row, std::uint32_t value) override {
    const Object& object = kObjects[row];
    if (object.index == kExcitationIndex) {
      if (object.sub == 1) excitation_.command(*dictionary_, value);
      return;
    }
    if (object.index != kTraceIndex) return profile_.written(object.index, value);
    if (object.sub == 1) trace_.command(*dictionary_, value);
  }

  void commit() override { profile_.commit(); }
  std::uint32_t tick() const override { return controller_.ticks(); }

  // ---- domains: the model's image, the trace, a program ----

  Abort begin_upload(std::size_t row, std::uint32_t& size) override {
    return is_model_image(row) ? ModelStaging::begin_upload(size) : trace_.begin_upload(size);
  }
  void upload(std::size_t row, std::uint32_t offset, std::span<std::uint8_t> out) override {
    if (is_model_image(row)) return ModelStaging::upload(*dictionary_, offset, out);
    trace_.upload(offset, out);
  }
  Abort begin_download(std::size_t row, std::uint32_t size) override {
    return is_program_data(row) ? program_.begin() : ModelStaging::begin_download(size);
  }
  Abort download(std::size_t row, std::uint32_t offset, std::span<const std::uint8_t> in) override {
    return is_program_data(row) ? program_.download(in, profile_.driving()) : model_.download(offset, in);
  }
  Abort end_download(std::size_t row, std::uint32_t size) override {
    return is_program_data(row) ? program_.end() : model_.end_download(*dictionary_, size);
  }

 private:
  std::uint32_t mode() const { return profile_.read(0x6061, kRow<0x6061>); }

  void step_reset() {
    const bool resetting = model_.resetting();
    model_.step(*dictionary_);
    if (resetting && !model_.resetting()) profile_.end_reset();
  }

  static bool is_model_image(std::size_t row) { return kObjects[row].index == kModelImageIndex; }
  static bool is_program_data(std::size_t row) { return kObjects[row].index == kProgramDataIndex; }

  Controller& controller_;
  std::uint32_t serial_;
  bool scalable_;
  Dictionary* dictionary_ = nullptr;
  DriveProfile profile_;
  EncoderObjects encoder_;
  AnalogueObjects analogue_;
  ModelStaging model_;
  Telemetry telemetry_;
  TraceObjects trace_;
  ExcitationObjects excitation_;
  ProgramDownload program_;
};

}  // namespace slipstack::canopen
