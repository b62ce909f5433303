// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "workbench/papers/experiments.h"
#include "workbench/papers/sweep_file.h"

namespace slipstack::workbench {
namespace {

std::string sweep_name(const sim::Sweep& sweep, std::size_t repeats) {
  std::string name = fmt::format("{:g} N {}", sweep.force_N, sweep.up ? "up" : "down");
  if (repeats > 1) name += fmt::format(" {}", sweep.repeat + 1);
  return name;
}

ExperimentTable points_table(const std::vector<sim::SweepChain>& chains) {
  ExperimentTable table{"points",
                        "Responses",
                        {{"force_N", "force", "N", 1.0, 5},
                         {"sweep", "sweep", "", 1.0, 4},
                         {"frequency_Hz", "frequency", "Hz", 1.0, 5},
                         {"amplitude_m", "amplitude", "µm", 1e6, 5},
                         {"compliance_m_per_N", "amplitude/force", "µm/N", 1e6, 5},
                         {"phase_rad", "phase", "°", 180.0 / std::numbers::pi, 4},
                         {"mean_m", "mean position", "mm", 1e3, 6},
                         {"periods", "periods", "", 1.0, 0},
                         {"mark", "", "", 1.0, 4}},
                        {}};
  for (const sim::SweepChain& chain : chains) {
    for (const sim::Sweep& sweep : chain.sweeps) {
      for (const sim::SinePoint& point : sweep.points) {
        const std::string mark = point.jump ? "jump" : point.settled ? "" : "not settled";
        table.rows.push_back({sweep.force_N, fmt::format("{} {}", sweep.up ? "up" : "down", sweep.repeat + 1),
                              point.frequency_Hz, point.amplitude_m, point.amplitude_m / sweep.force_N,
                              point.phase_rad, point.mean_m, point.periods, mark});
      }
    }
  }
  return table;
}

// The largest difference between an up and the down sweep after it, over their amplitude.
double up_down_difference(const sim::SweepChain& chain) {
  double worst = std::nan("");
  for (std::size_t i = 1; i < chain.sweeps.size(); ++i) {
    const auto& one = chain.sweeps[i - 1].points;
    const auto& other = chain.sweeps[i].points;
    if (chain.sweeps[i - 1].up == chain.sweeps[i].up) continue;
    for (std::size_t k = 0; k < one.size(); ++k) {
      const double a = one[k].amplitude_m;
      const double b = other[one.size() - 1 - k].amplitude_m;
      const double difference = std::fabs(a - b) / std::max(a, b);
      worst = std::isnan(worst) ? difference : std::max(worst, difference);
    }
  }
  return worst;
}

struct Counts {
  std::size_t jumps = 0;
  std::size_t unsettled = 0;
};

ExperimentTable summary_table(const std::vector<sim::SweepChain>& chains, Counts& counts) {
  ExperimentTable table{"levels",
                        "By force level",
                        {{"force_N", "force", "N", 1.0, 5},
                         {"resonance_Hz", "resonance", "Hz", 1.0, 5},
                         {"peak_m", "peak", "µm", 1e6, 5},
                         {"up_down_difference", "up against down", "%", 100.0, 2},
                         {"jumps", "jumps", "", 1.0, 0},
                         {"jump_Hz", "at", "Hz", 1.0, 4}},
                        {}};
  for (const sim::SweepChain& chain : chains) {
    const sim::Peak peak = sim::peak_of(chain.sweeps.front());
    std::size_t jumps = 0;
    std::string where;
    for (const sim::Sweep& sweep : chain.sweeps) {
      for (const sim::SinePoint& point : sweep.points) {
        if (!point.settled) ++counts.unsettled;
        if (!point.jump) continue;
        ++jumps;
        where += fmt::format("{}{:.3g} {}", where.empty() ? "" : ", ", point.frequency_Hz,
                             sweep.up ? "up" : "down");
      }
    }
    counts.jumps += jumps;
    table.rows.push_back({chain.force_N, peak.inside ? peak.frequency_Hz : std::nan(""), peak.amplitude_m,
                          up_down_difference(chain), static_cast<double>(jumps), where});
  }
  return table;
}

void add_charts(ExperimentResult& result, const std::vector<sim::SweepChain>& chains,
                const sim::SteppedSineRequest& request) {
  ExperimentChart amplitude =
      response_chart("Frequency response: fundamental amplitude", request.frequencies_Hz);
  ExperimentChart phase = phase_chart("Frequency response: phase", request.frequencies_Hz);
  std::size_t colour = 0;
  for (const sim::SweepChain& chain : chains) {
    for (const sim::Sweep& sweep : chain.sweeps) {
      const bool alone = chains.size() == 1;
      const std::string role =
          palette_role(alone ? static_cast<std::size_t>(&sweep - chain.sweeps.data()) : colour);
      const std::string name = sweep_name(sweep, request.repeats);
      amplitude.curves.push_back({name, compliance(sweep), {}, role, !sweep.up});
      phase.curves.push_back({name, phase_deg(sweep), {}, role, !sweep.up});
    }
    ++colour;
  }
  result.charts.push_back(std::move(amplitude));
  result.charts.push_back(std::move(phase));
}

ExperimentResult sine_result(const sim::ExperimentSetup& setup, const sim::SteppedSineRequest& request,
                             const std::vector<sim::SweepChain>& chains) {
  ExperimentResult result;
  result.experiment = "stepped-sine";
  result.setup = setup.title;
  Counts counts;
  ExperimentTable levels = summary_table(chains, counts);
  const sim::Peak first = sim::peak_of(chains.front().sweeps.front());
  const sim::Peak last = sim::peak_of(chains.back().sweeps.front());
  result.headline =
      chains.size() == 1
          ? fmt::format("At {:g} N the response peaks at {:.4g} Hz; {} jumps.", chains.front().force_N,
                        first.frequency_Hz, counts.jumps)
          : fmt::format("From {:g} to {:g} N the response's peak moves from {:.4g} to {:.4g} Hz; {} jumps.",
                        chains.front().force_N, chains.back().force_N, first.frequency_Hz, last.frequency_Hz,
                        counts.jumps);
  if (request.up && request.down) {
    double worst = 0.0;
    for (const sim::SweepChain& chain : chains) worst = std::max(worst, up_down_difference(chain));
    result.detail =
        fmt::format("Sweeps up and down differ by at most {:.2g} % of the amplitude.", 100.0 * worst);
    result.summary.push_back({"up_down_difference", worst});
  }
  result.summary.push_back({"jumps", counts.jumps});
  result.summary.push_back({"unsettled", counts.unsettled});
  result.tables = {std::move(levels), points_table(chains)};
  add_charts(result, chains, request);
  if (counts.unsettled > 0) {
    result.notes.push_back(
        fmt::format("{} points had not settled after {} periods: the motion does not repeat there.",
                    counts.unsettled, request.most_periods));
  }
  if (request.sensors)
    result.notes.emplace_back("Measured through encoder, noise, filter and delay of the set-up.");
  return result;
}

}  // namespace

void run_stepped_sine(const std::string& command_line, const SteppedSineOptions& wanted) {
  run_experiment(command_line, wanted.sine.outputs, wanted.sine.setup.inputs(), [&](Progress& progress) {
    const sim::ExperimentSetup setup = wanted.sine.setup.axis();
    sim::SteppedSineRequest request = wanted.sine.request(setup);
    request.up = wanted.direction != "down";
    request.down = wanted.direction != "up";
    request.repeats = wanted.repeats;
    request.sensors = wanted.sensors;
    request.seed = wanted.seed;
    const auto chains = run_kept_sweep(wanted.sine.resume, setup, request,
                                       control_of(progress, "stepped sine", wanted.sine.threads));
    return sine_result(setup, request, chains);
  });
}

}  // namespace slipstack::workbench
