#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`slipstack experiment` characterize and guideway on logs that are written here from closed forms."""

import math
import pathlib
import shutil
import tempfile
import unittest

from program import published, run

LEVEL_N = 0.35
LENGTH_M = 3e-6
HEADER = {"load_per_ball_N": 54, "groove_angle_deg": 90, "ball_diameter_m": 6e-3, "balls": 2}


def virgin(x, level=LEVEL_N, length=LENGTH_M):
    return level * (1 - (length / (x + length)) ** 2)


def masing_log(path, amplitudes, level=LEVEL_N, length=LENGTH_M, header=HEADER):
    """Twelve cosines of each amplitude with the force of Masing's rules."""
    lines = [f"# {key}: {value}" for key, value in header.items()] + ["time_s,position_m,force_N"]
    count = 0
    for amplitude in amplitudes:
        for i in range(12 * 400):
            phase = 2 * math.pi * i / 400
            x = -amplitude * math.cos(phase)
            tip = virgin(amplitude, level, length)
            if math.sin(phase) >= 0:
                force = -tip + 2 * virgin((x + amplitude) / 2, level, length)
            else:
                force = tip - 2 * virgin((amplitude - x) / 2, level, length)
            lines.append(f"{count * 1e-3:.3f},{x:.12e},{force:.12e}")
            count += 1
    path.write_text("\n".join(lines) + "\n")


class HysteresisExperiments(unittest.TestCase):
    def setUp(self):
        self.here = pathlib.Path(tempfile.mkdtemp(prefix="slipstack-test-"))
        self.addCleanup(shutil.rmtree, self.here)

    def result(self, *arguments):
        done = run("experiment", *arguments, "--json", "-", cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        return published(done.stdout)

    def refused(self, *arguments):
        done = run("experiment", *arguments, "--report", "r.html", "--json", "r.json", cwd=self.here)
        self.assertEqual(done.returncode, 2, done.stdout.decode())
        message = done.stderr.decode()
        self.assertEqual(message.count("\n"), 1, message)
        self.assertEqual(sorted(p.name for p in self.here.glob("r.*")), [])
        return message

    def test_characterize_finds_the_closed_forms_in_a_log(self):
        amplitudes = [1e-6, 3e-6, 10e-6]
        masing_log(self.here / "loops.csv", amplitudes)
        found = self.result("characterize", "loops.csv", "--report", "r.html")
        self.assertGreater((self.here / "r.html").stat().st_size, 20000)
        self.assertEqual(len(found["loops"]), 3)
        for loop, A in zip(found["loops"], amplitudes):
            zeta = 2 / math.pi * A / (A + 2 * LENGTH_M)
            self.assertAlmostEqual(loop["damping_ratio"] / zeta, 1, delta=0.01)
            self.assertAlmostEqual(loop["stiffness_N_per_m"] / (virgin(A) / A), 1, delta=1e-3)
            self.assertAlmostEqual(loop["closed_damping_ratio"] / zeta, 1, delta=0.005)
        self.assertAlmostEqual(found["summary"]["length_m"] / LENGTH_M, 1, delta=0.01)

    def test_characterize_simulates_what_the_paper_saw(self):
        found = self.result("characterize")["summary"]
        self.assertLess(found["damping_ratio_spread_over_preloads"], 0.02)
        self.assertGreater(found["loop_spread"], 0.2)
        self.assertLess(found["loop_spread_scaled"], 0.01)
        typical = {round(l["amplitude_m"] * 1e6): l["damping_ratio"] for l in self.result("characterize", "--typical")["loops"]}
        for amplitude, ratio in {1: 0.021, 2: 0.03, 10: 0.06}.items():
            self.assertAlmostEqual(typical[amplitude], ratio, delta=0.001)

    def test_guideway_predicts_the_scaled_loop(self):
        masing_log(self.here / "loops.csv", [20e-6])
        found = self.result("guideway", "loops.csv", "--to-load-N", "13.5", "--to-groove-angle-deg", "60",
                            "--to-ball-diameter-m", "1.5e-3", "--to-balls", "6")
        # sqrt(1/4) for load, 1/(1/2) for sin^2, 3 for balls; sqrt(1/4)*1/2 for displacement.
        self.assertAlmostEqual(found["summary"]["force_factor"], 3.0, delta=1e-9)
        self.assertAlmostEqual(found["summary"]["displacement_factor"], 0.25, delta=1e-9)
        k0 = 2 * 3.0 * LEVEL_N / (0.25 * LENGTH_M)
        self.assertAlmostEqual(found["summary"]["initial_stiffness_N_per_m"] / k0, 1, delta=0.1)
        predicted = found["guideways"][1]
        self.assertAlmostEqual(predicted["amplitude_m"], 5e-6, delta=5e-9)
        zeta = 2 / math.pi * 20 / (20 + 6)
        self.assertAlmostEqual(predicted["damping_ratio"], zeta, delta=0.005)

    def test_transducer_corrects_a_log_and_its_repetition(self):
        for seed, name in (("3", "a.csv"), ("4", "b.csv")):
            self.assertEqual(run("experiment", "transducer", "--seed", seed, "--write-log", name,
                                 cwd=self.here).returncode, 0)
        for logs in (("a.csv",), ("a.csv", "b.csv"), ()):
            found = self.result("transducer", *logs)["summary"]
            self.assertAlmostEqual(found["hysteresis_mV_per_V"], 1.5e-4, delta=1e-5)
            self.assertLess(found["formula_share"], 1 / 3)
            self.assertGreater(found["formula_share"], 0.1)
            self.assertLess(found["least_squares_share"], 0.5 * found["formula_share"])
            self.assertLess(found["uncertainty_formula_N"], found["uncertainty_before_N"] / 3)

    def test_transducer_refuses_a_malformed_log(self):
        self.assertEqual(run("experiment", "transducer", "--write-log", "a.csv", cwd=self.here).returncode, 0)
        good = (self.here / "a.csv").read_text().splitlines()

        def spoiled(change):
            rows = list(good)
            change(rows)
            (self.here / "bad.csv").write_text("\n".join(rows) + "\n")
            return self.refused("transducer", "bad.csv")

        self.assertIn("signal_mV_per_V", spoiled(lambda r: r.__setitem__(1, "time_s,load_N,volts")))
        self.assertIn("bad.csv:6", spoiled(lambda r: r.__setitem__(5, "1,2")))
        self.assertIn("bad.csv:6", spoiled(lambda r: r.__setitem__(5, r[5].replace(",", ",x", 1))))
        self.assertIn("negative", spoiled(lambda r: r.__setitem__(12, r[12].replace(",", ",-", 1))))
        self.assertIn("zero load", spoiled(lambda r: r.pop()))
        self.assertIn("time does not rise", spoiled(lambda r: r.__setitem__(9, r[8])))
        self.assertIn("without a header row", spoiled(lambda r: r.clear()))
        self.assertIn("no load steps", spoiled(lambda r: r.__delitem__(slice(2, None))))
        self.assertIn("no transducer", self.refused("transducer", "--setup", "slideway"))
        self.assertIn("nothing.csv", self.refused("transducer", "nothing.csv"))

    def test_models_side_by_side(self):
        found = self.result("models", "--report", "m.html")
        self.assertGreater((self.here / "m.html").stat().st_size, 20000)
        models = {m["model"]: m for m in found["models"]}
        self.assertEqual(len(models), 6)
        self.assertEqual(found["summary"]["returning"], ["gms", "maxwell-slip"])
        self.assertLess(models["maxwell-slip"]["held_out_error"], 0.01)
        for name in ("dahl", "lugre", "bouc-wen"):
            self.assertGreater(models[name]["return_error"], 0.05)
            self.assertGreater(models[name]["relative_error"], 5 * models["maxwell-slip"]["relative_error"])
        masing_log(self.here / "loops.csv", [10e-6])
        measured = {m["model"]: m["relative_error"] for m in self.result("models", "loops.csv")["models"]}
        self.assertLess(measured["maxwell-slip"], 0.05)
        self.assertLess(measured["maxwell-slip"], measured["dahl"])
        self.assertIn("nothing.csv", self.refused("models", "nothing.csv"))
        self.assertIn("transducer", self.refused("models", "--setup", "transducer"))

    def test_what_cannot_be_used_is_said_in_one_line(self):
        masing_log(self.here / "loops.csv", [10e-6])
        masing_log(self.here / "bare.csv", [10e-6], header={})
        (self.here / "line.csv").write_text("time_s,position_m,force_N\n" + "".join(
            f"{i * 1e-3:.3f},{i * 1e-6:.6f},{i * 0.1:.3f}\n" for i in range(300)))
        rows = (self.here / "loops.csv").read_text().splitlines()
        # A curve that is not concave: the same loop, force cubed within the loop's height.
        cubed = [r if not r[0].isdigit() else
                 ",".join(r.split(",")[:2] + [f"{float(r.split(',')[1]) ** 5 * 1e26 + (1e-3 if i % 400 < 200 else -1e-3):.9e}"])
                 for i, r in enumerate(rows, -5)]
        (self.here / "cubed.csv").write_text("\n".join(cubed) + "\n")
        self.assertIn("line.csv", self.refused("characterize", "line.csv"))
        self.assertIn("positive", self.refused("characterize", "--preloads", "1,-2"))
        self.assertIn("load_per_ball_N", self.refused("guideway", "bare.csv"))
        self.assertIn("concave", self.refused("guideway", "cubed.csv"))
        self.assertIn("load", self.refused("guideway", "loops.csv", "--to-load-N", "-3"))
        self.assertIn("angle", self.refused("guideway", "loops.csv", "--to-groove-angle-deg", "270"))
        self.assertIn("wood", self.refused("guideway", "loops.csv", "--to-material", "wood"))
        self.assertIn("nothing.csv", self.refused("guideway", "nothing.csv"))


if __name__ == "__main__":
    unittest.main()
