// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/bode_result.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "workbench/frequency/bode_charts.h"

namespace slipstack::workbench {
namespace {

constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

std::vector<TableColumn> margin_columns() {
  return {{"loop", "", "", 1.0, 4},
          {"modulus_margin", "modulus margin", "", 1.0, 3},
          {"modulus_margin_sd", "±", "", 1.0, 2},
          {"peak_sensitivity", "peak of S", "", 1.0, 3},
          {"peak_Hz", "at", "Hz", 1.0, 4},
          {"gain_margin", "gain margin", "", 1.0, 3},
          {"gain_margin_Hz", "at", "Hz", 1.0, 4},
          {"least_gain", "least gain", "", 1.0, 3},
          {"phase_margin_rad", "phase margin", "°", kDegreesPerRad, 3},
          {"phase_margin_Hz", "at", "Hz", 1.0, 4},
          {"delay_margin_s", "delay margin", "ms", 1e3, 3},
          {"crossover_Hz", "crossover", "Hz", 1.0, 4},
          {"bandwidth_Hz", "bandwidth", "Hz", 1.0, 4}};
}

std::vector<Cell> margin_row(const std::string& name, const Margins& margins, double modulus_sd) {
  return {name,
          margins.modulus,
          modulus_sd,
          margins.peak_sensitivity,
          margins.peak_Hz,
          margins.gain,
          margins.gain_Hz,
          margins.gain_down,
          margins.phase_rad,
          margins.phase_Hz,
          margins.delay_s,
          margins.crossover_Hz,
          margins.bandwidth_Hz};
}

ExperimentTable response_table(const LoopAnalysis& analysis) {
  ExperimentTable table{"response",
                        "Response",
                        {{"frequency_Hz", "frequency", "Hz", 1.0, 5},
                         {"plant_m_per_N", "plant", "µm/N", 1e6, 4},
                         {"plant_phase_rad", "phase", "°", kDegreesPerRad, 4},
                         {"plant_sd_m_per_N", "±", "µm/N", 1e6, 2},
                         {"coherence", "coherence", "", 1.0, 4},
                         {"loop_gain", "open loop", "", 1.0, 4},
                         {"loop_phase_rad", "phase", "°", kDegreesPerRad, 4},
                         {"sensitivity", "S", "", 1.0, 4},
                         {"sensitivity_measured", "S measured", "", 1.0, 4}},
                        {}};
  for (std::size_t i = 0; i < analysis.plant.size(); ++i) {
    const ResponsePoint& point = analysis.plant[i];
    const Complex loop = analysis.loop[i];
    table.rows.push_back({point.frequency_Hz, std::abs(point.plant), std::arg(point.plant), point.plant_sd,
                          point.coherence, std::abs(loop), std::arg(loop), 1.0 / std::abs(1.0 + loop),
                          std::isfinite(point.sensitivity.real()) ? std::abs(point.sensitivity) : kNoValue});
  }
  return table;
}

ExperimentTable gains_table() {
  return {"gains",
          "Gains",
          {{"loop", "", "", 1.0, 4},
           {"position_gain_per_s", "Kp", "1/s", 1.0, 4},
           {"velocity_gain_N_s_per_m", "Kv", "N s/m", 1.0, 5},
           {"integral_per_s", "integral", "1/s", 1.0, 4},
           {"notch_1_Hz", "notch 1", "Hz", 1.0, 4},
           {"notch_1_damping", "damping", "", 1.0, 3},
           {"notch_1_depth", "depth", "", 1.0, 3},
           {"notch_2_Hz", "notch 2", "Hz", 1.0, 4},
           {"notch_2_damping", "damping", "", 1.0, 3},
           {"notch_2_depth", "depth", "", 1.0, 3}},
          {}};
}

std::vector<Cell> gains_row(const std::string& name, const DriveController& gains) {
  std::vector<Cell> row{name, gains.position_gain_per_s, gains.velocity_gain_N_s_per_m, gains.integral_per_s};
  for (const DriveNotch& notch : gains.notch) {
    const bool on = notch.frequency_Hz > 0.0;
    row.insert(row.end(), {notch.frequency_Hz, on ? notch.damping : kNoValue, on ? notch.depth : kNoValue});
  }
  return row;
}

std::string motion_text(const LoopRecording& recording) {
  if (recording.velocity_mps == 0.0) return "at standstill";
  return fmt::format("at {:.4g} mm/s", 1e3 * recording.velocity_mps);
}

void add_notes(ExperimentResult& result, const LoopRecording& recording, const LoopAnalysis& analysis) {
  for (const std::string& note : recording.notes) result.notes.push_back(note);
  if (analysis.sensitivity_difference > 0.1) {
    result.notes.push_back(
        fmt::format("The measured sensitivity differs from the computed one by {:.0f} % beyond the noise "
                    "(median): the axis "
                    "is not linear at this amplitude, or other gains ran than the recording names.",
                    100.0 * analysis.sensitivity_difference));
  }
  const double last = std::abs(analysis.loop.back());
  if (last > 0.5) {
    result.notes.push_back(
        fmt::format("At the highest frequency the loop is still {:.2g}: what is above {:.0f} Hz may need "
                    "margins that are not seen; measure higher.",
                    last, analysis.frequency_Hz.back()));
  }
  if (recording.velocity_mps == 0.0) {
    result.notes.emplace_back(
        "At standstill the guideway's friction is a spring with hysteresis that depends on the amplitude; "
        "at low frequencies the response is that of this amplitude only.");
  }
}

// What the measured band does not show has no number.
std::string figure_text(double value, const char* unit) {
  return std::isfinite(value) ? fmt::format("{:.3g}{}", value, unit) : "not in the band";
}

std::string headline_of(const Margins& margins) {
  return fmt::format(
      "Modulus margin {:.3g} (peak of S {:.3g} at {:.4g} Hz), phase margin {}, gain margin {}, bandwidth {}.",
      margins.modulus, margins.peak_sensitivity, margins.peak_Hz,
      figure_text(kDegreesPerRad * margins.phase_rad, "°"), figure_text(margins.gain, ""),
      figure_text(margins.bandwidth_Hz, " Hz"));
}

}  // namespace

ExperimentResult bode_result(const LoopRecording& recording, const LoopAnalysis& analysis,
                             const std::string& setup) {
  ExperimentResult result;
  result.experiment = result.command = "bode";
  result.setup = setup;
  result.headline = headline_of(analysis.margins);
  result.detail =
      fmt::format("Measured {} from {:.3g} to {:.4g} Hz at {} frequencies.", motion_text(recording),
                  analysis.frequency_Hz.front(), analysis.frequency_Hz.back(), analysis.frequency_Hz.size());
  result.summary = {{"velocity_mps", recording.velocity_mps},
                    {"sensitivity_difference", analysis.sensitivity_difference}};
  ExperimentTable margins{"margins", "Margins", margin_columns(), {}};
  margins.rows.push_back(margin_row("measured", analysis.margins, analysis.modulus_sd));
  ExperimentTable gains = gains_table();
  gains.rows.push_back(gains_row("measured", recording.drive));
  result.tables = {std::move(margins), std::move(gains), response_table(analysis)};
  add_plant_charts(result, analysis);
  add_loop_charts(result, {{"plant × feedback", &analysis.frequency_Hz, &analysis.loop}}, analysis, true);
  add_notes(result, recording, analysis);
  return result;
}

ExperimentResult tune_result(const LoopRecording& recording, const LoopAnalysis& analysis,
                             const Tuning& tuning, const TuneRequest& request, const TunedLoop* tuned,
                             const std::string& setup) {
  ExperimentResult result;
  result.experiment = result.command = "tune";
  result.setup = setup;
  const Margins& now = tuned != nullptr ? tuned->analysis.margins : tuning.margins;
  result.headline = fmt::format(
      "Kp {:.4g} 1/s, Kv {:.5g} N s/m, integral {:.4g} 1/s, {} notches: modulus margin {:.3g} {}, wanted "
      "{:.3g}.",
      tuning.gains.position_gain_per_s, tuning.gains.velocity_gain_N_s_per_m, tuning.gains.integral_per_s,
      tuning.notches, now.modulus, tuned != nullptr ? "measured" : "predicted", request.modulus_margin);
  const auto stiffness = [](const DriveController& gains) {
    return gains.position_gain_per_s * gains.velocity_gain_N_s_per_m;
  };
  result.detail =
      fmt::format("Force per position error {:.3g} N/µm, before {:.3g} N/µm; bandwidth {}, before {}.",
                  1e-6 * stiffness(tuning.gains), 1e-6 * stiffness(recording.drive),
                  figure_text(now.bandwidth_Hz, " Hz"), figure_text(analysis.margins.bandwidth_Hz, " Hz"));
  result.summary = {{"wanted_modulus_margin", request.modulus_margin},
                    {"applied", std::string(tuned != nullptr ? "yes" : "no")},
                    {"velocity_mps", recording.velocity_mps}};
  ExperimentTable margins{"margins", "Margins", margin_columns(), {}};
  margins.rows.push_back(margin_row("before", analysis.margins, analysis.modulus_sd));
  margins.rows.push_back(margin_row("predicted", tuning.margins, kNoValue));
  ExperimentTable gains = gains_table();
  gains.rows.push_back(gains_row("before", recording.drive));
  gains.rows.push_back(gains_row("proposed", tuning.gains));
  const std::vector<Complex> predicted =
      loop_of(analysis.plant, FeedbackResponse(tuning.gains, analysis.plant).of(tuning.gains));
  std::vector<NamedLoop> loops{{"before", &analysis.frequency_Hz, &analysis.loop},
                               {"predicted", &analysis.frequency_Hz, &predicted}};
  if (tuned != nullptr) {
    margins.rows.push_back(margin_row("measured", tuned->analysis.margins, tuned->analysis.modulus_sd));
    gains.rows.push_back(gains_row("applied", tuned->gains));
    loops.push_back({"measured", &tuned->analysis.frequency_Hz, &tuned->analysis.loop});
  }
  result.tables = {std::move(margins), std::move(gains)};
  add_plant_charts(result, analysis);
  add_loop_charts(result, loops, analysis, false);
  add_notes(result, recording, tuned != nullptr ? tuned->analysis : analysis);
  return result;
}

}  // namespace slipstack::workbench
