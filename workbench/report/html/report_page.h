// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace slipstack::workbench {

/// One self-contained HTML page that shows `data`: the verdict, the reasons, the charts, the parameters, and
/// how it was measured. Styles, scripts and numbers are inlined; the page loads nothing from the network.
/// Text and tables need no script; only the charts do.
///
/// `data` holds SI values, NaN as null. Any part may be missing, null, empty or of another type and is then
/// left out. All strings are escaped, and bytes that are not UTF-8 replaced. Arrays that belong together have
/// equal length, null where a sample was excluded. Members:
///   title, command, log, setup; samples, duration_s, sample_rate_Hz
///   header: {mass_kg, magnet_pitch_m, encoder_resolution_m, motor_constant_N_per_A, normal_force_N}
///   verdict: {kind: missing_effect | complete | unexplained | comparison | fit | added | experiment,
///   headline,
///     detail}
///   figures: {noise_floor_N, train_rmse_N, holdout_rmse_N, holdout_interval_N, after_rmse_N,
///   after_interval_N,
///     relative_error (a share), after_relative_error}
///   baseline_effects: [id];  after_effects: [id], those of the second model;  notes: [text]
///   unexplained: {coordinate, description};  next_experiment: {why, command}
///   series: {time_s, position_m, velocity_mps, measured_N, model_N, residual_N, after_N}; "after": the
///   residual of
///     the second model. The charts stay fluid up to about 40 000 samples.
///   loops: [{title, displacement_m, measured_N, model_N, after_N}], in the order of recording
///   profiles: [{coordinate, title, unit (SI), x (rising), mean_N, spread_N (1 sd), after_mean_N,
///   forward_mean_N,
///     backward_mean_N, expected_mean_N, expected_name}]
///   spectrum: {frequency_Hz, residual_N, after_N (N/√Hz), floor_N}
///   candidates: [{effect, title, holdout_rmse_N, error_reduction and error_reduction_se (shares of the
///   baseline's
///     held-out error), criterion_difference, confounded_with: [id], evidence, cause, confirm_with}], best
///     first
///   steps: [{effect: "baseline" or id, holdout_rmse_N, criterion_difference}];  criterion_note: what that is
///   charts: [{title, x_axis: {name, unit, log}, y_axis, x: [value], curves: [{name, role, dashed, y, x}],
///   orbit}]: of
///     an experiment, in the units named; in an orbit every curve has its own x
///   tables: [{title, columns: [{heading, unit, number}], rows: [[text]]}]
///   parameters: [{effect, title, formula, parameters: [{name, value, standard_error, unit (SI), note}]}]
///
/// Cost: linear in the number of values, about 10 bytes of page for each.
std::string render_report(const nlohmann::json& data);

/// Writes render_report(data) to `path`: to a temporary file beside it, then renamed over it, so that a
/// reader never sees half a report and a failure leaves the old one in place. A symbolic link keeps pointing
/// where it does; a pipe or device is written to directly. Throws std::runtime_error with one line (path,
/// what is wrong) if that cannot be done.
void write_report(const std::filesystem::path& path, const nlohmann::json& data);

}  // namespace slipstack::workbench
