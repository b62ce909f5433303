#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The site of the documentation is made without a broken link, and no public name lacks its description. The commands of
the pages are typed by tests/documents."""

import re
import shutil
import subprocess
import sys
import unittest

import program

DOCS = program.REPOSITORY / "docs"
SITE_SKIPPED = 77


class Documented(program.Workshop):
    def test_site(self):
        done = subprocess.run([sys.executable, "-B", program.REPOSITORY / "toolchain/site", "--program", program.SLIPSTACK,
                               "--python-path", self.here / "none", "--out", self.here / "site"], capture_output=True, text=True)
        if done.returncode == SITE_SKIPPED:
            self.skipTest(done.stdout.strip())
        self.assertEqual(done.returncode, 0, done.stderr)
        html = self.here / "site/html"
        self.assertIn("slipstack experiment plan", (html / "commands.html").read_text())
        reference = (html / "cpp-reference.html").read_text()
        if shutil.which("doxygen"):  # of each header of the library: a class, a function, a field, a concept
            for name in ("MaxwellSlip", "MemoryStack", "set_elements", "acceleration_mps2", "PreparesGains", "model_hash", "kNotAscending"):
                self.assertIn(name, reference)
            self.assertNotIn("detail", reference)
        # Every page is in the menu: what is in docs but not there would be found by nobody.
        pages = {str(page.relative_to(DOCS)) for page in DOCS.glob("*.md")}
        menu = (program.REPOSITORY / "toolchain/mkdocs.yml").read_text()
        self.assertEqual({page for page in pages if f": {page}\n" not in menu}, set())
        # Anchors, which MkDocs does not check.
        texts = {page.resolve(): page.read_text() for page in html.rglob("*.html")}
        anchors = {page: set(re.findall(r'id="([^"]+)"', text)) for page, text in texts.items()}
        broken = {f"{page.name}: {target}#{anchor}" for page, text in texts.items()
                  for target, anchor in re.findall(r'href="([^":#]*)#([^"]+)"', text)
                  if anchor not in anchors.get((page.parent / target).resolve() if target else page, {anchor})}
        self.assertEqual(broken, set())


    @unittest.skipUnless(shutil.which("doxygen"), "doxygen is not installed")
    def test_a_public_name_without_a_docstring_is_refused(self):
        copy = self.here / "copy"
        for folder in ("friction", "effects"):
            shutil.copytree(program.REPOSITORY / "firmware" / folder, copy / "firmware" / folder)
        done = self.reference_of(copy)
        self.assertEqual(done.stdout, "made\n", done.stderr)
        header = copy / "firmware/friction/maxwell_slip.h"
        text = header.read_text()
        place = text.index("  constexpr void reset(")
        header.write_text(text[:place] + "  void another() const {}\n\n" + text[place:])
        header.write_text(header.read_text().replace("  /// Unloads every spring at position x: the virgin state.\n", ""))
        done = self.reference_of(copy)
        self.assertIn("maxwell_slip.h", done.stdout)
        self.assertIn("another() const (function) of class slipstack::MaxwellSlip is not documented", done.stdout)

    def reference_of(self, root):
        return subprocess.run([sys.executable, "-B", "-c", "import pathlib, sys, site_cpp\ntry:\n  site_cpp.page(pathlib.Path(sys.argv[1]))\n"
                               "  print('made')\nexcept site_cpp.Undocumented as error:\n  print(error)", root],
                              cwd=program.REPOSITORY / "toolchain", capture_output=True, text=True, check=True)


if __name__ == "__main__":
    program.main()
