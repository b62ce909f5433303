#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What of a log contradicts physics is said in one line, before anything else."""

import json
import unittest

import program


class InputWarnings(program.Workshop):
    def spoil(self, change):
        lines = (self.here / "good.csv").read_text().splitlines()
        rows = [line if line[0] in "#t" else ",".join(map(repr, change(*map(float, line.split(","))))) for line in lines]
        (self.here / "bad.csv").write_text("\n".join(rows) + "\n")

    def warnings_of(self, log, command):
        done = program.run(*command, "--json", "found.json", "--report", "found.html", cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.decode().splitlines()
        found = json.loads((self.here / "found.json").read_text())
        warnings = found["input_warnings"]
        if warnings:  # a motion is no remedy for wrong units
            self.assertIsNone(found.get("next_experiment"))
            self.assertNotIn("next experiment", done.stdout.decode())
            if command[0] == "diagnose":  # effects of a model fitted to such an input are no findings
                self.assertEqual(found["verdict"], "unexplained")
                self.assertEqual(found["unexplained"]["description"], warnings[0]["what"])
        for line, warning in zip(lines, warnings):
            self.assertEqual(line, "warning    " + warning["what"])
            self.assertIn(warning["what"][:40], (self.here / "found.html").read_text())
        self.assertFalse(any(line.startswith("warning") for line in lines[len(warnings):]), log)
        return [warning["kind"] for warning in warnings]

    def test_each_fault_is_said_first(self):
        faults = {
            None: lambda t, x, f: (t, x, f),
            "force_sign": lambda t, x, f: (t, x, -f),
            "force_unsigned": lambda t, x, f: (t, x, abs(f)),
            "units": lambda t, x, f: (t, x, 1e3 * f),
        }
        for kind, change in faults.items():
            self.spoil(change)
            for command in (("diagnose", "bad.csv"), ("fit", "bad.csv", "--effects", "inertia,coulomb", "--model", "m.toml"),
                            ("compare", "bad.csv", "--model", "good.toml")):
                with self.subTest(kind=kind, command=command[0]):
                    self.assertEqual(self.warnings_of("bad.csv", command), [kind] if kind else [])


if __name__ == "__main__":
    program.main()
