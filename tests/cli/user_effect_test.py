#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""User-defined effects on the command line: found, fitted, added, kept by the model, and refused with a caret."""

import json
import math
import os
import shutil
import subprocess
import unittest

import program
from program import BASELINE

SNAG = "snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]"


def hide_snag(source, target, level_N, place_m, width_m):
    """Adds dry friction over a short distance of the rail to the force of a log, by its recorded motion."""
    lines = source.read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("time_s"))
    rows = [[float(field) for field in line.split(",")] for line in lines[head + 1:]]
    written = lines[:head + 1]
    for i, (time_s, position_m, force_N) in enumerate(rows):
        before, after = rows[max(i - 3, 0)], rows[min(i + 3, len(rows) - 1)]
        velocity_mps = (after[1] - before[1]) / (after[0] - before[0])
        bump = math.exp(-((position_m - place_m) / width_m) ** 2)
        force_N += level_N * bump * math.tanh(velocity_mps / 2e-3)
        written.append(f"{time_s:.6f},{position_m:.9f},{force_N:.6f}")
    target.write_text("\n".join(written) + "\n")


class OwnEffect(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        program.simulate(cls.stock / "clean.csv", "--effects", "none", "--seconds", "20", "--rate", "1000", seed=3)
        hide_snag(cls.stock / "clean.csv", cls.stock / "snag.csv", 4.0, 0.21, 0.004)

    def succeed(self, *arguments):
        done = self.run_here(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        return done.stdout.decode()

    def test_is_named_first_and_takes_the_error_to_the_floor(self):
        result = program.published(self.succeed("diagnose", self.stock / "snag.csv", "--effect", SNAG, "--json", "-"))
        self.assertEqual(result["verdict"], "missing_effect")
        first = result["candidates"][0]
        self.assertEqual((first["effect"], first["definition"]), ("snag", SNAG))
        self.assertLess(result["best"]["holdout_rmse_N"], 1.2 * result["noise_floor_N"])
        self.assertGreater(result["baseline"]["holdout_rmse_N"], 2.0 * result["noise_floor_N"])

    def test_is_not_named_on_a_clean_log(self):
        result = program.published(self.succeed("diagnose", self.stock / "clean.csv", "--effect", SNAG, "--json", "-"))
        self.assertEqual(result["verdict"], "complete")

    def test_is_fitted_kept_and_compared(self):
        log = self.stock / "snag.csv"
        self.succeed("fit", log, "--effects", BASELINE, "--effect", SNAG, "--model", "one.toml")
        self.succeed("fit", log, "--effects", BASELINE, "--model", "base.toml")
        said = self.succeed("add", log, "--model", "base.toml", "--effect", SNAG, "--out", "two.toml", "--report", "r.html",
                            "--json", "added.json")
        self.assertRegex(said, r"controller snag as a table over position from \d+ mm to \d+ mm x direction")
        added = program.published((self.here / "added.json").read_text())
        tabulated = added["user_effects"][0]
        self.assertEqual((tabulated["effect"], tabulated["on_controller"], tabulated["over"]), ("snag", True, "position"))
        self.assertLess(tabulated["largest_error_N"], 0.01 * tabulated["peak_N"])
        self.assertLess(tabulated["from"], 0.205)
        self.assertGreater(tabulated["to"], 0.215)
        # The firmware runs it, in the same process, along a simulated motion.
        self.succeed("loop", "--model", "two.toml", "--seconds", "8", "--json", "loop.json")
        loop = json.loads((self.here / "loop.json").read_text())
        self.assertEqual(loop["model_hash"], added["hash"])
        self.assertIn("user_table", loop["last_force_by_effect_N"])
        self.assertIn("exp(-((x-x0)/w)^2)", (self.here / "r.html").read_text())
        floor_N = program.published(self.succeed("compare", log, "--model", "base.toml", "--json", "-"))["noise_floor_N"]
        for model in ("one.toml", "two.toml"):
            found = program.published(self.succeed("compare", log, "--model", model, "--json", "-"))
            self.assertIn("snag", found["effects"])
            self.assertLess(found["rmse_N"], 1.15 * floor_N)
        # A model with a user-defined effect can be a baseline like any other.
        result = program.published(self.succeed("diagnose", log, "--model", "two.toml", "--json", "-"))
        self.assertEqual(result["verdict"], "complete")
        self.assertIn("snag", result["baseline_effects"])

    def test_without_a_table_the_reason_is_reported(self):
        definition = "both = A*x*v; A: N s/m2"
        said = self.succeed("fit", self.stock / "snag.csv", "--effects", BASELINE, "--effect", definition, "--model", "b.toml",
                            "--json", "b.json")
        self.assertIn("controller without both: it follows position and speed at once", said)
        reported = program.published((self.here / "b.json").read_text())["user_effects"]
        self.assertEqual(reported, [{"effect": "both", "on_controller": False,
                                "why_not": "it follows position and speed at once"}])
        self.assertIn("left_out", (self.here / "b.toml").read_text())
        self.succeed("compare", self.stock / "snag.csv", "--model", "b.toml")
        self.assert_refused(["fit", "good.csv", "--effects", BASELINE + ",user_table", "--model", "new.toml"],
                            "unknown effect 'user_table'")

    def assert_caret(self, definition, marked, command=("diagnose", "good.csv", "--effect")):
        before = self.content()
        done = self.run_here(*command, definition)
        self.assertEqual(done.returncode, 2, done.stdout.decode())
        self.assertEqual(done.stdout, b"")
        lines = done.stderr.decode().splitlines()
        self.assertEqual(len(lines), 3, lines)
        self.assertTrue(lines[0].startswith("slipstack: --effect: "), lines)
        self.assertEqual(lines[1], "  " + definition)
        self.assertEqual(lines[2].index("^") - 2, marked, lines)
        self.assertEqual(self.content(), before)

    def test_a_caret_stands_under_the_error(self):
        for definition, wrong in ((SNAG.replace("sign", "sing"), "sing"), (SNAG.replace("v)", "v"), "(v"),
                                  (SNAG.replace("A: N", "A: lbf"), "lbf"),
                                  (SNAG.replace("[1e-4, 1e-2]", "[1e-2, 1e-4]"), "1e-2, 1e-4"),
                                  (SNAG + "; B: N", "B: N"), (SNAG.replace("A*", "A^2*"), "A^2")):
            with self.subTest(definition):
                self.assert_caret(definition, definition.index(wrong))
        self.assert_caret("viscous = A*v; A: N s/m", 0)
        self.assert_caret("snag = A*; A: N", 9, ("add", "good.csv", "--model", "good.toml", "--out", "new.toml", "--effect"))
        self.assert_caret("snag = A*; A: N", 9, ("fit", "good.csv", "--effects", BASELINE, "--model", "new.toml",
                                                 "--effect"))

    def test_a_name_alone_is_no_definition(self):
        self.assert_refused(["diagnose", "good.csv", "--effect", "viscous"], "defines no effect")
        self.assert_refused(["diagnose", "good.csv", "--effect", SNAG, "--effect", SNAG], "given twice")

    def test_a_value_that_is_not_finite_is_refused(self):
        self.assert_caret("deep = A*ln(x - 10); A: N", 7)
        self.assert_refused(["diagnose", "good.csv", "--effect", "far = A*ln(x + 10) + B*ln(x - 0.1); A: N; B: N"],
                            "effect 'far' is not a finite number at t = ")

    def test_a_header_compiles_and_computes_the_same(self):
        definition = ("odd_one = A*exp(-((x-x0)/w)^2)*sign(v) + B*(v > vs ? tanh(v/vs) : -v^3) + C*min(cos(2*pi*x/p), a, -x^0.5); "
                      "A: N; B: N; C: N; x0: m; w: m in [1e-4, 1e-2]; vs: m/s in [1e-3, 1]; p: m in [1e-3, 1]")
        self.succeed("effects", "--effect", definition, "--header", "odd_one.h")
        (self.here / "main.cpp").write_text('''
#include <cmath>
#include <cstdio>
#include "odd_one.h"
using slipstack::OddOne;
static_assert(slipstack::Effect<OddOne<float>, float> && slipstack::Effect<OddOne<double>, double>);
static_assert(slipstack::complete(OddOne<float>::text));
int main() {
  OddOne<double> effect;
  const double shape[4] = {0.2, 0.004, 0.05, 0.02};
  effect.prepare(shape, {});
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double x = 0.19 + 1e-5 * i, v = 0.2 * std::sin(0.37 * i), a = 2.0 * std::cos(0.11 * i);
    double out[3];
    effect.basis({.time_s = 0.1 * i, .displacement = x, .position_m = x, .velocity_mps = v, .acceleration_mps2 = a}, out);
    const double u = (x - 0.2) / 0.004;
    const double expected[3] = {std::exp(-u * u) * ((v > 0) - (v < 0)), v > 0.05 ? std::tanh(v / 0.05) : -v * v * v,
                                std::fmin(std::fmin(std::cos(2 * M_PI * x / 0.02), a), -std::sqrt(x))};
    for (int g = 0; g < 3; ++g) worst = std::fmax(worst, std::fabs(out[g] - expected[g]));
  }
  std::printf("%.3g", worst);
}
''')
        compiler = os.environ.get("CXX", "c++")
        flags = ["-std=c++20", "-Wall", "-Wextra", "-Wdouble-promotion", "-Werror", "-ffp-contract=off",
                 f"-I{program.REPOSITORY}", "-I."]
        built = subprocess.run([compiler, *flags, "main.cpp", "-o", "main"], cwd=self.here, capture_output=True)
        self.assertEqual(built.returncode, 0, built.stderr.decode())
        worst = float(subprocess.run(["./main"], cwd=self.here, capture_output=True, check=True).stdout)
        self.assertLess(worst, 1e-7)
        if cross := shutil.which("arm-none-eabi-g++"):
            (self.here / "target.cpp").write_text('#include "odd_one.h"\ntemplate class slipstack::OddOne<float>;\n')
            built = subprocess.run([cross, *flags, "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard", "-O2",
                                    "-fno-exceptions", "-fno-rtti", "-c", "target.cpp", "-o", "target.o"],
                                   cwd=self.here, capture_output=True)
            self.assertEqual(built.returncode, 0, built.stderr.decode())
            # No function of the C library is called: no symbol is undefined.
            names = subprocess.run(["arm-none-eabi-nm", "-u", "target.o"], cwd=self.here, capture_output=True, check=True)
            for forbidden in (b" exp", b" pow", b" sin", b" tanh"):
                self.assertNotIn(forbidden, names.stdout)

    def test_what_the_controller_cannot_compute_has_no_header(self):
        definition = "bent = A*atan(x/w); A: N; w: m in [1e-3, 1]"
        self.assert_caret(definition, definition.index("atan"), ("effects", "--header", "new.h", "--effect"))


if __name__ == "__main__":
    program.main()
