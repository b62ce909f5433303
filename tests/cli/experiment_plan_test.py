#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""slipstack experiment plan: the planned motion resolves what the first log could not, on an axis that shares no code."""

import os
import pathlib
import re
import shlex
import shutil
import unittest

import program

AXIS = ("--effects", "frictional_lag", "--strength", "1")  # of twice the strength the slow motion tells lag from Stribeck
SEED = 11
ALLOWED = "velocity=0.3,acceleration=4,jerk=200,force=400"
DATA = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", program.REPOSITORY / ".." / "shared")) / "data"


def poor_motion(path, rate_Hz=1000):
    """Slow traverses by the quintic: they excite the dependence of friction on velocity, but not its memory."""
    rows = []
    position_m, time_s = 0.1, 0.0

    def put(x_m):
        nonlocal time_s
        rows.append(f"{time_s:.6f},{x_m:.12f}")
        time_s += 1 / rate_Hz

    def rest(seconds):
        for _ in range(int(seconds * rate_Hz)):
            put(position_m)

    rest(0.3)
    for distance_m, seconds in ((2e-4, 2.0), (0.02, 5.0), (0.15, 8.0), (0.05, 6.0)):
        for way in (1, -1):
            start_m, count = position_m, int(seconds * rate_Hz)
            for i in range(count):
                u = i / count
                put(start_m + way * distance_m * u ** 3 * (10 - 15 * u + 6 * u * u))
            position_m = start_m + way * distance_m
            rest(0.2)
    path.write_text("time_s,position_m\n" + "\n".join(rows) + "\n")


class Plan(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        poor_motion(cls.stock / "poor.csv")
        cls.record("poor.csv", "first.csv")

    @classmethod
    def record(cls, motion, log):
        program.simulate(cls.stock / log, *AXIS, "--setpoints", str(cls.stock / motion), seed=SEED)

    def diagnosed(self, log):
        return program.published(self.assert_done("diagnose", log, "--json", "-").stdout)

    @staticmethod
    def pairs(result):
        return {frozenset((pair["effect"], pair["other"])) for pair in result["cannot_separate"]}

    def test_the_planned_motion_separates_what_the_first_log_could_not(self):
        first = self.diagnosed(self.stock / "first.csv")
        confused = frozenset(("stribeck", "frictional_lag"))
        self.assertIn(confused, self.pairs(first))
        self.assertIsNotNone(first["next_experiment"])
        done = self.assert_done("experiment", "plan", "--log", self.stock / "first.csv", "--for", "stribeck,frictional_lag",
                                "--seconds", "40", "--limits", ALLOWED, "--out",
                                self.stock / "plan.csv", "--json", "-")
        expected = {(row["effect"], row["other"]): row for row in program.published(done.stdout)["evidence"]}
        lag = expected[("frictional_lag", "stribeck")]
        self.assertGreater(lag["evidence"], 3 * max(lag["log_evidence"], 1))
        self.record("plan.csv", "second.csv")
        second = self.diagnosed(self.stock / "second.csv")
        self.assertEqual(second["verdict"], "missing_effect")
        self.assertEqual(second["candidates"][0]["effect"], "frictional_lag")
        self.assertNotIn("stribeck", second["candidates"][0]["confounded_with"])
        self.assertNotIn(confused, self.pairs(second))

    @program.long
    def test_the_proposed_command_runs_with_more_than_the_log_did(self):
        shutil.copy(self.stock / "first.csv", self.here / "first.csv")
        words = shlex.split(self.diagnosed("first.csv")["next_experiment"]["command"])
        self.assertEqual(words[:3], ["slipstack", "experiment", "plan"])
        # Within what this slow log did, no motion shows more than it did.
        self.assert_refused(words[1:], "less evidence")
        self.assert_done(*words[1:], "--limits", ALLOWED)
        self.assertTrue((self.here / "setpoints.csv").read_text().startswith("# what: set points"))

    def test_limits_are_kept(self):
        done = self.assert_done("experiment", "plan", "--for", "viscous,quadratic_drag", "--seconds", "15", "--limits",
                                "stroke=0.1:0.3,velocity=0.2,acceleration=1,jerk=40,force=60", "--out", "s.csv", "--json", "-")
        summary = program.published(done.stdout)["summary"]
        for key, limit in (("velocity_mps", 0.2), ("acceleration_mps2", 1), ("jerk_mps3", 41), ("force_N", 60)):
            self.assertLessEqual(summary[key], limit)
        rows = [list(map(float, line.split(","))) for line in (self.here / "s.csv").read_text().splitlines()[4:]]
        self.assertTrue(all(0.1 <= row[1] <= 0.3 and abs(row[2]) <= 0.2 and abs(row[3]) <= 1 for row in rows))
        self.assertLessEqual(rows[-1][0], 15)

    QUANTITIES = ("velocity_mps", "acceleration_mps2", "jerk_mps3", "force_N")

    def assert_no_more_than_the_log(self, *plan):
        """Or a refusal that says why; returns whether there is a plan."""
        done = self.run_here("experiment", "plan", *plan, "--out", "s.csv", "--json", "-")
        if done.returncode == 2:
            self.assertRegex(done.stderr.decode(), "less evidence|no motion|above its noise|shows these effects")
            return False
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = program.published(done.stdout)["summary"]
        unit = {key: key for key in self.QUANTITIES}
        if "velocity_radps" in summary:
            unit = dict(zip(self.QUANTITIES, ("velocity_radps", "acceleration_radps2", "jerk_radps3", "torque_Nm")))
        for key in unit.values():
            self.assertLessEqual(summary[key], summary["log"][key], key)
            self.assertEqual(summary["limits"][key], summary["log"][key], key)
        place = "rad" if "low_rad" in summary else "m"
        self.assertGreaterEqual(summary[f"low_{place}"], summary["log"][f"low_{place}"])
        self.assertLessEqual(summary[f"high_{place}"], summary["log"][f"high_{place}"])
        return True

    @program.long
    def test_no_plan_asks_for_more_than_the_log_did(self):
        self.assert_no_more_than_the_log("--for", "stribeck,viscous", "--log", self.stock / "first.csv")
        planned = 0
        for name in ("emps/emps_estimation", "tribometer/tribometer_loops", "odrive_cogging/odrive_0p1rev",
                     "hidden_effect/blind_1", "hidden_effect/blind_4"):
            log = DATA / f"{name}.csv"
            if not log.exists():
                print(f"SKIP {log}")
                continue
            with self.subTest(name):
                planned += self.assert_no_more_than_the_log("--for", "stribeck,viscous", "--log", log, "--seconds", "30")
        self.assertGreater(planned, 0)

    def test_log_limit_and_plan_stand_side_by_side(self):
        done = self.assert_done("experiment", "plan", "--for", "stribeck,frictional_lag", "--log", self.stock / "first.csv",
                                "--out", "s.csv", "--limits", ALLOWED, "--report",
                                "r.html")
        text = done.stdout.decode()
        table = text.split("Log and plan\n")[1].split("\n\n")[0].splitlines()
        self.assertEqual(table[0].split(), ["log", "limit", "plan", "unit"])
        self.assertEqual(len({line.rindex(line.split()[-1]) for line in table}), 1, "columns are not aligned")
        self.assertEqual(table[3].split()[2], "0.3")
        for line in table[1:]:
            self.assertRegex(line, r"\d .*(m|m/s|m/s2|m/s3|N)$", "a figure without its unit")
        measured_N, model_N = (float(re.search(rf"^ *force, {which} +(\S+)", text, re.M)[1])
                               for which in ("measured", "by the model"))
        rows = [line.split(",") for line in (self.stock / "first.csv").read_text().splitlines() if not line.startswith("#")]
        at = next(i for i, name in enumerate(rows[0]) if name.startswith(("force", "current")))
        forces_N = [abs(float(row[at])) for row in rows[1:]]
        self.assertLessEqual(measured_N, max(forces_N))
        self.assertGreater(measured_N, 0.5 * max(forces_N))
        self.assertGreater(model_N, 0)
        self.assertIn("Log and plan", (self.here / "r.html").read_text())

    def test_a_plan_that_shows_less_than_the_log_is_not_written(self):
        self.assert_refused(["experiment", "plan", "--for", "viscous", "--log", self.stock / "first.csv", "--seconds", "20",
                             "--limits", "velocity=0.01", "--out", "s.csv"], "less evidence")
        self.assertFalse((self.here / "s.csv").exists())

    @program.long
    def test_several_logs_and_a_limit_of_the_current(self):
        text = (self.stock / "first.csv").read_text()
        constant = float(re.search(r"# motor_constant_N_per_A: (\S+)", text)[1])
        for name in ("one.csv", "two.csv"):
            (self.here / name).write_text(text)
        (self.here / "bare.csv").write_text(re.sub(r"# motor_constant.*\n", "", text))
        plan = ["experiment", "plan", "--for", "stribeck,viscous", "--seconds", "20", "--out", "s.csv", "--json", "-", "--log"]
        single = program.published(self.assert_done(*plan, "one.csv", "--limits", ALLOWED).stdout)
        double = program.published(self.assert_done(*plan, "one.csv", "two.csv", "--limits", f"velocity=0.3,acceleration=1,jerk=50,current={60 / constant}").stdout)
        self.assertAlmostEqual(double["summary"]["limits"]["force_N"], 60, places=4)
        self.assertLessEqual(double["summary"]["force_N"], 60)
        # A copy of a log is no further evidence: what the form of a model leaves of it is the same.
        key = [(row["effect"], row["other"]) for row in single["evidence"]].index(("viscous", "nothing"))
        ratio = double["evidence"][key]["log_evidence"] / single["evidence"][key]["log_evidence"]
        self.assertGreater(ratio, 0.5)
        self.assertLess(ratio, 1.5)
        self.assert_refused(["experiment", "plan", "--for", "viscous", "--log", "bare.csv", "--limits", "current=2", "--out",
                             "s.csv"],
                            "motor constant")
        # The command that diagnose proposes names all logs.
        result = program.published(self.assert_done("diagnose", "one.csv", "two.csv", "--json", "-").stdout)
        if result["next_experiment"]:
            self.assertIn("--log 'one.csv' 'two.csv'", result["next_experiment"]["command"])

    def test_wrong_use(self):
        plan = ["experiment", "plan", "--out", "s.csv"]
        self.assert_refused([*plan, "--for", "viscous"], "--limits: stroke is missing")
        self.assert_refused([*plan, "--for", "nothing", "--log", "good.csv"], "unknown effect")
        self.assert_refused([*plan, "--for", "time_delay", "--log", "good.csv"], "no experiment can be planned")
        for limits, told in (("speed=1", "'speed=1' is none of"), ("velocity=fast", "not a number"),
                             ("velocity=-1", "one positive number"), ("stroke=0.3:0.1", "low below high")):
            self.assert_refused([*plan, "--for", "viscous", "--log", "good.csv", "--limits", limits], told)
        self.assert_refused([*plan, "--for", "viscous", "--log", "good.csv", "--seconds", "1"], "--seconds")
        self.assert_refused([*plan, "--for", "viscous", "--log", "good.csv", "--limits", "force=0.1"], "no motion fits")


if __name__ == "__main__":
    program.main()
