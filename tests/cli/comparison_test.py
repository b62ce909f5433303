# SPDX-License-Identifier: Apache-2.0
"""`slipstack loop --compare` as typed: wrong use in one line, nothing written."""

import pathlib
import unittest

import program


class Comparison(program.Workshop):
    def assert_refused(self, *arguments, expected):
        done = program.run(*arguments, cwd=self.here)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stdout, b"")
        self.assert_one_line(done.stderr, expected)

    def test_a_comparison_takes_no_options_of_a_run(self):
        for arguments in (("--model", "m.toml"), ("--push", "2"), ("--board", "host"), ("--out", "log.csv")):
            self.assert_refused("loop", "--compare", *arguments, expected="--compare")
        self.assert_refused("loop", "--seeds", "2", expected="--compare")
        self.assert_refused("loop", "--keep", "kept", expected="--compare")
        self.assert_refused("loop", "--compare", "--seeds", "0", expected="--seeds")
        self.assert_refused("loop", "--compare", "--setup", "mine", expected="--setup")
        self.assert_refused("loop", "--compare", "--effects", "cogging", expected="cogging")
        self.assert_refused("loop", "--compare", "--effects", "viscous", "--strength", "-1", expected="--strength")

    def test_what_is_kept_is_of_this_comparison_or_refused(self):
        kept = pathlib.Path(self.here, "kept")
        kept.write_text('{"schema": "urn:slipstack:loop-compare-axis-1", "task": "another", "seed": 1, "contenders": {}}\n')
        self.assert_refused("loop", "--compare", "--keep", "kept", expected="kept:1: it keeps another comparison (another)")
        kept.write_text("time_s,position_m\n")
        self.assert_refused("loop", "--compare", "--keep", "kept", expected="kept:1: not a line of a comparison")
        self.assertEqual(kept.read_text(), "time_s,position_m\n")
        self.assert_refused("loop", "--compare", "--keep", "no/such/kept", expected="no/such/kept: cannot be written")


if __name__ == "__main__":
    program.main()
