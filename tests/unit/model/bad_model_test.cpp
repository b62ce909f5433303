// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/model/model_support.h"

namespace slipstack::workbench::test {
namespace {

// Lines are counted from 1; the tests below name them.
constexpr std::string_view kGood = R"(format = "slipstack model 1"
[source]
log = "run.csv"
samples = 1000
[[effect]]
id = "inertia"
[[effect.gain]]
name = "mass"
unit = "kg"
value = 35.45
standard_error = 0.02
[[effect]]
id = "stribeck"
[[effect.shape]]
name = "stribeck_velocity"
unit = "m/s"
value = 0.01
[[effect.shape]]
name = "exponent"
unit = "1"
value = 1.0
[[effect.gain]]
name = "weakening"
unit = "1"
value = 0.5
[[effect.gain]]
name = "weakening_with_tail"
unit = "1"
value = 0.0
[target]
holdout_rmse_N = 0.1
[[target.effect]]
id = "presliding_hysteresis"
[[target.effect.shape]]
name = "slip_distance"
unit = "m"
value = [1e-6, 2e-6]
[[target.effect.gain]]
name = "stiffness"
unit = "N/m"
value = [1e5, 2e5]
)";

std::string without_line(int number) {
  std::string text;
  int line = 0;
  std::string_view rest = kGood;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n') + 1;
    if (++line != number) text += rest.substr(0, end);
    rest.remove_prefix(end);
  }
  return text;
}

std::string with(std::string_view what, std::string_view instead) {
  std::string text(kGood);
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  EXPECT_EQ(text.find(what, at + 1), std::string::npos) << what << " is there twice";
  return text.replace(at, what.size(), instead);
}

/// The message begins with file and line and contains `says`; it is one line, and says what to do where
/// possible.
void expect_refused(const std::string& text, int line, std::string_view says) {
  const TemporaryFile file;
  const std::string message = refusal(file.write(text));
  const std::string where = file.path().string() + ":" + std::to_string(line) + ": ";
  EXPECT_TRUE(message.starts_with(where)) << "should be " << where << ", is: " << message;
  EXPECT_NE(message.find(says), std::string::npos) << message;
  EXPECT_EQ(message.find_first_of("\n\r"), std::string::npos) << message;
}

TEST(BadModel, AcceptsAGoodModel) {
  const TemporaryFile file;
  EXPECT_EQ(refusal(file.write(kGood)), "");
}

TEST(BadModel, AcceptsCarriageReturnsAndAByteOrderMark) {
  const TemporaryFile file;
  std::string text = "\xEF\xBB\xBF";
  for (const char c : kGood) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(refusal(file.write(text)), "");
}

TEST(BadModel, UnknownEffect) {
  expect_refused(with("\"inertia\"", "\"inertial\""), 6, "unknown effect 'inertial'; known: inertia, ");
}
TEST(BadModel, EffectTwice) {
  expect_refused(with("[target]\n", "[[effect]]\nid = \"inertia\"\n[target]\n"), 30,
                 "'inertia' appears twice");
}
TEST(BadModel, EffectWithoutId) {
  expect_refused(without_line(6), 5, "has no id");
}
TEST(BadModel, EffectThatIsNoTable) {
  expect_refused("format = \"slipstack model 1\"\neffect = [1, 2]\n", 2, "must be a table");
}
TEST(BadModel, NoEffects) {
  expect_refused("format = \"slipstack model 1\"\n[target]\n", 1, "no [[effect]]");
  expect_refused("format = \"slipstack model 1\"\neffect = []\n[target]\n", 1, "no [[effect]]");
}
TEST(BadModel, NoTarget) {
  const std::string text(kGood.substr(0, kGood.find("[target]")));
  expect_refused(text, 1, "[target] is missing");
}
TEST(BadModel, NoEffectsInTarget) {
  const std::string text(kGood.substr(0, kGood.find("[[target.effect]]")));
  expect_refused(text, 30, "no [[effect]]");
}

TEST(BadModel, UnknownKey) {
  expect_refused(with("samples = 1000", "samples = 1000\nsmaples = 3"), 5, "unknown key 'smaples'");
  expect_refused(with("value = 35.45", "value = 35.45\nvalve = 3"), 11, "unknown key 'valve'");
  expect_refused(with("id = \"inertia\"", "id = \"inertia\"\ntitle = 3"), 7, "unknown key 'title'");
  expect_refused(with("[source]", "version = 3\n[source]"), 2, "unknown key 'version'");
  expect_refused(with("holdout_rmse_N = 0.1", "holdout_rmse = 0.1"), 31, "unknown key 'holdout_rmse'");
}
TEST(BadModel, UnknownParameter) {
  expect_refused(with("name = \"weakening\"", "name = \"weakness\""), 22,
                 "unknown gain 'weakness' of effect 'stribeck'; known: weakening");
  expect_refused(with("name = \"exponent\"", "name = \"exponents\""), 18, "unknown shape 'exponents'");
  expect_refused(with("name = \"exponent\"\n", ""), 18, "unknown shape ''");
  expect_refused(with("id = \"inertia\"", "id = \"inertia\"\nshape = 3"), 7,
                 "shape must be an array of tables");
  expect_refused(with("id = \"inertia\"", "id = \"inertia\"\nshape = [3]"), 7, "a shape must be a table");
}
TEST(BadModel, ParameterTwice) {
  expect_refused(
      with("[target]\n", "[[effect.gain]]\nname = \"weakening\"\nunit = \"1\"\nvalue = 1\n[target]\n"), 30,
      "gain 'weakening' appears twice");
}
TEST(BadModel, MissingShape) {
  expect_refused(with("[[effect.shape]]\nname = \"exponent\"\nunit = \"1\"\nvalue = 1.0\n", ""), 12,
                 "shape 'exponent' of effect 'stribeck' is missing");
}
TEST(BadModel, MissingGain) {
  expect_refused(with("[[effect.gain]]\nname = \"weakening\"\nunit = \"1\"\nvalue = 0.5\n", ""), 12,
                 "gain 'weakening' of effect 'stribeck' is missing");
}
TEST(BadModel, MissingValue) {
  expect_refused(without_line(10), 7, "mass has no value");
}
TEST(BadModel, MissingUnit) {
  expect_refused(without_line(9), 7, "unit");
}
TEST(BadModel, WrongUnit) {
  expect_refused(with("unit = \"kg\"", "unit = \"g\""), 7, "mass has unit 'g'; it must be 'kg'");
}

TEST(BadModel, OutOfBounds) {
  expect_refused(with("value = 35.45", "value = -1"), 10,
                 "mass = -1 is out of bounds; it must lie in [0, 100000]");
  expect_refused(with("value = 35.45", "value = 1e9"), 10, "out of bounds");
  expect_refused(with("value = 0.01", "value = 0"), 17, "out of bounds");
  expect_refused(with("[1e5, 2e5]", "[1e5, -2e5]"), 41, "out of bounds");
  expect_refused(with("standard_error = 0.02", "standard_error = -0.02"), 11, "out of bounds");
}
// 1.0e-2f is 0.00999999977…: 0.01 in a file means the bound and is read as the bound itself.
TEST(BadModel, DecimalsOfABoundAreTheBound) {
  const TemporaryFile file;
  constexpr std::string_view kCoulomb = R"(format = "slipstack model 1"
[[effect]]
id = "coulomb"
[[effect.shape]]
name = "saturation_velocity"
unit = "m/s"
value = 0.01
[[effect.gain]]
name = "coulomb"
unit = "N"
value = 3
[target]
[[target.effect]]
id = "offset_force"
[[target.effect.gain]]
name = "offset"
unit = "N"
value = 3
)";
  const Model model = read_model(file.write(kCoulomb));
  EXPECT_EQ(model.terms[0].shapes[0], static_cast<double>(0.01F));
  std::string beyond(kCoulomb);
  beyond.replace(beyond.find("0.01"), 4, "0.010001");
  expect_refused(beyond, 7, "out of bounds");
}
TEST(BadModel, NotANumber) {
  for (const char* value : {"nan", "inf", "-inf", "\"35\"", "true", "1979-05-27", "{}", "[[1]]"}) {
    expect_refused(with("35.45", value), 10, "mass is not a finite number");
  }
  expect_refused(with("[1e-6, 2e-6]", "[1e-6, nan]"), 37, "slip_distance is not a finite number");
}
TEST(BadModel, WrongNumberOfValues) {
  expect_refused(with("35.45", "[35.45, 1.0]"), 10, "mass has 2 values; it must have 1");
  expect_refused(with("35.45", "[]"), 10, "mass has 0 values");
  std::string many = "[1e5";
  for (int i = 0; i < 40; ++i) many += ", 1e5";
  expect_refused(with("[1e5, 2e5]", many + "]"), 41, "stiffness has 41 values");
}
// The controller has ten elements; with or without a hash line, a file must not ask for more.
TEST(BadModel, MoreElementsThanTheControllerHas) {
  std::string slip = "[1e-6";
  std::string stiffness = "[1e5";
  for (int i = 1; i < 12; ++i) {
    slip += ", " + std::to_string(i + 1) + "e-6";
    stiffness += ", 1e5";
  }
  std::string text = with("[1e-6, 2e-6]", slip + "]");
  text.replace(text.find("[1e5, 2e5]"), 10, stiffness + "]");
  expect_refused(text, 32, "12 elements; the controller has 10");
  text.insert(text.find("[source]"), "hash = \"00000000\"\n");
  expect_refused(text, 33, "12 elements; the controller has 10");
}
TEST(BadModel, SlipDistancesAndStiffnessesThatDoNotPair) {
  expect_refused(with("[1e5, 2e5]", "[1e5, 2e5, 3e5]"), 32, "2 slip distances and 3 stiffnesses");
}

TEST(BadModel, HashOfAnother) {
  expect_refused(with("[source]", "hash = \"deadbeef\"\n[source]"), 2,
                 "hash does not belong to the parameters");
  expect_refused(with("[source]", "hash = 3\n[source]"), 2, "hash does not belong to the parameters");
}
TEST(BadModel, NoFormatLine) {
  expect_refused(without_line(1), 1, "no line format = \"slipstack model 1\"");
  expect_refused(with("slipstack model 1", "slipstack model 2"), 1, "no line format");
}

TEST(BadModel, NotToml) {
  expect_refused(with("value = 35.45", "value = = 35.45"), 10, "not TOML");
  expect_refused(with("id = \"inertia\"", "id = \"inertia"), 6, "not TOML");
  expect_refused(with("value = 35.45", "value = 35.45\nvalue = 3"), 11, "not TOML");
  expect_refused("time_s,position_m,force_N\n0,0,0\n", 1, "not TOML");
  expect_refused(std::string(100'000, '['), 1, "not TOML");
  expect_refused(std::string("\0\0\0", 3), 1, "");
}
TEST(BadModel, Empty) {
  expect_refused("", 1, "no line format");
}

// Escapes in names must not break the message into several lines.
TEST(BadModel, MessagesStayOnOneLine) {
  expect_refused(with("\"inertia\"", "\"in\\nertia\\u0007\""), 6, "unknown effect");
  expect_refused(with("unit = \"kg\"", "unit = \"k\\ng\""), 7, "unit");
  expect_refused(with("[source]", "\"a\\nb\" = 3\n[source]"), 2, "unknown key");
  expect_refused(with("name = \"weakening\"", "name = \"weak\\r\\nening\""), 22, "unknown gain");
}
TEST(BadModel, MessagesStayShort) {
  const TemporaryFile file;
  EXPECT_LT(refusal(file.write(with("\"inertia\"", '"' + std::string(1'000'000, 'x') + '"'))).size(), 1500u);
}

void expect_refused_file(const std::filesystem::path& path, std::string_view says) {
  const std::string message = refusal(path);
  EXPECT_TRUE(message.starts_with(path.string() + ": ")) << message;
  EXPECT_NE(message.find(says), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(BadModel, NoSuchFile) {
  const TemporaryFile file;
  expect_refused_file(file.path(), "no such file");
}
TEST(BadModel, ADirectory) {
  const TemporaryFile file;
  expect_refused_file(file.directory(), "not a file");
}
TEST(BadModel, ADevice) {
  expect_refused_file("/dev/zero", "not a file");
}
TEST(BadModel, TwentyMegabytes) {
  const TemporaryFile file;
  file.write("");
  std::filesystem::resize_file(file.path(), 20u << 20);
  expect_refused_file(file.path(), "larger than any model");
}

}  // namespace
}  // namespace slipstack::workbench::test
