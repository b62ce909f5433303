// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "workbench/estimate/nonlinear/fitted_model.h"
#include "workbench/long_logs/log_search.h"
#include "workbench/model/model.h"
#include "workbench/report/pictures.h"
#include "workbench/serve/http/bytes.h"

namespace slipstack::workbench {

/// The logs as they are drawn, and models on them. Nothing here is fitted but gains, at once, as a first
/// answer; what is kept comes from a job (analysis/). All members may be called from any thread.
class View {
 public:
  /// Opens and measures the logs. Throws InputError.
  View(const LogRequest& request, Progress& progress);

  /// Coordinates of the rows and where they lie in the logs: arrays time_s, position_m, velocity_mps,
  /// acceleration_mps2, since_reversal_s, measured_N; header: sample_rate_Hz, starts (first row of each part
  /// after a gap), logs.
  Bytes rows() const;
  /// What a model makes of them: arrays measured_N, model_N, residual_N; header: rmse_N, relative_error,
  /// left, parameters, worst.
  Bytes model(const std::string& key, const Terms& terms);
  /// Residual charts of a model, and of a second one beside it (null: none): loops, profiles, spectrum
  /// (report/pictures.h), coherence, autocorrelation, response (analysis/residual_dynamics.h).
  nlohmann::json charts(const std::string& key, const Terms& terms, const std::string& other_key,
                        const Terms* other);

  /// The model with some parameters set by hand: as model(), without parameters.
  Bytes bent(const std::string& key, const Terms& terms, const Terms& by_hand);
  /// Held-out error of the model without each of its effects, at once: its shapes stay, the gains of the
  /// others are fitted again (normal equations). [{effect, without_N}] and `with_N`.
  nlohmann::json worth(const std::string& key, const Terms& terms);
  /// Held-out error with one more term at given shapes, likewise: {before_N, after_N}.
  nlohmann::json with_term(const std::string& key, const Terms& terms, const Term& term);

  const Measurement& measurement() const { return *measurement_; }
  /// Terms of a model file, as many gains as these logs need.
  Terms on_logs(const Terms& terms) const;

 private:
  struct Fitted {
    Terms terms;
    std::unique_ptr<Linearisation> linearisation;
    std::unique_ptr<NormalEquations> equations;
    NormalEquations::Constraints constraints;
  };
  const ForceRows& rows_of_model(const std::string& key, const Terms& terms);
  const Fitted& fitted(const std::string& key, const Terms& terms);
  Bytes answer(const ForceRows& rows, const Terms& terms, bool whole) const;

  std::unique_ptr<Measurement> measurement_;
  std::mutex lock_;  ///< of what follows
  std::map<std::string, ForceRows> rows_;
  std::string fitted_key_;
  std::unique_ptr<Fitted> fitted_;
};

}  // namespace slipstack::workbench
