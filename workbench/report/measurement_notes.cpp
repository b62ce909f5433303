// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/measurement_notes.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "workbench/base/axis_units.h"
#include "workbench/base/axis_words.h"
#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/report/json_values.h"
#include "workbench/report/texts.h"
#include "workbench/signal/noise_estimate.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

std::string noise_method(const Measurement& measurement) {
  if (measurement.force_noise_given()) return "given by --noise";
  const double step_N = coarse_step(measurement.log().force_N);
  if (measurement.log_count() == 1 && step_N / std::sqrt(12.0) >= measurement.force_noise_N())
    return fmt::format("from its steps of {} (step / sqrt(12))", newtons(step_N));
  return fmt::format("from differences of sixth order of the {}", force_word());
}

std::string caution(const Measurement& measurement) {
  if (measurement.force_noise_given()) return "";
  if (const double cut_Hz = measurement.force_cut_Hz(); cut_Hz > 0.0) {
    return fmt::format(
        "\n           the {} was low-passed alone, to half of its amplitude at {}: all is judged below {}, "
        "where the filter takes less than 2 %",
        force_word(), quantity(cut_Hz, "Hz"), quantity(measurement.bandwidth_Hz(), "Hz"));
  }
  const double growth = growth_of_noise_at_half_rate(measurement.log().force_N);
  if (growth < kNotWhite) return "";
  return fmt::format(
      "\n           it is not white: {:.1f} times as much by every second sample, as where the {} was "
      "filtered or interpolated; so it is a lower bound, and so is the noise floor",
      growth, force_word());
}

}  // namespace

std::string warning_lines(const std::vector<InputWarning>& warnings) {
  std::string text;
  for (const InputWarning& warning : warnings) text += fmt::format("warning    {}\n", warning.what);
  return text;
}

std::string warning_sentences(const std::vector<InputWarning>& warnings) {
  std::string text;
  for (const InputWarning& warning : warnings) text += "Check the input: " + warning.what + ". ";
  return text;
}

json warnings_json(const std::vector<InputWarning>& warnings) {
  json list = json::array();
  for (const InputWarning& warning : warnings)
    list.push_back({{"kind", warning.kind}, {"what", warning.what}});
  return list;
}

std::string noise_line(const Measurement& measurement) {
  return fmt::format(
      "noise      {} in one sample of the {}, {}; the noise floor also has the encoder's quantisation, by "
      "reading the motion on shifted grids{}\n",
      newtons(measurement.force_noise_N()), force_word(), noise_method(measurement), caution(measurement));
}

std::string repair_lines(const Measurement& measurement) {
  std::string text;
  for (const LogPart& part : measurement.parts()) {
    for (const std::string& note : part.repaired) {
      const std::string of = measurement.log_count() > 1 ? printable(part.path) + ": " : "";
      text += fmt::format("repaired   {}{}\n", of, note);
    }
  }
  return text;
}

json repairs_json(const Measurement& measurement) {
  json list = json::array();
  for (const LogPart& part : measurement.parts()) {
    for (const std::string& note : part.repaired) list.push_back({{"log", part.path}, {"what", note}});
  }
  return list;
}

std::string excerpt_line(const Measurement& measurement, std::string_view what) {
  if (!measurement.is_excerpt()) return "";
  return fmt::format("excerpt    {} in {} intervals, {} of {} samples; errors are those of all samples\n",
                     what, measurement.parts().size(), measurement.sample_count(),
                     measurement.whole_sample_count());
}

json noise_json(const Measurement& measurement) {
  return {{"force_noise_N", number_json(measurement.force_noise_N())},
          {"method", noise_method(measurement)},
          {"quantisation", "the motion read again on three shifted encoder grids"}};
}

json method_notes(const Measurement& measurement) {
  json notes = json::array();
  notes.push_back(fmt::format(
      "{} and every regressor passed the same zero-phase low-pass of {:.0f} Hz and were compared at {} "
      "instants, {:.1f} ms apart.",
      axis_is_rotary() ? "Torque" : "Force", measurement.bandwidth_Hz(), measurement.row_count(),
      1e3 * static_cast<double>(measurement.row_stride()) * measurement.tick_s()));
  if (measurement.burn_in_s() > 0.0) {
    notes.push_back(fmt::format("The first {} are left out: how the axis moved before the log is not known.",
                                quantity(measurement.burn_in_s(), "s")));
  }
  notes.push_back(fmt::format(
      "Noise of the {} before the filter: {} ({}). Held-out errors: {} contiguous blocks in {} folds, each "
      "judged by a fit to the others.",
      force_word(), quantity(measurement.force_noise_N(), "N"), noise_method(measurement),
      measurement.block_count(), measurement.fold_count()));
  if (measurement.log_count() > 1) {
    std::string logs;
    for (std::size_t log = 0; log < measurement.log_count(); ++log) {
      const LogPart& part = measurement.parts()[measurement.parts_of_log(log).first];
      logs += (logs.empty() ? "" : ", ") + printable(part.path);
    }
    notes.push_back(fmt::format("Logs, one after another: {}.", logs));
  }
  if (measurement.is_excerpt()) {
    notes.push_back(fmt::format(
        "Effects were searched, and the pictures drawn, in {} intervals, {} of {} samples; errors are those "
        "of all.",
        measurement.parts().size(), measurement.sample_count(), measurement.whole_sample_count()));
  }
  for (const std::string& note : measurement.log().notes) notes.push_back(note);
  return notes;
}

}  // namespace slipstack::workbench
