// SPDX-License-Identifier: Apache-2.0
// What every entry of the catalogue must have, so that a new one cannot forget it.
#include "firmware/effects/catalogue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

std::vector<std::string> ids() {
  std::vector<std::string> list;
  test::for_each_effect<double>([&]<class E>(std::type_identity<E>) { list.emplace_back(E::text.id); });
  return list;
}

/// The effects in the order of docs/effect-objects.csv, which toolchain/regenerate writes.
std::vector<std::string> documented_ids() {
  std::vector<std::string> list;
  std::ifstream file(SLIPSTACK_EFFECT_OBJECTS);
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("21")) list.push_back(line.substr(line.find(',') + 1));
  }
  return list;
}

// The place in the list goes into the hash of a model and into the controller's parameter store: a new effect
// is added at the end, none is moved.
TEST(Catalogue, KeepsItsOrder) {
  EXPECT_EQ(ids(), documented_ids()) << "an effect was added (run toolchain/regenerate) or moved";
}

TEST(Catalogue, IdsAreUniqueWords) {
  std::set<std::string> seen;
  for (const std::string& id : ids()) {
    EXPECT_TRUE(seen.insert(id).second) << id;
    EXPECT_EQ(id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"), std::string::npos) << id;
  }
}

TEST(Catalogue, IsTheSameInBothPrecisions) {
  std::vector<std::string> floats;
  test::for_each_effect<float>([&]<class E>(std::type_identity<E>) { floats.emplace_back(E::text.id); });
  EXPECT_EQ(floats, ids());
}

TEST(Catalogue, SatisfiesTheContract) {
  test::for_each_effect<double>([]<class E>(std::type_identity<E>) {
    static_assert(Effect<E, double>);
    static_assert(complete(E::text));
    static_assert(total_count(E::gains) == E::gain_count);
    static_assert(E::shapes.size() == E::shape_count);
    static_assert(E::gain_count + E::shape_count > 0);
  });
  test::for_each_effect<float>([]<class E>(std::type_identity<E>) { static_assert(Effect<E, float>); });
}

// The model sums dry friction before whatever modulates it: no effect can be both.
TEST(Catalogue, NoEffectModulatesItself) {
  test::for_each_effect<double>([]<class E>(std::type_identity<E>) {
    bool dry = false;
    bool scale = false;
    for (const GainGroup& group : E::gains) {
      dry |= group.acts == Acts::dry;
      scale |= group.acts == Acts::dry_scale || group.acts == Acts::total_scale;
    }
    EXPECT_FALSE(dry && scale) << E::text.id;
  });
}

TEST(Catalogue, TextsSaySomething) {
  test::for_each_effect<double>([]<class E>(std::type_identity<E>) {
    const EffectText& text = E::text;
    for (const std::string_view one :
         {text.title, text.formula, text.source, text.residual, text.evidence, text.cause, text.confirm}) {
      EXPECT_GE(one.size(), 3u) << text.id;
      EXPECT_EQ(one.find_first_of("\n\t"), std::string_view::npos) << text.id;
      EXPECT_NE(one.front(), ' ') << text.id;
      EXPECT_NE(one.back(), ' ') << text.id;
      EXPECT_EQ(one.find("  "), std::string_view::npos) << text.id << ": " << one;
    }
    EXPECT_NE(std::string_view(text.formula).find_first_of("=x"), std::string_view::npos) << text.id;
    EXPECT_GE(std::string_view(text.evidence).size(), 30u) << text.id;
    EXPECT_GE(std::string_view(text.confirm).size(), 20u) << text.id;
  });
}

TEST(Catalogue, ParametersAreBoundedAndNamed) {
  test::for_each_effect<double>([]<class E>(std::type_identity<E>) {
    std::set<std::string> names;
    for (const GainGroup& group : E::gains) {
      EXPECT_TRUE(names.insert(group.name).second) << E::text.id << ' ' << group.name;
      EXPECT_FALSE(std::string_view(group.unit).empty()) << group.name;
      EXPECT_TRUE(std::isfinite(group.lower) && std::isfinite(group.upper)) << group.name;
      EXPECT_LT(group.lower, group.upper) << group.name;
      EXPECT_LE(group.lower, 0.0F) << group.name << ": an effect must be able to vanish";
      EXPECT_GE(group.upper, 0.0F) << group.name;
      EXPECT_LE(group.upper, kUnbounded) << group.name;
      EXPECT_GE(group.count, 1) << group.name;
      if (group.acts == Acts::dry) {
        EXPECT_GE(group.lower, 0.0F) << group.name << ": dry friction never pushes";
      }
      if (group.acts == Acts::dry_scale) {
        EXPECT_GT(group.lower, -1.0F) << group.name << ": nor does it turn round when it is modulated";
      }
    }
    std::string previous;
    for (const ShapeSpec& spec : E::shapes) {
      // Runs of one name are one parameter with many values (slip distances).
      if (spec.name != previous) {
        EXPECT_TRUE(names.insert(spec.name).second) << E::text.id << ' ' << spec.name;
      }
      previous = spec.name;
      EXPECT_FALSE(std::string_view(spec.unit).empty()) << spec.name;
      EXPECT_TRUE(std::isfinite(spec.lower) && std::isfinite(spec.upper)) << spec.name;
      EXPECT_LT(spec.lower, spec.upper) << spec.name;
      const bool may_be_zero = spec.kind == ShapeKind::delay || spec.kind == ShapeKind::filter ||
                               spec.kind == ShapeKind::position || spec.kind == ShapeKind::slip_distance ||
                               spec.kind == ShapeKind::table;
      if (!may_be_zero) {
        EXPECT_GT(spec.lower, 0.0F) << spec.name << ": it divides or is searched in its logarithm";
      }
    }
  });
}

// What a trait points to exists: gains and shapes of the effect, and another effect of the catalogue.
TEST(Catalogue, TraitsPointToWhatExists) {
  const std::vector<std::string> known = ids();
  std::set<Role> roles;
  test::for_each_effect<double>([&]<class E>(std::type_identity<E>) {
    constexpr EffectTraits traits = traits_of<E>();
    if (traits.role != Role::none) {
      EXPECT_TRUE(roles.insert(traits.role).second) << E::text.id << ": one effect has a role";
    }
    EXPECT_LT(traits.axis_mass_gain, E::gain_count) << E::text.id;
    EXPECT_LT(traits.constant_gain, E::gain_count) << E::text.id;
    EXPECT_LT(traits.part_of_another.gain, E::gain_count) << E::text.id;
    EXPECT_EQ(traits.part_of_another.gain >= 0, traits.part_of_another.whole != Role::none) << E::text.id;
    EXPECT_LT(traits.plausible.shape.shape, E::shape_count) << E::text.id;
    if (traits.plausible.shape.shape >= 0) {
      EXPECT_LT(traits.plausible.shape.lower, traits.plausible.shape.upper) << E::text.id;
    }
    const std::string special_case = traits.special_case.id;
    EXPECT_NE(special_case, E::text.id);
    if (!special_case.empty()) {
      EXPECT_EQ(std::count(known.begin(), known.end(), special_case), 1) << E::text.id;
    }
    EXPECT_LE(traits.special_case.gains, E::gain_count) << E::text.id;
  });
  // Rules of the workbench ask for each of them.
  EXPECT_EQ(roles.size(), static_cast<std::size_t>(Role::measurement_delay));
}

TEST(Catalogue, AnEffectNeedNotStateTraits) {
  struct Plain {};
  constexpr EffectTraits traits = traits_of<Plain>();
  EXPECT_EQ(traits.role, Role::none);
  EXPECT_TRUE(traits.plannable);
  EXPECT_FALSE(traits.in_default_baseline || traits.per_log || traits.plausible.least_share_of_force > 0.0);
}

/// Names in braces, in order; an unmatched brace counts as a name that nothing has.
std::vector<std::string> placeholders(std::string_view text) {
  std::vector<std::string> names;
  for (std::size_t at = text.find_first_of("{}"); at != std::string_view::npos;
       at = text.find_first_of("{}", at)) {
    const std::size_t end = text.find('}', at);
    if (text[at] == '}' || end == std::string_view::npos) return {"unmatched brace"};
    names.emplace_back(text.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return names;
}

TEST(Catalogue, EvidenceNamesParametersOfItsOwn) {
  test::for_each_effect<double>([]<class E>(std::type_identity<E>) {
    std::set<std::string> own;
    for (const GainGroup& group : E::gains) own.insert(group.name);
    for (const ShapeSpec& spec : E::shapes) own.insert(spec.name);
    if (std::any_of(E::shapes.begin(), E::shapes.end(),
                    [](const ShapeSpec& spec) { return spec.kind == ShapeKind::travel; })) {
      own.insert("force_in_middle");  // of the travel (evidence.cpp)
    }
    if (std::any_of(E::shapes.begin(), E::shapes.end(),
                    [](const ShapeSpec& spec) { return spec.kind == ShapeKind::fading_velocity; })) {
      own.insert("weakening_at_standstill");  // all gains together (evidence.cpp)
    }
    for (const std::string& name : placeholders(E::text.evidence)) {
      EXPECT_TRUE(own.contains(name)) << E::text.id << ": {" << name << "}";
    }
    for (const char* other : {E::text.residual, E::text.cause, E::text.confirm, E::text.title}) {
      EXPECT_TRUE(placeholders(other).empty()) << E::text.id << ": only evidence is filled in";
    }
  });
  EXPECT_EQ(placeholders("a {b} c {d}"), (std::vector<std::string>{"b", "d"}));
  EXPECT_EQ(placeholders("a {b"), (std::vector<std::string>{"unmatched brace"}));
}

}  // namespace
}  // namespace slipstack
