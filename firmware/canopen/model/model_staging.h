// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/model/staged_model.h"
#include "firmware/canopen/network/counter.h"
#include "firmware/canopen/objects/encoder_objects.h"
#include "firmware/control/controller.h"
#include "hal/include/signal_scaling.h"

namespace slipstack::canopen {

/// The friction model on its way into the controller: staged in the dictionary (2100h and up, or 2141h at
/// once), then applied by its hash (2140h).
class ModelStaging {
 public:
  /// `scaling`, `encoder`: of the board; nullptr where it has none.
  ModelStaging(Controller& controller, SignalScaling* scaling, AbsoluteEncoder* encoder)
      : controller_(controller), scaling_(scaling), encoder_(encoder) {}

  /// The dictionary holds other values, after a start or a reset: step() brings them into force.
  void reset() { phase_ = Phase::kStopping; }
  bool resetting() const { return phase_ != Phase::kNone; }

  /// Once in every poll. At a reset the axis stops by the parameters that it moves by; then those are
  /// withdrawn, so that nothing runs that no object shows; then the values of the dictionary are applied, and
  /// if they are refused the drive has none.
  void step(Dictionary& dictionary) {
    if (controller_.parameters().axis.check_direction && !controller_.direction_unknown()) {
      dictionary.set(kRow<kDirectionIndex, 5>, checked_scales_);
    }
    if (phase_ == Phase::kNone || controller_.change_pending() || controller_.driving()) return;
    if (phase_ == Phase::kStopping && controller_.parameters().valid) {
      if (controller_.withdraw_parameters()) phase_ = Phase::kWithdrawn;
      return;
    }
    if (phase_ != Phase::kFirstReadings) {
      // Nothing is in force now: readings may step.
      scales_ = staged_scales(dictionary);
      if (scaling_ != nullptr) scaling_->set_scales(scales_);
      if (encoder_ != nullptr) encoder_->use(staged_encoder(dictionary));
      since_ = controller_.ticks();
      phase_ = Phase::kFirstReadings;
    }
    // An encoder with frames has a position some ticks later.
    if (encoder_ != nullptr && controller_.ticks() - since_ < kFirstReadings_ticks) return;
    phase_ = Phase::kNone;
    configure(dictionary, staged_model(dictionary));
  }

  /// 2140h:03: applied if the hash that the master writes is that of the staged model.
  Abort apply_checked(const Dictionary& dictionary, std::uint32_t hash) {
    if (resetting() || controller_.driving() || controller_.change_pending()) return Abort::kDeviceState;
    const ModelParameters model = staged_model(dictionary);
    if (hash != model_hash(model)) return Abort::kBadValue;
    configure(dictionary, model);
    if (status_ == ParameterStatus::kOk) return Abort::kNone;
    count(refused_);
    return Abort::kGeneral;
  }

  std::uint32_t read(const Dictionary& dictionary, std::uint8_t sub) const {
    switch (sub) {
      case 1:
        return model_hash(staged_model(dictionary));
      case 2:
        return controller_.parameters().hash;
      case 4:
        return static_cast<std::uint32_t>(status_);
      case 5:
        return controller_.change_pending() ? 1U : 0U;
      case 6:
        return refused_;
      default:
        return 0;
    }
  }

  // ---- 2141h: all words of the model as one domain ----

  static Abort begin_upload(std::uint32_t& size) {
    size = kImageBytes;
    return Abort::kNone;
  }
  static void upload(const Dictionary& dictionary, std::uint32_t offset, std::span<std::uint8_t> out) {
    for (std::uint8_t& byte : out) {
      byte = static_cast<std::uint8_t>(dictionary.value(kModelImageRows[offset / 4]) >> (8 * (offset % 4)));
      ++offset;
    }
  }
  static Abort begin_download(std::uint32_t size) {
    return size == 0 || size == kImageBytes ? Abort::kNone : Abort::kLength;
  }
  Abort download(std::uint32_t offset, std::span<const std::uint8_t> in) {
    for (const std::uint8_t byte : in) {
      if (offset >= kImageBytes) return Abort::kTooLong;
      const std::uint32_t shift = 8 * (offset % 4);
      std::uint32_t& into = incoming_[offset / 4];
      into = (into & ~(0xFFU << shift)) | (static_cast<std::uint32_t>(byte) << shift);
      ++offset;
    }
    return Abort::kNone;
  }
  /// All or nothing: one value out of bounds, and the staged model stays what it was.
  Abort end_download(Dictionary& dictionary, std::uint32_t size) {
    if (size != kImageBytes) return Abort::kTooShort;
    for (std::size_t i = 0; i < kModelWords; ++i) {
      const Abort code = check_bounds(kObjects[kModelImageRows[i]], incoming_[i]);
      if (code != Abort::kNone) return code;
    }
    for (std::size_t i = 0; i < kModelWords; ++i) dictionary.set(kModelImageRows[i], incoming_[i]);
    return Abort::kNone;
  }

 private:
  static constexpr std::uint32_t kImageBytes = 4 * kModelWords;

  // Checked first: what the controller itself refuses counts as a fault of an enabled axis.
  void configure(const Dictionary& dictionary, const ModelParameters& model) {
    const AxisParameters axis = staged_axis(dictionary);
    status_ = slipstack::check(axis, model);
    if (status_ == ParameterStatus::kOk && scaling_ != nullptr &&
        axis.current_limit_A > scaling_->largest_A(scales_)) {
      status_ = ParameterStatus::kAmplifierTooSmall;
    }
    if (status_ == ParameterStatus::kOk) status_ = controller_.configure(axis, model);
    if (status_ == ParameterStatus::kOk) checked_scales_ = scales_hash(dictionary);
  }

  enum class Phase : std::uint8_t { kNone, kStopping, kWithdrawn, kFirstReadings };
  static constexpr std::uint32_t kFirstReadings_ticks = 8;

  Controller& controller_;
  SignalScaling* scaling_;
  AbsoluteEncoder* encoder_;
  std::uint32_t since_ = 0;           // the tick from which readings are those of the scales
  SignalScales scales_;               // in force
  std::uint32_t checked_scales_ = 0;  // with the parameters in force
  Phase phase_ = Phase::kNone;
  ParameterStatus status_ = ParameterStatus::kNoMass;
  std::uint32_t refused_ = 0;
  std::array<std::uint32_t, kModelWords> incoming_{};
};

}  // namespace slipstack::canopen
