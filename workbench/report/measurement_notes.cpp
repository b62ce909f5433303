// SPDX-License-Identifier: Apache-2.0
#include "workbench/report/measurement_notes.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "workbench/base/quantity.h"
#include "workbench/base/text.h"
#include "workbench/report/json_values.h"
#include "workbench/report/texts.h"

namespace slipstack::workbench {

using nlohmann::json;

namespace {

const char* noise_method(const Measurement& measurement) {
  return measurement.force_noise_given() ? "given by --noise"
                                         : "from differences of sixth order of the force";
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
      "noise      {} in one sample of the force, {}; with the encoder's quantisation, by reading "
      "the motion on shifted grids\n",
      newtons(measurement.force_noise_N()), noise_method(measurement));
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
      "Force and every regressor passed the same zero-phase low-pass of {:.0f} Hz and were compared at {} "
      "instants, {:.1f} ms apart.",
      measurement.bandwidth_Hz(), measurement.row_count(),
      1e3 * static_cast<double>(measurement.row_stride()) * measurement.tick_s()));
  if (measurement.burn_in_s() > 0.0) {
    notes.push_back(fmt::format("The first {} are left out: the state of the hysteresis is not known there.",
                                quantity(measurement.burn_in_s(), "s")));
  }
  notes.push_back(fmt::format(
      "Force noise before the filter: {} (from differences of sixth order). Held-out errors: {} contiguous "
      "blocks in {} folds, each judged by a fit to the others.",
      quantity(measurement.force_noise_N(), "N"), measurement.block_count(), measurement.fold_count()));
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
