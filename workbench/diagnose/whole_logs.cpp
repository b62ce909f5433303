// SPDX-License-Identifier: Apache-2.0
#include "workbench/diagnose/whole_logs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "workbench/fleet/requests.h"
#include "workbench/identify/parallel.h"
#include "workbench/identify/robust.h"
#include "workbench/identify/user_effect.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

/// Samples conditioned at once, and before them at most so many in which the hysteresis finds its state.
constexpr std::size_t kPiece = 196608;
constexpr std::size_t kLongestLead = 262144;

/// Samples over which an error is looked at on its own.
constexpr std::size_t kWindow = 4096;
/// A window that errs so many times as much as the worst of the excerpt is a surprise.
constexpr double kSurprise = 5.0;
constexpr std::size_t kMostSurprises = 3;

/// Whether `model` is `base` with one more term, and all terms simply add.
bool only_adds(const Terms& base, const Terms& model) {
  if (model.size() != base.size() + 1 || any_multiplies(model)) return false;
  for (std::size_t t = 0; t < base.size(); ++t) {
    if (model[t].effect != base[t].effect || model[t].shapes != base[t].shapes) return false;
  }
  return true;
}

json to_json(const Terms& terms) {
  json list = json::array();
  for (const Term& term : terms) {
    list.push_back({{"effect", term.id()},
                    {"definition", term.effect->definition},
                    {"shapes", term.shapes},
                    {"gains", term.gains},
                    {"lower", term.lower},
                    {"upper", term.upper}});
  }
  return list;
}

Terms terms_of(const json& list) {
  Terms terms;
  for (const json& one : list) {
    Term term;
    const auto definition = one.at("definition").get<std::string>();
    term.effect =
        definition.empty() ? find_effect(one.at("effect").get<std::string>()) : &declare_effect(definition);
    term.shapes = one.at("shapes").get<std::vector<double>>();
    term.gains = one.at("gains").get<std::vector<double>>();
    term.lower = one.at("lower").get<std::vector<double>>();
    term.upper = one.at("upper").get<std::vector<double>>();
    terms.push_back(std::move(term));
  }
  return terms;
}

/// Squares of what a model leaves and of the measured force.
struct Squares {
  double left = 0.0;
  double measured = 0.0;
  double weighted_left = 0.0;
  double weight = 0.0;
  void add(const Squares& other) {
    left += other.left;
    measured += other.measured;
    weighted_left += other.weighted_left;
    weight += other.weight;
  }
  double relative() const { return std::sqrt(left / std::max(measured, 1e-300)); }
  double rmse_N() const { return std::sqrt(weighted_left / std::max(weight, 1e-300)); }
};

}  // namespace

void WholeLogs::Reached::add(const Reached& other) {
  low_m = std::min(low_m, other.low_m);
  high_m = std::max(high_m, other.high_m);
  velocity_mps = std::max(velocity_mps, other.velocity_mps);
  acceleration_mps2 = std::max(acceleration_mps2, other.acceleration_mps2);
}

void WholeLogs::Reached::take(const Measurement& measurement, std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i) {
    const double x_m = measurement.log().position_m[i];
    add({x_m, x_m, std::abs(measurement.velocity_mps()[i]), std::abs(measurement.acceleration_mps2()[i])});
  }
}

WholeLogs::Reached WholeLogs::reached() const {
  Reached all = reached_;
  if (!excerpt_.is_excerpt()) all.take(excerpt_, 0, excerpt_.sample_count());
  return all;
}

struct WholeLogs::Sums {
  std::size_t log = 0;
  int first_block = 0;
  std::vector<NormalEquations> equations;  ///< of the unit's blocks, by model
  std::vector<Squares> squares;            ///< by model, of the full ones
  std::vector<Window> windows;             ///< of the last full model
  Reached reached;
};

WholeLogs::WholeLogs(const std::vector<LongLog>& logs, const Measurement& excerpt,
                     const RowWeighing& weighing, Team& team)
    : logs_(logs), excerpt_(excerpt), weighing_(weighing), team_(team) {
  const auto all = static_cast<double>(excerpt.whole_sample_count());
  for (std::size_t log = 0; log < logs.size(); ++log) {
    const std::size_t samples = logs[log].sample_count();
    const double share = static_cast<double>(samples) / all;
    const auto count = static_cast<std::size_t>(blocks_of_share(share));
    for (std::size_t b = 0; b < count; ++b) {
      const std::size_t first = samples * b / count;
      const std::size_t end = samples * (b + 1) / count;
      const bool goes_on = b > 0 && end - units_.back().borders.front() <= kPiece;
      if (!goes_on) units_.push_back({log, block_count_, {first}});
      units_.back().borders.push_back(end);
      ++block_count_;
    }
  }
}

void WholeLogs::sum_piece(const Unit& unit, const std::vector<std::size_t>& borders, const Task& task,
                          Sums& sums) const {
  const auto& [models, full, limit_N] = task;
  const std::size_t margin = excerpt_.margin();
  const LongLog& log = logs_[unit.log];
  const std::size_t known = lead_in(log, borders.front(), kLongestLead);
  const std::size_t from = known - std::min(known, 2 * margin);
  const std::size_t to = std::min(log.sample_count(), borders.back() + margin);
  std::vector<std::size_t> local;
  local.reserve(borders.size());
  for (const std::size_t border : borders) local.push_back(border - from);
  Measurement piece({log.piece(from, to - from), unit.log, from, log.sample_count(), log.travel_m()},
                    excerpt_, local);
  sums.reached.take(piece, borders.front() - from, borders.back() - from);
  if (piece.row_count() == 0) return;
  weighing_.apply(piece);

  const Linearisation base(piece, models.front());
  if (limit_N > 0.0) piece.set_row_weights(huber_weights(piece.row_weights(), base.residual_N(), limit_N));
  const NormalEquations base_equations(piece, base.columns(), base.target());
  for (std::size_t m = 0; m < models.size(); ++m) {
    const Terms& model = models[m];
    if (m >= full && only_adds(models.front(), model)) {
      const Term& added = model.back();
      if (added.gains.empty()) {  // a lag moves the measured force
        const Eigen::VectorXd target = base.target() - base.measured_N() + piece.force_N(lag_of(model));
        sums.equations[m].add(base_equations.with_target(piece, base.columns(), target), 0);
      } else {
        sums.equations[m].add(
            base_equations.with(piece, base.columns(), base.columns_of(added), base.target()), 0);
      }
      continue;
    }
    std::optional<Linearisation> own;
    if (m > 0) own.emplace(piece, model, &base);
    const Linearisation& linearisation = m > 0 ? *own : base;
    sums.equations[m].add(
        m > 0 ? NormalEquations(piece, linearisation.columns(), linearisation.target()) : base_equations, 0);
    if (m >= full) continue;
    const Eigen::VectorXd left = linearisation.residual_N().cwiseProduct(piece.row_usable());
    sums.squares[m].add({left.squaredNorm(),
                         linearisation.measured_N().cwiseProduct(piece.row_usable()).squaredNorm(),
                         left.cwiseAbs2().dot(piece.row_weights()), piece.row_weights().sum()});
    if (m + 1 != full) continue;
    for (Eigen::Index row = 0; row < left.size(); ++row) {
      const std::size_t window = (from + piece.row_samples()[static_cast<std::size_t>(row)]) / kWindow;
      if (sums.windows.empty() || sums.windows.back().index != window) {
        sums.windows.push_back({unit.log, window, 0.0, 0.0});
      }
      sums.windows.back().squares += piece.row_weights()(row) * left(row) * left(row);
      sums.windows.back().weight += piece.row_weights()(row);
    }
  }
}

WholeLogs::Sums WholeLogs::sum_unit(const Unit& unit, const Task& task) const {
  Sums sums;
  sums.log = unit.log;
  sums.first_block = unit.first_block;
  for (const Terms& model : task.models) {
    sums.equations.emplace_back(unknown_count(model), unit.block_count(), kFolds);
  }
  sums.squares.resize(task.full);
  if (unit.block_count() > 1) {
    sum_piece(unit, unit.borders, task, sums);
  } else {  // a block may be long
    const std::size_t end = unit.borders.back();
    for (std::size_t first = unit.borders.front(); first < end; first += kPiece) {
      sum_piece(unit, {first, std::min(end, first + kPiece)}, task, sums);
    }
  }
  for (NormalEquations& equations : sums.equations) equations.sum_up();
  return sums;
}

/// The units that are this process's.
std::vector<WholeLogs::Sums> WholeLogs::sum_share(const Task& task, const Progress& progress) const {
  std::vector<const Unit*> mine;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    if (static_cast<int>(u) % team_.size() == team_.rank()) mine.push_back(&units_[u]);
  }
  std::vector<Sums> sums(mine.size());
  std::atomic<std::size_t> done{0};
  parallel_for(mine.size(), [&](std::size_t i) {
    sums[i] = sum_unit(*mine[i], task);
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(mine.size()));
  });
  return sums;
}

json WholeLogs::to_json(const std::vector<Sums>& sums) {
  json list = json::array();
  for (const Sums& one : sums) {
    json entry{
        {"log", one.log},
        {"block", one.first_block},
        {"equations", json::array()},
        {"reached",
         {one.reached.low_m, one.reached.high_m, one.reached.velocity_mps, one.reached.acceleration_mps2}},
        {"squares", json::array()},
        {"windows", json::array()}};
    for (const NormalEquations& equations : one.equations) {
      json blocks = json::array();
      for (int b = 0; b < equations.block_count(); ++b) blocks.push_back(equations.numbers_of(b));
      entry["equations"].push_back(std::move(blocks));
    }
    for (const Squares& squares : one.squares) {
      entry["squares"].push_back({squares.left, squares.measured, squares.weighted_left, squares.weight});
    }
    for (const Window& window : one.windows) {
      entry["windows"].push_back({window.log, window.index, window.squares, window.weight});
    }
    list.push_back(std::move(entry));
  }
  return list;
}

std::vector<WholeLogs::Sums> WholeLogs::sums_of(const json& list, const std::vector<Terms>& models) {
  std::vector<Sums> all;
  all.reserve(list.size());
  for (const json& entry : list) {
    Sums one;
    one.log = entry["log"].get<std::size_t>();
    one.first_block = entry["block"].get<int>();
    for (std::size_t m = 0; m < models.size(); ++m) {
      const json& blocks = entry["equations"][m];
      NormalEquations equations(unknown_count(models[m]), static_cast<int>(blocks.size()), kFolds);
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        equations.add(blocks[b].get<std::vector<double>>(), static_cast<int>(b));
      }
      equations.sum_up();
      one.equations.push_back(std::move(equations));
    }
    const json& reached = entry["reached"];
    one.reached = {reached[0].get<double>(), reached[1].get<double>(), reached[2].get<double>(),
                   reached[3].get<double>()};
    for (const json& squares : entry["squares"]) {
      one.squares.push_back({squares[0].get<double>(), squares[1].get<double>(), squares[2].get<double>(),
                             squares[3].get<double>()});
    }
    for (const json& window : entry["windows"]) {
      one.windows.push_back({window[0].get<std::size_t>(), window[1].get<std::size_t>(),
                             window[2].get<double>(), window[3].get<double>()});
    }
    all.push_back(std::move(one));
  }
  return all;
}

/// Every unit, by block; each process sums its share.
std::vector<WholeLogs::Sums> WholeLogs::sum(const Task& task, const Progress& progress) {
  json request{{"do", "sum"}, {"full", task.full}, {"limit_N", task.limit_N}, {"models", json::array()}};
  for (const Terms& model : task.models) request["models"].push_back(workbench::to_json(model));
  std::vector<Sums> all;
  const std::vector<json> answers = ask(team_, request, [&] {
    all = sum_share(task, progress);
    return nullptr;
  });
  for (std::size_t rank = 1; rank < answers.size(); ++rank) {
    for (Sums& one : sums_of(answers[rank], task.models)) all.push_back(std::move(one));
  }
  std::sort(all.begin(), all.end(),
            [](const Sums& a, const Sums& b) { return a.first_block < b.first_block; });
  for (const Sums& one : all) reached_.add(one.reached);
  return all;
}

json WholeLogs::share(const json& request) const {
  Task task;
  task.full = request.at("full").get<std::size_t>();
  task.limit_N = request.at("limit_N").get<double>();
  task.models.reserve(request.at("models").size());
  for (const json& model : request.at("models")) task.models.push_back(terms_of(model));
  return to_json(sum_share(task, {}));
}

/// What one of the models that say so leaves of each log.
std::vector<LogErrors> WholeLogs::log_errors(const std::vector<Sums>& sums, std::size_t model) const {
  std::vector<Squares> squares(logs_.size());
  for (const Sums& one : sums) squares[one.log].add(one.squares[model]);
  std::vector<LogErrors> errors;
  errors.reserve(squares.size());
  for (const Squares& one : squares) errors.push_back({one.rmse_N(), 0.0, one.relative()});
  return errors;
}

/// Gains and errors of the models; `error_N` scales what is known before the data.
std::vector<FittedModel> WholeLogs::judged(const Task& task, double error_N, const Progress& progress) {
  const std::vector<Sums> sums = sum(task, progress);
  const std::vector<Terms>& models = task.models;
  windows_.clear();
  for (const Sums& one : sums) windows_.insert(windows_.end(), one.windows.begin(), one.windows.end());
  std::vector<FittedModel> judged(models.size());
  parallel_for(models.size(), [&](std::size_t m) {
    NormalEquations equations(unknown_count(models[m]), block_count_, kFolds);
    for (const Sums& one : sums) equations.add(one.equations[m], one.first_block);
    equations.sum_up();
    const NormalEquations::Constraints constraints = constraints_of(models[m], error_N);
    FittedModel& model = judged[m];
    model.solution = equations.fit(constraints);
    const auto held_out = equations.cross_validate(constraints, model.solution.rests);
    model.train_rmse_N = std::sqrt(equations.squared_error(model.solution.value) / equations.weight());
    model.holdout_rmse_N = held_out.rmse;
    model.block_squared_error = held_out.block_squared_error;
    for (int block = 0; block < equations.block_count(); ++block) {
      model.block_weight.push_back(equations.weight(block));
    }
    if (m >= task.full) return;
    Squares squares;
    for (const Sums& one : sums) squares.add(one.squares[m]);
    model.relative_error = squares.relative();
    model.log_errors = log_errors(sums, m);
    struct Weighted {
      double left = 0.0;
      double unseen = 0.0;
      double weight = 0.0;
    };
    std::vector<Weighted> of_log(logs_.size());
    for (const Sums& one : sums) {
      const int end = one.first_block + one.equations[m].block_count();
      for (int block = one.first_block; block < end; ++block) {
        of_log[one.log].left += equations.squared_error(model.solution.value, block);
        of_log[one.log].unseen += model.block_squared_error[static_cast<std::size_t>(block)];
        of_log[one.log].weight += equations.weight(block);
      }
    }
    for (std::size_t log = 0; log < logs_.size(); ++log) {
      const double weight = std::max(of_log[log].weight, 1e-300);
      model.log_errors[log].rmse_N = std::sqrt(of_log[log].left / weight);
      model.log_errors[log].holdout_rmse_N = std::sqrt(of_log[log].unseen / weight);
    }
  });
  return judged;
}

namespace {

/// The errors of `judged` in place of those of `model`.
void take_errors(FittedModel& model, const FittedModel& judged) {
  model.train_rmse_N = judged.train_rmse_N;
  model.holdout_rmse_N = judged.holdout_rmse_N;
  model.relative_error = judged.relative_error;
  model.block_squared_error = judged.block_squared_error;
  model.block_weight = judged.block_weight;
  model.log_errors = judged.log_errors;
}

}  // namespace

void WholeLogs::fit(const std::vector<FittedModel*>& models, double limit_N, const Progress& progress) {
  if (!excerpt_.is_excerpt()) return;
  const auto half = [&progress](double from) {
    return [&progress, from](double fraction) {
      if (progress) progress(from + 0.5 * fraction);
    };
  };
  Task task;
  task.limit_N = limit_N;
  for (const FittedModel* model : models) task.models.push_back(model->terms);
  task.full = task.models.size();
  const std::vector<FittedModel> found = judged(task, models.front()->train_rmse_N, half(0.0));
  task.models.clear();
  for (std::size_t m = 0; m < models.size(); ++m) {
    FittedModel& model = *models[m];
    take_errors(model, found[m]);
    model.solution = found[m].solution;
    Eigen::Index next = 0;
    for (Term& term : model.terms) {
      for (double& gain : term.gains) gain = model.solution.value(next++);
    }
    model.linearisation =
        std::make_shared<const Linearisation>(excerpt_, model.terms, model.linearisation.get());
    task.models.push_back(model.terms);
  }
  // With these gains; and where terms multiply, the force is no longer the one that was linearised.
  const std::vector<Left> left = left_by(task.models, half(0.5));
  for (std::size_t m = 0; m < models.size(); ++m) {
    models[m]->relative_error = left[m].relative_error;
    for (std::size_t log = 0; log < logs_.size(); ++log) {
      LogErrors& errors = models[m]->log_errors[log];
      errors.rmse_N = left[m].logs[log].rmse_N;
      errors.relative_error = left[m].logs[log].relative_error;
    }
  }
}

std::vector<WholeLogs::Left> WholeLogs::left_by(const std::vector<Terms>& models, const Progress& progress) {
  const std::vector<Sums> sums = sum({models, models.size(), 0.0}, progress);
  windows_.clear();
  std::vector<Squares> squares(models.size());
  for (const Sums& one : sums) {
    for (std::size_t m = 0; m < models.size(); ++m) squares[m].add(one.squares[m]);
    windows_.insert(windows_.end(), one.windows.begin(), one.windows.end());
  }
  std::vector<Left> left;
  left.reserve(models.size());
  for (std::size_t m = 0; m < models.size(); ++m) {
    left.push_back({squares[m].rmse_N(), squares[m].relative(), log_errors(sums, m)});
  }
  return left;
}

void WholeLogs::judge(Diagnosis& diagnosis, const Progress& progress) {
  // The baseline and the steps first, of which more is told; then the candidates.
  Task task;
  for (const Step& step : diagnosis.steps) task.models.push_back(step.terms);
  const std::size_t full = task.full = task.models.size();
  for (const Candidate& candidate : diagnosis.candidates) task.models.push_back(candidate.terms);
  const std::vector<FittedModel> found = judged(task, diagnosis.baseline.train_rmse_N, progress);
  // An effect that the excerpt cannot show was given the baseline's error, and keeps it.
  std::vector<bool> shown;
  for (const Candidate& candidate : diagnosis.candidates) {
    shown.push_back(candidate.block_squared_error != diagnosis.baseline.block_squared_error);
  }
  take_errors(diagnosis.baseline, found[0]);
  take_errors(diagnosis.best, found[std::min<std::size_t>(1, full - 1)]);
  take_errors(diagnosis.explained, found[full - 1]);
  for (std::size_t s = 0; s < full; ++s) diagnosis.steps[s].holdout_rmse_N = found[s].holdout_rmse_N;
  for (std::size_t c = 0; c < diagnosis.candidates.size(); ++c) {
    const FittedModel& model = shown[c] ? found[full + c] : found[0];
    diagnosis.candidates[c].holdout_rmse_N = model.holdout_rmse_N;
    diagnosis.candidates[c].block_squared_error = model.block_squared_error;
  }
}

std::vector<LogStretch> WholeLogs::surprises(const std::vector<LogStretch>& excerpt) const {
  // What of a stretch leads in was not seen by the search either.
  const auto in_excerpt = [&](const Window& window) {
    for (std::size_t i = 0; i < excerpt.size(); ++i) {
      const std::size_t known = excerpt[i].first + excerpt_.parts()[i].unknown_start;
      if (excerpt[i].log == window.log && window.index * kWindow >= known &&
          (window.index + 1) * kWindow <= excerpt[i].first + excerpt[i].count) {
        return true;
      }
    }
    return false;
  };
  const auto error = [](const Window& window) { return std::sqrt(window.squares / window.weight); };
  double known = 0.0;
  std::vector<Window> unknown;
  for (const Window& window : windows_) {
    if (window.weight <= 0.0) continue;
    if (in_excerpt(window)) {
      known = std::max(known, error(window));
    } else {
      unknown.push_back(window);
    }
  }
  std::sort(unknown.begin(), unknown.end(), [&](const Window& a, const Window& b) {
    return std::tuple(-error(a), a.log, a.index) < std::tuple(-error(b), b.log, b.index);
  });
  std::vector<LogStretch> found;
  for (const Window& window : unknown) {
    if (error(window) < kSurprise * known || found.size() == kMostSurprises) break;
    const LongLog& log = logs_[window.log];
    const std::size_t first = lead_in(log, window.index * kWindow, kLongestLead);
    const std::size_t end = std::min(log.sample_count(), (window.index + 1) * kWindow);
    found.push_back({window.log, first, end - first});
  }
  return found;
}

}  // namespace slipstack::workbench
