// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/effects/effect.h"

namespace slipstack::workbench {

/// What the workbench knows of one effect of the firmware's catalogue, without its type.
struct EffectDescription {
  EffectText text;
  std::vector<GainGroup> gain_groups;
  std::vector<ShapeSpec> shapes;
  int gain_count = 0;

  std::string id() const { return text.id; }
  /// How gain `index` acts, and the group it belongs to.
  const GainGroup& group_of_gain(int index) const;
  bool acts_as(Acts acts) const;
  /// Parameters that a fit of this effect spends.
  int parameter_count() const { return gain_count + static_cast<int>(shapes.size()); }
};

/// One effect of the firmware in double precision, called through a virtual function: host only. The basis
/// that it returns is the firmware's own.
class EffectBasis {
 public:
  virtual ~EffectBasis() = default;
  virtual void prepare(std::span<const double> shapes, const Scales<double>& scales) = 0;
  virtual void reset(const Sample<double>& sample) = 0;
  /// Basis at each of the samples, in order; `out` holds gain_count values per sample.
  virtual void run(std::span<const Sample<double>> samples, double* out) = 0;
};

/// Every effect, in the catalogue's order.
const std::vector<EffectDescription>& catalogue();

/// The description of `id`, or nullptr.
const EffectDescription* find_effect(std::string_view id);

/// A fresh instance of the effect `id`; `id` must be of the catalogue.
std::unique_ptr<EffectBasis> make_basis(std::string_view id);

/// All ids, separated by commas: for messages.
std::string known_effects();

}  // namespace slipstack::workbench
