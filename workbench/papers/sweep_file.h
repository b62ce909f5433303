// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "workbench/papers/parallel_sweeps.h"

namespace slipstack::workbench {

/// A stopped sweep in a file (--resume): read when there is one, written when the user stops, removed when
/// the sweep is done. The file of another request is refused.
class SweepFile {
 public:
  /// `path` empty: nothing is stored. `request` identifies the request.
  SweepFile(std::string path, std::string request) : path_(std::move(path)), request_(std::move(request)) {}

  /// The stored chains, or none. Throws UsageError when the file is not such a file or belongs to another
  /// request.
  std::vector<sim::SweepChain> read() const;
  /// Stores the chains, completely or not at all; throws UsageError when that fails.
  void write(const std::vector<sim::SweepChain>& chains) const;
  void remove() const;
  /// "kept in FILE; …" or what to do to keep it the next time.
  std::string stopped_text(const std::vector<sim::SweepChain>& chains, std::size_t points) const;

 private:
  std::string path_;
  std::string request_;
};

/// Everything that determines the result of a stepped sine, as text.
std::string request_text(const sim::ExperimentSetup& setup, const sim::SteppedSineRequest& request);

/// Runs a stepped sine that Ctrl-C can stop and that continues from `path`; throws Stopped when the user
/// stops it. When the sweep is complete, the file is removed, unless it is one of several (`one_of_many`),
/// which the caller removes together.
std::vector<sim::SweepChain> run_kept_sweep(const std::string& path, const sim::ExperimentSetup& setup,
                                            const sim::SteppedSineRequest& request, const RunControl& control,
                                            bool one_of_many = false);

}  // namespace slipstack::workbench
