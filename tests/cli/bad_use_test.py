#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Wrong use of the commands, and the help that prevents it."""

import unittest

import program

FIT = ["fit", "good.csv", "--model", "new.toml", "--effects"]
ADD = ["add", "good.csv", "--model", "good.toml", "--out", "new.toml", "--effect"]

# what is wrong: (arguments, what the message must say)
WRONG = {
    "no command": ([], ["subcommand is required", "--help"]),
    "unknown command": (["explain", "good.csv"], ["unknown command 'explain'", "known: compare, fit, diagnose, add"]),
    "unknown option": (["diagnose", "good.csv", "--fast"], ["--fast"]),
    "no log": (["diagnose"], ["LOG is required"]),
    "two logs": (["diagnose", "good.csv", "good.csv"], ["good.csv"]),
    "option without its value": (["diagnose", "good.csv", "--json"], ["--json"]),
    "option twice": (["diagnose", "good.csv", "--json", "a", "--json", "b"], ["--json"]),
    "empty report": (["diagnose", "good.csv", "--report", ""], ["--report", "empty"]),
    "empty json": (["diagnose", "good.csv", "--json="], ["--json"]),
    "empty log": (["diagnose", ""], ["LOG", "empty"]),
    "compare without a model": (["compare", "good.csv"], ["--model is required"]),
    "fit without effects": (["fit", "good.csv", "--model", "new.toml"], ["--effects is required"]),
    "add without a place": (ADD[:4] + ["--effect", "viscous"], ["--out is required"]),
    "add without an effect": (ADD[:-1], ["--effect is required"]),
    "unknown effect to fit": (FIT + ["inertia,magic"], ["unknown effect 'magic'", "known: inertia, "]),
    "unknown effect to add": (ADD + ["magic"], ["unknown effect 'magic'", "known: inertia, "]),
    "unknown baseline": (["diagnose", "good.csv", "--effects", "magic"], ["unknown effect 'magic'"]),
    "list to add": (ADD + ["viscous,stribeck"], ["unknown effect 'viscous,stribeck'"]),
    "no effect": (FIT + [","], ["unknown effect ''"]),
    "effect twice": (FIT + ["inertia,viscous,inertia"], ["'inertia' is named twice"]),
    "baseline twice": (["diagnose", "good.csv", "--effects", "inertia,inertia"], ["'inertia' is named twice"]),
    "effect already there": (ADD + ["inertia"], ["good.toml already contains inertia"]),
    "nothing to modulate": (FIT + ["inertia,stribeck"], ["stribeck", "dry friction", "coulomb"]),
    "baseline with nothing to modulate": (["diagnose", "good.csv", "--effects", "inertia,drift"],
                                          ["drift", "dry friction"]),
    "two baselines": (["diagnose", "good.csv", "--effects", "inertia", "--model", "good.toml"],
                      ["--effects", "--model"]),
    "negative noise": (["diagnose", "good.csv", "--noise", "-1"], ["--noise: Value -1 is not positive; see"]),
    "escape codes": (["diagnose", "good.csv", "--\x1b[31mred"], []),
}


class WrongUse(program.Workshop):
    def test_each(self):
        for what, (arguments, expected) in WRONG.items():
            with self.subTest(what):
                self.assert_refused(arguments, *expected)

    def test_nothing_to_modulate_in_a_model(self):
        self.assert_done("fit", "good.csv", "--effects", "inertia,viscous", "--model", "smooth.toml")
        self.assert_refused(["add", "good.csv", "--model", "smooth.toml", "--effect", "stribeck", "--out", "new.toml"],
                            "stribeck", "dry friction")

    def test_mass_that_is_not_known_cannot_be_told_from_a_payload(self):
        text = (self.here / "good.csv").read_text()
        (self.here / "massless.csv").write_text(text.replace("# mass_kg:", "# weight:"))
        self.assert_refused(["fit", "massless.csv", "--effects", "inertia,payload_mass", "--model", "new.toml"],
                            "payload_mass", "mass_kg")
        self.assert_done("fit", "good.csv", "--effects", "inertia,payload_mass", "--model", "new.toml")

    def test_blanks_around_names_do_no_harm(self):
        self.assert_done("fit", "good.csv", "--effects", " inertia , viscous", "--model", "new.toml")


class Help(program.Workshop):
    def test_help_and_version(self):
        for arguments in (["--help"], ["-h"], ["--version"], *([name, "--help"] for name in program.every_command())):
            with self.subTest(arguments):
                before = self.content()
                done = self.assert_done(*arguments)
                self.assertGreater(len(done.stdout), 10)
                self.assertEqual(self.content(), before)

    def test_help_names_every_command_and_effect(self):
        text = self.assert_done("--help").stdout.decode()
        for name in program.every_command():
            self.assertIn(f"\n  {name} ", text)
        for command in ("fit", "diagnose", "add"):
            text = self.assert_done(command, "--help").stdout.decode()
            for effect in ("inertia", "presliding_hysteresis", "time_delay", "drift"):
                self.assertIn(f"\n  {effect} ", text)

    def test_version_is_a_number(self):
        self.assertRegex(self.assert_done("--version").stdout.decode(), r"^slipstack \d+\.\d+\.\d+\n$")


if __name__ == "__main__":
    program.main()
