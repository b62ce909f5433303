#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The constants of the diagnosis: each is in a table of docs/theory.md with its value, has a comment, and no more decide
than the document says; and the diagnosis knows no effect by its name.
"""

import pathlib
import re
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
DIAGNOSIS = REPOSITORY / "workbench/diagnose"
DOCUMENT = REPOSITORY / "docs/theory.md"
LIMIT = 20  # constants that decide, at most

# Texts and tables of texts are no numbers.
DEFINITION = re.compile(r"^ *(?:static |inline )*constexpr (?!const char|std::string_view|std::array)[\w:]+ (k\w+)\s*(?:= ([^;]+)|(\{[^;]+\}));(.*)$",
                        re.MULTILINE)
ANY_DEFINITION = re.compile(r"^ *(?:static |inline )*constexpr [^;(]*?\b(k[A-Z]\w*)\b", re.MULTILINE)
OF_TEXTS = re.compile(r"constexpr (?:const char|std::string_view|std::array<EachWayName)")


def sources():
    return sorted(path for path in DIAGNOSIS.rglob("*") if path.suffix in (".h", ".cpp"))


def is_commented(text, start, rest):
    """A comment behind the definition, or above it: perhaps above other constants in between."""
    if "//" in rest:
        return True
    for line in reversed(text[:start].splitlines()):
        if line.strip().startswith("//"):
            return True
        if "constexpr" not in line:
            return False
    return False


class Constant:
    def __init__(self, path, name, value, commented):
        self.path, self.name, self.value, self.commented = path.relative_to(REPOSITORY), name, value, commented


def constants_of(path):
    text = path.read_text()
    for found in DEFINITION.finditer(text):
        value = found[2] or found[3]
        # Of an effort the evaluations.
        value = value.strip("{}").split(",")[0].strip()
        yield Constant(path, found[1], value, is_commented(text, found.start(), found[4]))


def number_of(text):
    """A number, perhaps in per cent; None for an expression."""
    found = re.fullmatch(r"(-?[\d.]+(?:e-?\d+)?)( %)?", text)
    return float(found[1]) * (0.01 if found[2] else 1.0) if found else None


def table_of(document, heading):
    """The rows of the table whose first column has this heading: name and value of each constant."""
    rows = document.split(f"| {heading} |", 1)[1].split("\n\n", 1)[0].splitlines()[2:]
    told = []
    for row in rows:
        names, values = (cell.strip() for cell in row.strip("|").split("|")[:2])
        told += zip(re.findall(r"`(k\w+)`", names), values.split(", "), strict=True)
    return told


class Constants(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.document = DOCUMENT.read_text()
        cls.deciding = table_of(cls.document, "constant")
        cls.others = table_of(cls.document, "constant that does not decide")
        cls.constants = [one for path in sources() for one in constants_of(path)]

    def test_every_definition_is_read(self):
        for path in sources():
            text = path.read_text()
            lines = [line for line in text.splitlines() if ANY_DEFINITION.match(line) and not OF_TEXTS.search(line)]
            self.assertEqual([ANY_DEFINITION.match(line)[1] for line in lines], [one.name for one in constants_of(path)], path)
        names = [one.name for one in self.constants]
        self.assertEqual(len(names), len(set(names)), "two constants have one name")

    def test_each_is_in_one_table(self):
        told = [name for name, _ in self.deciding + self.others]
        self.assertEqual(sorted(told), sorted(one.name for one in self.constants))

    def test_each_has_the_value_of_its_table(self):
        told = dict(self.deciding + self.others)
        values = {one.name: number_of(one.value) for one in self.constants}
        for one in self.constants:
            value = told.get(one.name, "").strip("`")
            if value == one.value:
                continue
            computed = values[one.name]
            if computed is None and (product := re.fullmatch(r"static_cast<int>\(([\d.]+) / (k\w+)\)", one.value)):
                computed = round(float(product[1]) / values[product[2]])
            self.assertIsNotNone(number_of(value), f"{one.name}: {value} is not {one.value}")
            self.assertIsNotNone(computed, f"{one.name}: {value} is not {one.value}")
            self.assertAlmostEqual(computed, number_of(value), places=12, msg=one.name)

    def test_each_has_a_comment(self):
        self.assertEqual([f"{one.path}: {one.name}" for one in self.constants if not one.commented], [])

    def test_no_more_decide_than_the_document_says(self):
        stated = int(re.search(r"^(\d+) constants of `workbench/diagnose` decide", self.document, re.MULTILINE)[1])
        self.assertEqual(len(self.deciding), stated)
        self.assertLessEqual(stated, LIMIT)
        for row in self.document.split("| constant |", 1)[1].split("\n\n", 1)[0].splitlines()[2:]:
            self.assertGreater(len(row.strip("|").split("|")[3].strip()), 0, f"no source or measurement: {row}")

    def test_no_effect_is_known_by_its_name(self):
        ids = [re.search(r'\.id = "(\w+)"', path.read_text()) for path in (REPOSITORY / "firmware/effects").glob("*.h")]
        ids = [found[1] for found in ids if found]
        self.assertGreater(len(ids), 15)
        for path in sources():
            strings = re.findall(r'^(?!#include).*?"([^"\n]*)"', path.read_text(), re.MULTILINE)
            named = {effect for effect in ids for text in strings if text == effect or "_" in effect and effect in text}
            self.assertEqual(named, set(), path.relative_to(REPOSITORY))


if __name__ == "__main__":
    unittest.main()
