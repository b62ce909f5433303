#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Unusable model files: refused like unusable logs, with file and line."""

import re
import unittest

import program
from program import every_command


def replaced(pattern, replacement):
    """The first match of `pattern` replaced."""
    def change(text):
        changed, count = re.subn(pattern, replacement, text, count=1, flags=re.MULTILINE)
        assert count == 1, pattern
        return changed
    return change


def first_number(name, replacement):
    """The first number of the array of values named `name` within [[effect]] replaced."""
    return replaced(r"(^\[\[effect\]\](?s:.)*?name = '%s'(?s:.)*?value = \[\s*)[-+0-9.e]+" % name,
                    r"\g<1>" + replacement)


# what is wrong: (change to the text, pattern of the message)
SPOILT = {
    "unknown effect": (replaced(r"^id = 'inertia'", "id = 'magic'"),
                       r"bad\.toml:\d+: unknown effect 'magic'; known: inertia, "),
    "no id": (replaced(r"^id = 'inertia'\n", ""), r"bad\.toml:\d+: .*no id"),
    "effect twice": (replaced(r"^id = 'presliding_hysteresis'", "id = 'inertia'"), r"bad\.toml:\d+: .*twice"),
    "negative stiffness": (first_number("stiffness", "-1.0"), r"bad\.toml:\d+: stiffness = -1 is out of bounds"),
    "huge stiffness": (first_number("stiffness", "1e300"), r"bad\.toml:\d+: stiffness = 1e\+300 is out of bounds"),
    "negative slip": (first_number("slip_distance", "-1e-6"), r"bad\.toml:\d+: slip_distance = -1e-06 is out of b"),
    "NaN": (first_number("stiffness", "nan"), r"bad\.toml:\d+: stiffness is not a finite number"),
    "infinity": (first_number("stiffness", "inf"), r"bad\.toml:\d+: stiffness is not a finite number"),
    "text in a number": (first_number("stiffness", "'stiff'"), r"bad\.toml:\d+: stiffness is not a finite number"),
    "other unit": (replaced(r"unit = 'kg'", "unit = 'g'"), r"bad\.toml:\d+: mass has unit 'g'; it must be 'kg'"),
    "other parameter": (replaced(r"name = 'mass'", "name = 'weight'"), r"bad\.toml:\d+: unknown gain 'weight' of effect"),
    "unknown key": (replaced(r"^id = 'inertia'", "id = 'inertia'\ncolour = 'red'"), r"bad\.toml:\d+: .*'colour'"),
    "other hash": (replaced(r"hash = '\w+'", "hash = '00000000'"), r"bad\.toml:\d+: hash does not belong"),
    "parameter of the target": (replaced(r"value = \[ [0-9.]+", "value = [ 1.0"), r"bad\.toml:4: hash does not"),
    "not TOML": (replaced(r"^id = 'inertia'", "id = inertia"), r"bad\.toml:\d+: not TOML: "),
    "other format": (replaced(r"format = .*", "format = 'slipstack model 99'"), r"bad\.toml:\d+: .*format"),
    "no target": (replaced(r"\[target\](?s:.)*?\n(?=\[\[effect)", ""), r"bad\.toml:\d+: table \[target\] is missing"),
    "cut off": (lambda text: text[:len(text) // 2], r"bad\.toml:\d+: "),
    "no effects": (lambda text: "format = 'slipstack model 1'\n", r"bad\.toml:\d+: no \[\[effect\]\]"),
    "a log": (lambda text: "time_s,position_m,force_N\n0,0,0\n", r"bad\.toml:1: not TOML: "),
    "zero bytes": (lambda text: "", r"bad\.toml:.* format "),
}


class BadModel(program.Workshop):
    def refuse_everywhere(self, *expected):
        for name, command in every_command(model="bad.toml").items():
            if name != "fit":  # fit only writes a model
                with self.subTest(command=name):
                    self.assert_refused(command, *expected)

    def test_damaged_text(self):
        good = (self.here / "good.toml").read_text()
        for what, (change, pattern) in SPOILT.items():
            (self.here / "bad.toml").write_text(change(good))
            for name in ("compare", "diagnose", "add"):
                with self.subTest(what, command=name):
                    command = every_command(model="bad.toml")[name]
                    done = self.run_here(*command)
                    self.assertRegex(done.stderr.decode(), pattern)
                    self.assert_refused(command)

    def test_the_line_is_that_of_the_error(self):
        lines = (self.here / "good.toml").read_text().splitlines()
        line = next(i for i, text in enumerate(lines) if "unit = 'kg'" in text)
        lines[line] = lines[line].replace("kg", "lb")
        (self.here / "bad.toml").write_text("\n".join(lines))
        done = self.run_here("compare", "good.csv", "--model", "bad.toml")
        named = int(re.search(r"bad\.toml:(\d+):", done.stderr.decode()).group(1))
        self.assertLessEqual(abs(named - (line + 1)), 4, done.stderr)  # the table that holds the value

    def test_sparse_two_gigabytes(self):
        with open(self.here / "bad.toml", "wb") as file:
            file.truncate(2 << 30)
        self.refuse_everywhere("bad.toml", "larger than any model")

    def test_directory_and_nothing(self):
        self.refuse_everywhere("bad.toml", "no such file")
        (self.here / "bad.toml").mkdir()
        self.refuse_everywhere("bad.toml", "not a file")

    def test_crlf_and_byte_order_mark_are_read(self):
        text = (self.here / "good.toml").read_bytes()
        (self.here / "other.toml").write_bytes(b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n"))
        plain = self.assert_done("compare", "good.csv", "--model", "good.toml").stdout
        other = self.assert_done("compare", "good.csv", "--model", "other.toml").stdout
        self.assertEqual(plain.replace(b"good.toml", b"other.toml"), other)

    def test_a_model_for_the_controller_may_be_edited_without_its_hash(self):
        text = (self.here / "good.toml").read_text()
        (self.here / "other.toml").write_text(re.sub(r"hash = .*\n", "", text))
        self.assert_done("compare", "good.csv", "--model", "other.toml")


if __name__ == "__main__":
    program.main()
