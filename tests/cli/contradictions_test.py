# SPDX-License-Identifier: Apache-2.0
"""No two statements of one diagnosis contradict each other: over the shared measurements and simulated logs."""

import os
import pathlib
import re
import unittest

import program

DATA = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", program.REPOSITORY / ".." / "shared")) / "data"
LOGS = [f"hidden_effect/blind_{i}.csv" for i in range(1, 7)] + ["emps/emps_estimation.csv",
                                                                "tribometer/tribometer_loops.csv",
                                                                "odrive_cogging/odrive_0p1rev.csv"]
# A value with its unit in a sentence and without an interval: not the half width of "20.19 +- 0.25 N".
TOKEN = r"(?:[munk]?(?:N|m|s|Hz|kg|rad|A)\d?(?:/[a-z]+\d?)?|%)(?![\w/])"
FIGURE = re.compile(r"(?<!\+- )(?<![-\w.])-?\d[\d.]*(?:e-?\d+)? " + TOKEN + "(?: " + TOKEN + ")*")
SHOWN = 0.005  # reductions below it are not in the table


def error(of, kind="holdout"):
    """The error of a model or a step, of an axis in newtons or in newton metres."""
    return of[f"{kind}_rmse_N"] if f"{kind}_rmse_N" in of else of[f"{kind}_rmse_Nm"]


class Contradictions(program.Workshop):
    def diagnose(self, log, *options):
        done = program.run("diagnose", "--stepwise", *options, "--json", "found.json", str(log), cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.decode(), program.published(pathlib.Path(self.here, "found.json").read_text())

    def check(self, log, *options):
        text, found = self.diagnose(log, *options)
        candidates = found["candidates"]
        lowers = {one["effect"] for one in candidates if one["error_reduction"] >= SHOWN}
        steps = found["steps"]
        added = [step["effect"] for step in steps[1:]]
        with self.subTest(log=str(log)):
            # What lowers the error, and what explains the log, is nothing that the log cannot show.
            hidden = {one["effect"] for one in found["cannot_show"]}
            self.assertFalse(hidden & (lowers | set(added) | set(found["baseline_effects"])))
            # A verdict names the first step; without a verdict there is none.
            if found["verdict"] == "missing_effect":
                self.assertEqual(added[0], candidates[0]["effect"])
                self.assertIn("Missing: " + candidates[0]["title"], text)
            elif found["verdict"] == "complete":
                self.assertEqual(added, [])
                self.assertIsNone(found["unexplained"])
            else:
                self.assertIsNotNone(found["unexplained"])
            self.assertEqual(error(steps[0]), error(found["baseline"]))
            for before, after in zip(steps, steps[1:]):
                self.assertLess(error(after), error(before))
                # The log supports each step that is told upon those before it.
                self.assertLess(after["criterion_difference"], 0.0, after["effect"])
                self.assertNotIn("at its bound", after["evidence"])
                self.assertNotIn("at their bound", after["evidence"])
            # Every value of a sentence has its interval, and nothing at a bound is told of a step.
            for told in steps[1:] + candidates[:1] * bool(added):
                self.assertNotRegex(told["evidence"], FIGURE)
            # Each relation is stated from both sides, or not at all.
            by_id = {one["effect"]: one for one in candidates}
            for one in candidates:
                for other in one["confounded_with"]:
                    if by_id[other]["error_reduction"] >= 0.03 and one["error_reduction"] >= 0.03:
                        self.assertIn(one["effect"], by_id[other]["confounded_with"], (one["effect"], other))
            # Held out is never better than in sample by more than chance.
            for model in [found["baseline"]] + ([found["best"]] if "best" in found else []):
                self.assertGreaterEqual(error(model), 0.97 * error(model, "train"))
            # The table of effects alone falls with its error column.
            shares = [float(share) for share in re.findall(r"^\w+ +[\d.]+ \S+(?: \S+)? +(-?[\d.]+) % +[\d.]+ %",
                                                           text, re.MULTILINE)]
            self.assertEqual(shares, sorted(shares, reverse=True))

    def test_simulated_logs(self):
        for seed, hidden in enumerate(("", "viscous", "stribeck,force_ripple"), start=21):
            log = pathlib.Path(self.here, f"axis_{seed}.csv")
            effects = ["--effects", hidden] if hidden else []
            program.simulate(log, *effects, "--seconds", "15", "--rate", "1000", seed=seed)
            self.check(log)

    @program.long
    def test_measured_logs(self):
        logs = [DATA / name for name in LOGS if (DATA / name).is_file()]
        if not logs:
            self.skipTest(f"SKIP: no measurements in {DATA}; set SLIPSTACK_SHARED")
        for log in logs:
            self.check(log)
            if log.parent.name == "emps":  # four and more effects are missing then
                self.check(log, "--effects", "inertia")

    def test_baseline_that_the_log_chooses(self):
        log = pathlib.Path(self.here, "axis.csv")
        program.simulate(log, "--effects", "viscous", "--seconds", "10", "--rate", "1000", "--strength", "10", seed=3)
        text, found = self.diagnose(log, "--baseline", "auto")
        self.assertEqual(found["baseline_effects"], ["inertia", "presliding_hysteresis", "viscous"])
        self.assertIn("baseline   inertia, presliding_hysteresis, viscous", text)
        self.assertNotIn("--effects auto", text)

    def test_fit_that_only_shows(self):
        before = sorted(os.listdir(self.here))
        done = program.run("fit", "--effects", "inertia,coulomb", "good.csv", cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(b"not written", done.stdout)
        self.assertEqual(sorted(os.listdir(self.here)), before)


if __name__ == "__main__":
    program.main()
