#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""toolchain/demo: names the effect that it hid, for arbitrary seeds; takes a log of the user; stops without leaving files."""

import json
import os
import re
import subprocess
import unittest

import program

DEMO = program.REPOSITORY / "toolchain" / "demo"
SEED = 1
OTHER_SEEDS = (2,)
WRITTEN = ["added.html", "added.json", "baseline.toml", "better.toml", "diagnosis.html", "diagnosis.json"]


class Demo(program.Workshop):
    def demo(self, *arguments, out="out"):
        return subprocess.run([DEMO, *arguments, "--built", os.path.dirname(program.SLIPSTACK), "--out", out],
                              cwd=self.here, capture_output=True, timeout=program.PATIENCE_S, text=True)

    def assert_demo(self, *arguments):
        done = self.demo(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")
        return done.stdout

    def test_names_what_it_hid(self):
        self.check_seed(SEED)

    @program.long
    def test_names_what_it_hid_for_other_seeds(self):
        for seed in OTHER_SEEDS:
            with self.subTest(seed=seed):
                self.check_seed(seed)

    def check_seed(self, seed):
        text = self.assert_demo("--seed", str(seed))
        hidden = re.search(r"^hidden: (\w+)$", text, re.MULTILINE).group(1)
        self.assertEqual(json.loads((self.here / "out/truth.json").read_text())["effects"], [hidden])
        self.assertRegex(text, rf"(?m)^named:  {hidden}$")
        self.assertIn("The right one.", text)
        self.assertEqual(sorted(os.listdir(self.here / "out")), sorted([*WRITTEN, "log.csv", "truth.json"]))
        self.check_that_the_error_falls(text, hidden)

    def check_that_the_error_falls(self, text, effect):
        added = json.loads((self.here / "out/added.json").read_text())
        self.assertEqual(added["added"], effect)
        # The plant has another formula than the catalogue: the error must be within 1.3 of the noise floor.
        self.assertLess(added["holdout_rmse_N"], 1.3 * added["noise_floor_N"])
        self.assertLess(added["holdout_rmse_N"], 0.97 * added["before"]["holdout_rmse_N"])
        bars = re.findall(r"^  (.+?) +(\d+) mN  (#+)$", text, re.MULTILINE)
        self.assertEqual([name for name, _, _ in bars], [f"without {effect}", f"with {effect}", "noise floor"])
        self.assertEqual(int(bars[1][1]), round(1e3 * added["holdout_rmse_N"]))

    @program.long
    def test_every_command_that_it_shows_can_be_typed(self):
        text = self.assert_demo("good.csv")
        self.assertIn("toolchain/demo --loop", text.splitlines()[-1])
        for line in re.findall(r"^\$ (.*)$", text, re.MULTILINE):
            with self.subTest(line):
                subprocess.run(line.split(), cwd=self.here, check=True, capture_output=True)
        self.assertIn("Missing: Viscous friction", text)
        self.assertNotIn("hidden:", text)

    @program.long
    def test_log_of_an_earlier_run(self):
        """A log that the demonstration itself wrote can be given to it, and must not be deleted."""
        self.assert_demo("--seed", "1")
        before = (self.here / "out/log.csv").read_bytes()
        text = self.assert_demo("out/log.csv")
        self.assertEqual((self.here / "out/log.csv").read_bytes(), before)
        self.assertNotIn("hidden:", text)

    @program.long
    def test_nothing_hidden(self):
        program.simulate(self.here / "plain.csv", "--effects", "none")
        text = self.assert_demo("plain.csv")
        self.assertIn("Complete: ", text)
        self.assertIn("nothing to add", text)
        self.assertFalse((self.here / "out/better.toml").exists())

    def test_bad_log(self):
        (self.here / "bad.csv").write_text("time_s,position_m\n0,0\n")
        for log in ("bad.csv", "nothing.csv"):
            done = self.demo(log)
            self.assertEqual(done.returncode, 2)
            self.assert_one_line(done.stderr.encode(), log)
            self.assertEqual(os.listdir(self.here / "out"), [])

    def test_wrong_use(self):
        for arguments in (["--seed"], ["--seed", "two"], ["--seed", "-1"], ["--fast"], ["a.csv", "b.csv"],
                          ["--seed", "1", "good.csv"], ["--loop", "good.csv"]):
            with self.subTest(arguments):
                done = self.demo(*arguments)
                self.assertEqual(done.returncode, 2)
                self.assertEqual(done.stdout, "")
                self.assertRegex(done.stderr, r"^demo: [^\n]+\n$")
                self.assertFalse((self.here / "out").exists())

    @program.long
    def test_an_axis_from_nothing_to_compensated(self):
        for _ in range(2):  # it begins anew each time
            text = self.assert_demo("--loop")
            self.assertRegex(text, r"(?m)^The axis follows to .* times better than with its mass alone")
            self.assertRegex(text, r"(?m)^hidden: \w+$")
            self.assertIn("the motor is connected the other way round", text)
            self.assertTrue((self.here / "out/deployed.toml").exists())
            (self.here / "out/report.html").unlink()

    def test_help(self):
        self.assertIn("toolchain/demo LOG.csv", self.assert_demo("--help"))


if __name__ == "__main__":
    program.main()
