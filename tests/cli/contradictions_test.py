# SPDX-License-Identifier: Apache-2.0
"""No two statements of one output contradict each other: over the shared measurements and simulated logs."""

import html
import os
import pathlib
import re
import shlex
import unittest

import program
from experiment_plan_test import poor_motion

DATA = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", program.REPOSITORY / ".." / "shared")) / "data"
LOGS = [f"hidden_effect/blind_{i}.csv" for i in range(1, 7)] + ["emps/emps_estimation.csv",
                                                                "tribometer/tribometer_loops.csv",
                                                                "odrive_cogging/odrive_0p1rev.csv"]
# A value with its unit in a sentence and without an interval: not the half width of "20.19 +- 0.25 N".
TOKEN = r"(?:[munk]?(?:N|m|s|Hz|kg|rad|A)\d?(?:/[a-z]+\d?)?|%)(?![\w/])"
FIGURE = re.compile(r"(?<!\+- )(?<![-\w.])-?\d[\d.]*(?:e-?\d+)? " + TOKEN + "(?: " + TOKEN + ")*")
# What a sentence tells beside parameters: errors, and shares of the residual that were counted in this log.
COUNTED = re.compile(r"held-out error is [^;]*|1 % of the time holds [\d.]+ % of it|"
                     r"in the [\d.]+ % of the time that lie within [\d.]+ \w+|"
                     r"(?:needs?|need) [\d.]+ times the measured (?:force|torque)|which are those below [\d.]+ \w+")
SHOWN = 0.005  # reductions below it are not in the table
UNCERTAIN = 1.1  # a noise floor is uncertain by this factor: nothing is left below it by more (docs/theory.md)


def error(of, kind="holdout"):
    """The error of a model or a step, of an axis in newtons or in newton metres."""
    return of[f"{kind}_rmse_N"] if f"{kind}_rmse_N" in of else of[f"{kind}_rmse_Nm"]


SI_PREFIX = {"": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9, "k": 1e3}
FORCE = r"(-?[\d.]+(?:e[-+]?\d+)?) ([munk]?)N(?: m)?"


def forces(text):
    """The forces of a sentence, or torques, in SI units."""
    return [float(number) * SI_PREFIX[prefix] for number, prefix in re.findall(FORCE, text)]


# How a row of parameters ends: with a standard error, or with why there is none. Long names and units widen a row.
ROW = re.compile(r"(\w+) +(\w.*?) (at its bound|given|set|not determined|"
                 r"[\d.]+(?:e[-+]?\d+)?(?: (?!at its|set$|given$|not )[^\d\s]\S*)*)")


def table_rows(text):
    """Of the table of parameters in a text: effect, parameter with its value, and the column of the error."""
    table = text.split("std. error\n", 1)[1].split("\n\n", 1)[0]
    return [ROW.fullmatch(line).groups() for line in table.splitlines()
            if not line.startswith("friction  ")]


class WrittenModels(program.Workshop):
    """What fit, add and compare state: in text and in JSON, and of one model each of the others."""

    def told(self, *arguments):
        done = program.run(*arguments, "--json", "told.json", cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.decode(), program.published(pathlib.Path(self.here, "told.json").read_text())

    def assert_told(self, sentence, *values):
        """The forces of a sentence are these values, to the three digits that are shown."""
        shown = forces(sentence)
        self.assertEqual(len(shown), len(values), sentence)
        for one, value in zip(shown, values):
            self.assertAlmostEqual(one, value, delta=0.0051 * abs(value), msg=sentence)

    def level(self, told):
        deviation = next(value for key, value in told.items() if key.startswith("standard_error_"))
        return {"name": "level of", "standard_error": deviation, "note": "" if deviation else "not determined"}

    def check_parameters(self, text, told):
        rows = table_rows(text)
        stated = []
        for term in told["parameters"]:
            if "levels" in term:  # the text has one level for all the elements
                stated += [(term["effect"], self.level(level)) for level in term["levels"]]
                continue
            stated += [(term["effect"], one) for one in term["parameters"]]
        self.assertEqual([row[0] for row in rows], [effect for effect, _ in stated])
        for (effect, name, error_column), (_, one) in zip(rows, stated):
            where = f"{effect} {name}: '{error_column}' and {one}"
            # The JSON names a gain as the model file does, whatever kind of axis it is.
            told_as = "moment of inertia" if (one["name"], one.get("unit")) == ("mass", "kg m2") else one["name"]
            self.assertTrue(name.startswith(told_as), where)
            # A value has an interval, or both outputs say why there is none; never both.
            if one["standard_error"] is None:
                self.assertEqual(error_column, "set" if one["note"] == "shape" else one["note"], where)
            else:
                self.assertRegex(error_column, r"^[\d.]", where)
                self.assertIn(one["note"], ("", "shape"), where)
        ways = re.findall("^friction   .*$", text, re.MULTILINE)
        self.assertEqual(len(ways), 1 if "friction_each_way" in told else 0)
        for line in ways:
            self.assertNotRegex(line, FIGURE)

    def check_quality(self, told):
        low, high = next(value for key, value in told.items() if key.startswith("holdout_interval_"))
        self.assertLessEqual(low, error(told))
        self.assertLessEqual(error(told), high)
        # Held out is never better than in sample by more than chance.
        self.assertGreaterEqual(error(told), 0.97 * error(told, "train"))

    def check(self, log, effects=program.BASELINE, added="viscous"):
        with self.subTest(log=str(log)):
            text, fit = self.told("fit", str(log), "--effects", effects, "--model", "fit.toml")
            floor = next(value for key, value in fit.items() if key.startswith("noise_floor_"))
            self.check_quality(fit)
            self.check_parameters(text, fit)
            low, high = next(value for key, value in fit.items() if key.startswith("holdout_interval_"))
            self.assertGreater(error(fit), floor / UNCERTAIN)
            line = re.search("^error .*$", text, re.MULTILINE)[0]
            self.assert_told(line, error(fit), low, high, error(fit, "train"), floor)

            # The same model on the same log: its error in sample.
            text, compared = self.told("compare", str(log), "--model", "fit.toml")
            rms = compared["rmse_N"] if "rmse_N" in compared else compared["rmse_Nm"]
            self.assertEqual(compared["hash"], fit["hash"])
            self.assertAlmostEqual(rms, error(fit, "train"), delta=0.01 * rms)
            line = re.search("^error .*$", text, re.MULTILINE)[0]
            self.assert_told(line, rms, next(compared[key] for key in compared if key.startswith("noise_floor_")))
            self.assertIn(compared["left"][1:], text)
            self.assertNotIn("at its bound", compared["left"])
            self.assertNotRegex(COUNTED.sub("", compared["left"]), FIGURE)

            text, after = self.told("add", str(log), "--model", "fit.toml", "--effect", added, "--out", "add.toml")
            self.check_quality(after)
            self.check_parameters(text, after)
            # Each command lowers the floor by its own model: that of more effects by no less.
            lower = next(value for key, value in after.items() if key.startswith("noise_floor_"))
            self.assertLess(lower, 1.01 * floor)
            self.assert_told(text.splitlines()[0], error(after["before"]), error(after), lower)
            self.assertAlmostEqual(error(after["before"]), error(fit), delta=0.01 * error(fit))
            step = error(after) < 0.97 * error(after["before"]) and after["criterion_difference"] < 0.0
            self.assertEqual("It is no step" in text, not step)

    def test_simulated_logs(self):
        self.check(pathlib.Path(self.here, "good.csv"))
        # Without viscous friction, the log does not move the asymmetry of it.
        self.check(pathlib.Path(self.here, "good.csv"), "inertia,coulomb", "direction_asymmetry")

    @program.long
    def test_measured_logs(self):
        logs = [DATA / name for name in LOGS if (DATA / name).is_file()]
        if not logs:
            self.skipTest(f"SKIP: no measurements in {DATA}; set SLIPSTACK_SHARED")
        for log in logs:
            self.check(log)
            if not log.name.startswith("blind"):  # of those one is enough: test_simulated_logs
                self.check(log, "inertia,coulomb", "direction_asymmetry")


def partners(pairs, effect):
    """The effects that stand with this one in the pairs."""
    return {one for pair in pairs if effect in pair for one in pair if one != effect}


# A row of the candidates in the text: effect, criterion, and what the log cannot tell from it.
CANDIDATE_ROW = re.compile(r"^(\w+) +[\d.]+ \S+(?: \S+)? +-?[\d.]+ % +[\d.]+ % +([-+][\d.]+)(?:  (\w.*))?$", re.MULTILINE)
# The same in the report, behind the title and the key of the effect.
REPORT_ROW = re.compile(r'<tr data-effect="(\w+)">.*?<td class="num">([^<]*)</td><td>([^<]*)</td></tr>')


class Ties:
    """The statements of a diagnosis about effects that its log cannot tell apart."""

    def __init__(self, test, text, found, report):
        self.test, self.text, self.found, self.report = test, text, found, report
        self.title = {one["effect"]: one["title"] for one in found["candidates"]}
        self.pairs = [frozenset((pair["effect"], pair["other"])) for pair in found["cannot_separate"]]
        self.added = [step["effect"] for step in found["steps"][1:]]

    def check(self):
        self.check_pairs()
        self.check_candidates()
        self.check_list()
        self.check_sentences()
        self.check_report()

    def check_pairs(self):
        """Each pair once, and of effects that the log supports or names; where none is named, of forces that are mostly the
        same."""
        self.test.assertEqual(len(self.pairs), len(set(self.pairs)))
        supported = {one["effect"] for one in self.found["candidates"] if one["criterion_difference"] < -2.0}
        for pair in self.pairs:
            self.test.assertTrue(pair & (set(self.added) or supported), pair)
        for pair in self.found["cannot_separate"]:
            self.test.assertTrue(self.added or pair["angle_deg"] < 45.0, pair)

    def check_candidates(self):
        """JSON and table state at each candidate what the pairs state."""
        for one in self.found["candidates"]:
            self.test.assertEqual(set(one["confounded_with"]), partners(self.pairs, one["effect"]), one["effect"])
        for effect, _, others in CANDIDATE_ROW.findall(self.text):
            self.test.assertEqual(set(filter(None, others.split(", "))), partners(self.pairs, effect), effect)

    def check_list(self):
        """The list in the text has the pairs of the JSON, and the next experiment is for one of them."""
        told = re.findall(r"^this log cannot tell (\w+) from (\w+) \((?:force|torque)s [\d.]+ degrees apart\)$", self.text, re.MULTILINE)
        self.test.assertEqual([frozenset(pair) for pair in told], self.pairs)
        following = self.found["next_experiment"]
        asked = re.match(r"this log cannot tell (\w+) from (\w+) \(", following["why"]) if following else None
        if following:
            self.test.assertIn(f"next experiment        {following['why']}:\n", self.text)
        if asked:
            self.test.assertIn(frozenset(asked.groups()), self.pairs)
            self.test.assertEqual(set(following["for"]), set(asked.groups()))

    def check_sentences(self):
        """The headline tells the ties of the first step, the sentences below it those of the others."""
        lines = self.text.split("\none effect added")[0].split("\nnone of the")[0]
        told = {}
        for effect, others in re.findall(r"this log cannot tell (\w+) from ((?:\w+ or )*\w+)\.", lines, re.IGNORECASE):
            named = self.added[0] if effect == "it" else effect
            told[named] = set(others.split(" or "))
        self.test.assertEqual(told, {effect: partners(self.pairs, effect) for effect in self.added if partners(self.pairs, effect)})

    def check_report(self):
        """The report states at each candidate what the JSON does, and the criterion as the text."""
        in_text = {effect: criterion for effect, criterion, _ in CANDIDATE_ROW.findall(self.text)}
        rows = REPORT_ROW.findall(self.report)
        self.test.assertEqual(len(rows), len(self.found["candidates"]))
        for effect, criterion, others in rows:
            self.test.assertEqual({html.unescape(other) for other in others.split(", ") if other},
                                  {self.title[other] for other in partners(self.pairs, effect)}, effect)
            if effect in in_text:
                self.test.assertAlmostEqual(float(re.sub(r"[^-+.\d]", "", criterion.replace("\u2212", "-"))), float(in_text[effect]),
                                            delta=0.101)
        self.test.assertEqual("What this log cannot tell apart" in self.report, bool(self.pairs))


class Contradictions(program.Workshop):
    def diagnose(self, log, *options):
        done = program.run("diagnose", "--stepwise", *options, "--json", "found.json", "--report", "found.html", str(log),
                           cwd=self.here)
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
                self.assertNotRegex(after["evidence"], "(pitch|delay) is at an end of its search")
            floor = next(value for key, value in found.items() if key.startswith("noise_floor_"))
            self.assertGreater(error(steps[-1]), floor / UNCERTAIN)
            # Every value of a sentence has its interval, and nothing at a bound is told of a step.
            for told in steps[1:] + candidates[:1] * bool(added):
                self.assertNotRegex(told["evidence"], FIGURE)
            if found["unexplained"] is not None:
                self.assertNotRegex(COUNTED.sub("", found["unexplained"]["description"]), FIGURE)
            # Where no effect accounts for the log, one that it supports alone is not passed over in silence.
            supported = [one for one in candidates if one["criterion_difference"] < -2.0 and one["error_reduction"] >= 0.03]
            if found["verdict"] == "unexplained" and not added and supported and not found["input_warnings"]:
                self.assertTrue(any(one["effect"] in found["unexplained"]["description"] for one in supported), found["unexplained"])
            # Nor is one that alone leaves less than all that are named together, nor, of those that alone leave less than the
            # first named one, the one of least error.
            others = sorted((one for one in supported if one["effect"] not in added), key=error)
            for rank, one in enumerate(others if found["verdict"] == "missing_effect" else []):
                if error(one) < 0.97 * error(steps[1 if rank == 0 else -1]):
                    self.assertTrue(one["confounded_with"] or f"{one['effect']} alone would leave less" in text, one)
            Ties(self, text, found, pathlib.Path(self.here, "found.html").read_text()).check()
            # Held out is never better than in sample by more than chance.
            for model in [found["baseline"]] + ([found["best"]] if "best" in found else []):
                self.assertGreaterEqual(error(model), 0.97 * error(model, "train"))
            # The table of effects alone falls with its error column.
            shares = [float(share) for share in re.findall(r"^\w+ +[\d.]+ \S+(?: \S+)? +(-?[\d.]+) % +[\d.]+ %",
                                                           text, re.MULTILINE)]
            self.assertEqual(shares, sorted(shares, reverse=True))
        return found

    def test_simulated_logs(self):
        for seed, hidden in enumerate(("", "viscous", "stribeck,force_ripple"), start=21):
            log = pathlib.Path(self.here, f"axis_{seed}.csv")
            effects = ["--effects", hidden] if hidden else []
            program.simulate(log, *effects, "--seconds", "15", "--rate", "1000", seed=seed)
            self.check(log)

    def test_the_plan_that_is_printed_can_be_made(self):
        for seed, hidden in enumerate(("viscous", "stribeck", "force_ripple", "structural_resonance"), start=61):
            log = pathlib.Path(self.here, f"axis_{seed}.csv")
            program.simulate(log, "--effects", hidden, "--seconds", "40", "--rate", "1000", seed=seed)
            text, _ = self.diagnose(log)
            printed = re.search(r"^  slipstack (experiment plan .*)$", text, re.MULTILINE)
            self.assertIsNotNone(printed, text)
            done = program.run(*shlex.split(printed[1]), cwd=self.here)
            self.assertEqual(done.returncode, 0, done.stderr)
            pathlib.Path(self.here, "setpoints.csv").unlink()

    def test_what_no_free_curve_describes(self):
        # A memory times a map, and a delay: what curves leave of them is not the noise floor.
        for effects in ("frictional_lag,position_dependent_preload", "time_delay"):
            log = pathlib.Path(self.here, "axis.csv")
            program.simulate(log, "--effects", effects, "--seconds", "40",
                             "--rate", "2500", seed=9)
            self.check(log)

    def test_ties(self):
        # A slow motion tells hardly that friction has a memory.
        told = 0
        for hidden in ("frictional_lag", "stribeck"):
            log = pathlib.Path(self.here, f"{hidden}.csv")
            poor_motion(pathlib.Path(self.here, "motion.csv"))
            program.simulate(log, "--effects", hidden, "--strength", "1", "--setpoints",
                             str(pathlib.Path(self.here, "motion.csv")), seed=11)
            told += len(self.check(log)["cannot_separate"])
        self.assertGreater(told, 0, "no log of this test has a tie")

    @program.long
    def test_long_log_of_which_an_excerpt_is_searched(self):
        log = pathlib.Path(self.here, "axis.csv")
        program.simulate(log, "--effects", "frictional_lag,position_dependent_preload",
                         "--seconds", "200", "--rate", "2500", seed=9)
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

    def test_causes_outside_the_catalogue(self):
        for seed, kind in enumerate(("line", "bump", "burst", "backlash", "slip"), start=31):
            log = pathlib.Path(self.here, f"{kind}.csv")
            program.simulate(log, "--outside", kind, "--seconds", "15", "--rate", "1000", seed=seed)
            found = self.check(log)
            if kind in ("line", "slip"):
                self.assertIn(" +- ", found["unexplained"]["description"])

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
