#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis depends on what was measured: not on how it was written down, nor on the machine."""

import math
import os
import unittest

import program

HEADER = 5
MOTOR_CONSTANT_N_PER_A = 60.0


class Written(program.Workshop):
    """The same log written in other ways."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        lines = (cls.stock / "good.csv").read_text().splitlines()
        cls.head, cls.names = lines[:HEADER], lines[HEADER].split(",")
        cls.rows = [[float(field) for field in line.split(",")] for line in lines[HEADER + 1:]]
        assert cls.names == ["time_s", "position_m", "force_N"]
        cls.expected = cls.diagnosis(cls.stock)

    @staticmethod
    def diagnosis(folder):
        done = program.run("diagnose", "good.csv", "--stepwise", "--json", "-", cwd=folder)
        assert done.returncode == 0, done.stderr
        return program.published(done.stdout)

    def write(self, names, rows, head=None):
        with open(self.here / "good.csv", "w", encoding="utf-8") as file:
            file.write("\n".join([*(self.head if head is None else head), ",".join(names)]) + "\n")
            file.writelines(",".join(repr(value) for value in row) + "\n" for row in rows)

    def assert_same(self, what, tolerance):
        """The same verdict, the same effect named, the same errors."""
        found = self.diagnosis(self.here)
        with self.subTest(what):
            self.assertEqual(found["verdict"], self.expected["verdict"])
            # Whether a further small effect is significant may depend on the last bit; the first must not.
            self.assertEqual(found["steps"][1]["effect"], self.expected["steps"][1]["effect"])
            self.assertEqual(found["candidates"][0]["effect"], self.expected["candidates"][0]["effect"])
            # Wider on one side, so that an effect at the limit is not lost to the last bit.
            errors = self.errors(self.expected, 0.0)
            for effect, error_N in self.errors(found, 0.05).items():
                self.assertTrue(math.isclose(error_N, errors[effect], rel_tol=tolerance), (what, effect))

    @staticmethod
    def errors(result, least_reduction):
        """Held-out errors by effect, of those that lower the error: the shapes of others are not determined."""
        before = result["baseline"]["holdout_rmse_N"]
        return {"baseline": before, **{candidate["effect"]: candidate["holdout_rmse_N"]
                                       for candidate in result["candidates"] if candidate["error_reduction"] > least_reduction}}

    def test_plain_copy(self):
        self.write(self.names, self.rows)
        self.assert_same("as it was", 0.0)

    def test_column_order(self):
        for order in ((1, 0, 2), (2, 1, 0), (1, 2, 0)):
            self.write([self.names[i] for i in order], ([row[i] for i in order] for row in self.rows))
            self.assert_same(f"columns {order}", 0.0)

    def test_header_order_and_remarks(self):
        self.write(self.names, self.rows, head=["# operator: J. Doe", "#", *reversed(self.head), "# just a remark"])
        self.assert_same("header lines", 0.0)

    def test_units(self):
        resolution_m = 1e-6
        ways = {
            "position_mm": (1, lambda x: x * 1e3),
            "position_um": (1, lambda x: x * 1e6),
            "position_counts": (1, lambda x: round(x / resolution_m)),
            "force_mN": (2, lambda force: force * 1e3),
            "force_uN": (2, lambda force: force * 1e6),
            "current_A": (2, lambda force: force / MOTOR_CONSTANT_N_PER_A),
        }
        for name, (column, convert) in ways.items():
            names = list(self.names)
            names[column] = name
            self.write(names, ([*row[:column], convert(row[column]), *row[column + 1:]] for row in self.rows))
            # Rounding of the written numbers, seen through searches that stop at 1e-5.
            self.assert_same(name, 1e-4)

    def test_when_the_clock_started(self):
        for start_s in (-3.5, 86400.0):
            self.write(self.names, ([start_s + row[0], *row[1:]] for row in self.rows))
            self.assert_same(f"start at {start_s} s", 1e-6)

    def test_where_zero_is(self):
        for shift_m in (-0.25, 12.0):
            self.write(self.names, ([row[0], round(row[1] + shift_m, 9), row[2]] for row in self.rows))
            self.assert_same(f"zero at {shift_m} m", 1e-4)

    def test_which_way_is_positive(self):
        self.write(self.names, ([row[0], -row[1], -row[2]] for row in self.rows))
        # The encoder realisations, by which rows are weighted, are mirror images of each other.
        self.assert_same("mirrored", 1e-6)


class Machine(program.Workshop):
    """The same bytes from every run, however many processors."""

    def outputs(self, **options):
        # A model says in its history when it was made: at the same time, every byte is the same.
        options["env"] = dict(options.get("env", os.environ), SOURCE_DATE_EPOCH="1767225600")
        self.assert_done("diagnose", "good.csv", "--stepwise", "--report", "r.html", "--json", "j.json", **options)
        self.assert_done("fit", "good.csv", "--effects", "inertia,presliding_hysteresis,stribeck", "--model", "m.toml",
                         "--json", "f.json", **options)
        return {name: content for name, content in self.content().items() if not name.startswith("good")}

    def test_again(self):
        self.assertEqual(self.outputs(), self.outputs())

    @unittest.skipIf(len(os.sched_getaffinity(0)) < 2, "one processor")
    def test_one_processor_and_all(self):
        one = min(os.sched_getaffinity(0))
        self.assertEqual(self.outputs(), self.outputs(preexec_fn=lambda: os.sched_setaffinity(0, {one})))

    def test_other_language(self):
        other = dict(os.environ, LC_ALL="de_DE.UTF-8", LANG="de_DE.UTF-8", TZ="Asia/Kolkata")
        self.assertEqual(self.outputs(), self.outputs(env=other))


if __name__ == "__main__":
    program.main()
