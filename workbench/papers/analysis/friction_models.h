// SPDX-License-Identifier: Apache-2.0
// Friction models of the literature on the same motion: which of them return to the main loop after a small
// one ([3], section 4).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

enum class FrictionKind {
  kCoulombStribeck,
  kDahl,
  kBoucWen,
  kLuGre,
  kGms,
  kMaxwellSlip,
  kVelocityTable,
  kElastoPlastic
};

/// Those that the paper compares.
inline constexpr FrictionKind kFrictionKinds[] = {
    FrictionKind::kCoulombStribeck, FrictionKind::kDahl, FrictionKind::kBoucWen,
    FrictionKind::kLuGre,           FrictionKind::kGms,  FrictionKind::kMaxwellSlip};

std::string_view name(FrictionKind kind);

/// A motion sampled uniformly.
struct SampledMotion {
  double step_s = 1e-3;
  std::vector<double> position_m;
  std::vector<double> velocity_mps;
  // Between which the lengths of pre-sliding are searched and the slip distances lie; 0: from the extent and
  // the steps of this motion. Where the motion is more than pre-sliding, its extent says nothing about them.
  double shortest_m = 0.0;
  double longest_m = 0.0;
};

/// A parameter on which the force depends nonlinearly; its logarithm is searched between its bounds.
struct ShapeParameter {
  std::string_view name;
  double lower = 0.0;
  double upper = 1.0;
};

/// Shape parameters of a model for motions of this extent:
///   coulomb-stribeck  v_s                       Fc·sgn v + (Fs − Fc)·sgn v·exp(−(v/v_s)²)
///   dahl              ℓ                         dz/dx = (1 − z·sgn v)/ℓ
///   bouc-wen          ℓ, n, β                   dz/dx = (1 − |z|ⁿ·(β·sgn(v·z) + 1 − β))/ℓ, and a spring
///   lugre             ℓ, Fs/Fc − 1, v_s         dz/dt = (v − |v|·z/s(v))/ℓ, s(v) = 1 + r·exp(−(v/v_s)²)
///   gms               Fs/Fc − 1, v_s, C         12 elements: stick until |z| = d·s(v), then dz/dt =
///   C·(d·s(v) − z) maxwell-slip      none                      20 elements
///   velocity-table    v_last                    20 forces over velocity, closer together near rest, and
///   straight lines between them elasto-plastic    ℓ, Fs/Fc − 1, v_s, b     dz/dt = (v − α(z)·|v|·z/s(v))/ℓ:
///   elastic until |z| reaches the share b of s(v), then α rises to 1 (Dupont et al., IEEE TAC 47(5) 2002)
/// States are scaled so that the gains are forces; every model has viscous friction too.
std::vector<ShapeParameter> shapes_of(FrictionKind kind, const SampledMotion& motion);

/// The columns that the gains multiply (of the models with elements, one for each of `slips_m`): states of
/// the model on this motion, started relaxed. Steps are integrated exactly where velocity is constant within
/// a sample (Dahl, LuGre, GMS, Maxwell-slip), Bouc-Wen by Runge-Kutta steps of at most a tenth of ℓ. One pass
/// over the motion, about 10 to 200 ns for each sample.
Eigen::MatrixXd model_columns(FrictionKind kind, const std::vector<double>& shape,
                              const std::vector<double>& slips_m, const SampledMotion& motion);

/// Slip distances of the models with elements (empty for others): geometric from the resolution of the sensor
/// to half the extent of the motion that is fitted.
std::vector<double> slip_distances(FrictionKind kind, const SampledMotion& motion);

/// The data of a fit: `observe` takes a signal with a value per sample to the rows that are compared (a
/// filter; empty: as it is). `others`: columns that belong to every model, inertia for one, with a value per
/// sample.
struct FrictionData {
  SampledMotion motion;
  Eigen::VectorXd force_N;  // at the rows
  std::vector<std::vector<double>> others;
  std::function<Eigen::VectorXd(std::span<const double>)> observe;
  Eigen::Index fitted_rows = 0;  // the first of them are fitted, the rest are held out; 0: all are fitted
};

struct FrictionFit {
  FrictionKind kind = FrictionKind::kDahl;
  std::vector<double> shape;
  std::vector<double> slips_m;  // of the models with elements
  Eigen::VectorXd gains;        // of model_columns, then of `others`, then the offset
  double relative_error = 0.0;  // |force − model| / |force| on the fitted rows
  double held_out_error = 0.0;  // on the rest; 0 without
};

/// Gains by non-negative least squares (the offset is free), shapes by a search in the box: DIRECT, then
/// Sbplx from its best. Deterministic. Cost: `evaluations` passes of model_columns. Throws
/// std::invalid_argument when sizes do not match.
FrictionFit fit_friction(FrictionKind kind, const FrictionData& data, int evaluations = 120);

/// Half a loop of amplitude A, then full loops, `inner` with a small loop on each branch: from 0.3·A back to
/// −0.2·A on the way up and mirrored on the way down. Constant speed. `marks`: samples at which the motion
/// has returned to the beginning of a small loop.
struct LoopMotion {
  SampledMotion motion;
  std::vector<std::size_t> marks;
};
LoopMotion loop_motion(double amplitude_m, double speed_mps, bool inner);

/// How far a fitted model is from its main loop when a small loop has closed: largest difference to the same
/// motion without small loops, over half the height of the main loop. A model that wipes out closed loops has
/// zero.
double return_error(const FrictionFit& fit, double amplitude_m, double speed_mps);

}  // namespace slipstack::workbench
