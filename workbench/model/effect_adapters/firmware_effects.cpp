// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/effect_adapters/firmware_effects.h"

#include <algorithm>
#include <array>
#include <concepts>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include "firmware/effects/catalogue.h"
#include "workbench/base/wide_vectors.h"

namespace slipstack::workbench {
namespace {

/// An effect with memory whose basis follows what the velocity alone determines.
template <class E>
concept FollowsVelocity = requires(E effect, std::array<double, E::gain_count> steady,
                                   std::span<double, E::gain_count> out) {
  { std::as_const(effect).steady(0.0) } -> std::same_as<std::array<double, E::gain_count>>;
  effect.basis_towards(steady, 0.0, out);
};

/// Calls visit(sample, steady, velocity) for each sample, in order. What depends on the velocity alone is
/// computed in vectors for many samples at once: powers and exponentials cost ten times what the memory does.
template <FollowsVelocity E, class Visit>
[[gnu::always_inline]] inline void each_basis(E& effect, std::span<const Sample<double>> samples,
                                              Visit&& visit) {
  constexpr std::size_t kAtOnce = 128;
  constexpr auto kGains = static_cast<std::size_t>(E::gain_count);
  double velocity_mps[kAtOnce];
  double steady[kGains][kAtOnce];
  for (std::size_t first = 0; first < samples.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, samples.size() - first);
    for (std::size_t i = 0; i < count; ++i) velocity_mps[i] = samples[first + i].velocity_mps;
    for (std::size_t i = 0; i < count; ++i) {
      const auto now = effect.steady(velocity_mps[i]);
      for (std::size_t g = 0; g < kGains; ++g) steady[g][i] = now[g];
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::array<double, kGains> now;
      for (std::size_t g = 0; g < kGains; ++g) now[g] = steady[g][i];
      visit(first + i, now, velocity_mps[i]);
    }
  }
}

/// Writes basis[sample][gain]. The state is copied to a local, because the compiler would have to reload at
/// each sample whatever `out` may alias.
template <class E>
void run_basis(E& state, std::span<const Sample<double>> samples, double* out) {
  E effect = state;
  const auto at = [out](std::size_t i) {
    return std::span<double, E::gain_count>(out + i * E::gain_count, E::gain_count);
  };
  if constexpr (FollowsVelocity<E>) {
    each_basis(effect, samples, [&](std::size_t i, const auto& steady, double velocity_mps) {
      effect.basis_towards(steady, velocity_mps, at(i));
    });
  } else {
    for (std::size_t i = 0; i < samples.size(); ++i) effect.basis(samples[i], at(i));
  }
  state = effect;
}

/// Gains padded to whole vectors of four. The sum of gain x basis has four partial sums, so that its order
/// does not depend on the machine.
template <int Count>
constexpr std::size_t kPadded = (static_cast<std::size_t>(Count) + 3) / 4 * 4;

template <std::size_t Count>
[[gnu::always_inline]] inline double weighted_sum(const std::array<double, Count>& gains,
                                                  const double* basis) {
  FourDoubles sum = {};
  for (std::size_t g = 0; g < Count; g += 4) {
    FourDoubles gain, value;
    load(gain, gains.data() + g);
    load(value, basis + g);
    sum += gain * value;
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// Writes the sum of gain x basis at each sample. The bases of some samples are written to memory before they
/// are summed: where the compiler keeps a basis in registers, it takes the vectors apart again.
template <class E>
void run_weighted(E& state, const std::array<double, kPadded<E::gain_count>>& gains,
                  std::span<const Sample<double>> samples, double* out) {
  constexpr std::size_t kAtOnce = 16;
  constexpr auto kGains = static_cast<std::size_t>(E::gain_count);
  constexpr std::size_t kWidth = kPadded<E::gain_count>;
  E effect = state;
  std::array<double, kAtOnce * kWidth> basis{};
  const auto at = [&basis](std::size_t i) {
    return std::span<double, kGains>(basis.data() + i * kWidth, kGains);
  };
  if constexpr (FollowsVelocity<E>) {
    each_basis(effect, samples, [&](std::size_t i, const auto& steady, double velocity_mps) {
      effect.basis_towards(steady, velocity_mps, at(0));
      out[i] = weighted_sum(gains, basis.data());
    });
  } else {
    for (std::size_t first = 0; first < samples.size(); first += kAtOnce) {
      const std::size_t count = std::min(kAtOnce, samples.size() - first);
      for (std::size_t i = 0; i < count; ++i) effect.basis(samples[first + i], at(i));
      for (std::size_t i = 0; i < count; ++i) out[first + i] = weighted_sum(gains, basis.data() + i * kWidth);
    }
  }
  state = effect;
}

template <class E>
class BasisOf final : public EffectBasis {
 public:
  void prepare(std::span<const double> shapes, const Scales<double>& scales) override {
    if (shapes.size() != E::shape_count) throw std::invalid_argument("wrong number of shapes");
    effect_.prepare(shapes.first<E::shape_count>(), scales);
  }
  void reset(const Sample<double>& sample) override { effect_.reset(sample); }
  void run(std::span<const Sample<double>> samples, double* out) override {
    run_wide([&] { run_basis(effect_, samples, out); });
  }

 private:
  E effect_{};
};

template <class E>
class ForceOf final : public EffectForce {
 public:
  ForceOf(std::span<const double> shapes, std::span<const double> gains, const Scales<double>& scales) {
    if (shapes.size() != E::shape_count || gains.size() != E::gain_count)
      throw std::invalid_argument("wrong number of parameters");
    effect_.prepare(shapes.first<E::shape_count>(), scales);
    for (std::size_t i = 0; i < gains.size(); ++i) gains_[i] = gains[i];
  }
  void reset(const Sample<double>& sample) override { effect_.reset(sample); }
  void run(std::span<const Sample<double>> samples, double* out) override {
    run_wide([&] { run_weighted(effect_, gains_, samples, out); });
  }

 private:
  E effect_{};
  std::array<double, kPadded<E::gain_count>> gains_{};
};

template <class E>
std::unique_ptr<EffectForce> make_force(std::type_identity<E>, std::span<const double> shapes,
                                        std::span<const double> gains, const Scales<double>& scales) {
  return std::make_unique<ForceOf<E>>(shapes, gains, scales);
}

/// An element of a hysteresis without stiffness adds nothing. A fit leaves a handful of the 32 with
/// stiffness, and only these are run.
std::unique_ptr<EffectForce> make_force(std::type_identity<PreslidingHysteresis<double>>,
                                        std::span<const double> shapes, std::span<const double> gains,
                                        const Scales<double>& scales) {
  std::vector<double> slip_m;
  std::vector<double> stiffness;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    if (gains[i] == 0.0) continue;
    slip_m.push_back(shapes[i]);
    stiffness.push_back(gains[i]);
  }
  const auto of_size = [&]<int N>(std::integral_constant<int, N>) -> std::unique_ptr<EffectForce> {
    slip_m.resize(N, 0.0);
    stiffness.resize(N, 0.0);
    return std::make_unique<ForceOf<PreslidingHysteresis<double, N>>>(slip_m, stiffness, scales);
  };
  // Not fewer: GCC 12 unrolls loops over 16 elements before it makes vectors of them, which takes three times
  // as long as 24 elements do (measured: 14 ns a sample, 5 ns).
  if (slip_m.size() <= 24) return of_size(std::integral_constant<int, 24>{});
  return of_size(std::integral_constant<int, kIdentifiedElements>{});
}

/// The force by the basis, of effects that are not of the catalogue.
class ForceByBasis final : public EffectForce {
 public:
  ForceByBasis(std::unique_ptr<EffectBasis> basis, std::span<const double> gains)
      : basis_(std::move(basis)), gains_(gains.begin(), gains.end()) {}
  void reset(const Sample<double>& sample) override { basis_->reset(sample); }
  void run(std::span<const Sample<double>> samples, double* out) override {
    values_.resize(samples.size() * gains_.size());
    basis_->run(samples, values_.data());
    const double* value = values_.data();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      out[i] = 0.0;
      for (const double gain : gains_) out[i] += gain * *value++;
    }
  }

 private:
  std::unique_ptr<EffectBasis> basis_;
  std::vector<double> gains_;
  std::vector<double> values_;
};

template <class E>
EffectDescription description_of() {
  static_assert(Effect<E, double>);
  static_assert(complete(E::text));
  EffectDescription description;
  description.text = E::text;
  // One by one: for an empty array, GCC 12 warns of copying from a null pointer (-Wnonnull).
  for (const GainGroup& group : E::gains) description.gain_groups.push_back(group);
  for (const ShapeSpec& shape : E::shapes) description.shapes.push_back(shape);
  description.gain_count = E::gain_count;
  description.traits = traits_of<E>();
  description.make = [] { return std::make_unique<BasisOf<E>>(); };
  description.make_weighted = [](std::span<const double> shapes, std::span<const double> gains,
                                 const Scales<double>& scales) {
    return make_force(std::type_identity<E>{}, shapes, gains, scales);
  };
  return description;
}

template <class... Effects>
std::vector<EffectDescription> descriptions_of(std::type_identity<std::tuple<Effects...>>) {
  std::vector<EffectDescription> list;
  list.reserve(sizeof...(Effects));
  const auto take = [&list]<class E>(std::type_identity<E>) {
    if constexpr (!std::is_same_v<E, UserTable<double>>) list.push_back(description_of<E>());
  };
  (take(std::type_identity<Effects>{}), ...);
  return list;
}

}  // namespace

const GainGroup& EffectDescription::group_of_gain(int index) const {
  for (const GainGroup& group : gain_groups) {
    if (index < group.count) return group;
    index -= group.count;
  }
  throw std::out_of_range("gain index");
}

std::optional<std::size_t> EffectDescription::find_shape(ShapeKind kind) const {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (shapes[i].kind == kind) return i;
  }
  return std::nullopt;
}

bool EffectDescription::acts_as(Acts acts) const {
  for (const GainGroup& group : gain_groups) {
    if (group.acts == acts) return true;
  }
  return false;
}

std::unique_ptr<EffectForce> EffectDescription::make_force(std::span<const double> at_shapes,
                                                           std::span<const double> gains,
                                                           const Scales<double>& scales) const {
  if (make_weighted) return make_weighted(at_shapes, gains, scales);
  std::unique_ptr<EffectBasis> basis = make();
  basis->prepare(at_shapes, scales);
  return std::make_unique<ForceByBasis>(std::move(basis), gains);
}

const std::vector<EffectDescription>& catalogue() {
  static const std::vector<EffectDescription> all = descriptions_of(std::type_identity<Catalogue<double>>{});
  return all;
}

const EffectDescription& controller_table() {
  static const EffectDescription table = description_of<UserTable<double>>();
  return table;
}

const EffectDescription& effect_with_role(Role role) {
  for (const EffectDescription& description : catalogue()) {
    if (description.has_role(role)) return description;
  }
  throw std::logic_error("no effect of the catalogue has the role that a rule needs");
}

const EffectDescription* find_in_catalogue(std::string_view id) {
  for (const EffectDescription& description : catalogue()) {
    if (id == description.text.id) return &description;
  }
  return nullptr;
}

}  // namespace slipstack::workbench
