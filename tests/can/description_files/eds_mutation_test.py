# SPDX-License-Identifier: Apache-2.0
"""The reader of data sheets against data sheets that are not: random damage never makes it fall over, and damage that
changes what a sheet says is seen, by a complaint or by other objects."""

import os
import pathlib
import random
import re
import unittest

from eds import Eds

SHEET = (pathlib.Path(__file__).resolve().parents[3] / "docs/slipstack.eds").read_text(encoding="ascii")
TRIES = int(os.environ.get("SLIPSTACK_EDS_MUTATIONS", "120"))


def objects_of(eds):
    return eds.objects, {name: dict(keys) for name, keys in eds.sections.items() if re.fullmatch(r"[0-9A-F]{4}.*", name)}


def damage_bytes(rng, text):
    """Bytes changed, removed, doubled, moved; whole lines too."""
    lines = text.split("\n")
    for _ in range(rng.choice((1, 1, 1, 3, 20))):
        at = rng.randrange(len(lines))
        what = rng.randrange(8)
        if what == 0:
            del lines[at]
        elif what == 1:
            lines.insert(at, lines[rng.randrange(len(lines))])
        elif what == 2:
            lines[at] = lines[at][:rng.randrange(len(lines[at]) + 1)]
        elif what == 3:
            lines[at] += chr(rng.choice((0, 7, 61, 91, 93, 127, 233, 0x4E2D)))
        elif what == 4:
            lines[at] = lines[at].replace("=", rng.choice(("", "==", " = ", ":")), 1)
        elif what == 5:
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        elif what == 6:
            place = rng.randrange(len(lines[at]) + 1)
            lines[at] = lines[at][:place] + chr(rng.randrange(32, 127)) + lines[at][place + 1:]
        else:
            lines[at] = "A" * rng.choice((254, 256, 5000)) + lines[at]
        if not lines:
            break
    return "\n".join(lines)


# A line of an object, and what it may be changed to: each says something else, or nothing that is allowed.
LIES = (("DataType", lambda r, v: r.choice(("0x0000", "0x0010", "9", "", "five"))),
        ("AccessType", lambda r, v: r.choice(("rx", "", "RW ", "read"))),
        ("ObjectType", lambda r, v: r.choice(("0x1", "0x6", "", "seven"))),
        ("PDOMapping", lambda r, v: r.choice(("2", "", "yes", "-1"))),
        ("SubNumber", lambda r, v: str(int(v, 0) + r.choice((-1, 1, 100)))),
        ("SupportedObjects", lambda r, v: str(int(v, 0) + r.choice((-1, 1, 1000)))),
        ("ParameterName", lambda r, v: r.choice(("", "x" * 250))),
        ("DefaultValue", lambda r, v: r.choice(("0x1FFFFFFFF", "nothing", "1e3x"))))


class Mutations(unittest.TestCase):
    def test_the_sheet_itself_is_right(self):
        self.assertEqual(Eds(SHEET).problems, [])

    def test_random_damage_is_no_exception(self):
        seen = 0
        for seed in range(TRIES):
            rng = random.Random(seed)
            eds = Eds(damage_bytes(rng, SHEET))
            seen += bool(eds.problems)
        self.assertGreater(seen, TRIES // 2)

    def test_no_text_at_all_and_noise(self):
        for text in ("", "\n", "[", "[]", "=", "[FileInfo]", "\0" * 1000, "[1000]\n=\n", "[1000sub]\n[1000sub0]\n"):
            self.assertNotEqual(Eds(text).problems, [], repr(text))
        rng = random.Random(1)
        for _ in range(100):
            noise = "".join(chr(rng.choice((10, 61, 91, 93, 48, 49, 65, rng.randrange(1, 300)))) for _ in range(2000))
            self.assertNotEqual(Eds(noise).problems, [])

    def test_every_lie_is_seen(self):
        lines = SHEET.split("\n")
        good = objects_of(Eds(SHEET))
        for key, lie in LIES:
            places = [i for i, line in enumerate(lines) if line.startswith(key + "=")]
            if key == "DefaultValue":  # of numbers: the text of a string is what it is
                places = [i for i in places if re.search(r"=-?(0x)?[0-9]", lines[i]) and "VISIBLE" not in lines[i]]
            for seed in range(TRIES // 10):
                rng = random.Random(f"{key} {seed}")
                at = rng.choice(places)
                changed = list(lines)
                changed[at] = f"{key}={lie(rng, lines[at].partition('=')[2])}"
                eds = Eds("\n".join(changed))
                self.assertTrue(eds.problems or objects_of(eds) != good, f"line {at + 1}: {changed[at]}")
                if key not in ("DefaultValue", "DataType"):
                    self.assertTrue(eds.problems, f"line {at + 1}: {changed[at]}")


if __name__ == "__main__":
    unittest.main()
