// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "firmware/effects/numerics/interval.h"
#include "firmware/effects/numerics/power_table.h"
#include "firmware/effects/numerics/ripple_table.h"
#include "firmware/effects/numerics/speed_table.h"
#include "firmware/effects/presliding_hysteresis.h"
#include "workbench/c_export/recorded.h"

// What the effects of the firmware use besides arithmetic and approx.h, for a scalar that records: tables,
// rows of intervals, and stop operators. Each records a call of its C form in c_functions.cpp.
namespace slipstack::workbench {

/// The interval of a table that the motion is in.
struct RecordedIndex {
  ValueId value = 0;
};

/// An initialiser of a table: rows of literals.
template <class Row>
std::string table_rows(std::size_t count, Row row) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    text += "    {";
    bool first = true;
    for (const float number : row(i)) {
      text += (first ? "" : ", ") + c_literal(number);
      first = false;
    }
    text += "},\n";
  }
  return text;
}

class RecordedRippleTable {
 public:
  template <class Wave>
  void fill(Wave wave) {
    table_.fill([&](float cycles) { return wave(Recorded<float>(cycles)).constant(); });
  }
  Recorded<float> at(const Recorded<float>& cycles) const {
    const std::string rows = table_rows(RippleTable::kIntervals, [this](std::size_t i) {
      const RippleTable::Parabola& p = table_.intervals()[i];
      return std::array{p.begin, p.slope, p.bend};
    });
    const std::string name = recording().table("REAL", "[64][3]", rows);
    return Recorded<float>::of(
        recording().operation("@ripple(" + name + ", {})", {cycles.value()}, "REAL", false));
  }

 private:
  RippleTable table_;
};

class RecordedPowerTable {
 public:
  void fill(const Recorded<float>& p) { table_.fill(p.constant()); }
  Recorded<float> at(const Recorded<float>& x) const {
    const std::string octaves =
        table_rows(PowerTable::kOctaves, [this](std::size_t i) { return std::array{table_.octaves()[i]}; });
    const std::string parabolas = table_rows(PowerTable::kIntervals, [this](std::size_t i) {
      const PowerTable::Parabola& p = table_.intervals()[i];
      return std::array{p.begin, p.slope, p.bend};
    });
    const std::string first = recording().table("REAL", "[32][1]", octaves);
    const std::string second = recording().table("REAL", "[8][3]", parabolas);
    return Recorded<float>::of(
        recording().operation("@power_table(" + first + ", " + second + ", {})", {x.value()}, "REAL", false));
  }

 private:
  PowerTable table_;
};

class RecordedSpeedTable {
 public:
  template <class Weakening>
  void fill(const Recorded<float>& velocity_mps, const Recorded<float>& exponent, Weakening weakening) {
    table_.fill(velocity_mps.constant(), exponent.constant(), [&](float speed_mps) {
      const auto both = weakening(Recorded<float>(speed_mps));
      return SpeedTable::Values{both[0].constant(), both[1].constant()};
    });
  }
  std::array<Recorded<float>, 2> at(const Recorded<float>& velocity_mps) const {
    const std::string rows = table_rows(SpeedTable::kIntervals + 1, [this](std::size_t i) {
      const auto& knot = table_.knots()[i];
      return std::array{knot[0].value, knot[0].bend, knot[1].value, knot[1].bend};
    });
    const std::string name = recording().table("REAL", "[129][4]", rows);
    const std::string call = "@speed_table(" + name + ", " + std::to_string(table_.first_bits()) + "U, " +
                             std::to_string(table_.shift()) + "U, {})";
    return members_of<float>(recording().operation(call, {velocity_mps.value()}, "@pair", false));
  }

 private:
  SpeedTable table_;
};

/// Overload of the firmware's for a place that only the motion decides.
template <class T>
IntervalPlace<Recorded<T>> recorded_interval_at(const Recorded<T>& place, std::size_t count) {
  const ValueId interval = recording().operation("@interval({}, " + std::to_string(count) + ")",
                                                 {place.value()}, "int32_t", false);
  const auto begin = Recorded<T>::of(recording().operation("(REAL){}", {interval}, "REAL", false));
  return {RecordedIndex{interval}, place - begin};
}

/// A table of constants from the interval on that the motion is in.
template <class T>
class RecordedValues {
 public:
  RecordedValues(std::string table, ValueId interval) : table_(std::move(table)), interval_(interval) {}
  Recorded<T> operator[](std::size_t offset) const {
    const std::string form = table_ + (offset == 0 ? "[{}]" : "[{} + " + std::to_string(offset) + "]");
    return Recorded<T>::of(recording().operation(form, {interval_}, "REAL", false));
  }

 private:
  std::string table_;
  ValueId interval_;
};

template <std::size_t N, class T>
RecordedValues<T> values_from(const std::array<Recorded<T>, N>& values, RecordedIndex interval) {
  constexpr std::size_t kInALine = 8;
  std::string rows;
  for (std::size_t i = 0; i < N; ++i) {
    rows += (i % kInALine == 0 ? "    " : " ") + c_literal(values[i].constant());
    rows += i + 1 == N || i % kInALine == kInALine - 1 ? ",\n" : ",";
  }
  return {recording().table("REAL", "[" + std::to_string(N) + "]", rows), interval.value};
}

}  // namespace slipstack::workbench

namespace slipstack {

template <>
inline constexpr bool kOnTarget<workbench::Recorded<float>> = true;

template <>
struct TableFor<RippleTable, workbench::Recorded<float>> {
  using type = workbench::RecordedRippleTable;
};
template <>
struct TableFor<PowerTable, workbench::Recorded<float>> {
  using type = workbench::RecordedPowerTable;
};
template <>
struct TableFor<SpeedTable, workbench::Recorded<float>> {
  using type = workbench::RecordedSpeedTable;
};

template <class T>
struct IndexOf<workbench::Recorded<T>> {
  using type = workbench::RecordedIndex;
};
template <>
inline IntervalPlace<workbench::Recorded<float>> interval_at(workbench::Recorded<float> place,
                                                             std::size_t count) {
  return workbench::recorded_interval_at(place, count);
}
template <>
inline IntervalPlace<workbench::Recorded<double>> interval_at(workbench::Recorded<double> place,
                                                              std::size_t count) {
  return workbench::recorded_interval_at(place, count);
}

/// The stop operators are no formula but a loop over state: recorded as one call. In float they are the
/// packed elements of the controller, whole stiffnesses and slip distances; in double those of the workbench.
template <class T, int Elements>
class PreslidingHysteresis<workbench::Recorded<T>, Elements> {
  using Real = workbench::Recorded<T>;
  using Own = PreslidingHysteresis<T, Elements>;

 public:
  static constexpr EffectText text = Own::text;
  static constexpr auto gains = Own::gains;
  static constexpr auto shapes = Own::shapes;
  static constexpr EffectTraits traits = Own::traits;
  static constexpr int gain_count = Own::gain_count;
  static constexpr int shape_count = Own::shape_count;

  void prepare(std::span<const Real, shape_count> shape, const Scales<Real>& scales) {
    metres_per_displacement_ = scales.metres_per_displacement.constant();
    for (std::size_t i = 0; i < slip_m_.size(); ++i) slip_m_[i] = shape[i].constant();
  }
  void reset(const Sample<Real>&) {}
  void basis(const Sample<Real>&, std::span<Real, gain_count>) {
    throw workbench::NotRecordable("its elements are not available one by one");
  }
  Real weighted(const Sample<Real>& sample, const std::array<Real, gain_count>& stiffness_N_per_m) {
    workbench::ComputationRecord::Hysteresis& elements = workbench::recording().hysteresis;
    elements = {};
    if constexpr (std::is_same_v<T, float>) {
      take_packed(stiffness_N_per_m, elements);
    } else {
      for (std::size_t i = 0; i < slip_m_.size(); ++i) {
        if (stiffness_N_per_m[i].is(T(0))) continue;
        elements.slip_distance.push_back(workbench::c_literal(slip_m_[i]));
        elements.stiffness.push_back(workbench::c_literal(stiffness_N_per_m[i].constant()));
      }
    }
    if (elements.stiffness.empty()) return Real(0);
    return Real::of(workbench::recording().operation("@hysteresis(state, {})", {sample.displacement.value()},
                                                     "REAL", false));
  }

 private:
  using Packed = PackedMaxwellSlip<static_cast<std::size_t>(Elements)>;

  /// As the controller does: PreslidingHysteresis::prepare() and prepare_weighted().
  void take_packed(const std::array<Real, gain_count>& stiffness_N_per_m,
                   workbench::ComputationRecord::Hysteresis& elements) const {
    std::array<std::int32_t, Elements> slip{};
    std::array<float, Elements> stiffness{};
    for (std::size_t i = 0; i < slip_m_.size(); ++i) {
      const float steps = slip_m_[i] / metres_per_displacement_ + 0.5F;
      slip[i] = static_cast<std::int32_t>(
          approx::clamp(steps, 0.0F, static_cast<float>(Packed::kLargestSlipDistance)));
      stiffness[i] = stiffness_N_per_m[i].constant() * metres_per_displacement_;
    }
    Packed packed;
    if (packed.set_elements(slip, stiffness) != SetupStatus::kOk) {
      throw workbench::NotRecordable("a stiffness is negative or not finite");
    }
    const float unit_N = packed.stiffness_step();
    elements.scale = workbench::c_literal(unit_N);
    for (std::size_t i = 0; i < slip.size(); ++i) {
      const long whole = std::lround(packed.stiffness(i) / unit_N);
      if (whole == 0 || slip[i] == 0) continue;
      elements.slip_distance.push_back(std::to_string(slip[i]));
      elements.stiffness.push_back(std::to_string(whole));
    }
  }

  std::array<T, Elements> slip_m_{};
  T metres_per_displacement_{1};
};

}  // namespace slipstack
