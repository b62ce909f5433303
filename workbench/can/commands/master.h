// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "workbench/can/client/sdo_client.h"
#include "workbench/model/model.h"

// The work of `deploy`, `record` and `status` on a bus. Every function throws UsageError, one line.
namespace slipstack::workbench {

using Show = std::function<void(const std::string& stage, double fraction)>;

/// Checks the model against the bounds of the drive, stages it, reads it back, applies it between two ticks,
/// compares the hash, and stores it if asked. Returns the text to print. If the drive refuses or a transfer
/// fails, the active model is unchanged.
std::string deploy_model(SdoClient& drive, const Model& model, const std::string& name, bool store,
                         const Show& show);

/// A parameter that a deployment would change on the drive.
struct ModelDifference {
  std::string object;  ///< name of the object
  std::string unit;
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  double on_drive = 0.0;
  double in_model = 0.0;
};

/// Compares what the drive holds with the model, parameter by parameter. Nothing is written.
std::vector<ModelDifference> differences_from_drive(SdoClient& drive, const Model& model, const Show& show);

struct Recording {
  std::string log;  ///< CSV text
  std::size_t samples = 0;
  std::size_t lost = 0;
  /// Of a stream: latest less earliest arrival against the drive's clock, by the bus's time stamps.
  std::optional<double> arrival_spread_s = {};
};

/// Streams position and current by TPDO 3 for some seconds, timed by the drive's own SYNC, and makes a log of
/// it. Lost samples are counted in the log's head; it is then `sampling: irregular`. The communication
/// objects that it changes are restored.
Recording record_stream(SdoClient& drive, double seconds, double rate_Hz, const Show& show);

/// Arms the trace buffer, waits, reads it by block transfer: every tick, as many as the buffer holds.
Recording record_trace(SdoClient& drive, std::uint32_t decimation, const Show& show);

/// Identity, states, faults, hashes, counters.
std::string drive_status(SdoClient& drive);

}  // namespace slipstack::workbench
