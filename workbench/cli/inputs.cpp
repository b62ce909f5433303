// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "workbench/identify/noise_floor.h"
#include "workbench/identify/shape_search.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {
namespace {

/// Cross-validation fits to four fifths of the instants: with fewer than these it would fit noise.
constexpr Eigen::Index kInstantsPerParameter = 2;
constexpr Eigen::Index kLeastInstants = 100;

}  // namespace

std::vector<std::string> parse_effects(const std::string& list) {
  std::vector<std::string> ids;
  for (const std::string_view field : split_fields(list)) {
    const std::string id(field);
    if (find_effect(id) == nullptr) {
      throw UsageError(fmt::format("unknown effect {}; known: {}", quoted(field), known_effects()));
    }
    if (std::find(ids.begin(), ids.end(), id) != ids.end()) {
      throw UsageError(fmt::format("effect '{}' is named twice; name it once", id));
    }
    ids.push_back(id);
  }
  return ids;
}

Measurement measure(const Options& options, Progress& progress) {
  progress.show("read the log");
  Measurement measurement(read_log(options.log));
  if (measurement.row_count() < kLeastInstants) {
    throw InputError(fmt::format(
        "{}: {} samples leave {} instants after filtering, fewer than the {} that a fit needs; record longer",
        printable(options.log), measurement.sample_count(), measurement.row_count(), kLeastInstants));
  }
  progress.show("weigh the rows");
  weigh_rows(measurement);
  return measurement;
}

void check_combination(const Measurement& measurement, const std::vector<std::string>& ids) {
  const auto has = [&](std::string_view id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); };
  if (has("inertia") && has("payload_mass") && !measurement.log().mass_kg) {
    throw UsageError(
        "payload_mass and inertia are one and the same while the mass is not known; add the line "
        "'# mass_kg: value' to the log or leave payload_mass out");
  }
  const bool dry = std::any_of(ids.begin(), ids.end(),
                               [](const std::string& id) { return find_effect(id)->acts_as(Acts::dry); });
  for (const std::string& id : ids) {
    if (!dry && find_effect(id)->acts_as(Acts::dry_scale)) {
      throw UsageError(
          fmt::format("{} changes the level of dry friction, and the model has none; add "
                      "presliding_hysteresis or coulomb",
                      id));
    }
  }
}

void check_enough(const Options& options, const Measurement& measurement,
                  const std::vector<std::string>& ids) {
  Eigen::Index parameters = 0;
  for (const std::string& id : ids) {
    const EffectDescription& effect = *find_effect(id);
    parameters += effect.gain_count;
    parameters += static_cast<Eigen::Index>(searched_shapes(measurement, effect).size());
  }
  if (measurement.row_count() < kInstantsPerParameter * parameters) {
    throw InputError(fmt::format(
        "{}: {} instants after filtering cannot tell {} parameters; record longer or fit fewer effects",
        printable(options.log), measurement.row_count(), parameters));
  }
}

Terms terms_on(const Measurement& measurement, const Model& model) {
  Terms terms = model.terms;
  for (Term& term : terms) {
    if (term.id() == "inertia" && measurement.log().mass_kg) {
      term.gains[0] = term.lower[0] = term.upper[0] = *measurement.log().mass_kg;
    }
  }
  return terms;
}

std::vector<std::string> ids_of(const Terms& terms) {
  std::vector<std::string> ids;
  for (const Term& term : terms) ids.push_back(term.id());
  return ids;
}

}  // namespace slipstack::workbench
