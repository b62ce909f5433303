// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/alternatives/spectral_line.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <span>
#include <unsupported/Eigen/FFT>

#include "workbench/base/interval.h"
#include "workbench/base/quantity.h"
#include "workbench/base/statistics.h"
#include "workbench/diagnose/alternatives/steady_line.h"
#include "workbench/diagnose/evidence/chance.h"
#include "workbench/diagnose/evidence/held_out.h"
#include "workbench/diagnose/evidence/reduction.h"
#include "workbench/estimate/linear/normal_equations.h"
#include "workbench/signal/spectrum.h"

namespace slipstack::workbench {
namespace {

/// Two values, each with half the width of its interval.
struct Line {
  double frequency_Hz = 0.0;
  double frequency_half_width_Hz = 0.0;
  double amplitude_N = 0.0;
  double amplitude_half_width_N = 0.0;
};

std::string described(const Line& line) {
  return fmt::format("what is left is a line in time at {}, amplitude {}, whatever the motion",
                     quantity_with_interval(line.frequency_Hz, line.frequency_half_width_Hz, "Hz"),
                     quantity_with_interval(line.amplitude_N, line.amplitude_half_width_N, "N"));
}

/// The frequencies at which the blocks of a log are alike in amplitude and phase, by more than chance.
struct Coherent {
  double strongest_Hz = 0.0;
  double most_alike_Hz = 0.0;
  double bin_Hz = 0.0;
  double chance = 1.0;  ///< probability that chance makes them as alike at one frequency: of the most alike
  double tried = 0.0;   ///< independent frequencies
};

/// The F test of a line (Thomson 1982) over P intervals of the log instead of over windows: with their
/// transforms c, each in units of its own rms, so that moves of large residual do not count for more than
/// others, R = |sum c|^2 / (P sum |c|^2) exceeds r by chance with the probability (1 - r)^(P - 1). The
/// intervals are the blocks of cross-validation, or fewer where these would have fewer rows than there are of
/// them.
Coherent coherent_in(const Measurement& measurement, const LogPart& part, const Eigen::VectorXd& residual_N) {
  const auto rows = static_cast<Eigen::Index>(part.row_count);
  const auto first_row = static_cast<Eigen::Index>(part.first_row);
  const Eigen::Index intervals =
      std::min<Eigen::Index>(part.block_count, static_cast<Eigen::Index>(std::sqrt(part.row_count)));
  const std::size_t length = std::bit_ceil(2 * part.row_count);
  std::vector<std::complex<double>> sum(length / 2), own;
  std::vector<double> power(length / 2, 0.0);
  Eigen::FFT<double> transform;
  for (Eigen::Index i = 0; i < intervals; ++i) {
    const Eigen::Index from = rows * i / intervals;
    const Eigen::Index count = rows * (i + 1) / intervals - from;
    Eigen::VectorXd interval = residual_N.segment(first_row + from, count);
    interval.array() -= interval.mean();
    std::vector<double> padded(length, 0.0);
    Eigen::Map<Eigen::VectorXd>(padded.data() + from, count) = interval / std::max(interval.norm(), 1e-300);
    transform.fwd(own, padded);
    for (std::size_t k = 0; k < sum.size(); ++k) {
      sum[k] += own[k];
      power[k] += std::norm(own[k]);
    }
  }
  Coherent best;
  best.bin_Hz = measurement.row_rate_Hz() / static_cast<double>(length);
  best.tried = 0.5 * static_cast<double>(part.row_count);
  double most = 0.0;
  const auto count = static_cast<double>(intervals);
  // Less than a period in an interval is no line.
  for (std::size_t k = length * static_cast<std::size_t>(intervals) / part.row_count; k < sum.size(); ++k) {
    const double share = std::min(1.0, std::norm(sum[k]) / std::max(count * power[k], 1e-300));
    const double chance = std::pow(1.0 - share, count - 1.0);
    if (is_chance(chance, best.tried)) continue;
    const double frequency_Hz = best.bin_Hz * static_cast<double>(k);
    if (chance < best.chance) {
      best.chance = chance;
      best.most_alike_Hz = frequency_Hz;
    }
    if (std::norm(sum[k]) <= most) continue;
    most = std::norm(sum[k]);
    best.strongest_Hz = frequency_Hz;
  }
  return best;
}

/// Derivative by the frequency of what cosine and sine columns with these gains make.
Eigen::VectorXd slope_by_frequency(const Eigen::VectorXd& times, const Eigen::MatrixXd& columns,
                                   const Eigen::VectorXd& gains) {
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(times.size());
  for (Eigen::Index i = 0; i < gains.size(); i += 2) {
    slope += 2.0 * std::numbers::pi *
             times.cwiseProduct(gains(i + 1) * columns.col(i) - gains(i) * columns.col(i + 1));
  }
  return slope;
}

/// The line of the largest amplitude among the phases, from its cosine and sine columns and their gains; two
/// standard errors to either side, frequency and gains jointly.
Line with_intervals(const Eigen::VectorXd& times, const Halves& halves, const Eigen::MatrixXd& columns,
                    const Eigen::VectorXd& residual_N, double frequency_Hz, const Eigen::VectorXd& gains) {
  Eigen::MatrixXd all(columns.rows(), columns.cols() + 1);
  all.leftCols(columns.cols()) = columns;
  all.col(columns.cols()) = slope_by_frequency(times, columns, gains);
  Line line{frequency_Hz};
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(all.cols(), 2);
  for (Eigen::Index i = 0; i < gains.size(); i += 2) {
    const double amplitude_N = std::hypot(gains(i), gains(i + 1));
    if (amplitude_N <= line.amplitude_N) continue;
    line.amplitude_N = amplitude_N;
    sums.col(0).setZero();
    sums.col(0).segment(i, 2) = gains.segment(i, 2) / amplitude_N;
  }
  sums(columns.cols(), 1) = 1.0;
  const Eigen::VectorXd errors = errors_of_sums(all, residual_N, halves, sums);
  line.amplitude_half_width_N = 2.0 * errors(0);
  line.frequency_half_width_Hz = 2.0 * errors(1);
  return line;
}

/// The residual of one part, and its rate.
struct Signal {
  std::span<const double> values;
  double rate_Hz = 0.0;
};

/// The power of a signal at a frequency, up to a factor.
double power_at(const Signal& signal, double frequency_Hz) {
  const std::complex<double> step = std::polar(1.0, -2.0 * std::numbers::pi * frequency_Hz / signal.rate_Hz);
  std::complex<double> turn = 1.0, sum = 0.0;
  for (const double value : signal.values) {
    sum += value * turn;
    turn *= step;
  }
  return std::norm(sum);
}

/// Whether a line has nearly all of the power that it has together with the harmonics of the motion beside
/// it: what repeats with a motion has a series of harmonics, of which one does not stand out like mains hum.
/// Of dry friction (1, 1/3, 1/5 ...) the third harmonic would have 0.7.
bool stands_out(const Signal& signal, double frequency_Hz, double period_s) {
  // Harmonics to either side. Chosen.
  constexpr int kBeside = 4;
  // Share of the power of all nine; the third harmonic of dry friction has 0.7. Chosen.
  constexpr double kNearlyAll = 0.95;
  const double own = power_at(signal, frequency_Hz);
  double beside = 0.0;
  for (int k = 1; k <= kBeside; ++k) {
    beside += power_at(signal, frequency_Hz - k / period_s) + power_at(signal, frequency_Hz + k / period_s);
  }
  return own > kNearlyAll * (own + beside);
}

/// Whether the line is a harmonic of a motion that repeats, so that it need not be there whatever the motion.
/// As far as its frequency is known, and within the resolution of the log where harmonics are so far
/// apart that few lines are there by chance; and it does not stand out of the harmonics beside it.
bool is_harmonic_of_motion(const Measurement& measurement, const LogPart& part, const Line& line,
                           const Signal& residual_N) {
  constexpr double kByChance = 0.25;  // at most; chosen
  const double period_s = rows_of_period(measurement, part) / measurement.row_rate_Hz();
  if (period_s == 0.0) return false;
  const double resolution_Hz = measurement.row_rate_Hz() / static_cast<double>(part.row_count);
  const double turns = line.frequency_Hz * period_s;
  const double off_Hz = std::abs(turns - std::round(turns)) / period_s;
  for (const double within_Hz : {resolution_Hz, line.frequency_half_width_Hz}) {
    if (off_Hz <= within_Hz && 2.0 * within_Hz * period_s <= kByChance)
      return !stands_out(residual_N, line.frequency_Hz, period_s);
  }
  return false;
}

/// No line.
Structure no_line(const Eigen::VectorXd& residual_N) {
  return {Coordinate::frequency, 0.0, 0.0, "", Eigen::VectorXd::Zero(residual_N.size())};
}

/// Rows over which a line keeps its phase: a log, or a part of one (of an excerpt).
enum class OnePhase { in_each_part, in_each_log };

/// Cosine and sine of each phase at the rows, of which `times` are known.
Eigen::MatrixXd line_columns(const Measurement& measurement, const Eigen::VectorXd& times,
                             double frequency_Hz, OnePhase one_phase) {
  const std::vector<LogPart>& parts = measurement.parts();
  const bool of_log = one_phase == OnePhase::in_each_log;
  const std::size_t phases = of_log ? measurement.log_count() : parts.size();
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(measurement.row_count(), 2 * static_cast<Eigen::Index>(phases));
  const Eigen::ArrayXd turned = 2.0 * std::numbers::pi * frequency_Hz * times.array();
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto first = static_cast<Eigen::Index>(parts[p].first_row);
    const auto count = static_cast<Eigen::Index>(parts[p].row_count);
    const auto column = 2 * static_cast<Eigen::Index>(of_log ? parts[p].log : p);
    columns.col(column).segment(first, count) = turned.segment(first, count).cos();
    columns.col(column + 1).segment(first, count) = turned.segment(first, count).sin();
  }
  return columns;
}

/// A line and how much of a residual it explains.
struct FoundLine {
  double frequency_Hz = 0.0;
  Eigen::MatrixXd columns;
  HeldOut judged;
};

/// The strongest line within `width_Hz` of `around_Hz`: by steps of 0.3 of a period over `length_s`, then by
/// Gauss-Newton steps between them, which converge that near the minimum.
FoundLine strongest_line(const Measurement& measurement, const Eigen::VectorXd& times, const Halves& halves,
                         const Eigen::VectorXd& residual_N, double around_Hz, double width_Hz,
                         double length_s, OnePhase one_phase) {
  const auto columns_at = [&](double frequency_Hz) {
    return line_columns(measurement, times, frequency_Hz, one_phase);
  };
  FoundLine found;
  found.frequency_Hz = around_Hz;
  const double step_Hz = 0.3 / length_s;
  double strongest = 0.0;
  for (double f = around_Hz - width_Hz; f <= around_Hz + width_Hz; f += step_Hz) {
    const double power = (columns_at(f).transpose() * residual_N).squaredNorm();
    if (power > strongest) {
      strongest = power;
      found.frequency_Hz = f;
    }
  }
  found.columns = columns_at(found.frequency_Hz);
  const double on_grid_Hz = found.frequency_Hz;
  for (int i = 0; i < 3; ++i) {
    const Eigen::LDLT<Eigen::MatrixXd> normal(found.columns.transpose() * found.columns);
    const auto gains_of = [&](const Eigen::VectorXd& values) -> Eigen::VectorXd {
      return normal.solve(found.columns.transpose() * values);
    };
    const Eigen::VectorXd slope = slope_by_frequency(times, found.columns, gains_of(residual_N));
    const Eigen::VectorXd free = slope - found.columns * gains_of(slope);  // what no gains can do instead
    const double by_Hz = free.dot(residual_N) / std::max(free.squaredNorm(), 1e-300);
    found.frequency_Hz = std::clamp(found.frequency_Hz + by_Hz, on_grid_Hz - step_Hz, on_grid_Hz + step_Hz);
    found.columns = columns_at(found.frequency_Hz);
  }
  found.judged = held_out(found.columns, residual_N, halves);
  return found;
}

/// The strongest line at the rows between `around_Hz` - `width_Hz` and `around_Hz` + `width_Hz`, of which
/// `strongest_in` has most. Of an excerpt its phase may differ from part to part, or hold over the whole log:
/// then its frequency is known far better.
Structure line_within(const Measurement& measurement, const LogPart& strongest_in,
                      const Eigen::VectorXd& residual_N, double around_Hz, double width_Hz) {
  const Eigen::VectorXd times = row_times(measurement);
  const Halves halves = alternating_blocks(measurement);
  std::size_t longest = 0;
  for (const LogPart& part : measurement.parts()) longest = std::max(longest, part.sample_count);
  const double part_s = static_cast<double>(longest) * measurement.tick_s();
  FoundLine found = strongest_line(measurement, times, halves, residual_N, around_Hz, width_Hz, part_s,
                                   OnePhase::in_each_part);
  if (measurement.parts().size() > measurement.log_count()) {
    FoundLine of_logs = strongest_line(measurement, times, halves, residual_N, found.frequency_Hz,
                                       0.3 / part_s, measurement.longest_log_s(), OnePhase::in_each_log);
    if (of_logs.judged.error_reduction > found.judged.error_reduction) found = std::move(of_logs);
  }
  const Line line =
      with_intervals(times, halves, found.columns, residual_N, found.frequency_Hz, found.judged.value);
  const std::span<const double> rows{residual_N.data() + strongest_in.first_row, strongest_in.row_count};
  if (is_harmonic_of_motion(measurement, strongest_in, line, {rows, measurement.row_rate_Hz()}))
    return no_line(residual_N);
  return {Coordinate::frequency, found.judged.error_reduction, found.frequency_Hz, described(line),
          found.judged.explained};
}

/// The largest amplitude of a line that the encoder makes: at a constant speed its steps come at one
/// frequency, a sawtooth of one step, and the mass times its second derivative has the line that the force
/// does not have.
double encoder_line_N(const LogPart& part, double frequency_Hz) {
  const double rate = 2.0 * std::numbers::pi * frequency_Hz;
  return part.rough_mass_kg * rate * rate * part.encoder_resolution_m / std::numbers::pi;
}

/// Whether the signal has a line whatever the motion: as much of it at every speed. A force that depends on
/// the position is a line too where the speed is always the same, and a motion that repeats gives it one
/// phase; but it is none while the axis stands or is faster. The samples are dealt to `kGroups` groups of as
/// many each, by their speed; in each group the line needs the share `kMajority` of its amplitude at least,
/// less two standard errors.
bool is_there_at_every_speed(std::span<const double> signal, std::span<const double> velocity_mps,
                             double cycles_per_sample) {
  // From standstill to the fastest, with as many samples each. Chosen.
  constexpr std::size_t kGroups = 4;
  std::vector<std::size_t> order(signal.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(velocity_mps[a]) < std::abs(velocity_mps[b]);
  });
  std::array<std::complex<double>, kGroups> of_group{};
  std::array<double, kGroups> squares{};
  std::complex<double> whole;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const std::size_t i = order[rank];
    const std::complex<double> turned =
        signal[i] * std::polar(1.0, -2.0 * std::numbers::pi * cycles_per_sample * static_cast<double>(i));
    of_group[rank * kGroups / order.size()] += turned;
    squares[rank * kGroups / order.size()] += std::norm(turned);
    whole += turned;
  }
  const double amplitude = std::max(std::abs(whole), 1e-300);
  for (std::size_t group = 0; group < kGroups; ++group) {
    const double in_phase = std::real(of_group[group] * std::conj(whole)) / amplitude;
    const double error = std::sqrt(0.5 * squares[group]);
    if (in_phase + 2.0 * error < kMajority * amplitude / static_cast<double>(kGroups)) return false;
  }
  return true;
}

}  // namespace

Structure line_at_rows(const Measurement& measurement, const Eigen::VectorXd& residual_N) {
  Coherent best;
  const LogPart* at = nullptr;
  double tried = 0.0;
  for (const LogPart& part : measurement.parts()) {  // the phase differs from log to log
    if (part.block_count < 2 || part.row_count < 4) continue;
    const Coherent own = coherent_in(measurement, part, residual_N);
    tried += own.tried;
    if (own.chance >= best.chance) continue;
    best = own;
    at = &part;
  }
  if (at == nullptr || is_chance(best.chance, tried)) return no_line(residual_N);
  // Of mains hum a harmonic may be as much alike as the hum itself; of a motion that repeats the strongest
  // may be a harmonic.
  Structure line = line_within(measurement, *at, residual_N, best.strongest_Hz, best.bin_Hz);
  if (!line.description.empty() || best.most_alike_Hz == best.strongest_Hz) return line;
  return line_within(measurement, *at, residual_N, best.most_alike_Hz, best.bin_Hz);
}

std::optional<Structure> line_beyond_rows(const Measurement& measurement, const std::vector<double>& model_N,
                                          double error_N) {
  std::vector<double> residual_N = measurement.log().force_N;
  for (std::size_t i = 0; i < residual_N.size(); ++i) residual_N[i] -= model_N[i];
  const auto of_part = [](const std::vector<double>& signal, const LogPart& part) {
    return std::span(signal).subspan(part.first_sample, part.sample_count);
  };
  std::optional<SteadyLine> best;
  const LogPart* at = nullptr;
  for (const LogPart& part : measurement.parts()) {  // the phase differs from log to log
    const SteadySearch search{measurement.sample_rate_Hz(), measurement.bandwidth_Hz(),
                              static_cast<std::size_t>(part.block_count)};
    const auto line = steady_line(of_part(residual_N, part), search);
    if (!line || (best && line->chance >= best->chance)) continue;
    const bool in_force = is_steady_at(of_part(measurement.log().force_N, part), search, line->frequency_Hz);
    if (!in_force && line->amplitude_N < encoder_line_N(part, line->frequency_Hz)) continue;
    if (!is_there_at_every_speed(of_part(residual_N, part), of_part(measurement.velocity_mps(), part),
                                 line->frequency_Hz / measurement.sample_rate_Hz()) ||
        is_harmonic_of_motion(measurement, part, {line->frequency_Hz, 2.0 * line->frequency_error_Hz},
                              {of_part(residual_N, part), measurement.sample_rate_Hz()})) {
      continue;
    }
    best = line;
    at = &part;
  }
  if (at == nullptr) return {};
  const double power = 0.5 * best->amplitude_N * best->amplitude_N;
  const std::string line = described(
      {best->frequency_Hz, 2.0 * best->frequency_error_Hz, best->amplitude_N, 2.0 * best->amplitude_error_N});
  // The reader sees an amplitude that may be many times the error.
  return Structure{Coordinate::frequency, 1.0 - error_N / std::sqrt(error_N * error_N + power),
                   best->frequency_Hz,
                   fmt::format("{}; the errors, which are those below {}, do not contain it", line,
                               quantity(measurement.bandwidth_Hz(), "Hz")),
                   Eigen::VectorXd::Zero(measurement.row_count())};
}

}  // namespace slipstack::workbench
