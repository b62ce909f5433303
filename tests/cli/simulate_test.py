#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""slipstack simulate: a model that fits follows the measured position from the force alone; wrong use is one line."""

import unittest

import program
from program import BASELINE


class Simulate(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        program.simulate(cls.stock / "moved.csv", "--effects", "viscous", "--strength", "12", "--seconds", "20", "--rate",
                         "1000", "--closed-loop", seed=4)

    def simulated(self, model, *options):
        done = self.assert_done("simulate", model, *options, "--json", "-")
        return program.published(done.stdout)["summary"]

    def test_a_missing_effect_appears_in_the_position_too(self):
        log = self.stock / "moved.csv"
        self.assert_done("fit", log, "--effects", BASELINE, "--model", "base.toml")
        self.assert_done("fit", log, "--effects", BASELINE + ",viscous", "--model", "whole.toml")
        base = self.simulated("base.toml", "--log", log)
        whole = self.simulated("whole.toml", "--log", log, )
        self.assertLess(whole["rmse_m"], 0.5 * base["rmse_m"])
        self.assertGreater(whole["fit"], 0.8)
        short = self.simulated("whole.toml", "--log", log, "--start", "5", "--end", "8")
        self.assertAlmostEqual(short["duration_s"], 3.0, delta=0.01)

    def test_writes_the_motion_and_a_report(self):
        self.assert_done("simulate", "good.toml", "--log", "good.csv", "--out", "m.csv", "--report", "r.html")
        lines = (self.here / "m.csv").read_text().splitlines()
        self.assertEqual(lines[0], "time_s,position_m,measured_position_m")
        self.assertIn("Error of the position", (self.here / "r.html").read_text())

    def test_set_points_give_a_force(self):
        rows = [f"{i / 100},{0.1 + 1e-4 * i * i / 100}" for i in range(100)]
        (self.here / "s.csv").write_text("time_s,position_m\n" + "\n".join(rows) + "\n")
        found = self.simulated("good.toml", "--setpoints", "s.csv", "--out", "f.csv")
        # 35.45 kg at 0.02 m/s2, and the friction level that the baseline fits to 15 N and viscous friction.
        self.assertLess(found["peak_force_N"], 35.45 * 0.02 + 25.0)
        self.assertGreater(found["peak_force_N"], 5.0)

    def test_wrong_use(self):
        self.assert_refused(["simulate", "good.toml"], "--log", "--setpoints")
        self.assert_refused(["simulate", "good.toml", "--log", "good.csv", "--setpoints", "good.csv"], "either")
        self.assert_refused(["simulate", "good.toml", "--log", "good.csv", "--start", "9", "--end", "3"], "--start, --end")
        self.assert_refused(["simulate", "good.toml", "--log", "good.csv", "--start", "-1"], "negative")
        self.assert_refused(["simulate", "good.toml", "--setpoints", "none.csv"], "none.csv", "no such file")
        (self.here / "s.csv").write_text("time_s,position_m\n0,0\n1,x\n")
        self.assert_refused(["simulate", "good.toml", "--setpoints", "s.csv"], "s.csv:3", "position_m")
        self.assert_done("fit", "good.csv", "--effects", "viscous", "--model", "light.toml")
        self.assert_refused(["simulate", "light.toml", "--log", "good.csv"], "no mass")
        self.assert_refused(["simulate", "good.toml", "--log", "good.csv", "--json", "good.csv"], "good.csv")


if __name__ == "__main__":
    program.main()
