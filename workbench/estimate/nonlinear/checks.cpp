// SPDX-License-Identifier: Apache-2.0
#include "workbench/estimate/nonlinear/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "workbench/base/axis_units.h"
#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Cross-validation fits to four fifths of the instants. With fewer instants than these it would fit noise.
/// Chosen.
constexpr Eigen::Index kInstantsPerParameter = 2;
constexpr Eigen::Index kLeastInstants = 100;
/// Slower samples resolve neither reversals nor movements; as a rule their time is in another unit.
constexpr double kLeastRate_Hz = 10.0;

std::vector<std::string> effects_that_act(Acts acts) {
  std::vector<std::string> ids;
  for (const EffectDescription& effect : catalogue()) {
    if (effect.acts_as(acts)) ids.push_back(effect.id());
  }
  return ids;
}

}  // namespace

void check_combination(const Measurement& measurement, const std::vector<std::string>& ids) {
  const auto has = [&](std::string_view id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); };
  const std::string inertia = effect_with_role(Role::inertia).id();
  const std::string added_mass = effect_with_role(Role::added_mass).id();
  if (has(inertia) && has(added_mass) && !measurement.log().mass_kg) {
    throw UsageError(
        fmt::format("{0} and {1} are one and the same while the mass is not known; add the line "
                    "'# {2}: value' to the log or leave {0} out",
                    added_mass, inertia, axis_key("mass_kg")));
  }
  const bool dry = std::any_of(ids.begin(), ids.end(),
                               [](const std::string& id) { return find_effect(id)->acts_as(Acts::dry); });
  for (const std::string& id : ids) {
    if (!dry && find_effect(id)->acts_as(Acts::dry_scale)) {
      throw UsageError(fmt::format("{} changes the level of dry friction, and the model has none; add {}", id,
                                   fmt::join(effects_that_act(Acts::dry), " or ")));
    }
  }
}

void check_enough(const std::string& logs, const Measurement& measurement,
                  const std::vector<std::string>& ids) {
  Eigen::Index parameters = 0;
  for (const std::string& id : ids) {
    const EffectDescription& effect = *find_effect(id);
    parameters += static_cast<Eigen::Index>(static_cast<std::size_t>(effect.gain_count) *
                                            measurement.gain_sets(effect.text.id));
    parameters += static_cast<Eigen::Index>(searched_shapes(measurement, effect).size());
  }
  if (measurement.row_count() < kInstantsPerParameter * parameters) {
    throw InputError(fmt::format(
        "{}: {} instants after filtering cannot determine {} parameters; record longer or fit fewer effects",
        printable(logs), measurement.row_count(), parameters));
  }
}

void refuse_slow_or_short(const Measurement& measurement) {
  if (measurement.sample_rate_Hz() < kLeastRate_Hz) {
    throw InputError(fmt::format(
        "{}: column time_s: {:.3g} samples a second are too few to see friction (at least {:.0f}); if the "
        "column holds milliseconds, write seconds",
        printable(measurement.parts().front().path), measurement.sample_rate_Hz(), kLeastRate_Hz));
  }
  for (std::size_t log = 0; log < measurement.log_count(); ++log) {
    const auto [first, count] = measurement.rows_of_log(log);
    const auto usable = static_cast<Eigen::Index>(measurement.row_usable().segment(first, count).sum());
    if (usable >= kLeastInstants) continue;
    const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
    if (count >= kLeastInstants) {
      throw InputError(
          fmt::format("{}: of {} instants {} are left once its faults are cut out, fewer than the {} that a "
                      "fit needs ({}); record again",
                      printable(part.path), count, usable, kLeastInstants,
                      part.repaired.empty() ? "" : part.repaired.back()));
    }
    const std::size_t missing = static_cast<std::size_t>(kLeastInstants - count) * measurement.row_stride();
    const double enough_s =
        static_cast<double>(measurement.log_sample_count(log) + missing) * measurement.tick_s();
    throw InputError(
        fmt::format("{}: {} samples leave {} instants after filtering to {:.3g} Hz, fewer than the {} that a "
                    "fit needs; record longer, {:.0f} s",
                    printable(part.path), measurement.log_sample_count(log), count,
                    measurement.bandwidth_Hz(), kLeastInstants, std::ceil(enough_s)));
  }
}

}  // namespace slipstack::workbench
