// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/cause_forms.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "firmware/effects/force_ripple.h"
#include "firmware/effects/numerics/approx.h"
#include "firmware/effects/numerics/harmonics.h"
#include "firmware/effects/offset_force.h"
#include "firmware/effects/payload_mass.h"
#include "firmware/effects/viscous.h"
#include "workbench/base/wide_vectors.h"
#include "workbench/diagnose/alternatives/gap.h"
#include "workbench/diagnose/alternatives/load_reversals.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

using std::numbers::pi;

class LineBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override { frequency_Hz_ = shapes[0]; }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    run_wide([&] {
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const auto wave = approx::sin_cos_of_cycles(frequency_Hz_ * samples[i].time_s);
        out[2 * i] = wave.cos;
        out[2 * i + 1] = wave.sin;
      }
    });
  }

 private:
  double frequency_Hz_ = 0.0;
};

/// A part of the log, from the first shape to the second.
struct TimeSpan {
  double from_s = 0.0;
  double until_s = 0.0;
  bool contains(double time_s) const { return time_s >= from_s && time_s < until_s; }
};

class ChangeBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    changed_ = {shapes[0], shapes[1]};
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      const double changed = changed_.contains(sample.time_s) ? 1.0 : 0.0;
      *out++ = changed;
      *out++ = changed;
    }
  }

 private:
  TimeSpan changed_;
};

class LoadBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    loaded_ = {shapes[0], shapes[1]};
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples)
      *out++ = loaded_.contains(sample.time_s) ? sample.acceleration_mps2 : 0.0;
  }

 private:
  TimeSpan loaded_;
};

/// Linear B-splines with `knots` knots one apart, at `at` from the first, times `scale`.
void write_hats(double at, std::ptrdiff_t knots, double scale, double* out) {
  std::fill_n(out, knots, 0.0);
  if (at >= static_cast<double>(knots)) return;
  const auto knot = static_cast<std::ptrdiff_t>(at);
  const double next = at - static_cast<double>(knot);
  out[knot] = (1.0 - next) * scale;
  if (knot + 1 < knots) out[knot + 1] = next * scale;
}

/// Linear B-splines over the time from the first shape to the second.
class CurveBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    first_s_ = shapes[0];
    per_s_ = kCurveIntervals / std::max(shapes[1] - shapes[0], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      const double at = std::clamp((sample.time_s - first_s_) * per_s_, 0.0, kCurveIntervals - 1e-9);
      write_hats(at, kCurveIntervals + 1, 1.0, out);
      out += kCurveIntervals + 1;
    }
  }

 private:
  double first_s_ = 0.0;
  double per_s_ = 1.0;
};

class PlaceBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    middle_m_ = shapes[0];
    half_width_m_ = std::max(shapes[1], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      const auto columns = place_basis((sample.position_m - middle_m_) / half_width_m_);
      out = std::copy(columns.begin(), columns.end(), out);
    }
  }

 private:
  double middle_m_ = 0.0;
  double half_width_m_ = 1.0;
};

class GapBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>& scales) override {
    gap_.emplace(GapInDrive::Parameters{shapes[0], shapes[1], shapes[2]}, scales.tick_s);
  }
  void reset(const Sample<double>& sample) override { gap_->reset(sample); }
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) *out++ = gap_->step(sample);
  }

 private:
  std::optional<GapInDrive> gap_;
};

/// The deflection of a bristle, -1 to 1 (Dahl 1968).
class Bristle {
 public:
  void set_slip(double slip_m) { slip_m_ = std::max(slip_m, 1e-12); }
  void reset(double position_m) {
    position_m_ = position_m;
    deflection_ = 0.0;
  }
  /// Writes the deflection at each sample; from one to the next the axis does not turn.
  void run(std::span<const Sample<double>> samples, double* deflection) {
    if (samples.empty()) return;
    run_wide([&] {
      deflection[0] = kept_after(samples[0].position_m - position_m_);
      for (std::size_t i = 1; i < samples.size(); ++i)
        deflection[i] = kept_after(samples[i].position_m - samples[i - 1].position_m);
    });
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double end = samples[i].position_m < position_m_ ? -1.0 : 1.0;
      deflection_ = deflection[i] = end + (deflection_ - end) * deflection[i];
      position_m_ = samples[i].position_m;
    }
  }
  /// dz/dt at a deflection [1/s].
  double rate_per_s(double deflection, double velocity_mps) const {
    return (velocity_mps - std::abs(velocity_mps) * deflection) / slip_m_;
  }

 private:
  /// Share of what the deflection lacked before this way.
  double kept_after(double way_m) const { return approx::exp(-approx::absolute(way_m) / slip_m_); }

  double slip_m_ = 1.0;
  double position_m_ = 0.0;
  double deflection_ = 0.0;
};

class DeflectionBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    bristle_.set_slip(shapes[0]);
  }
  void reset(const Sample<double>& sample) override { bristle_.reset(sample.position_m); }
  void run(std::span<const Sample<double>> samples, double* out) override {
    bristle_.run(samples, out);
    for (std::size_t i = 0; i < samples.size(); ++i)
      out[i] = bristle_.rate_per_s(out[i], samples[i].velocity_mps);
  }

 private:
  Bristle bristle_;
};

class BristleBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    bristle_.set_slip(shapes[0]);
  }
  void reset(const Sample<double>& sample) override { bristle_.reset(sample.position_m); }
  void run(std::span<const Sample<double>> samples, double* out) override { bristle_.run(samples, out); }

 private:
  Bristle bristle_;
};

class LoadReversalBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>& scales) override {
    per_s_ = kKnotsAfterReversal / std::max(shapes[0], 1e-12);
    load_.emplace(LoadReversals::Parameters{shapes[1], shapes[2]}, scales.tick_s);
  }
  void reset(const Sample<double>& sample) override { load_->reset(sample); }
  void run(std::span<const Sample<double>> samples, double* out) override {
    for (const Sample<double>& sample : samples) {
      load_->step(sample);
      for (const double scale : {load_->side(), load_->load()}) {
        write_hats(load_->since_s() * per_s_, kKnotsAfterReversal, scale, out);
        out += kKnotsAfterReversal;
      }
    }
  }

 private:
  std::optional<LoadReversals> load_;
  double per_s_ = 1.0;
};

/// Two harmonics of a pitch: a detent force or a bearing has hardly more, and two pitches with four each
/// would take the form of much.
class PitchBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    per_m_ = 1.0 / std::max(shapes[0], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    run_wide([&] {
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const auto [sine, cosine] = approx::sin_cos_of_cycles(samples[i].position_m * per_m_);
        out[4 * i] = cosine;
        out[4 * i + 1] = sine;
        out[4 * i + 2] = cosine * cosine - sine * sine;
        out[4 * i + 3] = 2.0 * cosine * sine;
      }
    });
  }

 private:
  double per_m_ = 0.0;
};

class MassOverPositionBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    first_m_ = shapes[0];
    rate_ = pi / std::max(shapes[1] - shapes[0], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    static_assert(kMassHarmonics == kRippleHarmonics);
    const double cycles_per_m = rate_ / (2.0 * pi);
    run_wide([&] {
      for (const Sample<double>& sample : samples) {
        std::array<double, std::size_t{2} * kRippleHarmonics> waves;
        harmonics(approx::sin_cos_of_cycles(cycles_per_m * (sample.position_m - first_m_)), std::span(waves));
        const double half_square = 0.5 * sample.velocity_mps * sample.velocity_mps;
        for (std::size_t k = 0; k < kRippleHarmonics; ++k) {
          const double rate = static_cast<double>(k + 1) * rate_;
          *out++ = waves[2 * k] * sample.acceleration_mps2 - rate * waves[2 * k + 1] * half_square;
        }
      }
    });
  }

 private:
  double first_m_ = 0.0;
  double rate_ = 0.0;
};

class ViscousOverTimeBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    first_s_ = shapes[0];
    per_s_ = 1.0 / std::max(shapes[1] - shapes[0], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    // With so many time constants within the log.
    const auto risen = [](double at, double time_constants) {
      return approx::exp_minus_one(-time_constants * at) / approx::exp_minus_one(-time_constants);
    };
    run_wide([&] {
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const double at = (samples[i].time_s - first_s_) * per_s_;
        out[3 * i] = at * samples[i].velocity_mps;
        out[3 * i + 1] = risen(at, 3.0) * samples[i].velocity_mps;
        out[3 * i + 2] = risen(at, 9.0) * samples[i].velocity_mps;
      }
    });
  }

 private:
  double first_s_ = 0.0;
  double per_s_ = 1.0;
};

class PowerOfVelocityBasis final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    exponent_ = shapes[0];
    per_mps_ = 1.0 / std::max(shapes[1], 1e-12);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    run_wide([&] {
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const double velocity_mps = samples[i].velocity_mps;
        const double size = approx::power(approx::absolute(velocity_mps) * per_mps_, exponent_);
        out[i] = std::copysign(size, velocity_mps);
      }
    });
  }

 private:
  double exponent_ = 1.0;
  double per_mps_ = 1.0;
};

/// The description of a cause; its shapes are found by shapes_of_cause() and not searched, unless they have
/// ranges as those of effects have.
template <class Basis>
EffectDescription cause(const char* id, std::vector<GainGroup> gains, std::vector<ShapeSpec> shapes,
                        SpecialCase special_case = {}) {
  EffectDescription description;
  description.text = {.id = id,
                      .title = id,
                      .formula = "",
                      .source = "",
                      .residual = "",
                      .evidence = "",
                      .cause = "",
                      .confirm = ""};
  for (const GainGroup& group : gains) description.gain_count += group.count;
  description.gain_groups = std::move(gains);
  description.shapes = std::move(shapes);
  description.traits.plannable = false;
  description.traits.special_case = special_case;
  description.traits.per_log = std::is_same_v<Basis, LineBasis>;  // the phase differs from log to log
  description.make = [] { return std::make_unique<Basis>(); };
  return description;
}

GainGroup any_force(const char* name) {
  return {name, "N", -kUnbounded, kUnbounded, 1, Acts::force};
}

/// Of the dry friction in excess; its derivative is not known where nothing is left of it (composition.h).
GainGroup friction_level() {
  return {"level", "", -0.95f, kUnbounded, 1, Acts::dry_scale};
}

ShapeSpec found(const char* name, const char* unit) {
  return {name, unit, -kUnbounded, kUnbounded, ShapeKind::table};
}

/// A pitch within the bounds of those of the catalogue.
ShapeSpec searched_pitch() {
  const EffectDescription& ripple = *find_effect(ForceRipple<double>::text.id);
  return ripple.shapes[ripple.find_shape(ShapeKind::pitch).value()];
}

/// In the order of CauseForm.
const std::array<EffectDescription, 14>& all_causes() {
  static const std::array<EffectDescription, 14> all{
      cause<LineBasis>("line_in_time", {any_force("cosine"), any_force("sine")}, {found("frequency", "Hz")}),
      cause<ChangeBasis>("change_at_a_time", {friction_level(), any_force("offset")},
                         {found("from", "s"), found("until", "s")}),
      cause<LoadBasis>("load_from_a_time", {{"mass", "kg", -kUnbounded, kUnbounded, 1, Acts::force}},
                       {found("from", "s"), found("until", "s")}),
      cause<PlaceBasis>("force_at_a_place", {any_force("push"), any_force("slope"), friction_level()},
                        {found("place", "m"), found("half_width", "m")}),
      cause<CurveBasis>(
          "force_over_time",
          {{"curve", "N", -kUnbounded, kUnbounded, kCurveIntervals + 1, Acts::force, /*smooth=*/true}},
          {found("first", "s"), found("last", "s")}, {.id = OffsetForce<double>::text.id}),
      cause<GapBasis>("gap_in_drive", {{"carriage", "kg", 0.0f, kUnbounded, 1, Acts::force}},
                      {found("gap", "m"), found("deceleration", "m/s2"), found("slip_distance", "m")}),
      cause<DeflectionBasis>("damped_deflection", {{"damping", "N s", 0.0f, kUnbounded, 1, Acts::force}},
                             {found("slip_distance", "m")}),
      cause<BristleBasis>("bristle", {{"level", "N", 0.0f, kUnbounded, 1, Acts::dry}},
                          {found("slip_distance", "m")}),
      cause<LoadReversalBasis>(
          "after_load_reversals",
          {{"blow", "N", -kUnbounded, kUnbounded, kKnotsAfterReversal, Acts::force, /*smooth=*/true},
           {"lost_load", "N", -kUnbounded, kUnbounded, kKnotsAfterReversal, Acts::force, /*smooth=*/true}},
          {found("window", "s"), found("deceleration", "m/s2"), found("slip_distance", "m")},
          {.id = PayloadMass<double>::text.id}),
      cause<PitchBasis>("second_ripple", {{"cosine_and_sine", "N", -kUnbounded, kUnbounded, 4, Acts::force}},
                        {searched_pitch()}),
      cause<PitchBasis>("friction_ripple", {{"cosine_and_sine", "", -0.9f, 0.9f, 4, Acts::dry_scale}},
                        {searched_pitch()}),
      cause<MassOverPositionBasis>(
          "mass_over_position", {{"harmonics", "kg", -kUnbounded, kUnbounded, kMassHarmonics, Acts::force}},
          {found("first", "m"), found("last", "m")}),
      cause<ViscousOverTimeBasis>("viscous_over_time",
                                  {{"change", "N s/m", -kUnbounded, kUnbounded, 3, Acts::force}},
                                  {found("first", "s"), found("last", "s")}),
      cause<PowerOfVelocityBasis>(
          "power_of_velocity", {{"at_largest_speed", "N", 0.0f, kUnbounded, 1, Acts::force}},
          {found("exponent", "1"), found("largest_speed", "m/s")}, {.id = Viscous<double>::text.id})};
  return all;
}

/// Whether an effect is one that a cause supplements; null for a cause that is tried beside any.
using IsSupplemented = bool (*)(const EffectDescription&);
IsSupplemented supplemented_by(CauseForm form) {
  if (form == CauseForm::second_ripple) {  // of the catalogue or of the user's own
    return [](const EffectDescription& effect) {
      return effect.has_shape(ShapeKind::pitch) && effect.acts_as(Acts::force);
    };
  }
  if (form == CauseForm::power_of_velocity)
    return [](const EffectDescription& effect) { return effect.has_role(Role::viscous_friction); };
  return nullptr;
}

/// Whether the terms have an effect that the cause supplements, if it needs one.
bool has_supplemented(const Terms& terms, const EffectDescription& cause) {
  return supplemented_by(form_of(cause)) == nullptr ||
         std::any_of(terms.begin(), terms.end(),
                     [&](const Term& term) { return supplements(cause, *term.effect); });
}

}  // namespace

std::array<double, 3> place_basis(double from_middle) {
  if (std::abs(from_middle) >= 1.0) return {};
  const double window = 0.5 * (1.0 + std::cos(pi * from_middle));
  return {window, window * std::sin(pi * from_middle), window};
}

std::vector<const EffectDescription*> causes_to_try(const Measurement& measurement, const Terms& terms) {
  std::vector<const EffectDescription*> causes;
  for (const EffectDescription& one : all_causes()) {
    const CauseForm form = form_of(one);
    const bool needs_one_clock = form == CauseForm::change_at_a_time || form == CauseForm::load_from_a_time ||
                                 form == CauseForm::force_over_time || form == CauseForm::viscous_over_time;
    if (needs_one_clock && measurement.log_count() > 1) continue;
    if (!has_supplemented(terms, one)) continue;
    if (!period_fits(measurement, one)) continue;
    causes.push_back(&one);
  }
  return causes;
}

double longest_blow_s(const Measurement& measurement) {
  // Play is crossed within tens of milliseconds; a drive that resonates above 10 Hz rings for two periods.
  constexpr double kLongest_s = 0.2;
  return kLongest_s + 1.0 / measurement.bandwidth_Hz();
}

bool is_outside_catalogue(const EffectDescription& effect) {
  return std::any_of(all_causes().begin(), all_causes().end(),
                     [&](const EffectDescription& one) { return &one == &effect; });
}

CauseForm form_of(const EffectDescription& cause) {
  return static_cast<CauseForm>(&cause - all_causes().data());
}

const EffectDescription& cause_of(CauseForm form) {
  return all_causes()[static_cast<std::size_t>(form)];
}

const Term* find_cause(const Terms& terms, CauseForm form) {
  const auto found = std::find_if(terms.begin(), terms.end(),
                                  [&](const Term& term) { return term.effect == &cause_of(form); });
  return found == terms.end() ? nullptr : &*found;
}

bool supplements(const EffectDescription& cause, const EffectDescription& effect) {
  const IsSupplemented supplemented = supplemented_by(form_of(cause));
  return supplemented != nullptr && !is_outside_catalogue(effect) && supplemented(effect);
}

bool lacks_supplemented(const Terms& terms) {
  return std::any_of(terms.begin(), terms.end(), [&](const Term& term) {
    return is_outside_catalogue(*term.effect) && !has_supplemented(terms, *term.effect);
  });
}

bool is_searched_as_effect(const EffectDescription& cause) {
  return cause.has_shape(ShapeKind::pitch);
}

bool is_fitted_jointly(const EffectDescription& cause) {
  switch (form_of(cause)) {
    case CauseForm::gap_in_drive:
    case CauseForm::damped_deflection:
    case CauseForm::bristle:
    case CauseForm::after_load_reversals:
    case CauseForm::second_ripple:
    case CauseForm::friction_ripple:
    case CauseForm::power_of_velocity:
      return true;
    case CauseForm::line_in_time:
    case CauseForm::change_at_a_time:
    case CauseForm::load_from_a_time:
    case CauseForm::force_at_a_place:
    case CauseForm::force_over_time:
    case CauseForm::mass_over_position:
    case CauseForm::viscous_over_time:
      break;
  }
  return false;
}

}  // namespace slipstack::workbench
