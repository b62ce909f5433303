// SPDX-License-Identifier: Apache-2.0
#include "workbench/can/commands/tune_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "workbench/can/drive/drive_gains.h"

namespace slipstack::workbench {
namespace {

constexpr int kAttempts = 3;

/// Puts the gains of before back unless the new ones are kept.
class GainsGuard {
 public:
  GainsGuard(SdoClient& drive, const DriveController& before) : drive_(drive), before_(before) {}
  GainsGuard(const GainsGuard&) = delete;
  GainsGuard& operator=(const GainsGuard&) = delete;
  ~GainsGuard() {
    if (kept_) return;
    try {
      apply_gains(drive_, before_, false, [](const std::string&, double) {});
    } catch (
        const std::exception&) {  // the bus is gone, or the axis in a fault: a reset brings the stored ones
    }
  }
  void keep() { kept_ = true; }

 private:
  SdoClient& drive_;
  DriveController before_;
  bool kept_ = false;
};

}  // namespace

Tuning propose_or_refuse(const LoopRecording& recording, const LoopAnalysis& analysis,
                         const TuneRequest& request) {
  // Below the band nothing is known: there both loops must be large.
  if (!(std::abs(analysis.loop.front()) > 1.0)) {
    throw UsageError(fmt::format(
        "the open loop is {:.2g} at {:.4g} Hz already, the lowest frequency measured; measure lower (--from)",
        std::abs(analysis.loop.front()), analysis.frequency_Hz.front()));
  }
  const std::optional<Tuning> tuning = propose(analysis.plant, recording.drive, request);
  if (!tuning) {
    throw UsageError(
        fmt::format("no gains with a modulus margin of {:.3g} were found for this plant; measure with more "
                    "--amplitude or "
                    "--captures, or ask for less (--modulus-margin)",
                    request.modulus_margin));
  }
  return *tuning;
}

TunedDrive tune_drive(SdoClient& drive, const LoopRecording& recording, const LoopAnalysis& analysis,
                      const LoopMeasurement& measurement, const TuneRequest& request, bool store,
                      const Show& show) {
  GainsGuard guard(drive, recording.drive);
  TuneRequest asked = request;
  LoopRecording base = recording;
  LoopAnalysis known = analysis;
  double measured = 0.0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    TunedDrive tuned{propose_or_refuse(base, known, asked), {}};
    apply_gains(drive, tuned.tuning.gains, false, show);
    const LoopRecording now = measure_loop(drive, measurement, show);
    tuned.loop = {now.drive, analyse(now, fmt::format("node {}", drive.node()))};
    measured = tuned.loop.analysis.margins.modulus;
    if (measured + 2.0 * tuned.loop.analysis.modulus_sd >= request.modulus_margin) {
      guard.keep();
      if (store) apply_gains(drive, now.drive, true, show);
      return tuned;
    }
    asked.modulus_margin = std::min(asked.modulus_margin + (request.modulus_margin - measured), 0.9);
    base = now;
    known = tuned.loop.analysis;
  }
  throw UsageError(
      fmt::format("node {}: the axis reaches a modulus margin of {:.3g} where {:.3g} was predicted; the "
                  "gains of before are "
                  "back. Measure with --velocity, more --amplitude or more --captures",
                  drive.node(), measured, request.modulus_margin));
}

}  // namespace slipstack::workbench
