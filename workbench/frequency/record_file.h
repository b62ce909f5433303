// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/frequency/drive_controller.h"
#include "workbench/frequency/excited_record.h"

namespace slipstack::workbench {

/// Captures of an excited loop in several bands, and the feedback that ran meanwhile.
struct LoopRecording {
  DriveController drive;
  double velocity_mps = 0.0;  ///< of the axis; 0: at standstill
  double force_limit_N = 0.0;
  double motor_constant_N_per_A = 1.0;
  std::vector<std::vector<ExcitedRecord>> bands;  ///< captures of each
  std::vector<std::string> notes;                 ///< what was not linear, and the like
};

/// CSV with `# key: value` lines and the columns band, capture, position_m, force_N, excitation
/// (docs/bode.md).
std::string recording_text(const LoopRecording& recording);

/// Reads such a file. Throws InputError, one line with file and line, when it is not one or is damaged.
LoopRecording read_recording(const std::string& path);

}  // namespace slipstack::workbench
