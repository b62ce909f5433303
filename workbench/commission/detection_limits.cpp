// SPDX-License-Identifier: Apache-2.0
#include "workbench/commission/detection_limits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "workbench/diagnose/detectability/detectability.h"
#include "workbench/estimate/terms/search_ranges.h"
#include "workbench/estimate/terms/terms.h"
#include "workbench/model/effect_adapters/effect_registry.h"

namespace slipstack::workbench {
namespace {

/// Of the highest frequency at which a mode is looked for; the mode at its end is none (plausibility.h).
constexpr std::array kShares{0.75, 0.5, 0.25};

}  // namespace

std::string delay_limit_text(const Measurement& measurement, const FittedModel& explained) {
  if (has_role(explained.terms, Role::measurement_delay)) return "";
  const Term delay = make_term(measurement, effect_with_role(Role::measurement_delay));
  const double least_s =
      detection_limit(measurement, explained, baseline_residual_maker(measurement, explained), delay);
  return fmt::format("A delay between force and motion below {:.3g} µs would not have been named.",
                     1e6 * least_s);
}

std::string mode_limit_text(const Measurement& measurement, const FittedModel& explained) {
  const EffectDescription& resonance = effect_with_role(Role::resonance);
  const std::vector<ShapeRange> ranges = searched_shapes(measurement, resonance);
  const ShapeRange* frequencies = find_range(ranges, resonance, ShapeKind::frequency);
  if (has_role(explained.terms, Role::resonance) || frequencies == nullptr) return "";
  const ResidualMaker residual_maker = baseline_residual_maker(measurement, explained);
  const double heaviest_kg = resonance.traits.plausible.most_axis_masses * mass_kg(explained.terms);
  std::vector<std::string> below;
  for (const double share : kShares) {
    Term mode = make_term(measurement, resonance);
    mode.shapes[frequencies->index] = std::max(frequencies->lower, share * frequencies->upper);
    const double least_kg = detection_limit(measurement, explained, residual_maker, mode);
    if (least_kg < heaviest_kg)
      below.push_back(fmt::format("{:.2g} kg at {:.3g} Hz", least_kg, mode.shapes[frequencies->index]));
  }
  if (below.empty()) return "A structural resonance would not have been named, whatever its mass.";
  return fmt::format("A structural resonance below {} would not have been named, nor one above {:.3g} Hz.",
                     fmt::join(below, ", "), frequencies->upper);
}

}  // namespace slipstack::workbench
