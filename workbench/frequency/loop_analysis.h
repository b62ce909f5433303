// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/frequency/margins.h"
#include "workbench/frequency/record_file.h"

namespace slipstack::workbench {

/// What a recording says of the loop.
struct LoopAnalysis {
  std::vector<ResponsePoint> plant;  ///< averaged where single lines are uncertain
  std::vector<double> frequency_Hz;
  std::vector<Complex> loop;  ///< measured plant × the drive's feedback
  Margins margins;
  double modulus_sd = 0.0;  ///< of the modulus margin, by the plant's
  /// Median over the lines of |S measured − S computed| / |S computed|, above what their noise explains (95
  /// %): the feedback that ran is not the computed one, or the axis is not linear. NaN: not measured.
  double sensitivity_difference = 0.0;
};

/// Throws InputError with `name` in front where the recording cannot be evaluated.
LoopAnalysis analyse(const LoopRecording& recording, const std::string& name);

}  // namespace slipstack::workbench
