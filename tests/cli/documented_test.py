#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What docs/tutorial.md, docs/other-programs.md and docs/install.md say can be typed does what they say, every command of every
page is one that the programs take, and the site of the documentation is made without a broken link."""

import itertools
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import unittest

import program

DOCS = program.REPOSITORY / "docs"
DATA = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", program.REPOSITORY / ".." / "shared")) / "data"
FOREIGN = program.REPOSITORY / "tests/data/foreign"
SITE_SKIPPED = 77


def blocks(page):
    """(language, text) of the blocks of a page, in their order."""
    return re.findall(r"^```(\w*)\n(.*?)^```$", (DOCS / page).read_text(), re.MULTILINE | re.DOTALL)


def normal(text):
    return re.sub(r" +", " ", text)


class Documented(program.Workshop):
    def shell(self, text):
        path = f"{pathlib.Path(program.SLIPSTACK).parent}:{os.environ['PATH']}"
        done = subprocess.run(["bash", "-ec", text], cwd=self.here, capture_output=True, text=True, timeout=program.PATIENCE_S,
                              env={**os.environ, "PATH": path})
        self.assertEqual(done.returncode, 0, f"{text}\n{done.stderr}")
        return done.stdout

    def test_tutorial(self):
        """Each line that it shows is one of the command before."""
        log = DATA / "emps/emps_estimation.csv"
        if not log.is_file():
            self.skipTest(f"{log} is not there; set SLIPSTACK_SHARED")
        shutil.copy(log, self.here / "emps.csv")
        output, commands, lines = "", 0, 0
        for language, text in blocks("tutorial.md"):
            if language == "sh":
                output = normal(self.shell(text))
                commands += 1
            elif language == "text":
                for line in text.splitlines():
                    self.assertIn(normal(line), output)
                    lines += 1
        self.assertEqual((commands, lines > 10), (5, True))
        for name in ("emps.html", "better.html", "setpoints.csv"):
            self.assertTrue((self.here / name).is_file(), name)

    def test_logs_of_other_programs(self):
        for name in ("scope.csv", "other.csv"):
            lines = (FOREIGN / "pandas_german.csv").read_text().splitlines()
            lines[0] = ";Zeit [ms];Pos [mm];F"
            (self.here / name).write_text("\n".join(lines))
        (imports, *_), = [[text for _, text in blocks("other-programs.md") if text.startswith("slipstack import")]]
        self.shell(imports)
        first, second = ((self.here / name).read_text().splitlines() for name in ("log.csv", "log2.csv"))
        self.assertEqual(first[-1], second[-1])
        self.assertGreater(len(first), 1000)

    def test_every_command_is_taken(self):
        """Commands of all pages with an option that there is not: it is the only thing that the programs complain about."""
        asked = 0
        pages = [program.REPOSITORY / "README.md", *sorted(DOCS.rglob("*.md"))]
        for page in pages:
            for _, text in re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL):
                for line in text.replace("\\\n", " ").splitlines():
                    line = re.sub(r"^(\$ |\. <\()", "", line.strip())
                    if not re.match(r"slipstack(-sim)? [a-z-]", line):
                        continue
                    words = shlex.shlex(line, posix=True, punctuation_chars="|&;<>()")
                    words.whitespace_split = True
                    words = list(itertools.takewhile(lambda word: not set(word) <= set("|&;<>()"), words))
                    name = {"slipstack": program.SLIPSTACK, "slipstack-sim": program.SLIPSTACK_SIM}[words[0]]
                    if page.name == "hardware.md":  # which says that they are left out there
                        words += ["--can", "vcan0", "--node", "5"]
                    done = subprocess.run([name, *words[1:], "--no-such-option"], cwd=self.here, capture_output=True, text=True,
                                          timeout=program.PATIENCE_S)
                    with self.subTest(page=page.name, line=line):
                        self.assertEqual(done.returncode, 2, done.stdout)
                        self.assertIn("not expected: --no-such-option;", done.stderr)
                    asked += 1
        self.assertGreater(asked, 60)

    def test_manual_and_completion(self):
        text = [text for _, text in blocks("install.md") if text.startswith("slipstack manual")]
        self.assertIn("pages in man", self.shell(text[0]))
        self.assertTrue((self.here / "man/slipstack-diagnose.1").is_file())

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
