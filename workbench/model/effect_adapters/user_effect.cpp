// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/effect_adapters/user_effect.h"

#include <fmt/format.h>

#include <cmath>
#include <deque>
#include <mutex>

#include "workbench/base/errors.h"
#include "workbench/model/expression/definition.h"
#include "workbench/model/expression/expression.h"
#include "workbench/model/expression/linearity.h"

namespace slipstack::workbench {
namespace {

/// The expression as a basis: one column per gain, evaluated with that gain at one and the others at zero.
class ExpressionBasis final : public EffectBasis {
 public:
  ExpressionBasis(const Definition& definition, const ParameterRoles& roles)
      : definition_(definition), roles_(roles), expression_(definition) {}

  void prepare(std::span<const double> shapes, const Scales<double>&) override {
    for (std::size_t i = 0; i < roles_.shapes.size(); ++i) expression_.set(roles_.shapes[i], shapes[i]);
    for (const std::size_t gain : roles_.gains) expression_.set(gain, 0.0);
  }
  void reset(const Sample<double>&) override {}
  void run(std::span<const Sample<double>> samples, double* out) override {
    const std::size_t gains = roles_.gains.size();
    for (std::size_t g = 0; g < gains; ++g) {
      expression_.set(roles_.gains[g], 1.0);
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const Sample<double>& sample = samples[i];
        const double value =
            expression_.at({sample.time_s, sample.position_m, sample.velocity_mps, sample.acceleration_mps2});
        if (!std::isfinite(value)) fail(sample);
        out[i * gains + g] = value;
      }
      expression_.set(roles_.gains[g], 0.0);
    }
  }

 private:
  [[noreturn]] void fail(const Sample<double>& sample) const {
    throw InputError(fmt::format(
        "effect '{}' is not a finite number at t = {:.4g} s, x = {:.4g} m, v = {:.4g} m/s, a = {:.4g} m/s2; "
        "keep its expression or the bounds of its parameters away from there",
        definition_.name, sample.time_s, sample.position_m, sample.velocity_mps, sample.acceleration_mps2));
  }

  const Definition& definition_;
  const ParameterRoles& roles_;
  Expression expression_;
};

/// A user-defined effect, with the strings to which its description points.
class UserEffect {
 public:
  UserEffect(Definition definition, ParameterRoles roles)
      : definition_(std::move(definition)), roles_(std::move(roles)) {
    title_ = definition_.name + " (user-defined effect)";
    formula_ = "F = " + definition_.expression;
    evidence_ = "the residual follows " + definition_.expression + " with ";
    for (std::size_t i = 0; i < definition_.parameters.size(); ++i) {
      const std::string& name = definition_.parameters[i].name;
      evidence_ += fmt::format("{}{} = {{{}}}", i == 0 ? "" : ", ", name, name);
    }
    residual_ = "follows " + definition_.expression;
    description_.text = {
        .id = definition_.name.c_str(),
        .title = title_.c_str(),
        .formula = formula_.c_str(),
        .source = "given by the user",
        .residual = residual_.c_str(),
        .evidence = evidence_.c_str(),
        .cause = "what the author of the expression had in mind",
        .confirm = "record again where the expression says that the force is large, and beside it"};
    for (const std::size_t p : roles_.gains) description_.gain_groups.push_back(gain_of(p));
    for (const std::size_t p : roles_.shapes) description_.shapes.push_back(shape_of(p));
    description_.gain_count = static_cast<int>(roles_.gains.size());
    description_.definition = definition_.text;
    description_.make = [this] { return std::make_unique<ExpressionBasis>(definition_, roles_); };
  }
  UserEffect(const UserEffect&) = delete;
  UserEffect& operator=(const UserEffect&) = delete;
  UserEffect(UserEffect&&) = delete;
  UserEffect& operator=(UserEffect&&) = delete;
  ~UserEffect() = default;

  const EffectDescription& description() const { return description_; }

 private:
  GainGroup gain_of(std::size_t p) const {
    const DeclaredParameter& parameter = definition_.parameters[p];
    const auto bounds = bounds_of(parameter);
    return {parameter.name.c_str(),
            parameter.unit.c_str(),
            static_cast<float>(bounds.lower),
            static_cast<float>(bounds.upper),
            1,
            Acts::force};
  }
  ShapeSpec shape_of(std::size_t p) const {
    const DeclaredParameter& parameter = definition_.parameters[p];
    const auto bounds = bounds_of(parameter);
    return {parameter.name.c_str(), parameter.unit.c_str(), static_cast<float>(bounds.lower),
            static_cast<float>(bounds.upper), ShapeKind::user_defined};
  }
  static DeclaredParameter::Bounds bounds_of(const DeclaredParameter& parameter) {
    constexpr auto kFar = static_cast<double>(kUnbounded);
    return parameter.bounds.value_or(DeclaredParameter::Bounds{-kFar, kFar});
  }

  Definition definition_;
  ParameterRoles roles_;
  std::string title_, formula_, evidence_, residual_;
  EffectDescription description_;
};

/// All effects that were declared. A deque, because pointers to their descriptions must remain valid.
struct Declared {
  std::mutex lock;
  std::deque<UserEffect> effects;
};

Declared& declared() {
  static Declared all;
  return all;
}

}  // namespace

const EffectDescription& declare_effect(const std::string& text) {
  Definition definition = parse_definition(text);
  for (const EffectDescription& known : catalogue()) {
    if (definition.name == known.text.id) {
      throw DefinitionError(
          fmt::format("'{}' is an effect of the catalogue; call yours otherwise", definition.name), text,
          text.find(definition.name));
    }
  }
  const EffectDescription* other = find_user_effect(definition.name);
  if (other != nullptr && other->definition == text) return *other;
  ParameterRoles roles = roles_of(definition);
  if (other != nullptr) {
    throw DefinitionError(
        fmt::format("'{}' is defined already, by another text; call one of them otherwise", definition.name),
        text, text.find(definition.name));
  }
  Declared& all = declared();
  const std::lock_guard guard(all.lock);
  return all.effects.emplace_back(std::move(definition), std::move(roles)).description();
}

const EffectDescription* find_user_effect(std::string_view id) {
  Declared& all = declared();
  const std::lock_guard guard(all.lock);
  for (const UserEffect& effect : all.effects) {
    if (id == effect.description().text.id) return &effect.description();
  }
  return nullptr;
}

bool is_definition(std::string_view text) {
  return text.find_first_of("=:;()") != std::string_view::npos;
}

}  // namespace slipstack::workbench
