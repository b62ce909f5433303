# SPDX-License-Identifier: Apache-2.0
"""What `fit` states is what `compare` finds: the errors are those of the model that was written.

Each log of the shared measurements with sets of effects that multiply each other, drawn at random from a fixed seed;
and a simulated log, so that the test runs where no measurements are.
"""

import os
import pathlib
import random
import unittest

import program

DATA = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", program.REPOSITORY / ".." / "shared")) / "data"
LOGS = [f"hidden_effect/blind_{i}.csv" for i in range(1, 7)] + ["emps/emps_estimation.csv",
                                                                "tribometer/tribometer_loops.csv"]
PLAIN = ["inertia", "presliding_hysteresis"]
MULTIPLY = ["position_dependent_preload", "direction_asymmetry", "motor_constant_ripple", "drift",
            "acceleration_dependent_preload"]
ADD = ["viscous", "coulomb", "offset_force", "cable_chain_stiffness", "quadratic_drag"]


class StatedErrors(program.Workshop):
    def check(self, log, effects):
        fit = program.run("fit", "--effects", ",".join(effects), "--model", "axis.toml", "--json", "fit.json", str(log),
                          cwd=self.here)
        self.assertEqual(fit.returncode, 0, fit.stderr)
        compare = program.run("compare", "--model", "axis.toml", "--json", "compare.json", str(log), cwd=self.here)
        self.assertEqual(compare.returncode, 0, compare.stderr)
        stated = program.published(pathlib.Path(self.here, "fit.json").read_text())
        found = program.published(pathlib.Path(self.here, "compare.json").read_text())
        with self.subTest(log=str(log), effects=effects):
            self.assertAlmostEqual(found["rmse_N"] / stated["train_rmse_N"], 1.0, delta=0.01)
            self.assertAlmostEqual(found["relative_error"] / stated["relative_error"], 1.0, delta=0.01)
            self.assertGreaterEqual(stated["holdout_rmse_N"], 0.97 * stated["train_rmse_N"])
            self.assertGreater(stated["forward_rmse_N"], 0.0)

    def test_simulated_log(self):
        log = pathlib.Path(self.here, "axis.csv")
        program.simulate(log, "--effects", "position_dependent_preload,direction_asymmetry", "--seconds", "20", seed=4)
        self.check(log, PLAIN + MULTIPLY[:2])

    @program.long
    def test_measured_logs(self):
        draw = random.Random(16)
        # One set for each log; half of the blind ones, which take longest.
        logs = [DATA / name for name in LOGS[1::2] + LOGS[6:7] if (DATA / name).is_file()]
        if not logs:
            self.skipTest(f"SKIP: no measurements in {DATA}; set SLIPSTACK_SHARED")
        for log in logs:
            self.check(log, PLAIN + draw.sample(MULTIPLY, 2) + draw.sample(ADD, 1))

    def test_tribometer_with_a_map_that_modulates_most_of_the_force(self):
        log = DATA / "tribometer/tribometer_loops.csv"
        if not log.is_file():
            self.skipTest(f"SKIP: {log} is not there; set SLIPSTACK_SHARED")
        self.check(log, ["presliding_hysteresis", "direction_asymmetry", "position_dependent_preload"])


if __name__ == "__main__":
    program.main()
