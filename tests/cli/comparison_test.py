# SPDX-License-Identifier: Apache-2.0
"""`slipstack loop --compare` as typed: wrong use in one line, nothing written."""

import unittest

import program


class Comparison(program.Workshop):
    def assert_refused(self, *arguments, expected):
        done = program.run(*arguments, cwd=self.here)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stdout, b"")
        self.assert_one_line(done.stderr, expected)

    def test_a_comparison_takes_no_options_of_a_run(self):
        for arguments in (("--model", "m.toml"), ("--effects", "viscous"), ("--board", "host"), ("--out", "log.csv")):
            self.assert_refused("loop", "--compare", *arguments, expected="--compare")
        self.assert_refused("loop", "--seeds", "2", expected="--compare")
        self.assert_refused("loop", "--compare", "--seeds", "0", expected="--seeds")
        self.assert_refused("loop", "--compare", "--setup", "mine", expected="--setup")


if __name__ == "__main__":
    program.main()
