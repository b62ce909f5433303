// SPDX-License-Identifier: Apache-2.0
#include "workbench/model/expression/definition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "workbench/model/expression/expression.h"
#include "workbench/model/expression/linearity.h"
#include "workbench/model/expression/units.h"

namespace slipstack::workbench {
namespace {

const std::string kSnag = "snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]";

/// The message for a wrong definition; the position of the caret is marked by '@'.
struct Wrong {
  std::string marked;
  std::string described;
};

void expect_refused(const Wrong& wrong) {
  const std::size_t at = wrong.marked.find('@');
  ASSERT_NE(at, std::string::npos);
  std::string text = wrong.marked;
  text.erase(at, 1);
  try {
    roles_of(parse_definition(text));
    ADD_FAILURE() << "taken: " << text;
  } catch (const DefinitionError& error) {
    EXPECT_EQ(error.column(), at) << text << "\n" << error.picture() << error.what();
    EXPECT_NE(std::string(error.what()).find(wrong.described), std::string::npos) << text << "\n"
                                                                                  << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(Definition, ReadsNamesUnitsAndBounds) {
  const Definition snag = parse_definition(kSnag);
  EXPECT_EQ(snag.name, "snag");
  EXPECT_EQ(snag.expression, "A*exp(-((x-x0)/w)^2)*sign(v)");
  ASSERT_EQ(snag.parameters.size(), 3u);
  EXPECT_EQ(snag.parameters[0].unit, "N");
  EXPECT_FALSE(snag.parameters[1].bounds.has_value());
  EXPECT_EQ(snag.parameters[2].bounds->lower, 1e-4);
  EXPECT_EQ(snag.parameters[2].bounds->upper, 1e-2);
}

TEST(Definition, PointsAtTheError) {
  for (const Wrong& wrong : std::initializer_list<Wrong>{
           {"@A*x; A: N/m", "no '='"},
           {"@= A*x; A: N/m", "name of the effect is missing"},
           {"s@-g = A*x; A: N/m", "letters, digits"},
           {"snag =@", "expression is missing"},
           {"snag = A*x + @B*v; A: N/m", "unknown name 'B'"},
           {"snag = A*@sinus(x); A: N", "no such function"},
           {"snag = A*@y; A: N/m", "unknown name 'y'"},
           {"snag = A*x; A@", "unit of 'A' is missing"},
           {"snag = A*x; A:@", "unit of 'A' is missing"},
           {"snag = A*x; A: @in [0, 1]", "unit of 'A' is missing"},
           {"snag = A*x; A: @furlong", "not understood"},
           {"snag = A*x; A: @mm", "not an SI unit; give it in m"},
           {"snag = A*x; A: @N/", "not complete"},
           {"snag = A*@(x + v; A: N/m", "not closed"},
           {"snag = A*(x + v)@); A: N/m", "closes nothing"},
           {"snag = A*(x + @); A: N/m", ""},
           {"snag = A*x*@; A: N/m", "ends too early"},
           {"snag = A*@*x; A: N/m", "not expected"},
           {"snag = A*x @= 3; A: N/m", "second '='"},
           {"snag = A*x; A: N/m in [@1, -1]", "reversed"},
           {"snag = A*x; A: N/m in [@1, 1]", "reversed"},
           {"snag = A*x; A: N/m in [@low, 1]", "not a number"},
           {"snag = A*x; A: N/m in [0,@]", "missing"},
           {"snag = A*x; A: N/m in @0 to 1", "[low, high]"},
           {"snag = A*x; A: N/m; @B: N", "does not use it"},
           {"snag = A*x; A: N/m; @A: N", "declared twice"},
           {"snag = A*x; A: N/m; @x: m", "is a variable"},
           {"snag = A*x; A: N/m; @sin: m", "function or a constant"},
           {"snag = @sign(v)", "no parameter"},
           {"snag = @A^2*x; A: N in [1, 2]", "'A' does not enter linearly"},
           {"snag = exp(@A*x); A: N/m", "'A' does not enter linearly"},
           {"snag = @A*x + sign(v); A: N/m", "multiplied by no gain"},
           {"snag = A*abs(x)^n; A: N; @n: 1", "needs bounds"},
           {"snag = A*B*x; A: N; @B: 1", "only scales"},
           {"snag = A*x@\x01; A: N/m", "ASCII"},
       }) {
    expect_refused(wrong);
  }
}

TEST(Definition, TheCaretStaysUnderTheErrorInALongText) {
  std::string text = "long = A*x";
  for (int i = 0; i < 40; ++i) text += " + A*x";
  const std::size_t at = text.size() + 3;
  text += " + C*x; A: N/m";
  try {
    Expression expression(parse_definition(text));
    FAIL();
  } catch (const DefinitionError& error) {
    EXPECT_EQ(error.column(), at);
    const std::string picture = error.picture();
    const std::size_t line = picture.find('\n');
    EXPECT_EQ(picture[picture.find('^') - line - 1], 'C');
  }
}

/// Random sequences of valid tokens are either parsed or refused.
TEST(Definition, AnyTextIsParsedOrRefused) {
  const std::vector<std::string> pieces{"snag", " = ",  "A",  "*", "x", "(", ")",   "; ", ":",   "N", " in ",
                                        "[",    "1e-3", ", ", "]", "^", "-", "exp", "v",  "0.5", "=", "?"};
  std::mt19937 random(5);
  int taken = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string text = i % 2 == 0 ? "snag = A*" : "";
    for (auto n = random() % 14; n > 0; --n) text += pieces[random() % pieces.size()];
    if (i % 2 == 0) text += "; A: N";
    try {
      roles_of(parse_definition(text));
      ++taken;
    } catch (const DefinitionError& error) {
      EXPECT_LE(error.column(), text.size());
    }
  }
  EXPECT_GT(taken, 10);
  EXPECT_LT(taken, 3000);
}

TEST(Units, AreProductsOfSiUnits) {
  for (const char* good :
       {"N", "1", "N/m", "N s/m", "m/s2", "m/s^2", "1/m", "N*s^2/m2", "kg", "s^-1", "1/s"}) {
    EXPECT_EQ(unit_fault(good), "") << good;
  }
  for (const char* bad : {"", "um", "lbf", "N//", "N m s q", "mm/s", "2", "/m"})
    EXPECT_NE(unit_fault(bad), "") << bad;
}

TEST(Expression, EvaluatesLikeTheFormula) {
  Expression expression(parse_definition(kSnag));
  expression.set(0, 3.0);
  expression.set(1, 0.2);
  expression.set(2, 0.004);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(0.19, 0.21), speed(-1.0, 1.0);
  for (int i = 0; i < 1000; ++i) {
    const double x = place(random), v = speed(random);
    const double u = (x - 0.2) / 0.004;
    const double wanted = 3.0 * std::exp(-u * u) * (v > 0.0 ? 1.0 : -1.0);
    EXPECT_NEAR(expression.at({0.0, x, v, 0.0}), wanted, 1e-12);
  }
}

}  // namespace
}  // namespace slipstack::workbench
