# SPDX-License-Identifier: Apache-2.0
"""The EDS, the DBC and the reference page: not stale, after the rules, and of one mind."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from eds import BITS, Eds

DOCS = pathlib.Path(__file__).resolve().parents[3] / "docs"
FILES = ("slipstack.eds", "slipstack.dbc", "object-dictionary.md", "effect-objects.csv")
PROGRAM = os.environ.get("CANOPEN_FILES", str(DOCS.parent / "build/host/bin/canopen-files"))


class DescriptionFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.text = (DOCS / "slipstack.eds").read_text(encoding="ascii")
        cls.eds = Eds(cls.text)

    def test_none_is_stale(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, folder], check=True)
            for name in FILES:
                self.assertEqual((pathlib.Path(folder) / name).read_bytes(), (DOCS / name).read_bytes(),
                                 f"docs/{name} is stale: run toolchain/regenerate")

    def test_an_effect_keeps_its_place(self):
        rows = (DOCS / "effect-objects.csv").read_text().splitlines(keepends=True)
        moved = [*rows[:-2], rows[-1].split(",")[0] + "," + rows[-2].split(",")[1], rows[-1]]
        for text, status in (("".join(rows[:-1]), 0), ("".join(moved), 2)):
            with self.subTest(status=status), tempfile.TemporaryDirectory() as folder:
                kept = pathlib.Path(folder, "effect-objects.csv")
                kept.write_text(text)
                done = subprocess.run([PROGRAM, folder], capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, status, done.stderr)
                self.assertEqual(kept.read_text(), "".join(rows) if status == 0 else text)
                self.assertEqual(done.stderr.count("\n"), status // 2)

    def test_eds_keeps_the_rules(self):
        self.assertEqual(self.eds.problems, [])
        self.assertGreater(len(self.eds.objects), 400)

    def test_the_checker_can_fail(self):
        for what, by in (("DataType=0x0007", "DataType=0x00FF"), ("PDOMapping=1", "PDOMapping=2"),
                         ("DataType=0x000F", "PDOMapping=0\nDataType=0x000F"), ("AccessType=ro", "AccessType=read"), ("SubNumber=5", "SubNumber=4"),
                         ("[1018]", "[1019]"), ("SupportedObjects=3", "SupportedObjects=4"),
                         ("CreationDate=01-01-2026", "CreationDate=2026-01-01"), ("LowLimit=0x", "LowLimit=zero"),
                         ("DefaultValue=$NODEID+0x80", "DefaultValue=0x1FFFFFFFF")):
            self.assertIn(what, self.text)
            self.assertNotEqual(Eds(self.text.replace(what, by, 1)).problems, [], what)

    def test_objects_that_the_standards_want(self):
        # CiA 301 table 54; CiA 402, chapters 6 to 10, for pp and csp.
        for index, sub, data_type, access in (
                (0x1000, 0, 7, "const"), (0x1001, 0, 5, "ro"), (0x1003, 0, 5, "rw"), (0x1005, 0, 7, "rw"),
                (0x1014, 0, 7, "rw"), (0x1016, 1, 7, "rw"), (0x1017, 0, 6, "rw"), (0x1018, 1, 7, "const"),
                (0x1018, 4, 7, "ro"), (0x1200, 1, 7, "const"), (0x1400, 1, 7, "rw"), (0x1A00, 8, 7, "rw"),
                (0x603F, 0, 6, "ro"), (0x6040, 0, 6, "rw"), (0x6041, 0, 6, "ro"), (0x605A, 0, 3, "rw"),
                (0x605E, 0, 3, "rw"), (0x6060, 0, 2, "rw"), (0x6061, 0, 2, "ro"), (0x6064, 0, 4, "ro"),
                (0x606C, 0, 4, "ro"), (0x6077, 0, 3, "ro"), (0x607A, 0, 4, "rw"),
                (0x6081, 0, 7, "rw"), (0x60C2, 1, 5, "rw"), (0x60F4, 0, 4, "ro"),
                (0x6502, 0, 7, "const")):
            with self.subTest(index=f"{index:04X}", sub=sub):
                entry = self.eds.objects[index, sub]
                self.assertEqual((entry["type"], entry["access"]), (data_type, access))

    def test_default_pdos_map_what_may_be_mapped(self):
        for comm, mapping in ((0x1400, 0x1600), (0x1800, 0x1A00)):
            for n in range(4):
                count = self.eds.objects[mapping + n, 0]["default"]
                bits = 0
                for sub in range(1, count + 1):
                    entry = self.eds.objects[mapping + n, sub]["default"]
                    mapped = self.eds.objects[entry >> 16, entry >> 8 & 0xFF]
                    self.assertTrue(mapped["mapped"], f"{entry:08X}")
                    self.assertEqual(BITS[mapped["type"]], entry & 0xFF)
                    bits += entry & 0xFF
                self.assertLessEqual(bits, 64)
                cob = self.eds.objects[comm + n, 1]["default"] & 0x7FF
                self.assertEqual(cob, (0x200 if comm == 0x1400 else 0x180) + 0x100 * n + self.eds.node)

    def test_dbc_says_what_the_eds_says(self):
        text = (DOCS / "slipstack.dbc").read_text(encoding="ascii")
        messages = {}
        for line in text.splitlines():
            if match := re.fullmatch(r"BO_ (\d+) ([RT])PDO(\d): (\d) (Master|Drive)", line):
                signals = messages.setdefault((match[2], int(match[3])), [])
                base = 0x1400 if match[2] == "R" else 0x1800
                cob = self.eds.objects[base + int(match[3]) - 1, 1]["default"]
                self.assertEqual(int(match[1]), cob & 0x7FF, line)
            elif match := re.match(r" SG_ (\w+) : (\d+)\|(\d+)@1([+-]) \(([^,]+),0\)", line):
                signals.append((int(match[2]), int(match[3]), match[4]))
        for (way, number), signals in messages.items():
            mapping = (0x1600 if way == "R" else 0x1A00) + number - 1
            self.assertEqual(len(signals), self.eds.objects[mapping, 0]["default"])
            at = 0
            for sub, (start, length, sign) in enumerate(signals, 1):
                entry = self.eds.objects[mapping, sub]["default"]
                mapped = self.eds.objects[entry >> 16, entry >> 8 & 0xFF]
                self.assertEqual((start, length), (at, entry & 0xFF))
                self.assertEqual(sign, "-" if mapped["type"] in (2, 3, 4, 8) else "+")
                at += length
        self.assertEqual(len(messages), 6)


if __name__ == "__main__":
    unittest.main()
