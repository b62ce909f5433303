// SPDX-License-Identifier: Apache-2.0
// Headers of models, compiled by the system's C compiler and run beside the firmware on the same random
// motion.
#include <dlfcn.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "firmware/effects/model.h"
#include "tests/unit/c_export/random_model.h"
#include "tests/unit/temporary_directory.h"
#include "workbench/base/axis_units.h"
#include "workbench/c_export/friction_header.h"

namespace slipstack {
namespace {

using test::Draw;

constexpr double kRate_Hz = 8192.0;  // the period is exact
constexpr float kStep_m = 2e-7F;     // holds slip distances of 2 mm

/// As the header declares it.
struct FloatMotion {
  float time_s;
  std::int32_t position_steps;
  float position_m, velocity_mps, acceleration_mps2;
};
struct DoubleMotion {
  double time_s, position_m, velocity_mps, acceleration_mps2;
};

struct Exported {
  workbench::Model model;
  bool is_float = true;
  std::string name;
  std::string header;
};

/// Any motion: places beyond every table, standstill, jumps that close all loops, a counter that wraps.
class RandomMotion {
 public:
  explicit RandomMotion(std::uint64_t seed) : draw_(seed) {}

  Sample<double> next() {
    Sample<double> sample;
    time_s_ += draw_.uniform(0.0, 1e-2);
    sample.time_s = time_s_;
    const double size = draw_.below(50) == 0 ? 1e5 : draw_.log_uniform(0.5, 3e3);
    steps_ += static_cast<std::uint32_t>(static_cast<std::int32_t>(draw_.sign() * size));
    sample.displacement = static_cast<double>(static_cast<std::int32_t>(steps_));
    if (draw_.below(10) == 0) {
      position_m_ = draw_.uniform(-0.6, 0.6);
    } else {
      position_m_ += draw_.sign() * draw_.log_uniform(1e-8, 1e-2);
    }
    sample.position_m = position_m_;
    const double zero = draw_.below(2) == 0 ? 0.0 : -0.0;
    sample.velocity_mps = draw_.below(20) == 0 ? zero : draw_.sign() * draw_.log_uniform(1e-8, 4.0);
    sample.acceleration_mps2 = draw_.below(20) == 0 ? zero : draw_.sign() * draw_.log_uniform(1e-4, 80.0);
    return test::rounded(sample);
  }

 private:
  Draw draw_;
  double time_s_ = 0.0;
  double position_m_ = 0.0;
  std::uint32_t steps_ = 0x7FFF0000U;
};

class CExport : public ::testing::Test {
 protected:
  void TearDown() override { workbench::forget_axis(); }

  static std::string flags(const std::string& standard) {
    return standard +
           " -O2 -ffp-contract=off -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Wpedantic "
           "-Werror ";
  }

  /// One effect at a time on top of a hysteresis that others modulate, all together, and some of them; in
  /// both precisions.
  static std::vector<Exported> models() {
    std::vector<Exported> all;
    const auto add = [&all](const auto& wanted, std::uint64_t seed) {
      for (const bool is_float : {true, false}) {
        Draw draw(seed);
        Exported one{test::random_model(draw, wanted), is_float, fmt::format("m{}", all.size()), {}};
        workbench::FrictionHeaderOptions options;
        options.is_float = is_float;
        options.name = one.name;
        options.rate_Hz = kRate_Hz;
        if (is_float) options.step_m = static_cast<double>(kStep_m);
        one.header = workbench::friction_header(one.model, options);
        all.push_back(std::move(one));
      }
    };
    add([](const EffectText&) { return true; }, 1);
    const std::string_view hysteresis = workbench::effect_with_role(Role::hysteresis).text.id;
    std::uint64_t seed = 2;
    test::for_each_effect<double>([&]<class E>(std::type_identity<E>) {
      add(
          [&](const EffectText& text) {
            return text.id == hysteresis || text.id == std::string_view(E::text.id);
          },
          seed++);
    });
    add([](const EffectText& text) { return text.id[0] % 2 == 0; }, seed++);
    add([](const EffectText& text) { return text.id[0] % 2 == 1; }, seed++);
    return all;
  }

  /// The headers in `folder`, and a source that includes all of them.
  static std::filesystem::path write(const test::TemporaryDirectory& folder,
                                     const std::vector<Exported>& all) {
    std::string source;
    std::string calls =
        "void begin(int model, const void *motion);\ndouble next(int model, const void *motion);\n";
    std::string begin = "void begin(int model, const void *motion) {\n  switch (model) {\n";
    std::string next = "double next(int model, const void *motion) {\n  switch (model) {\n";
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::string& name = all[i].name;
      folder.write(name + ".h", all[i].header);
      source += fmt::format("#include \"{0}.h\"\nstatic {0}_state {0};\n", name);
      begin += fmt::format("    case {1}: {0}_init(&{0}, (const {0}_motion *)motion); break;\n", name, i);
      next +=
          fmt::format("    case {1}: return (double){0}_step(&{0}, (const {0}_motion *)motion);\n", name, i);
    }
    return folder.write("all.c", source + "#ifdef __cplusplus\nextern \"C\" {\n#endif\n" + calls + begin +
                                     "    default: break;\n  }\n}\n" + next +
                                     "    default: return 0.0;\n  }\n}\n" +
                                     "#ifdef __cplusplus\n}\n#endif\n");
  }

  /// `steps_of_all`: of the two models with every effect.
  static void expect_the_force_of_the_firmware(const std::vector<Exported>& all, int steps_of_all);
  static int run(const std::string& command) { return std::system(command.c_str()); }
  static bool has(const std::string& program) {
    return run("command -v " + program + " >/dev/null 2>&1") == 0;
  }
};

template <class Real>
Sample<Real> for_firmware(const Sample<double>& motion) {
  Sample<Real> sample;
  sample.time_s = static_cast<Real>(motion.time_s);
  sample.position_m = static_cast<Real>(motion.position_m);
  sample.velocity_mps = static_cast<Real>(motion.velocity_mps);
  sample.acceleration_mps2 = static_cast<Real>(motion.acceleration_mps2);
  // In double there is one position, and the springs follow it.
  sample.displacement = std::is_same_v<Real, float> ? static_cast<DisplacementOf<Real>>(motion.displacement)
                                                    : static_cast<DisplacementOf<Real>>(motion.position_m);
  return sample;
}
FloatMotion for_c(const Sample<float>& s) {
  return {s.time_s, s.displacement, s.position_m, s.velocity_mps, s.acceleration_mps2};
}
DoubleMotion for_c(const Sample<double>& s) {
  return {s.time_s, s.position_m, s.velocity_mps, s.acceleration_mps2};
}

/// The compiled C of the models.
class LoadedModels {
 public:
  explicit LoadedModels(const std::string& library) : library_(::dlopen(library.c_str(), RTLD_NOW)) {
    if (!is_open()) return;
    begin = reinterpret_cast<void (*)(int, const void*)>(::dlsym(library_, "begin"));
    next = reinterpret_cast<double (*)(int, const void*)>(::dlsym(library_, "next"));
  }
  ~LoadedModels() {
    if (is_open()) ::dlclose(library_);
  }
  LoadedModels(const LoadedModels&) = delete;
  LoadedModels& operator=(const LoadedModels&) = delete;
  bool is_open() const { return library_ != nullptr; }

  void (*begin)(int number, const void* motion) = nullptr;
  double (*next)(int number, const void* motion) = nullptr;

 private:
  void* library_;
};

struct Agreement {
  int differing = 0;
  double largest_N = 0.0;
  double force_N = 0.0;  ///< largest
};

template <class Real>
Agreement compare(const workbench::Model& model, int number, int steps, const LoadedModels& loaded) {
  FrictionModel<Real> firmware;
  firmware.prepare(test::parameters_of<Real>(model),
                   {static_cast<Real>(1.0 / kRate_Hz),
                    std::is_same_v<Real, float> ? static_cast<Real>(kStep_m) : Real(1)});
  RandomMotion motion(7);
  Sample<Real> sample = for_firmware<Real>(motion.next());
  auto given = for_c(sample);
  firmware.reset(sample);
  loaded.begin(number, &given);
  Agreement agreement;
  for (int i = 0; i < steps; ++i) {
    sample = for_firmware<Real>(motion.next());
    given = for_c(sample);
    const auto is = static_cast<double>(firmware.step(sample).total_N);
    const double in_c = loaded.next(number, &given);
    if (is != in_c) ++agreement.differing;
    agreement.largest_N = std::max(agreement.largest_N, std::abs(is - in_c));
    agreement.force_N = std::max(agreement.force_N, std::abs(is));
  }
  return agreement;
}

// The oracle is the firmware's own model. Equal to the bit, so that nothing is left to a tolerance.
void CExport::expect_the_force_of_the_firmware(const std::vector<Exported>& all, int steps_of_all) {
  const test::TemporaryDirectory folder;
  const std::filesystem::path source = write(folder, all);
  const std::string library = (folder / "all.so").string();
  ASSERT_EQ(run(SLIPSTACK_C_COMPILER " " + flags("-std=c99") + "-shared -fPIC -o " + library + " " +
                source.string()),
            0);
  const LoadedModels loaded(library);
  ASSERT_TRUE(loaded.is_open()) << ::dlerror();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_all = i < 2;
    const int steps = is_all ? steps_of_all : 20'000;
    const int number = static_cast<int>(i);
    const Agreement agreement = all[i].is_float ? compare<float>(all[i].model, number, steps, loaded)
                                                : compare<double>(all[i].model, number, steps, loaded);
    EXPECT_EQ(agreement.differing, 0)
        << all[i].model.target_terms.back().id() << " " << (all[i].is_float ? "float" : "double") << ": by "
        << agreement.largest_N << " N of " << agreement.force_N << " N";
    EXPECT_GT(agreement.force_N, 0.01);
  }
}

TEST_F(CExport, ComputesTheForceOfTheFirmwareBitForBit) {
  expect_the_force_of_the_firmware(models(), 1'000'000);
}

// The numbers of a rotary axis are those of a linear one (workbench/base/axis_units.h): what may go wrong is
// a name that was changed in one place and not in another.
TEST_F(CExport, ComputesTheTorqueOfARotaryAxisBitForBit) {
  workbench::use_axis({workbench::AxisKind::rotary, workbench::AngleUnit::radian}, "this test");
  expect_the_force_of_the_firmware(models(), 1'000'000);
}

// Angles and torques, in identifiers and in words.
TEST_F(CExport, NamesTheUnitsOfARotaryAxis) {
  workbench::use_axis({workbench::AxisKind::rotary, workbench::AngleUnit::radian}, "this test");
  const std::regex linear_name(R"(\w_(N|m|M|mps|mps2)\b)");
  const std::regex linear_unit(R"([0-9.] (N(?! m)|m|m/s|kg(?! m2))\b|\bin N(?! m)\b|on the rail)");
  for (const Exported& one : models()) {
    std::smatch found;
    EXPECT_FALSE(std::regex_search(one.header, found, linear_name)) << found.str();
    EXPECT_FALSE(std::regex_search(one.header, found, linear_unit)) << found.str();
    for (const char* const name :
         {"velocity_radps;", "acceleration_radps2;", "position_rad;", "torque_Nm;", "the torque in N m"})
      EXPECT_NE(one.header.find(name), std::string::npos) << name;
  }
  workbench::forget_axis();
  EXPECT_TRUE(std::regex_search(models()[0].header, linear_name)) << "the search finds nothing";
}

// Every compiler that a user may have, with every warning an error.
TEST_F(CExport, CompilesWithoutWarnings) {
  const test::TemporaryDirectory folder;
  const std::string source = write(folder, models()).string();
  const auto compile = [&](const std::string& compiler) {
    EXPECT_EQ(run(compiler + " -c -o " + (folder / "all.o").string()), 0) << compiler;
  };
  compile(SLIPSTACK_CXX_COMPILER " " + flags("-std=c++11") + "-x c++ " + source);
  if (has("clang")) {
    compile("clang " + flags("-std=c99") + source);
    compile("clang++ " + flags("-std=c++20") + "-x c++ " + source);
  }
  if (has("arm-none-eabi-gcc")) {
    compile("arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard " +
            flags("-std=c99") + source);
  }
}

// A contraction into fused products, the default of some compilers, changes the rounding and no more.
TEST_F(CExport, AgreesToRoundingWhereProductsAreFused) {
  if (run("grep -qw fma /proc/cpuinfo") != 0) GTEST_SKIP() << "this processor has no fused products";
  const test::TemporaryDirectory folder;
  std::vector<Exported> all = models();
  all.resize(1);
  const std::filesystem::path source = write(folder, all);
  const std::string library = (folder / "fused.so").string();
  ASSERT_EQ(run(SLIPSTACK_C_COMPILER " -O2 -mfma -ffp-contract=fast -shared -fPIC -o " + library + " " +
                source.string()),
            0);
  const LoadedModels loaded(library);
  ASSERT_TRUE(loaded.is_open()) << ::dlerror();
  const Agreement agreement = compare<float>(all[0].model, 0, 100'000, loaded);
  EXPECT_GT(agreement.differing, 0);
  EXPECT_LT(agreement.largest_N, 2e-5 * agreement.force_N);
}

}  // namespace
}  // namespace slipstack
