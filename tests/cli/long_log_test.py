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
        return json.loads(self.assert_done("diagnose", *arguments, "--json", "-").stdout)

    def test_is_searched_in_part_and_judged_as_a_whole(self):
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

    def test_is_told_and_reported(self):
        done = self.assert_done("diagnose", self.stock / "long.csv", "--report", "r.html")
        self.assertRegex(done.stdout.decode(), rf"excerpt +effects searched in \d+ stretches, \d+ of {self.samples} samples")
        self.assertIn(f"of {self.samples} samples; errors are those of all", (self.here / "r.html").read_text())

    def test_two_logs_are_told_one_by_one(self):
        program.simulate(self.here / "other.csv", "--effects", "viscous", "--seconds", "100", "--rate", "2000", seed=11)
        found = self.diagnosis(self.stock / "long.csv", "other.csv")
        self.assertEqual([log["samples"] for log in found["logs"]], [self.samples, samples_of(self.here / "other.csv")])
        self.assertEqual(found["candidates"][0]["effect"], "viscous")


if __name__ == "__main__":
    unittest.main()
