// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstring>

#include "firmware/canopen/counter.h"
#include "firmware/canopen/node.h"
#include "firmware/canopen/staged_model.h"
#include "firmware/canopen/trace.h"
#include "firmware/control/controller.h"
#include "firmware/control/tick.h"

namespace slipstack::canopen {

enum class Mode : std::int8_t { kNone = 0, kProfilePosition = 1, kCyclicPosition = 8, kCyclicTorque = 10 };

/// The drive profile CiA 402 and the friction objects, bound to the controller. Runs in the main loop;
/// reaches the tick only through what the controller offers for that.
///
/// Values of several words that belong to one tick are read as a snapshot: taken again when a tick came in
/// between.
class Drive final : public Application {
 public:
  Drive(Controller& controller, const TickTiming& timing, TraceBuffer& trace, std::uint32_t serial)
      : controller_(controller), timing_(timing), trace_(trace), serial_(serial) {}

  /// From the tick's interrupt, behind the tick.
  ///
  /// What is recorded beside the counts is the force that acted when they were read: a command is held from
  /// this tick to the next, so about this instant the current was the mean of the last command and this one.
  /// The command alone would be half a tick early, at a jerk of 100 m/s3 and 35 kg 0.18 N.
  void after_tick() {
    const float command_A = controller_.output().current_A;
    about_reading_A_ = 0.5F * (last_command_A_ + command_A);
    last_command_A_ = command_A;
    trace_.sample({controller_.measured_counts(), controller_.output().reference_counts, about_reading_A_},
                  controller_.ticks());
  }

  ParameterStatus last_apply() const { return applied_; }

  // ---- what communication means ----

  void reset(Dictionary& dictionary) override {
    dictionary_ = &dictionary;
    control_ = 0;
    mode_ = Mode::kNone;
    command();
    apply();
  }

  void step(std::uint32_t) override {
    controller_.poll();
    follow_mode();
    command();
    give_torque();
    profile_position();
  }

  std::uint16_t error_code() override {
    return slipstack::error_code(controller_.state().faults().latched());
  }
  bool enabled() override { return controller_.state().driving(); }
  void set_operational(bool operational) override { operational_ = operational; }
  std::uint32_t serial_number() const override { return serial_; }

  void connection_lost() override {
    if (!enabled()) return;
    switch (value(kRow<0x6007>)) {
      case 2:
        control_ = static_cast<std::uint16_t>(control_ & ~kEnableVoltage);
        break;
      case 3:
        control_ = static_cast<std::uint16_t>(control_ & ~kQuickStop);
        break;
      default:
        return;
    }
    command();
  }

  /// Cyclic position: each SYNC takes the target as the next set-point.
  void synchronise() override {
    if (active_ != Mode::kCyclicPosition || !operation_enabled() || halted()) return;
    ReferenceGenerator& reference = controller_.reference();
    if (!streaming_) {
      last_target_ = reference.counts();
      stream_.start(reference, period_ticks());
      streaming_ = true;
    }
    // A set-point beyond what the axis may move in a period is taken as far as it may.
    const ControlSet& set = controller_.parameters();
    const float reach = set.axis.velocity_limit_mps / set.mps_per_count * static_cast<float>(period_ticks());
    const auto limit = static_cast<std::int32_t>(approx::clamp(reach, 1.0F, 1.0e6F));
    const std::int32_t way = std::clamp<std::int32_t>(
        difference(static_cast<std::int32_t>(value(kRow<0x607A>)), last_target_), -limit, limit);
    const std::int32_t target = sum(last_target_, way);
    if (stream_.push(reference, target)) last_target_ = target;
  }

  // ---- objects ----

  std::uint32_t read(std::size_t row) override {
    const Object& object = kObjects[row];
    switch (object.index) {
      case kModelIndex:
        return read_model(object.sub);
      case kObserverIndex:
        return object.sub < kMemorySub ? snapshot([&] { return read_observer(object.sub); })
                                       : read_memory(object.sub);
      case kByEffectIndex:
        return word(controller_.friction().by_effect_N[object.sub - 1U]);
      case kTimingIndex:
        return read_timing(object.sub);
      case kCountersIndex:
        return controller_.reference().underruns();
      case kFaultCountsIndex:
        return controller_.state().faults().count(static_cast<Fault>(object.sub));
      case kTraceIndex:
        return read_trace(object.sub);
      default:
        return read_profile(object.index, row);
    }
  }

  Abort check(std::size_t row, std::uint32_t value_now) override {
    const Object& object = kObjects[row];
    switch (object.index) {
      case 0x6007:
      case 0x605E:
        return value_now == 1 ? Abort::kBadValue : Abort::kNone;  // not offered
      case 0x605A:
        return value_now == 0 || value_now == 2 || value_now == 6 ? Abort::kNone : Abort::kBadValue;
      case 0x6060: {
        const auto mode = static_cast<Mode>(static_cast<std::int8_t>(value_now));
        const bool known = mode == Mode::kNone || mode == Mode::kProfilePosition ||
                           mode == Mode::kCyclicPosition || mode == Mode::kCyclicTorque;
        return known ? Abort::kNone : Abort::kBadValue;
      }
      case kModelIndex:
        return object.sub == 3 ? apply_checked(value_now) : Abort::kNone;
      case kTraceIndex:
        return object.sub != 1 && recording() ? Abort::kDeviceState : Abort::kNone;
      default:
        return Abort::kNone;
    }
  }

  void written(std::size_t row, std::uint32_t value_now) override {
    const Object& object = kObjects[row];
    switch (object.index) {
      case 0x6040:
        return controlword(static_cast<std::uint16_t>(value_now));
      case 0x6060:
        mode_ = static_cast<Mode>(static_cast<std::int8_t>(value_now));
        follow_mode();
        give_torque();
        return command();
      case 0x6071:
      case 0x60B2:
        return give_torque();
      case kTraceIndex:
        if (object.sub == 1) trace_command(value_now);
        return;
      default:
        return;
    }
  }

  // ---- domains: the model's image, the trace ----

  Abort begin_upload(std::size_t row, std::uint32_t& size) override {
    if (kObjects[row].index == kModelImageIndex) {
      size = 4 * kModelWords;
      return Abort::kNone;
    }
    if (recording() || trace_.samples() == 0) return Abort::kDeviceState;
    const ControlSet& set = controller_.parameters();
    head_ = {};
    head_.samples = trace_.samples();
    head_.decimation = trace_.decimation();
    head_.tick_s = set.axis.tick_s;
    head_.encoder_resolution_m = set.axis.encoder_resolution_m;
    head_.motor_constant_N_per_A = set.axis.motor_constant_N_per_A;
    head_.mass_kg = set.mass_kg;
    head_.model_hash = set.hash;
    head_.trigger_place = trace_.trigger_place();
    head_.last_tick = trace_.last_tick();
    size = static_cast<std::uint32_t>(sizeof(TraceHead) + sizeof(TraceSample) * head_.samples);
    return Abort::kNone;
  }

  void upload(std::size_t row, std::uint32_t offset, std::span<std::uint8_t> out) override {
    for (std::uint8_t& byte : out) {
      byte = kObjects[row].index == kModelImageIndex ? image_byte(offset) : trace_byte(offset);
      ++offset;
    }
  }

  Abort begin_download(std::size_t, std::uint32_t size) override {
    return size == 0 || size == 4 * kModelWords ? Abort::kNone : Abort::kLength;
  }
  Abort download(std::size_t, std::uint32_t offset, std::span<const std::uint8_t> in) override {
    for (const std::uint8_t byte : in) {
      if (offset >= 4 * kModelWords) return Abort::kTooLong;
      const std::uint32_t shift = 8 * (offset % 4);
      std::uint32_t& into = incoming_[offset / 4];
      into = (into & ~(0xFFU << shift)) | (static_cast<std::uint32_t>(byte) << shift);
      ++offset;
    }
    return Abort::kNone;
  }
  /// All or nothing: one value out of bounds, and the staged model stays what it was.
  Abort end_download(std::size_t, std::uint32_t size) override {
    if (size != 4 * kModelWords) return Abort::kTooShort;
    for (std::size_t i = 0; i < kModelWords; ++i) {
      const Abort code = check_bounds(kObjects[kModelImageRows[i]], incoming_[i]);
      if (code != Abort::kNone) return code;
    }
    for (std::size_t i = 0; i < kModelWords; ++i) dictionary_->set(kModelImageRows[i], incoming_[i]);
    return Abort::kNone;
  }

 private:
  static std::uint32_t word(float number) { return std::bit_cast<std::uint32_t>(number); }
  std::uint32_t value(std::size_t row) const { return dictionary_->value(row); }

  // Reads again when a tick came in between; a tick is far longer than a reading.
  template <class Reading>
  std::uint32_t snapshot(Reading&& reading) const {
    std::uint32_t result = 0;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t before = controller_.ticks();
      result = reading();
      if (controller_.ticks() == before) break;
    }
    return result;
  }

  // ---- the model ----

  void apply() { applied_ = controller_.configure(staged_axis(*dictionary_), staged_model(*dictionary_)); }

  Abort apply_checked(std::uint32_t hash) {
    if (enabled() || controller_.change_pending()) return Abort::kDeviceState;
    const ModelParameters model = staged_model(*dictionary_);
    if (hash != model_hash(model)) return Abort::kBadValue;
    // Looked at first: what the controller is asked to refuse would count as a fault of an enabled axis.
    const AxisParameters axis = staged_axis(*dictionary_);
    applied_ = slipstack::check(axis, model);
    if (applied_ == ParameterStatus::kOk) applied_ = controller_.configure(axis, model);
    if (applied_ == ParameterStatus::kOk) return Abort::kNone;
    count(refused_);
    return Abort::kGeneral;
  }

  std::uint32_t read_model(std::uint8_t sub) const {
    switch (sub) {
      case 1:
        return model_hash(staged_model(*dictionary_));
      case 2:
        return controller_.parameters().hash;
      case 4:
        return static_cast<std::uint32_t>(applied_);
      case 5:
        return controller_.change_pending() ? 1U : 0U;
      case 6:
        return refused_;
      default:
        return 0;
    }
  }

  std::uint8_t image_byte(std::uint32_t offset) const {
    return static_cast<std::uint8_t>(value(kModelImageRows[offset / 4]) >> (8 * (offset % 4)));
  }

  // ---- observer, timing, trace ----

  std::uint32_t read_observer(std::uint8_t sub) const {
    const ControlOutput& out = controller_.output();
    switch (sub) {
      case 1:
        return word(out.feedforward_N);
      case 2:
        return word(out.feedback_N);
      case 3:
        return word(out.residual_N);
      case 4:
        return word(out.level);
      case 5:
        return word(controller_.friction().dry_friction_N);
      case 6:
        return word(controller_.friction().total_N);
      case 7:
        return word(out.position_error_m);
      case 8:
        return word(out.velocity_mps);
      case 9:
        return static_cast<std::uint32_t>(out.reference_counts);
      case 10:
        return out.limits;
      case 11:
        return rounded(about_reading_A_ / controller_.parameters().axis.current_limit_A * 32767.0F, 32767.0F);
      case 12:
        return word(out.current_A);
      default:
        return controller_.parameters().hash;
    }
  }

  // Written by the main loop, as this is read in it.
  std::uint32_t read_memory(std::uint8_t sub) const {
    const HysteresisMemory& memory = controller_.memory();
    switch (sub) {
      case kMemorySub:
        return memory.depth();
      case kMemorySub + 1:
        return memory.overflow_count();
      case kMemorySub + 2:
        return word(memory.overflow_height_N());
      default:
        return memory.missed_ticks();
    }
  }

  std::uint32_t read_timing(std::uint8_t sub) const {
    switch (sub) {
      case 1:
        return timing_.longest_period;
      case 2:
        return timing_.longest_duration;
      case 3:
        return timing_.overruns;
      case 4:
        return controller_.ticks();
      default:
        return controller_.ticks() & 0xFFFF;
    }
  }

  bool recording() const {
    return trace_.state() == TraceState::kArmed || trace_.state() == TraceState::kTriggered;
  }
  std::uint32_t read_trace(std::uint8_t sub) const {
    switch (sub) {
      case 2:
        return static_cast<std::uint32_t>(trace_.state());
      case 8:
        return trace_.samples();
      case 9:
        return trace_.capacity();
      default:
        return value(kRow<kTraceIndex, 1>);
    }
  }
  void trace_command(std::uint32_t command_now) {
    if (command_now == 0) return trace_.stop();
    trace_.arm({value(kRow<kTraceIndex, 3>), static_cast<TraceTrigger>(value(kRow<kTraceIndex, 4>)),
                static_cast<std::uint8_t>(value(kRow<kTraceIndex, 5>)),
                dictionary_->real(kRow<kTraceIndex, 6>), value(kRow<kTraceIndex, 7>)});
  }
  std::uint8_t trace_byte(std::uint32_t offset) const {
    if (offset < sizeof(TraceHead)) return byte_of(head_, offset);
    const std::uint32_t at = offset - static_cast<std::uint32_t>(sizeof(TraceHead));
    return byte_of(trace_[at / sizeof(TraceSample)], at % sizeof(TraceSample));
  }
  template <class T>
  static std::uint8_t byte_of(const T& object, std::size_t at) {
    std::uint8_t byte = 0;
    std::memcpy(&byte, reinterpret_cast<const std::uint8_t*>(&object) + at, 1);
    return byte;
  }

  // ---- CiA 402 ----

  float rated_force_N() const {
    return static_cast<float>(value(kRow<0x6075>)) * 1e-3F *
           controller_.parameters().axis.motor_constant_N_per_A;
  }
  // Of the rated current, and so of the rated force.
  float in_thousandths(float current_A) const {
    return current_A / (static_cast<float>(value(kRow<0x6075>)) * 1e-6F);
  }
  static std::uint32_t rounded(float number, float largest) {
    const float limited = approx::clamp(number, -largest, largest);
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(limited + (limited < 0.0F ? -0.5F : 0.5F)));
  }
  float in_counts(float metres) const { return metres / controller_.parameters().axis.encoder_resolution_m; }

  std::uint32_t read_profile(std::uint16_t index, std::size_t row) const {
    const ControlOutput& out = controller_.output();
    switch (index) {
      case 0x603F:
        return slipstack::error_code(controller_.state().faults().latched());
      case 0x6041:
        return statusword();
      case 0x6061:
        return static_cast<std::uint32_t>(active_);
      case 0x6064:
        return static_cast<std::uint32_t>(controller_.measured_counts());
      case 0x606C:
        return rounded(in_counts(out.velocity_mps), 2.1e9F);
      case 0x6076:
        return rounded(rated_force_N() * 1e3F, 2.1e9F);
      case 0x6074:
        return rounded(in_thousandths(out.current_A), 32767.0F);
      case 0x6077:
        return rounded(in_thousandths(controller_.measured_A()), 32767.0F);
      case 0x60F4:
        return rounded(in_counts(out.position_error_m), 2.1e9F);
      default:
        return value(row);
    }
  }

  bool operation_enabled() const { return controller_.state().state() == DriveState::kOperationEnabled; }
  bool halted() const { return (control_ & kHaltBit) != 0; }

  // Bits of IEC 61800-7-201 table 29; 12 and 13 by mode.
  std::uint16_t statusword() const {
    const DriveState state = controller_.state().state();
    unsigned word_now = status_word(state);
    const bool voltage = controller_.parameters().valid;
    if (voltage) word_now |= 1U << 4;
    if (state == DriveState::kSwitchOnDisabled || state == DriveState::kFault ||
        state == DriveState::kFaultReactionActive || state == DriveState::kNotReadyToSwitchOn) {
      word_now |= (control_ & kQuickStop) != 0 ? 1U << 5 : 0U;
    }
    if (operational_) word_now |= 1U << 9;
    if (controller_.output().limits != 0) word_now |= 1U << 11;
    if (active_ == Mode::kProfilePosition) {
      if (controller_.reference().idle() && !waiting_) word_now |= 1U << 10;
      if (acknowledged_) word_now |= 1U << 12;
    } else if (active_ != Mode::kNone && state == DriveState::kOperationEnabled && !halted()) {
      word_now |= 1U << 12;  // the drive follows the command
    }
    if (controller_.state().faults().latched() == Fault::kFollowingError) word_now |= 1U << 13;
    return static_cast<std::uint16_t>(word_now);
  }

  void controlword(std::uint16_t word_now) {
    const auto rising = static_cast<std::uint16_t>(word_now & ~control_);
    control_ = word_now;
    command();
    if ((rising & kHaltBit) != 0 && operation_enabled()) {
      controller_.reference().stop();
      waiting_ = streaming_ = target_stands_ = false;
    }
    if (active_ == Mode::kProfilePosition) new_set_point(rising);
  }

  // Quick stop option 0: no braking, current off; fault reaction option 0 the same. Option 6: braked and
  // held, the state kept. Halt leaves torque mode: the axis brakes and holds its place.
  void command() {
    std::uint16_t word_now = control_;
    const bool quick_stop = (word_now & kQuickStop) == 0;
    if (quick_stop && dictionary_ != nullptr && value(kRow<0x605A>) == 0)
      word_now &= static_cast<std::uint16_t>(~kEnableVoltage);
    std::uint32_t options = 0;
    if (active_ == Mode::kCyclicTorque && !halted()) options |= kTorqueMode;
    if (dictionary_ != nullptr && value(kRow<0x605E>) == 0) options |= kReleaseOnFault;
    if (dictionary_ != nullptr && value(kRow<0x605A>) == 6) options |= kStayStopped;
    controller_.command_all(options | word_now);
  }

  // 6071h and 60B2h, in thousandths of the rated force. The target counts in torque mode only, the offset in
  // every mode.
  void give_torque() {
    const float per_thousandth_N = 1e-3F * rated_force_N();
    const auto force_N = [&](std::size_t row) {
      return static_cast<float>(static_cast<std::int32_t>(value(row))) * per_thousandth_N;
    };
    controller_.set_torque(force_N(kRow<0x6071>), force_N(kRow<0x60B2>));
  }

  void follow_mode() {
    if (!operation_enabled()) {
      streaming_ = waiting_ = acknowledged_ = target_stands_ = false;
    }
    if (mode_ == active_) return;
    if (operation_enabled()) controller_.reference().stop();
    active_ = mode_;
    streaming_ = waiting_ = acknowledged_ = target_stands_ = false;
  }

  // Controlword bit 4 rises: a set-point, which is the target and the profile as they are now; statusword bit
  // 12 says it was taken and falls with bit 4. A relative target counts from the one before; where there is
  // none, or a halt has given it up, from where the axis is asked to be.
  void new_set_point(std::uint16_t rising) {
    if ((control_ & kNewSetPointBit) == 0) {
      acknowledged_ = false;
      return;
    }
    if ((rising & kNewSetPointBit) == 0 || !operation_enabled() || halted() || waiting_) return;
    const auto target = static_cast<std::int32_t>(value(kRow<0x607A>));
    const std::int32_t from = target_stands_ ? last_target_ : controller_.reference().counts();
    target_ = (control_ & kRelativeBit) != 0 ? sum(from, target) : target;
    profile_ = {value(kRow<0x6081>), value(kRow<0x6083>), value(kRow<0x60A4, 1>)};
    if ((control_ & kImmediatelyBit) != 0) controller_.reference().stop();
    waiting_ = acknowledged_ = true;
  }

  void profile_position() {
    if (!waiting_ || active_ != Mode::kProfilePosition || !operation_enabled()) return;
    if (!controller_.reference().idle()) return;
    const ControlSet& set = controller_.parameters();
    const float tick_s = set.axis.tick_s;
    const auto limit = [](std::uint32_t wanted, float per, float axis) {
      const float own = static_cast<float>(wanted) * per;
      return own < axis ? own : axis;
    };
    const MotionLimits limits{
        limit(profile_.velocity, tick_s, set.axis.velocity_limit_mps / set.mps_per_count),
        limit(profile_.acceleration, tick_s * tick_s, set.axis.acceleration_limit_mps2 / set.mps2_per_count),
        limit(profile_.jerk, tick_s * tick_s * tick_s,
              set.axis.jerk_limit_mps3 / set.mps2_per_count * tick_s)};
    waiting_ = false;
    target_stands_ = true;
    last_target_ = target_;
    static_cast<void>(plan_move(controller_.reference(), target_, limits));
  }

  // 60C2h: value x 10^index seconds.
  std::int32_t period_ticks() const {
    float period_s = static_cast<float>(value(kRow<0x60C2, 1>));
    for (auto power = static_cast<std::int32_t>(value(kRow<0x60C2, 2>)); power < 0; ++power) period_s *= 0.1F;
    const float ticks = period_s / controller_.parameters().axis.tick_s + 0.5F;
    constexpr auto kLongest = static_cast<float>(SetpointStream::kLongestPeriod);
    return static_cast<std::int32_t>(approx::clamp(ticks, 1.0F, kLongest));
  }

  static constexpr std::uint16_t kNewSetPointBit = 1U << 4;
  static constexpr std::uint16_t kImmediatelyBit = 1U << 5;
  static constexpr std::uint16_t kRelativeBit = 1U << 6;
  static constexpr std::uint16_t kHaltBit = 1U << 8;

  Controller& controller_;
  const TickTiming& timing_;
  TraceBuffer& trace_;
  std::uint32_t serial_;
  float last_command_A_ = 0.0F;
  float about_reading_A_ = 0.0F;
  Dictionary* dictionary_ = nullptr;
  ParameterStatus applied_ = ParameterStatus::kNoMass;
  std::uint32_t refused_ = 0;
  std::uint16_t control_ = 0;
  Mode mode_ = Mode::kNone;
  Mode active_ = Mode::kNone;
  bool operational_ = false;
  bool streaming_ = false;
  bool waiting_ = false;
  bool acknowledged_ = false;
  struct Profile {
    std::uint32_t velocity = 1;      // counts/s
    std::uint32_t acceleration = 1;  // counts/s2
    std::uint32_t jerk = 1;          // counts/s3
  };
  Profile profile_;
  std::int32_t target_ = 0;
  std::int32_t last_target_ = 0;
  bool target_stands_ = false;
  SetpointStream stream_;
  TraceHead head_;
  std::array<std::uint32_t, kModelWords> incoming_{};
};

}  // namespace slipstack::canopen
