#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The keys, types and order that `--json` promises (docs/json.md), checked on every verdict."""

import json
import math
import unittest

import program

DIAGNOSIS = {"schema": str, "discrepancy_N": float, "cannot_show": list, "cannot_separate": list, "next_experiment": (dict, type(None)), "noise": dict,
             "repaired": list, "input_warnings": list, "log": str, "samples": int, "searched_samples": int,
             "baseline_effects": list, "noise_floor_N": float, "bandwidth_Hz": float, "baseline": dict,
             "verdict": str, "candidates": list, "parameters": list, "converged": bool, "unexplained": (dict, type(None))}
CANDIDATE = {"effect": str, "title": str, "holdout_rmse_N": float, "error_reduction": float,
             "error_reduction_se": float, "criterion_difference": float, "confounded_with": list, "evidence": str, "refusal": str, "cause": str, "confirm_with": str}
QUALITY = {"train_rmse_N": float, "holdout_rmse_N": float, "forward_rmse_N": float, "relative_error": float}


def effects_of_help(text):
    return [line.split()[0] for line in text.split("Effects:\n")[1].split("\n\n")[0].splitlines()]


class Contract(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, effects in {"none": "none", "one": "viscous", "two": "viscous,force_ripple"}.items():
            program.small_log(cls.stock / f"{name}.csv", effects)
        program.simulate(cls.stock / "outside.csv", "--outside", "burst", "--seconds", "8", "--rate", "500")

    def result(self, *arguments):
        done = self.assert_done(*arguments, "--json", "-")

        def not_a_number(text):
            self.fail(f"{text} in JSON")
        return program.published(done.stdout, parse_constant=not_a_number)

    def test_schemas_are_checked(self):
        """What a schema forbids is found: a key too many, one too few, a wrong type, another version."""
        if program.schema_library() is None:
            self.skipTest("jsonschema is not installed (python3-jsonschema; toolchain/install test)")
        good = self.result("compare", "good.csv", "--model", "good.toml")
        for change in ({"new": 1}, {"rmse_N": "1"}, {"hash": "123"}, {"axis": "bent"}):
            with self.assertRaises(AssertionError, msg=change):
                program.published(json.dumps({**good, **change}))
        for key in good:
            with self.assertRaises((AssertionError, KeyError), msg=key):
                program.published(json.dumps({k: v for k, v in good.items() if k != key}))
        with self.assertRaises(FileNotFoundError):
            program.published(json.dumps({**good, "schema": "urn:slipstack:compare-0"}))

    def assert_keys(self, value, wanted, also=()):
        self.assertEqual(set(value), set(wanted) | set(also))
        for key, kind in wanted.items():
            self.assertIsInstance(value[key], kind, key)
            if kind is float:
                self.assertTrue(math.isfinite(value[key]), key)

    def known_effects(self):
        return effects_of_help(self.assert_done("diagnose", "--help").stdout.decode())

    def check_diagnosis(self, result, baseline, stepwise):
        found = result["verdict"] == "missing_effect"
        self.assert_keys(result, DIAGNOSIS, also=[*(["steps"] if stepwise else []), *(["best"] if found else [])])
        self.assertIn(result["verdict"], ("missing_effect", "complete", "unexplained"))
        self.assertEqual(result["baseline_effects"], baseline)
        self.assert_keys(result["baseline"], {**QUALITY, "holdout_interval_N": list})
        low, high = result["baseline"]["holdout_interval_N"]
        self.assertTrue(low <= result["baseline"]["holdout_rmse_N"] <= high)
        self.assertGreater(result["noise_floor_N"], 0.0)
        known = self.known_effects()
        named = [candidate["effect"] for candidate in result["candidates"]]
        self.assertEqual(len(named), len(set(named)), "an effect is listed twice")
        self.assertLessEqual(set(named), set(known) - set(baseline))
        for candidate in result["candidates"]:
            self.check_candidate(candidate, result, known)
        for pair in result["cannot_separate"]:
            self.assertLessEqual({pair["effect"], pair["other"]}, set(named))
            self.assertTrue(0.0 <= pair["angle_deg"] <= 90.0)
        for entry in result["cannot_show"]:
            self.assertIn(entry["effect"], named)
            self.assertTrue(0.0 <= entry["orthogonal_share"] <= 1.0 + 1e-9)
            self.assertTrue(entry["least_visible_N"] is None or entry["least_visible_N"] > 0.0)
        if result["unexplained"] is not None:
            self.assert_keys(result["unexplained"], {"coordinate": str, "description": str})
            self.assertIn(result["unexplained"]["coordinate"],
                          ("time", "position", "velocity", "acceleration", "frequency", "reversal"))
        if result["verdict"] == "unexplained":
            self.assertIsNotNone(result["unexplained"])
        if found:
            self.assertEqual(result["best"]["effects"], baseline + [named[0]])
            self.assertLess(result["best"]["holdout_rmse_N"], 0.97 * result["baseline"]["holdout_rmse_N"])

    def check_candidate(self, candidate, result, known):
        self.assert_keys(candidate, CANDIDATE)
        self.assertIn(candidate["refusal"], ("", "at_floor", "implausible", "too_small", "superfluous"))
        self.assertGreaterEqual(candidate["error_reduction_se"], 0.0)
        before = result["baseline"]["holdout_rmse_N"]
        self.assertAlmostEqual(candidate["error_reduction"], 1.0 - candidate["holdout_rmse_N"] / before, places=9)
        for other in candidate["confounded_with"]:
            self.assertIn(other, known)
            self.assertNotEqual(other, candidate["effect"])
        for text in ("title", "evidence", "cause", "confirm_with"):
            self.assertGreater(len(candidate[text]), 5)
            self.assertNotIn("{", candidate[text], "a placeholder was not filled in")

    def test_diagnose(self):
        verdicts = set()
        for log in ("none", "one", "two", "outside"):
            for stepwise in ([], ["--stepwise"]):
                with self.subTest(log, stepwise=stepwise):
                    result = self.result("diagnose", self.stock / f"{log}.csv", *stepwise)
                    self.assertEqual(result["log"], str(self.stock / f"{log}.csv"))
                    self.check_diagnosis(result, program.BASELINE.split(","), bool(stepwise))
                    verdicts.add(result["verdict"])
        self.assertGreaterEqual(len(verdicts), 2, "the logs do not show what the contract is about")

    def test_best_first(self):
        """The effects of the explanation before all others; within each the lowest held-out error first."""
        for log in ("one", "two"):
            result = self.result("diagnose", self.stock / f"{log}.csv", "--stepwise")
            added = [step["effect"] for step in result["steps"][1:]]
            errors = [candidate["holdout_rmse_N"] for candidate in result["candidates"]]
            named = [candidate["effect"] for candidate in result["candidates"]]
            self.assertEqual(set(named[:len(added)]), set(added))
            for part in (errors[:len(added)], errors[len(added):]):
                self.assertEqual(part, sorted(part))

    def test_steps_fall_from_the_baseline(self):
        result = self.result("diagnose", self.stock / "two.csv", "--stepwise")
        steps = result["steps"]
        for step in steps:
            self.assert_keys(step, {"effect": str, "holdout_rmse_N": float, "forward_rmse_N": float},
                             also=[] if step is steps[0] else ["criterion_difference", "evidence"])
            if step is not steps[0]:
                self.assertLess(step["criterion_difference"], 0.0)
        self.assertEqual(steps[0], {"effect": "baseline", **{key: result["baseline"][key]
                                                             for key in ("holdout_rmse_N", "forward_rmse_N")}})
        self.assertGreaterEqual(len(steps), 3)
        errors = [step["holdout_rmse_N"] for step in steps]
        self.assertEqual(errors, sorted(errors, reverse=True))

    def test_nothing_left_to_try(self):
        everything = self.known_effects()
        result = self.result("diagnose", "good.csv", "--effects", ",".join(everything))
        self.assertEqual(result["candidates"], [])
        self.assertIn(result["verdict"], ("complete", "unexplained"))

    def check_fit(self, result, effects):
        self.assertEqual(result["effects"], effects)
        self.assertIsInstance(result["samples"], int)
        self.assertRegex(result["hash"], "^[0-9a-f]{8}$")
        for key in (*QUALITY, "noise_floor_N"):
            self.assertTrue(math.isfinite(result[key]), key)
        self.assertEqual([term["effect"] for term in result["parameters"]], effects)
        for term in result["parameters"]:
            for parameter in term["parameters"]:
                self.assertTrue(math.isfinite(parameter["value"]))
                self.assertIn("unit", parameter)
                if not parameter["note"]:  # neither given, nor at its bound, nor a shape
                    self.assertGreater(parameter["standard_error"], 0.0, parameter)

    def test_fit_compare_add(self):
        fit = self.result("fit", "good.csv", "--effects", program.BASELINE, "--model", "m.toml")
        self.check_fit(fit, program.BASELINE.split(","))
        compare = self.result("compare", "good.csv", "--model", "m.toml")
        self.assertEqual(compare["hash"], fit["hash"])
        self.assertEqual(compare["effects"], fit["effects"])
        self.assertAlmostEqual(compare["rmse_N"] / fit["train_rmse_N"], 1.0, places=9)
        self.assertAlmostEqual(compare["noise_floor_N"] / fit["noise_floor_N"], 1.0, places=9)
        add = self.result("add", "good.csv", "--model", "m.toml", "--effect", "viscous", "--out", "m2.toml")
        self.check_fit(add, program.BASELINE.split(",") + ["viscous"])
        self.assertEqual(add["added"], "viscous")
        self.assertAlmostEqual(add["before"]["holdout_rmse_N"] / fit["holdout_rmse_N"], 1.0, places=6)
        self.assertLess(add["holdout_rmse_N"], add["before"]["holdout_rmse_N"])
        better = self.result("compare", "good.csv", "--model", "m2.toml")
        self.assertEqual(better["hash"], add["hash"])
        self.assertAlmostEqual(better["rmse_N"] / add["train_rmse_N"], 1.0, places=9)

    def test_fit_by_simulation(self):
        effects = program.BASELINE + ",viscous"
        plain = self.result("fit", "good.csv", "--effects", effects)
        self.assertNotIn("criteria", plain)
        fit = self.result("fit", "good.csv", "--effects", effects, "--criterion", "simulation", "--horizon", "1", "--model",
                          "m.toml")
        self.assert_keys(fit, {key: type(value) for key, value in plain.items()}, also=["criteria"])
        self.check_fit(fit, effects.split(","))
        criteria = fit["criteria"]
        self.assert_keys(criteria, {"parameters": int, "runs": int, "run_s": float, "converged": bool,
                                    "inverse_dynamics": dict, "simulation": dict})
        for errors in (criteria["inverse_dynamics"], criteria["simulation"]):
            self.assert_keys(errors, {f"{what}{error}": float for what in ("", "held_out_", "forward_")
                                      for error in ("force_N", "position_m")})
        self.assertEqual(fit["holdout_rmse_N"], criteria["simulation"]["held_out_force_N"])
        self.assertEqual(fit["forward_rmse_N"], criteria["simulation"]["forward_force_N"])
        compare = self.result("compare", "good.csv", "--model", "m.toml")
        self.assertAlmostEqual(compare["rmse_N"] / fit["train_rmse_N"], 1.0, places=9)
        for arguments, told in ((["--criterion", "simulation", "--effects", "presliding_hysteresis"], "no mass"),
                                (["--criterion", "position", "--effects", "inertia"], "--criterion"),
                                (["--horizon", "0", "--criterion", "simulation", "--effects", "inertia"], "--horizon")):
            self.assert_refused(["fit", "good.csv", *arguments], told)

    def test_baseline_from_a_model_is_the_baseline(self):
        named = self.result("diagnose", "good.csv", "--effects", program.BASELINE)
        fitted = self.result("diagnose", "good.csv", "--model", "good.toml")
        default = self.result("diagnose", "good.csv")
        # The command of the next experiment says what was given.
        for result in (named, default):
            result.pop("next_experiment")
        self.assertEqual(named, default)
        self.assertEqual(named["verdict"], fitted["verdict"])
        self.assertEqual(named["candidates"][0]["effect"], fitted["candidates"][0]["effect"])
        self.assertAlmostEqual(named["baseline"]["holdout_rmse_N"] / fitted["baseline"]["holdout_rmse_N"], 1.0,
                               places=6)

    def test_names_that_are_no_text(self):
        name = "gr\u00f6\u00dfe \"1\"\n\xff.csv".encode("latin-1")
        (self.here / "good.csv").rename(self.here / name.decode("utf-8", "surrogateescape"))
        done = self.assert_done(b"fit", name, b"--effects", b"inertia", b"--model", b"m.toml", b"--report", b"r.html",
                                b"--json", b"j.json")
        self.assertIn("\"1\"", json.loads((self.here / "j.json").read_text())["log"])
        self.assertEqual(done.stdout.decode().splitlines()[1].split()[0], "effects")
        self.assert_done("diagnose", name, "--model", "m.toml", "--report", "r.html", "--json", "j.json")


if __name__ == "__main__":
    program.main()
