// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/blind/estimates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace slipstack::bench {
namespace {

using nlohmann::json;

/// Parameters that plant and model define in the same way: the effect, its formula in the plant, the key
/// there, and the shape or gain here.
struct Known {
  const char* effect;
  const char* formula;
  const char* key;
  bool shape;
  std::size_t at;
};
constexpr std::array<Known, 10> kKnown{{{"viscous", "linear", "coefficient_N_s_per_m", false, 0},
                                        {"quadratic_drag", "quadratic", "coefficient", false, 0},
                                        {"offset_force", "constant", "force_N", false, 0},
                                        {"cable_chain_stiffness", "linear", "stiffness_N_per_m", false, 0},
                                        {"payload_mass", "mass", "mass_kg", false, 0},
                                        {"force_ripple", "harmonics", "pitch_m", true, 0},
                                        {"structural_resonance", "mass_on_spring", "frequency_Hz", true, 0},
                                        {"structural_resonance", "mass_on_spring", "damping_ratio", true, 1},
                                        {"time_delay", "delay", "delay_s", true, 0},
                                        {"time_delay", "first_order_filter", "filter_s", true, 1}}};

/// A ripple with only even orders of its pitch has half that pitch.
int common_order(const json& harmonics) {
  int order = 0;
  for (const json& harmonic : harmonics) order = std::gcd(order, harmonic.at("order").get<int>());
  return std::max(1, order);
}

std::string share(const std::vector<double>& deviations, double limit) {
  const auto count = std::count_if(deviations.begin(), deviations.end(),
                                   [&](double deviation) { return std::abs(deviation) <= limit; });
  return fmt::format(
      "{}/{} {:.1f} %", count, deviations.size(),
      100.0 * static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, deviations.size())));
}

}  // namespace

std::vector<Estimate> estimates_of(const workbench::Terms& terms, const json& truth) {
  std::vector<Estimate> found;
  for (const Known& known : kKnown) {
    const workbench::Term* term = workbench::find_term(terms, known.effect);
    const json& formulas = truth["formulas"];
    if (term == nullptr || !formulas.contains(known.effect) || formulas[known.effect] != known.formula)
      continue;
    const json& numbers = truth["parameters"][known.effect];
    double true_value = numbers[known.key].get<double>();
    if (numbers.contains("harmonics")) true_value /= common_order(numbers["harmonics"]);
    const double value = (known.shape ? term->shapes : term->gains)[known.at];
    const double error = (known.shape ? term->shape_standard_errors : term->gain_standard_errors)[known.at];
    if (error > 0.0)
      found.push_back({fmt::format("{}.{}", known.effect, known.key), true_value, value, error});
  }
  return found;
}

std::string calibration(const std::vector<Estimate>& estimates) {
  std::map<std::string, std::vector<double>> deviations;
  for (const Estimate& one : estimates) {
    deviations["all"].push_back(one.deviation());
    deviations[one.parameter].push_back(one.deviation());
  }
  std::string text =
      fmt::format("\n{:<42} {:>15} {:>15} {:>7}\n", "parameter", "within one s.e.", "within two", "mean");
  for (const auto& [parameter, own] : deviations) {
    const double sum = std::accumulate(own.begin(), own.end(), 0.0);
    text += fmt::format("{:<42} {:>15} {:>15} {:>7.2f}\n", parameter, share(own, 1.0), share(own, 2.0),
                        sum / static_cast<double>(own.size()));
  }
  return text;
}

}  // namespace slipstack::bench
