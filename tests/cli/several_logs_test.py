#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Several logs of one axis at once, and logs with faults of the recorder, as a user gives them."""

import json
import random
import unittest

import program

HEADER = 6


class SeveralLogs(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        program.simulate(cls.stock / "bare.csv", "--effects", "none", "--seconds", "12", "--rate", "1000", seed=6)
        program.simulate(cls.stock / "loaded.csv", "--effects", "payload_mass", "--seconds", "12", "--rate", "1000",
                         seed=5, truth=cls.stock / "loaded.json")
        cls.payload_kg = json.loads((cls.stock / "loaded.json").read_text())["parameters"]["payload_mass"]["mass_kg"]

    def take(self, *names):
        for name in names:
            (self.here / name).write_bytes((self.stock / name).read_bytes())

    def diagnosis(self, *arguments):
        return program.published(self.assert_done("diagnose", *arguments, "--json", "-").stdout)

    def test_a_payload_in_one_log_is_found_in_that_log(self):
        self.take("bare.csv", "loaded.csv")
        found = self.diagnosis("bare.csv", "loaded.csv")
        self.assertEqual(found["verdict"], "missing_effect")
        self.assertEqual(found["candidates"][0]["effect"], "payload_mass")
        self.assertEqual(found["log"], "bare.csv, loaded.csv")
        self.assertEqual([log["log"] for log in found["logs"]], ["bare.csv", "loaded.csv"])
        self.assertEqual(found["samples"], sum(log["samples"] for log in found["logs"]))
        for log in found["logs"]:
            self.assertLess(log["holdout_rmse_N"], 3.0 * log["noise_floor_N"])
        done = self.assert_done("fit", "bare.csv", "loaded.csv", "--effects",
                                "inertia,presliding_hysteresis,payload_mass", "--model", "m.toml", "--json", "-")
        effects = {one["effect"]: one["parameters"] for one in program.published(done.stdout)["parameters"]}
        masses = {one["log"]: one["value"] for one in effects["payload_mass"]}
        self.assertAlmostEqual(masses[1], 0.0, delta=0.05)
        self.assertAlmostEqual(masses[2], self.payload_kg, delta=0.03 * self.payload_kg)
        # The model file holds one set of parameters, for the controller; it can be used as any other.
        self.assert_done("compare", "bare.csv", "loaded.csv", "--model", "m.toml")

    def test_effects_with_gains_per_log_can_be_chosen(self):
        self.take("bare.csv", "loaded.csv")
        shared = self.diagnosis("bare.csv", "loaded.csv", "--per-log", "none")
        own = self.diagnosis("bare.csv", "loaded.csv", "--per-log", "payload_mass")
        error = {name: result["candidates"][0]["holdout_rmse_N"] for name, result in (("shared", shared), ("own", own))}
        self.assertGreater(error["shared"], 2.0 * error["own"])

    def test_refused_in_one_line(self):
        self.take("bare.csv", "loaded.csv")
        lines = (self.here / "bare.csv").read_text().splitlines(keepends=True)
        (self.here / "plain.csv").write_text("".join(line for line in lines if "mass_kg" not in line))
        self.assert_refused(["diagnose", "bare.csv", "bare.csv"], "named twice")
        self.assert_refused(["diagnose", "plain.csv", "loaded.csv"], "mass_kg")
        self.assert_refused(["diagnose", "bare.csv", "loaded.csv", "--per-log", "magic"], "unknown effect")
        self.assert_refused(["fit", "bare.csv", "loaded.csv", "--effects", "inertia", "--model", "loaded.csv"], "is an input")

    def test_noise_can_be_given(self):
        found = self.diagnosis("good.csv", "--noise", "0.25")
        self.assertEqual(found["noise"]["force_noise_N"], 0.25)
        self.assertIn("--noise", found["noise"]["method"])
        estimated = self.diagnosis("good.csv")
        self.assertIn("differences", estimated["noise"]["method"])
        self.assert_refused(["diagnose", "good.csv", "--noise", "-1"], "noise")

    def test_outliers_are_reported_and_change_nothing(self):
        clean = self.diagnosis("good.csv")
        self.assertEqual(clean["repaired"], [])
        lines = (self.here / "good.csv").read_text().splitlines()
        rows = random.Random(4).sample(range(HEADER + 50, len(lines) - 50), 12)
        for row in rows:
            time, position, _ = lines[row].split(",")
            lines[row] = f"{time},{position},{random.Random(row).choice((-900.0, 700.0))}"
        (self.here / "outliers.csv").write_text("\n".join(lines) + "\n")
        found = self.diagnosis("outliers.csv")
        self.assertIn("12 outliers of the force", found["repaired"][0]["what"])
        self.assertEqual(found["candidates"][0]["effect"], clean["candidates"][0]["effect"])
        self.assertAlmostEqual(found["candidates"][0]["holdout_rmse_N"], clean["candidates"][0]["holdout_rmse_N"],
                               delta=0.1 * clean["candidates"][0]["holdout_rmse_N"])


if __name__ == "__main__":
    program.main()
