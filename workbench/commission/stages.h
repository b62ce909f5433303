// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "workbench/commission/commission_folder.h"
#include "workbench/console/progress.h"
#include "workbench/loop/live_axis.h"

namespace slipstack::workbench {

/// The commissioning ends here; what() says why, in one line without the name of the command.
struct CommissionStopped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A finished stage, for the report.
struct StageReport {
  std::string stage;
  std::string found;
  double axis_s = 0.0;  ///< that it took of the axis
};

/// What the stages of a commissioning share: the axis, the folder, and what is to be told.
class Stages {
 public:
  Stages(LiveAxis& axis_to_move, CommissionFolder& kept_in, Progress& shown)
      : axis(axis_to_move),
        plate(axis_to_move.nameplate()),
        folder(kept_in),
        progress(shown),
        counted_s_(axis_to_move.used_s()) {}

  /// What the stage found: in an earlier run of the command, or now, by `work`, and then it is in the folder
  /// before anything else happens. `fraction` of the whole commissioning, for the progress.
  const nlohmann::json& stage(const std::string& name, double fraction,
                              const std::function<nlohmann::json()>& work);
  /// What is told of it.
  void report(const std::string& name, const std::string& found);
  /// Moves the axis from where it is held to where `motion` begins, slowly, then along it. Throws
  /// CommissionStopped on a fault: `what` and the fault.
  AxisRecord follow(const SetPoints& motion, double approach_mps, const std::string& what);
  /// The same; a fault is left in the record.
  AxisRecord run(const SetPoints& motion, double approach_mps);
  /// Of all finished stages, in earlier runs too, s.
  double used_s() const;

  LiveAxis& axis;
  Nameplate plate;  ///< of the axis, with the travel that was found
  CommissionFolder& folder;
  Progress& progress;
  std::vector<StageReport> reports;
  std::vector<std::string> notes;

 private:
  double counted_s_ = 0.0;
};

}  // namespace slipstack::workbench
