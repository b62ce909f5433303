// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/parallel_sweeps.h"

#include <mutex>

#include "workbench/base/parallel.h"

namespace slipstack::workbench {
namespace {

/// Counts the points that several threads have finished and reports their share.
class PointCounter {
 public:
  PointCounter(const RunControl& control, std::size_t total) : control_(control), total_(total) {}

  void add(std::size_t points = 1) {
    const std::lock_guard lock(lock_);
    done_ += points;
    if (control_.progress) control_.progress(static_cast<double>(done_) / static_cast<double>(total_));
  }

 private:
  const RunControl& control_;
  std::size_t total_;
  std::size_t done_ = 0;
  std::mutex lock_;
};

}  // namespace

void run_sweeps(const sim::ExperimentSetup& setup, const sim::SteppedSineRequest& request,
                std::vector<sim::SweepChain>& chains, const RunControl& control) {
  sim::prepare_sweeps(setup, request, chains);
  PointCounter counter(control, chains.size() * sim::points_per_level(request));
  for (const sim::SweepChain& chain : chains) {
    for (const sim::Sweep& sweep : chain.sweeps) counter.add(sweep.points.size());
  }
  const sim::SweepControl each{[&] { counter.add(); }, control.stop};
  parallel_for(chains.size(), control.threads,
               [&](std::size_t i) { sim::run_sweep_chain(setup, request, i, chains[i], each); });
}

std::vector<sim::MeasuredLoop> measure_loops(const sim::ExperimentSetup& setup,
                                             const sim::LoopRequest& request, const RunControl& control) {
  sim::check_loops(setup, request);
  std::vector<sim::MeasuredLoop> loops(sim::loop_count(request));
  PointCounter counter(control, loops.size());
  parallel_for(loops.size(), control.threads, [&](std::size_t i) {
    loops[i] = sim::measure_loop(setup, request, i);
    counter.add();
  });
  return loops;
}

std::vector<std::vector<sim::DescribedPoint>> describe_responses(const sim::ExperimentSetup& setup,
                                                                 const sim::SteppedSineRequest& request,
                                                                 const RunControl& control) {
  const std::size_t frequencies = request.frequencies_Hz.size();
  std::vector<std::vector<sim::DescribedPoint>> responses(request.forces_N.size(),
                                                          std::vector<sim::DescribedPoint>(frequencies));
  PointCounter counter(control, responses.size() * frequencies);
  parallel_for(responses.size() * frequencies, control.threads, [&](std::size_t i) {
    const std::size_t force = i / frequencies;
    const std::size_t frequency = i % frequencies;
    responses[force][frequency] =
        sim::describe_response(setup, request.forces_N[force], request.frequencies_Hz[frequency]);
    counter.add();
  });
  return responses;
}

}  // namespace slipstack::workbench
