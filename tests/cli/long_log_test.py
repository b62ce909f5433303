#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A log too long to be searched whole, as a user gives it."""

import json
import resource
import unittest

import program

HEADER = 6
MOST_MB = 300


def samples_of(log):
    return len(log.read_bytes().splitlines()) - HEADER


class LongLog(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        program.simulate(cls.stock / "long.csv", "--effects", "viscous", "--seconds", "200", "--rate", "2000", seed=11)
        cls.samples = samples_of(cls.stock / "long.csv")

    def diagnosis(self, *arguments):
        return program.published(self.assert_done("diagnose", *arguments, "--json", "-").stdout)

    def test_is_searched_in_an_excerpt_and_judged_by_the_whole(self):
        found = self.diagnosis(self.stock / "long.csv")
        self.assertEqual(found["samples"], self.samples)
        self.assertGreater(found["searched_samples"], 20_000)
        self.assertLess(found["searched_samples"], 300_000)
        self.assertEqual(found["verdict"], "missing_effect")
        self.assertEqual(found["candidates"][0]["effect"], "viscous")
        self.assertLess(found["candidates"][0]["holdout_rmse_N"], 1.4 * found["noise_floor_N"])
        low, high = found["best"]["holdout_interval_N"]
        self.assertLess(low, found["best"]["holdout_rmse_N"])
        self.assertGreater(high, found["best"]["holdout_rmse_N"])
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, MOST_MB * 1024)

    def test_excerpt_is_named_in_text_and_report(self):
        done = self.assert_done("diagnose", self.stock / "long.csv", "--report", "r.html")
        self.assertRegex(done.stdout.decode(), rf"excerpt +effects searched in \d+ intervals, \d+ of {self.samples} samples")
        self.assertIn(f"of {self.samples} samples; errors are those of all", (self.here / "r.html").read_text())

    @program.long
    def test_two_logs_are_reported_one_by_one(self):
        program.simulate(self.here / "other.csv", "--effects", "viscous", "--seconds", "100", "--rate", "2000", seed=11)
        found = self.diagnosis(self.stock / "long.csv", "other.csv")
        self.assertEqual([log["samples"] for log in found["logs"]], [self.samples, samples_of(self.here / "other.csv")])
        self.assertEqual(found["candidates"][0]["effect"], "viscous")
        # Errors are those of the whole logs, the held-out ones too.
        for log in found["logs"]:
            self.assertGreater(log["holdout_rmse_N"], 0.99 * log["rmse_N"])
            self.assertLess(log["holdout_rmse_N"], 1.5 * log["rmse_N"])

    @program.long
    def test_fit_compare_and_add_use_the_whole_log_too(self):
        log = self.stock / "long.csv"
        fitted = self.answer("fit", log, "--effects", program.BASELINE + ",viscous", "--model", "m.toml")
        compared = self.answer("compare", log, "--model", "m.toml")
        self.assertAlmostEqual(compared["relative_error"] / fitted["relative_error"], 1.0, delta=0.01)
        self.assertGreater(compared["rmse_N"], 0.99 * fitted["train_rmse_N"])
        self.assertLess(compared["rmse_N"], 1.3 * fitted["train_rmse_N"])  # Huber's loss limits outliers in a fit
        # A model without viscous friction has a larger error, in the whole log as in the excerpt.
        self.answer("fit", log, "--effects", program.BASELINE, "--model", "poor.toml")
        poor = self.answer("compare", log, "--model", "poor.toml")
        self.assertGreater(poor["rmse_N"], 3.0 * compared["rmse_N"])
        added = self.answer("add", log, "--model", "poor.toml", "--effect", "viscous", "--out", "better.toml")
        self.assertAlmostEqual(added["before"]["holdout_rmse_N"] / poor["rmse_N"], 1.0, delta=0.03)
        self.assertAlmostEqual(added["holdout_rmse_N"] / compared["rmse_N"], 1.0, delta=0.05)
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, MOST_MB * 1024)

    @program.long
    def test_a_plan_uses_the_travel_of_the_whole_log(self):
        found = json.loads(self.assert_done("experiment", "plan", "--log", self.stock / "long.csv", "--for", "stribeck,frictional_lag", "--seconds", "120",
                                            "--out", "plan.csv", "--json", "-").stdout)
        rows = (self.stock / "long.csv").read_text().splitlines()[HEADER:]
        position_m = [float(row.split(",")[1]) for row in rows]
        self.assertAlmostEqual(found["summary"]["limits"]["low_m"], min(position_m), delta=1e-6)
        self.assertAlmostEqual(found["summary"]["limits"]["high_m"], max(position_m), delta=1e-6)
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, MOST_MB * 1024)

    def answer(self, *arguments):
        found = program.published(self.assert_done(*arguments, "--json", "-").stdout)
        self.assertEqual(found["samples"], self.samples)
        self.assertGreater(found["searched_samples"], 20_000)
        self.assertLess(found["searched_samples"], 300_000)
        return found


if __name__ == "__main__":
    program.main()
