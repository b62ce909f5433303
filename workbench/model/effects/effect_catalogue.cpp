// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/effects/effect_catalogue.h"

#include <stdexcept>
#include <tuple>
#include <type_traits>

#include "firmware/effects/catalogue.h"

namespace slipstack::workbench {
namespace {

/// Writes basis[sample][gain]. The state is copied to a local, because the compiler would have to reload at
/// each sample whatever `out` may alias.
template <class E>
void run_basis(E& state, std::span<const Sample<double>> samples, double* out) {
  E effect = state;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    effect.basis(samples[i], std::span<double, E::gain_count>(out + i * E::gain_count, E::gain_count));
  }
  state = effect;
}

// The same for processors with vectors of 4 and of 8 doubles. Products and sums are neither contracted nor
// reordered (CMakeLists.txt), so the results are those of run_basis, bit for bit, on every machine.
#if defined(__x86_64__)
template <class E>
[[gnu::target("avx2"), gnu::flatten]] void run_basis_by_4(E& state, std::span<const Sample<double>> samples,
                                                          double* out) {
  run_basis(state, samples, out);
}
template <class E>
[[gnu::target("avx2,avx512f,avx512dq,avx512vl"), gnu::flatten]] void run_basis_by_8(
    E& state, std::span<const Sample<double>> samples, double* out) {
  run_basis(state, samples, out);
}
int widest_vector() {
  if (__builtin_cpu_supports("avx2") == 0) return 2;
  const bool eight = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                     __builtin_cpu_supports("avx512vl") != 0;
  return eight ? 8 : 4;
}
#endif

/// run_basis with the widest vectors of this machine.
template <class E>
void run_basis_wide(E& state, std::span<const Sample<double>> samples, double* out) {
#if defined(__x86_64__)
  static const int kWidest = widest_vector();
  if (kWidest == 8) return run_basis_by_8(state, samples, out);
  if (kWidest == 4) return run_basis_by_4(state, samples, out);
#endif
  run_basis(state, samples, out);
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
    run_basis_wide(effect_, samples, out);
  }

 private:
  E effect_{};
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

bool EffectDescription::acts_as(Acts acts) const {
  for (const GainGroup& group : gain_groups) {
    if (group.acts == acts) return true;
  }
  return false;
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
