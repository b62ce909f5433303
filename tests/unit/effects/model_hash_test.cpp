// SPDX-License-Identifier: Apache-2.0
#include "firmware/effects/model_hash.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "tests/unit/effects/effect_support.h"

namespace slipstack {
namespace {

using Parameters = FrictionModel<float>::Parameters;

template <class E>
EffectParameters<E, float>& of(Parameters& parameters) {
  return std::get<EffectParameters<E, float>>(parameters);
}

/// All effects on, every parameter another number.
Parameters full() {
  Parameters parameters;
  float next = 0.5F;
  std::apply(
      [&](auto&... own) {
        const auto fill = [&](auto& one) {
          one.enabled = true;
          for (float& shape : one.shapes) shape = next += 0.25F;
          for (float& gain : one.gains) gain = next += 0.25F;
        };
        (fill(own), ...);
      },
      parameters);
  return parameters;
}

/// FNV-1a as Fowler, Noll and Vo publish it, byte by byte, least significant first.
std::uint32_t fnv1a(const std::vector<std::uint32_t>& words) {
  std::uint64_t hash = 0x811c9dc5u;
  for (const std::uint32_t word : words) {
    for (const unsigned shift : {0u, 8u, 16u, 24u}) {
      hash = ((hash ^ (word >> shift & 0xffu)) * 0x01000193u) % (1ull << 32);
    }
  }
  return static_cast<std::uint32_t>(hash);
}

TEST(ModelHash, IsFnv1aOfPlacesAndParameters) {
  Parameters parameters;
  EXPECT_EQ(model_hash(parameters), 0x811c9dc5u);  // the offset basis: nothing enabled
  of<Inertia<float>>(parameters) = {.gains = {35.45F}, .shapes = {}, .enabled = true};
  EXPECT_EQ(model_hash(parameters), fnv1a({1, 0x420dcccdu}));
  of<Coulomb<float>>(parameters) = {.gains = {2.5F}, .shapes = {1e-4F}, .enabled = true};
  EXPECT_EQ(model_hash(parameters), fnv1a({1, 0x420dcccdu, 3, 0x38d1b717u, 0x40200000u}));
}

TEST(ModelHash, TakesAllOfAFullModel) {
  Parameters parameters = full();
  std::vector<std::uint32_t> words;
  std::uint32_t place = 0;
  std::apply(
      [&](const auto&... own) {
        const auto each = [&](const auto& one) {
          words.push_back(++place);
          for (const float shape : one.shapes) words.push_back(std::bit_cast<std::uint32_t>(shape));
          for (const float gain : one.gains) words.push_back(std::bit_cast<std::uint32_t>(gain));
        };
        (each(own), ...);
      },
      parameters);
  EXPECT_EQ(model_hash(parameters), fnv1a(words));
}

// Controllers in the field report these: a change here makes every model file unreadable. Computed apart.
TEST(ModelHash, IsWhatItWas) {
  Parameters parameters;
  of<Inertia<float>>(parameters) = {.gains = {35.45F}, .shapes = {}, .enabled = true};
  of<Coulomb<float>>(parameters) = {.gains = {2.5F}, .shapes = {1e-4F}, .enabled = true};
  EXPECT_EQ(model_hash(parameters), 0x2c7c21c2u);
}

TEST(ModelHash, ChangesWithEveryParameter) {
  Parameters parameters = full();
  std::set<std::uint32_t> seen{model_hash(parameters)};
  std::size_t changes = 0;
  const auto try_change = [&](float& value) {
    const float kept = value;
    for (const float other : {std::nextafter(kept, 1e9F), std::nextafter(kept, -1e9F), -kept, 0.0F}) {
      value = other;
      EXPECT_TRUE(seen.insert(model_hash(parameters)).second || other == 0.0F);
      EXPECT_NE(model_hash(parameters), model_hash(full()));
      ++changes;
    }
    value = kept;
  };
  std::apply(
      [&](auto&... own) {
        const auto each = [&](auto& one) {
          for (float& shape : one.shapes) try_change(shape);
          for (float& gain : one.gains) try_change(gain);
          one.enabled = false;
          EXPECT_TRUE(seen.insert(model_hash(parameters)).second);
          one.enabled = true;
        };
        (each(own), ...);
      },
      parameters);
  EXPECT_EQ(model_hash(parameters), model_hash(full()));
  EXPECT_GT(changes, 4u * 60u);
}

TEST(ModelHash, KnowsOneZero) {
  Parameters parameters = full();
  of<OffsetForce<float>>(parameters).gains[0] = 0.0F;
  of<TimeDelay<float>>(parameters).shapes[0] = 0.0F;
  const std::uint32_t plain = model_hash(parameters);
  of<OffsetForce<float>>(parameters).gains[0] = -0.0F;
  EXPECT_EQ(model_hash(parameters), plain);
  of<TimeDelay<float>>(parameters).shapes[0] = -0.0F;
  EXPECT_EQ(model_hash(parameters), plain);
}

TEST(ModelHash, DoesNotLookAtWhatIsOff) {
  Parameters parameters = full();
  of<Drift<float>>(parameters).enabled = false;
  const std::uint32_t off = model_hash(parameters);
  of<Drift<float>>(parameters).gains[0] = 99.0F;
  EXPECT_EQ(model_hash(parameters), off);
}

// Two effects with the same numbers are two models.
TEST(ModelHash, KnowsWhichEffect) {
  Parameters inertia;
  of<Inertia<float>>(inertia) = {.gains = {1.0F}, .shapes = {}, .enabled = true};
  Parameters payload;
  of<PayloadMass<float>>(payload) = {.gains = {1.0F}, .shapes = {}, .enabled = true};
  EXPECT_NE(model_hash(inertia), model_hash(payload));
}

}  // namespace
}  // namespace slipstack
