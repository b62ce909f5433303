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
  /// The key of a version of the session: what is known of its model is found by it again.
  static std::string key_of(int version);

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
  /// (report/pictures.h), coherence, autocorrelation, response (analysis/residual_dynamics.h), damping of
  /// loops (loop_damping.h).
  nlohmann::json charts(const std::string& key, const Terms& terms, const std::string& other_key,
                        const Terms* other);

  /// The model with some parameters set by hand: as model(), without parameters.
  Bytes bent(const std::string& key, const Terms& terms, const Terms& by_hand);
  /// Held-out error of the model without each of its effects, at once: its shapes stay, the gains of the
  /// others are fitted again (normal equations). [{effect, without_N}] and `with_N`.
  nlohmann::json worth(const std::string& key, const Terms& terms);
  /// Held-out error with one more term at given shapes, likewise: {before_N, after_N}.
  nlohmann::json with_term(const std::string& key, const Terms& terms, const Term& term);

  /// A model whose gains were fitted at once, as a first answer: its shapes are held, those of the added term
  /// at what is given. Cost: one column set and one solution; some more where effects multiply.
  struct Gains {
    Terms terms;
    double before_N = 0.0;  ///< held-out error of the model that it came from, on what is searched
    double after_N = 0.0;   ///< its own
  };
  Gains added(const std::string& key, const Terms& terms, const Term& term);
  Gains removed(const std::string& key, const Terms& terms, const std::string& effect);

  /// The logs as they were opened: what a job begins with.
  const LogSearch& opened() const { return opened_; }
  const Measurement& measurement() const { return opened_.measurement(); }
  /// Terms of a model file, as many gains as these logs need.
  Terms on_logs(const Terms& terms) const;

 private:
  Eigen::VectorXd inertia_N(const Terms& terms) const;
  const ForceRows& rows_of_model(const std::string& key, const Terms& terms);
  const FittedModel& fitted(const std::string& key, const Terms& terms);
  Gains gains_only(const FittedModel& now, Terms terms) const;
  Bytes answer(const ForceRows& rows, const Terms& terms, bool whole) const;

  LogSearch opened_;
  std::mutex lock_;  ///< of what follows
  std::map<std::string, ForceRows> rows_;
  std::map<std::string, Bytes> answers_;  ///< of model(): those of a version do not change
  std::string fitted_key_;
  std::unique_ptr<FittedModel> fitted_;
};

}  // namespace slipstack::workbench
