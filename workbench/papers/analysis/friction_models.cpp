// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/analysis/friction_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace slipstack::workbench {
namespace {

constexpr std::size_t kGmsElements = 12;
constexpr std::size_t kMaxwellElements = 20;
constexpr std::size_t kTablePoints = 20;

double sign_of(double value) {
  return value < 0.0 ? -1.0 : 1.0;
}

double extent_of(const SampledMotion& motion) {
  const auto [low, high] = std::minmax_element(motion.position_m.begin(), motion.position_m.end());
  return *high - *low;
}

double fastest_of(const SampledMotion& motion) {
  double fastest = 0.0;
  for (const double v : motion.velocity_mps) fastest = std::max(fastest, std::fabs(v));
  return fastest;
}

std::vector<double> slips_of(const SampledMotion& motion, std::size_t count) {
  const double last_m = motion.longest_m > 0.0 ? motion.longest_m : 0.5 * extent_of(motion);
  // A travel of less than a step between samples is sliding, whatever the model.
  std::vector<double> moves;
  for (std::size_t i = 1; i < motion.position_m.size(); ++i) {
    const double move = std::fabs(motion.position_m[i] - motion.position_m[i - 1]);
    if (move > 0.0) moves.push_back(move);
  }
  double first_m = motion.shortest_m > 0.0 ? motion.shortest_m : 1e-3 * last_m;
  if (!moves.empty() && !(motion.shortest_m > 0.0)) {
    const auto small = moves.begin() + static_cast<std::ptrdiff_t>(moves.size() / 20);
    std::nth_element(moves.begin(), small, moves.end());
    first_m = std::clamp(*small, 1e-5 * last_m, 1e-2 * last_m);
  }
  std::vector<double> slips(count);
  for (std::size_t i = 0; i < count; ++i) {
    slips[i] = first_m * std::pow(last_m / first_m, static_cast<double>(i) / static_cast<double>(count - 1));
  }
  return slips;
}

/// Runs `step(dx, v, row)` over the motion; the first row has the state as it starts.
template <typename Step>
void along(const SampledMotion& motion, Step&& step) {
  for (std::size_t i = 0; i < motion.position_m.size(); ++i) {
    const double dx = i == 0 ? 0.0 : motion.position_m[i] - motion.position_m[i - 1];
    step(dx, motion.velocity_mps[i], static_cast<Eigen::Index>(i));
  }
}

/// Weakening: 1 + r·exp(−(v/v_s)²).
double level_at(double v, double excess, double stribeck_mps) {
  const double ratio = v / stribeck_mps;
  return 1.0 + excess * std::exp(-ratio * ratio);
}

Eigen::MatrixXd stribeck_columns(double stribeck_mps, const SampledMotion& motion) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(motion.position_m.size()), 3);
  double direction = 0.0;
  along(motion, [&](double dx, double v, Eigen::Index row) {
    if (dx != 0.0) direction = sign_of(dx);  // at rest the force keeps its side
    columns.row(row) << direction, direction * (level_at(v, 1.0, stribeck_mps) - 1.0), v;
  });
  return columns;
}

Eigen::MatrixXd dahl_columns(double length_m, const SampledMotion& motion) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(motion.position_m.size()), 2);
  double z = 0.0;
  along(motion, [&](double dx, double v, Eigen::Index row) {
    const double limit = sign_of(dx);
    z = limit + (z - limit) * std::exp(-std::fabs(dx) / length_m);
    columns.row(row) << z, v;
  });
  return columns;
}

Eigen::MatrixXd bouc_wen_columns(const std::vector<double>& shape, const SampledMotion& motion) {
  const double length_m = shape[0];
  const double exponent = shape[1];
  const double beta = shape[2];
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(motion.position_m.size()), 3);
  double z = 0.0;
  along(motion, [&](double dx, double v, Eigen::Index row) {
    const double direction = sign_of(dx);
    const auto slope = [&](double at) {
      const double bent = std::pow(std::fabs(at), exponent);
      return direction * (1.0 - bent * (direction * at >= 0.0 ? 1.0 : 1.0 - 2.0 * beta));
    };
    // In units of ℓ; beyond forty of them the state has long reached its limit.
    const double way = std::min(std::fabs(dx) / length_m, 40.0);
    const int steps = std::max(1, static_cast<int>(std::ceil(10.0 * way)));
    const double h = way / steps;
    for (int i = 0; i < steps && way > 0.0; ++i) {
      const double k1 = slope(z);
      const double k2 = slope(z + 0.5 * h * k1);
      const double k3 = slope(z + 0.5 * h * k2);
      const double k4 = slope(z + h * k3);
      z = std::clamp(z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), -1.0, 1.0);
    }
    columns.row(row) << z, motion.position_m[static_cast<std::size_t>(row)] - motion.position_m.front(), v;
  });
  return columns;
}

Eigen::MatrixXd lugre_columns(const std::vector<double>& shape, const SampledMotion& motion) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(motion.position_m.size()), 3);
  double z = 0.0;
  along(motion, [&](double dx, double v, Eigen::Index row) {
    const double level = level_at(v, shape[1], shape[2]);
    const double limit = sign_of(dx) * level;
    const double before = z;
    z = limit + (z - limit) * std::exp(-std::fabs(dx) / (shape[0] * level));
    columns.row(row) << z, (z - before) / motion.step_s, v;
  });
  return columns;
}

// An elastic share of 1 would leave no range for α to rise in.
constexpr double kMostElastic = 0.99;

/// dz/dt = (v − α(z)·|v|·z/s(v))/ℓ in a step of dx, exact while α is 0 or the state has reached its limit.
double elasto_plastic_step(double z, double dx, double length_m, double level, double elastic_share) {
  const double direction = sign_of(dx);
  const double elastic = std::min(elastic_share, kMostElastic) * level;
  double way = std::fabs(dx) / length_m;
  const double until = direction * z < elastic ? std::min(way, elastic - direction * z) : 0.0;
  z += direction * until;
  way -= until;
  const auto slope = [&](double at) {
    const double share = (direction * at - elastic) / (level - elastic);
    const double plastic =
        share <= 0.0 ? 0.0 : (share >= 1.0 ? 1.0 : 0.5 - 0.5 * std::cos(std::numbers::pi * share));
    return direction - plastic * at / level;
  };
  // At the limit nothing moves any more; the level may have fallen below the state, which then returns.
  const double step = std::min(0.1, 0.1 * (level - elastic) + 0.01);
  while (way > 0.0 && std::fabs(direction * z - level) > 1e-6 * level) {
    const double h = std::min(step, way);
    z += h * slope(z + 0.5 * h * slope(z));
    way -= h;
  }
  return z;
}

Eigen::MatrixXd elasto_plastic_columns(const std::vector<double>& shape, const SampledMotion& motion) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(motion.position_m.size()), 2);
  double z = 0.0;
  along(motion, [&](double dx, double v, Eigen::Index row) {
    z = elasto_plastic_step(z, dx, shape[0], level_at(v, shape[1], shape[2]), shape[3]);
    columns.row(row) << z, v;
  });
  return columns;
}

/// Hat functions over velocity, ten points to each side at squares of equal steps. That of the last point is
/// left out: together they would be the offset that every model has.
Eigen::MatrixXd table_columns(double fastest_mps, const SampledMotion& motion) {
  std::array<double, kTablePoints> places{};
  for (std::size_t i = 0; i < kTablePoints; ++i) {
    const double u = 2.0 * static_cast<double>(i) / static_cast<double>(kTablePoints - 1) - 1.0;
    places[i] = fastest_mps * u * std::fabs(u);
  }
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(motion.position_m.size()), kTablePoints - 1);
  along(motion, [&](double, double v, Eigen::Index row) {
    const double at = std::clamp(v, places.front(), places.back());
    const auto above = std::upper_bound(places.begin() + 1, places.end() - 1, at);
    const auto i = static_cast<Eigen::Index>(above - places.begin());
    const double share = (at - *(above - 1)) / (*above - *(above - 1));
    columns(row, i - 1) = 1.0 - share;
    if (i < columns.cols()) columns(row, i) = share;
  });
  return columns;
}

Eigen::MatrixXd gms_columns(const std::vector<double>& shape, const std::vector<double>& slips,
                            const SampledMotion& motion) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(motion.position_m.size()),
                          static_cast<Eigen::Index>(slips.size()) + 1);
  std::vector<double> z(slips.size(), 0.0);
  std::vector<bool> slipping(slips.size(), false);
  const double stay = std::exp(-shape[2] * motion.step_s);
  double direction = 0.0;
  along(motion, [&](double dx, double v, Eigen::Index row) {
    if (dx != 0.0 && sign_of(dx) != direction) {
      std::fill(slipping.begin(), slipping.end(), false);
      direction = sign_of(dx);
    }
    const double level = level_at(v, shape[0], shape[1]);
    for (std::size_t i = 0; i < slips.size(); ++i) {
      const double limit = direction * slips[i] * level;
      if (slipping[i] && dx != 0.0) {
        z[i] = limit + (z[i] - limit) * stay;
      } else if (!slipping[i]) {
        z[i] += dx;
        if (direction * z[i] >= slips[i] * level) {
          z[i] = limit;
          slipping[i] = true;
        }
      }
      columns(row, static_cast<Eigen::Index>(i)) = z[i] / slips[i];
    }
    columns(row, static_cast<Eigen::Index>(slips.size())) = v;
  });
  return columns;
}

Eigen::MatrixXd maxwell_columns(const std::vector<double>& slips, const SampledMotion& motion) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(motion.position_m.size()),
                          static_cast<Eigen::Index>(slips.size()) + 1);
  std::vector<double> z(slips.size(), 0.0);
  along(motion, [&](double dx, double v, Eigen::Index row) {
    for (std::size_t i = 0; i < slips.size(); ++i) {
      z[i] = std::clamp(z[i] + dx, -slips[i], slips[i]);
      columns(row, static_cast<Eigen::Index>(i)) = z[i] / slips[i];
    }
    columns(row, static_cast<Eigen::Index>(slips.size())) = v;
  });
  return columns;
}

}  // namespace

std::string_view name(FrictionKind kind) {
  switch (kind) {
    case FrictionKind::kCoulombStribeck:
      return "coulomb-viscous-stribeck";
    case FrictionKind::kDahl:
      return "dahl";
    case FrictionKind::kBoucWen:
      return "bouc-wen";
    case FrictionKind::kLuGre:
      return "lugre";
    case FrictionKind::kGms:
      return "gms";
    case FrictionKind::kMaxwellSlip:
      return "maxwell-slip";
    case FrictionKind::kVelocityTable:
      return "velocity-table";
    case FrictionKind::kElastoPlastic:
      return "elasto-plastic";
  }
  return "unknown";
}

std::vector<ShapeParameter> shapes_of(FrictionKind kind, const SampledMotion& motion) {
  const double extent_m = extent_of(motion);
  const double fastest = fastest_of(motion);
  const bool given = motion.longest_m > 0.0;
  const ShapeParameter length{"length_m", given ? motion.shortest_m : 1e-4 * extent_m,
                              given ? motion.longest_m : 10.0 * extent_m};
  const ShapeParameter stribeck{"stribeck_mps", 1e-3 * fastest, 2.0 * fastest};
  const ShapeParameter excess{"excess", 1e-3, 2.0};
  switch (kind) {
    case FrictionKind::kCoulombStribeck:
      return {stribeck};
    case FrictionKind::kDahl:
      return {length};
    case FrictionKind::kBoucWen:
      return {length, {"exponent", 0.3, 5.0}, {"beta", 0.5, 1.0}};
    case FrictionKind::kLuGre:
      return {length, excess, stribeck};
    case FrictionKind::kGms:
      return {excess, stribeck, {"attraction_per_s", 1e-2 / motion.step_s, 10.0 / motion.step_s}};
    case FrictionKind::kMaxwellSlip:
      return {};
    case FrictionKind::kVelocityTable:
      // The last point of the table: not searched further than the motion goes.
      return {{"fastest_mps", 0.5 * fastest, fastest}};
    case FrictionKind::kElastoPlastic:
      return {length, excess, stribeck, {"elastic_share", 0.05, 0.95}};
  }
  return {};
}

std::vector<double> slip_distances(FrictionKind kind, const SampledMotion& motion) {
  if (kind == FrictionKind::kGms) return slips_of(motion, kGmsElements);
  if (kind == FrictionKind::kMaxwellSlip) return slips_of(motion, kMaxwellElements);
  return {};
}

Eigen::MatrixXd model_columns(FrictionKind kind, const std::vector<double>& shape,
                              const std::vector<double>& slips_m, const SampledMotion& motion) {
  switch (kind) {
    case FrictionKind::kCoulombStribeck:
      return stribeck_columns(shape[0], motion);
    case FrictionKind::kDahl:
      return dahl_columns(shape[0], motion);
    case FrictionKind::kBoucWen:
      return bouc_wen_columns(shape, motion);
    case FrictionKind::kLuGre:
      return lugre_columns(shape, motion);
    case FrictionKind::kGms:
      return gms_columns(shape, slips_m, motion);
    case FrictionKind::kMaxwellSlip:
      return maxwell_columns(slips_m, motion);
    case FrictionKind::kVelocityTable:
      return table_columns(shape[0], motion);
    case FrictionKind::kElastoPlastic:
      return elasto_plastic_columns(shape, motion);
  }
  return {};
}

}  // namespace slipstack::workbench
