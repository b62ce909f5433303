// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "firmware/canopen/application.h"
#include "firmware/canopen/model/model_staging.h"
#include "firmware/canopen/node.h"
#include "firmware/canopen/objects/analogue_objects.h"
#include "firmware/canopen/objects/encoder_objects.h"
#include "firmware/canopen/objects/excitation_objects.h"
#include "firmware/canopen/objects/trace_objects.h"
#include "firmware/canopen/profile/drive_profile.h"
#include "firmware/canopen/sdo/program_download.h"
#include "firmware/canopen/telemetry/telemetry.h"

namespace slipstack::canopen {

/// The application of the node: the drive profile, the friction model, telemetry and the trace, each with its
/// objects. Runs in the main loop; reaches the tick only through what the controller offers for that.
class Drive final : public Application {
 public:
  /// `scaling`: of the board's signals; a board that has none keeps 2500h at its defaults. `programs`: of a
  /// board whose firmware can be replaced over the bus. `absolute_encoder`: of a board that can read one.
  /// `analogue`: of a board with inputs for temperature or DC link voltage. `edges`: of a board that catches
  /// the edges of an input.
  Drive(Controller& controller, const TickTiming& timing, TraceBuffer& trace, std::uint32_t serial,
        SignalScaling* scaling = nullptr, ProgramMemory* programs = nullptr,
        AbsoluteEncoder* absolute_encoder = nullptr, AnalogueInputs* analogue = nullptr,
        EdgeCapture* edges = nullptr);

  /// From the tick's interrupt, behind the tick.
  void after_tick();

  /// Once in every pass of the main loop. `reports`: the node takes part in the bus.
  void watch_trial(std::uint32_t now_us, bool reports);

  // ---- what communication means ----

  void reset(Dictionary& dictionary) override;
  void step(std::uint32_t now_us) override;
  std::uint16_t error_code() override;
  std::uint32_t warning() override;
  bool enabled() override;
  void set_operational(bool operational) override;
  std::uint32_t serial_number() const override;
  void connection_lost() override;
  void unheard() override;
  void synchronise(const Pdos& pdos) override;

  // ---- objects ----

  std::uint32_t read(std::size_t row) override;
  Abort check_read(std::size_t row) override;
  Abort check(std::size_t row, std::uint32_t value) override;
  void written(std::size_t row, std::uint32_t value) override;
  void commit() override;
  std::uint32_t tick() const override;

  // ---- domains: the model's image, the trace, a program ----

  Abort begin_upload(std::size_t row, std::uint32_t& size) override;
  void upload(std::size_t row, std::uint32_t offset, std::span<std::uint8_t> out) override;
  Abort begin_download(std::size_t row, std::uint32_t size) override;
  Abort download(std::size_t row, std::uint32_t offset, std::span<const std::uint8_t> in) override;
  Abort end_download(std::size_t row, std::uint32_t size) override;

 private:
  std::uint32_t mode() const { return profile_.read(0x6061, kRow<0x6061>); }

  void step_reset();

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
