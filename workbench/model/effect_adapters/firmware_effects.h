// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/effects/effect.h"

namespace slipstack::workbench {

class EffectBasis;
class EffectForce;

/// What the workbench knows of one effect, independent of its type: an effect of the firmware's catalogue, or
/// a user-defined one (user_effect.h).
struct EffectDescription {
  EffectText text;
  std::vector<GainGroup> gain_groups;
  std::vector<ShapeSpec> shapes;
  int gain_count = 0;
  EffectTraits traits;                                 ///< of an effect of the user's own: the defaults
  std::function<std::unique_ptr<EffectBasis>()> make;  ///< a fresh instance
  /// A fresh instance with these parameters, empty for effects outside the catalogue; see make_force().
  std::function<std::unique_ptr<EffectForce>(std::span<const double> shapes, std::span<const double> gains,
                                             const Scales<double>& scales)>
      make_weighted;
  std::string definition;  ///< of a user-defined effect; empty for the catalogue

  std::string id() const { return text.id; }
  /// The force at given shapes and one set of gains; a gain of zero adds nothing.
  std::unique_ptr<EffectForce> make_force(std::span<const double> at_shapes, std::span<const double> gains,
                                          const Scales<double>& scales) const;
  bool is_user_defined() const { return !definition.empty(); }
  /// The group of gain `index`.
  const GainGroup& group_of_gain(int index) const;
  bool acts_as(Acts acts) const;
  bool has_role(Role role) const { return traits.role == role; }
  /// Index of the first shape of this kind.
  std::optional<std::size_t> find_shape(ShapeKind kind) const;
  bool has_shape(ShapeKind kind) const { return find_shape(kind).has_value(); }
  /// Whether an experiment can be planned that shows it.
  bool is_plannable() const { return traits.plannable && gain_count > 0; }
  /// Number of parameters that a fit of this effect determines.
  int parameter_count() const { return gain_count + static_cast<int>(shapes.size()); }
};

/// One effect in double precision, behind virtual functions; host only. For an effect of the catalogue, run()
/// calls the basis() of the firmware.
class EffectBasis {
 public:
  virtual ~EffectBasis() = default;
  virtual void prepare(std::span<const double> shapes, const Scales<double>& scales) = 0;
  virtual void reset(const Sample<double>& sample) = 0;
  /// Basis at each of the samples, in order; `out` holds gain_count values per sample.
  virtual void run(std::span<const Sample<double>> samples, double* out) = 0;
};

/// The sum of gain x basis of one effect, which costs less than the basis.
class EffectForce {
 public:
  virtual ~EffectForce() = default;
  virtual void reset(const Sample<double>& sample) = 0;
  /// Writes the sum at each of the samples, in order.
  virtual void run(std::span<const Sample<double>> samples, double* out) = 0;
};

/// Every effect that a fit may choose, in the order of the catalogue.
const std::vector<EffectDescription>& catalogue();

/// The firmware's user_table, by which the controller represents a user-defined effect
/// (estimate/terms/user_table.h). No fit chooses it: it is neither in catalogue() nor found by find_effect().
const EffectDescription& controller_table();

/// The effect of the catalogue with this role. Throws std::logic_error where none has it.
const EffectDescription& effect_with_role(Role role);

/// The effect of the catalogue with this id, or nullptr.
const EffectDescription* find_in_catalogue(std::string_view id);

}  // namespace slipstack::workbench
