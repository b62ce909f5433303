// SPDX-License-Identifier: Apache-2.0
#include "workbench/cli/inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "workbench/identify/noise_floor.h"
#include "workbench/identify/shape_search.h"
#include "workbench/identify/user_effect.h"
#include "workbench/log/text.h"

namespace slipstack::workbench {
namespace {

/// Cross-validation fits to four fifths of the instants: with fewer than these it would fit noise.
constexpr Eigen::Index kInstantsPerParameter = 2;
constexpr Eigen::Index kLeastInstants = 100;
/// Slower samples show no reversal and no move: as a rule their time is in another unit.
constexpr double kLeastRate_Hz = 10.0;

}  // namespace

const EffectDescription& effect_named(std::string_view id) {
  const EffectDescription* effect = find_effect(id);
  if (effect == nullptr) {
    throw UsageError(fmt::format("unknown effect {}; known: {}", in_quotes(id), known_effects()));
  }
  return *effect;
}

std::vector<std::string> parse_effects(const std::string& list) {
  std::vector<std::string> ids;
  for (const std::string_view field : split_fields(list)) {
    const std::string id = effect_named(field).id();
    if (std::find(ids.begin(), ids.end(), id) != ids.end()) {
      throw UsageError(fmt::format("effect '{}' is named twice; name it once", id));
    }
    ids.push_back(id);
  }
  return ids;
}

void spare_logs(const Options& options, Outputs& outputs) {
  for (const std::string& log : options.logs) outputs.spare(log);
}

std::vector<const EffectDescription*> declared_effects(const Options& options) {
  std::vector<const EffectDescription*> effects;
  for (const std::string& text : options.own_effects) {
    if (!is_definition(text)) {
      throw UsageError(
          fmt::format("--effect: {} defines no effect; write 'name = expression; parameter: unit; ...'",
                      in_quotes(text)));
    }
    const EffectDescription* effect = &declare_effect(text);
    if (std::find(effects.begin(), effects.end(), effect) != effects.end()) {
      throw UsageError(fmt::format("effect '{}' is given twice; give it once", effect->id()));
    }
    effects.push_back(effect);
  }
  return effects;
}

namespace {

void refuse_repeats(const Options& options) {
  for (std::size_t i = 0; i < options.logs.size(); ++i) {
    if (std::find(options.logs.begin(), options.logs.begin() + static_cast<std::ptrdiff_t>(i),
                  options.logs[i]) != options.logs.begin() + static_cast<std::ptrdiff_t>(i)) {
      throw UsageError(fmt::format("{}: the log is named twice; name it once", printable(options.logs[i])));
    }
  }
}

ConditioningOptions conditioning_of(const Options& options) {
  ConditioningOptions conditioning;
  conditioning.force_noise_N = options.noise_N;
  if (options.per_log == "none") {
    conditioning.per_log.clear();
  } else if (!options.per_log.empty()) {
    conditioning.per_log = parse_effects(options.per_log);
  }
  return conditioning;
}

void refuse_slow_or_short(const Measurement& measurement) {
  if (measurement.sample_rate_Hz() < kLeastRate_Hz) {
    throw InputError(fmt::format(
        "{}: column time_s: {:.3g} samples a second are too few to see friction (at least {:.0f}); if the "
        "column "
        "holds milliseconds, write seconds",
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
                      "fit needs ({}); "
                      "record again",
                      printable(part.path), count, usable, kLeastInstants,
                      part.mended.empty() ? "" : part.mended.back()));
    }
    throw InputError(fmt::format(
        "{}: {} samples leave {} instants after filtering, fewer than the {} that a fit needs; record longer",
        printable(part.path), measurement.log_sample_count(log), count, kLeastInstants));
  }
}

/// The logs, long ones left in their files, every process of the team at work.
TeamLogs open_logs(const Options& options, Progress& progress) {
  refuse_repeats(options);
  const char* stage = options.logs.size() == 1 ? "read the log" : "read the logs";
  progress.show(stage);
  return {*options.team, options.logs, LongLog::kInMemoryBytes,
          [&progress, stage](double fraction) { progress.show(stage, fraction); }};
}

/// Refuses what cannot be fitted; the rows are weighed next.
std::function<void(const Measurement&)> may_be_fitted(Progress& progress) {
  return [&progress](const Measurement& measurement) {
    refuse_slow_or_short(measurement);
    progress.show("weigh the rows");
  };
}

}  // namespace

Searched search(const Options& options, Progress& progress,
                const std::function<void(Measurement&, WholeLogs&)>& work) {
  return search_logs(open_logs(options, progress), conditioning_of(options), may_be_fitted(progress), work);
}

WholeLogs::Progress judging(Progress& progress) {
  return [&progress](double fraction) { progress.show("judge by the whole logs", fraction); };
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
    parameters += static_cast<Eigen::Index>(static_cast<std::size_t>(effect.gain_count) *
                                            measurement.gain_sets(effect.text.id));
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
    term = with_gain_sets(measurement, std::move(term));
    if (term.id() == "inertia") give_mass(measurement, term);
  }
  return terms;
}

std::vector<std::string> ids_of(const Terms& terms) {
  std::vector<std::string> ids;
  for (const Term& term : terms) ids.push_back(term.id());
  return ids;
}

}  // namespace slipstack::workbench
