# SPDX-License-Identifier: Apache-2.0
"""The catalogue as users read it: the list, one page, and the pages of docs/effects, which must not be stale."""

import pathlib
import unittest

import program

PAGES = program.REPOSITORY / "docs" / "effects"


class Effects(program.Workshop):
    def test_pages_in_the_documentation_are_what_the_program_writes(self):
        done = program.run("effects", "--pages", "pages", cwd=self.here)
        self.assertEqual(done.returncode, 0, done.stderr)
        fresh = {page.name: page.read_text() for page in pathlib.Path(self.here, "pages").iterdir()}
        kept = {page.name: page.read_text() for page in PAGES.iterdir()}
        self.assertEqual(fresh, kept, "run: toolchain/regenerate")

    def test_every_page_is_complete(self):
        listed = program.run("effects", cwd=self.here).stdout.decode().splitlines()[:-1]
        self.assertGreaterEqual(len(listed), 18)
        for line in listed:
            page = program.run("effects", line.split()[0], cwd=self.here).stdout.decode()
            for part in ("Formula", "Source", "leaves", "Usual cause", "confirms", "On the controller"):
                self.assertIn(f"**{part}" if part[0].isupper() else part, page)
            self.assertTrue((program.REPOSITORY / "firmware/effects" / f"{line.split()[0]}.h").is_file(), line)

    def test_unknown_effect(self):
        done = program.run("effects", "stiction", cwd=self.here)
        self.assertEqual(done.returncode, 2)
        self.assertIn(b"unknown effect 'stiction'", done.stderr)

    def test_folder_that_cannot_be_made(self):
        done = program.run("effects", "--pages", "good.csv/pages", cwd=self.here)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr.count(b"\n"), 1)


if __name__ == "__main__":
    program.main()
