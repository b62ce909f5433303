// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/expression/linearity.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace slipstack::workbench {
namespace {

std::set<std::string> gains_of(const std::string& text) {
  const Definition definition = parse_definition(text);
  std::set<std::string> names;
  for (const std::size_t gain : roles_of(definition).gains) names.insert(definition.parameters[gain].name);
  return names;
}

TEST(Linearity, FindsTheGains) {
  using Names = std::set<std::string>;
  EXPECT_EQ(gains_of("e = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]"), (Names{"A"}));
  EXPECT_EQ(gains_of("e = A*x + B*v + C*sign(v); A: N/m; B: N s/m; C: N"), (Names{"A", "B", "C"}));
  EXPECT_EQ(gains_of("e = (A + B*x)*tanh(v/vs); A: N; B: N/m; vs: m/s"), (Names{"A", "B"}));
  EXPECT_EQ(gains_of("e = A*(1 + b*abs(v))*sign(v); b: s/m in [0, 10]; A: N"), (Names{"A"}));
  EXPECT_EQ(gains_of("e = A*cos(2*pi*x/p) + B*sin(2*pi*x/p); A: N; B: N; p: m"), (Names{"A", "B"}));
  EXPECT_EQ(gains_of("e = A*a*(1 - exp(-t/tau)); A: kg; tau: s"), (Names{"A"}));
  // Non-zero only near one position: narrow functions must not be taken for zero.
  EXPECT_EQ(gains_of("e = A*(abs(x-x0) < w)*sign(v); A: N; x0: m; w: m in [1e-5, 1e-4]"), (Names{"A"}));
  // A root is defined for half of the positions only.
  EXPECT_EQ(gains_of("e = A*sqrt(x); A: N"), (Names{"A"}));
}

TEST(Linearity, ABoundedMagnitudeIsLinearWithinItsBounds) {
  EXPECT_EQ(gains_of("e = abs(A)*x; A: N/m in [0, 5]"), (std::set<std::string>{"A"}));
  EXPECT_THROW(roles_of(parse_definition("e = abs(A)*x; A: N/m in [-5, 5]")), DefinitionError);
}

}  // namespace
}  // namespace slipstack::workbench
