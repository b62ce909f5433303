#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The packages as they are installed, each by what its user does first. Run by `toolchain/fresh packages` in a root that
has nothing but the base system and these packages; for the headers, a compiler and CMake too.

    installed_test.py REPOSITORY VERSION    the repository for its examples, the version that was packed
"""

import gzip
import json
import os
import pathlib
import re
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request

PATIENCE_S = 240
EFFECT = "viscous"


def run(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=PATIENCE_S, **options)


class Installed(unittest.TestCase):
    repository = pathlib.Path()
    version = ""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.here = pathlib.Path(folder.name)
        os.chdir(cls.here)
        cls.done("slipstack-sim", "log", "--seed", 1, "--effects", EFFECT, "--seconds", 8, "--rate", 500, "--strength", 10,
                 "--out", "log.csv")

    @staticmethod
    def done(*words, **options):
        done = run(*words, **options)
        if done.returncode != 0:
            raise AssertionError(f"{words}: status {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    def test_programs_are_those_of_the_packages(self):
        self.assertEqual(self.done("slipstack", "--version").split(), ["slipstack", self.version])
        self.assertEqual(self.done("which", "slipstack").strip(), "/usr/bin/slipstack")

    def test_a_log_is_diagnosed(self):
        result = json.loads(self.done("slipstack", "diagnose", "log.csv", "--report", "report.html", "--json", "-"))
        self.assertEqual(result["candidates"][0]["effect"], EFFECT)
        self.assertIn("uPlot", (self.here / "report.html").read_text(), "the report has no charts")

    def test_python_package(self):
        text = self.done("python3", "-c", "import slipstack; found = slipstack.diagnose('log.csv'); "
                         "print(slipstack.__file__, slipstack.__version__, found.candidates[0].effect)")
        self.assertEqual(text.split(), ["/usr/lib/python3/dist-packages/slipstack/__init__.py", self.version, EFFECT])

    def test_captures_of_candump(self):
        done = self.done("python3", "-m", "slipstack.candump", self.repository / "tests/data/foreign/candump.log", "--eds",
                         "/usr/share/slipstack/slipstack.eds", "--out", "-")
        self.assertGreater(done.count("\n"), 100)

    def test_results_name_an_installed_schema(self):
        result = json.loads(self.done("slipstack", "fit", "log.csv", "--effects", "inertia,coulomb", "--json", "-"))
        path = pathlib.Path("/usr/share/slipstack/schema", result["schema"].rpartition(":")[2] + ".json")
        self.assertEqual(json.loads(path.read_text())["$id"], result["schema"])

    def serve(self, *options, **environment):
        server = subprocess.Popen(["slipstack", "serve", "--session", str(self.here / "session"), *options, "log.csv"],
                                  stdout=subprocess.PIPE, text=True, env={**os.environ, **environment})

        def end():
            server.send_signal(signal.SIGINT)
            self.assertEqual(server.wait(PATIENCE_S), 0)
            server.stdout.close()
        self.addCleanup(end)
        line = server.stdout.readline().strip()
        self.assertRegex(line, r"^http://127\.0\.0\.1:\d+/#token=\w+$")
        return line

    @staticmethod
    def fetch(address, token=None):
        request = urllib.request.Request(address, headers={"Authorization": f"Bearer {token}"} if token else {})
        with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:
            return answer.read().decode()

    def test_pages_of_serve(self):
        base, token = self.serve().split("#token=")
        page = self.fetch(base)
        parts = re.findall(r'(?:src|href)="(/?[\w./-]+)"', page)
        self.assertGreaterEqual(len(parts), 2, "the page names neither style nor script")
        for part in parts:
            self.assertGreater(len(self.fetch(base + part.lstrip("/"))), 100, part)
        self.assertIn("log.csv", self.fetch(base + "api/state", token))
        with self.assertRaises(urllib.error.HTTPError):
            self.fetch(base + "api/state")

    def test_desktop_entry_opens_the_browser(self):
        entry = pathlib.Path("/usr/share/applications/slipstack.desktop").read_text()
        self.assertIn("\nExec=slipstack serve --open %F\n", entry)
        self.assertIn("\nIcon=slipstack\n", entry)
        self.assertIn("<svg", pathlib.Path("/usr/share/icons/hicolor/scalable/apps/slipstack.svg").read_text())
        opener = self.here / "bin/xdg-open"
        opener.parent.mkdir()
        opener.write_text(f'#!/bin/sh\necho "$@" > {self.here}/opened.new\nstat -c %a "$1" >> {self.here}/opened.new\n'
                          f'cat "$1" >> {self.here}/opened.new\nmv {self.here}/opened.new {self.here}/opened\n')
        opener.chmod(opener.stat().st_mode | stat.S_IXUSR)
        address = self.serve("--open", PATH=f"{opener.parent}:{os.environ['PATH']}")
        deadline = time.monotonic() + 10
        while not (self.here / "opened").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        arguments, mode, page = (self.here / "opened").read_text().split("\n", 2)
        self.assertNotIn("token", arguments, "every user could read it")
        self.assertEqual(mode, "600")
        self.assertIn(f"url={address}", page)

    def test_no_browser_is_said_in_one_line(self):
        done = run("/usr/bin/slipstack", "serve", "--open", "--session", "session2", "log.csv", env={"PATH": "/nowhere"})
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1), done.stderr)
        self.assertIn("xdg-utils", done.stderr)

    def test_man_pages_and_completions(self):
        for page in ("slipstack.1.gz", "slipstack-experiment-plan.1.gz", "slipstack-sim-log.1.gz"):
            text = gzip.decompress(pathlib.Path("/usr/share/man/man1", page).read_bytes()).decode()
            self.assertIn(".SH SYNOPSIS", text)
        script = ("set -u; . /usr/share/bash-completion/completions/slipstack; COMP_WORDS=(slipstack diag); COMP_CWORD=1; "
                  "_slipstack; echo \"${COMPREPLY[@]}\"")
        self.assertEqual(self.done("bash", "-c", script), "diagnose\n")

    def test_images_are_found(self):
        # Without the emulator the complaint is about the emulator, not about the image.
        done = run("slipstack", "loop", "--board", "mps2-an386", "--seconds", "8")
        self.assertEqual(done.returncode, 2)
        self.assertIn("install the package qemu-system-arm", done.stderr)

    def test_headers(self):
        build = self.here / "example"
        self.done("cmake", "-S", self.repository / "docs/examples/host", "-B", build)
        self.done("cmake", "--build", build)
        self.assertEqual(len(self.done(build / "friction_example").split()), 200)
        self.assertIn("slipstack_DIR:PATH=/usr/share/cmake/slipstack", (build / "CMakeCache.txt").read_text())

    def test_documents(self):
        for package in ("slipstack", "slipstack-firmware", "python3-slipstack", "libslipstack-dev"):
            folder = pathlib.Path("/usr/share/doc", package)
            self.assertIn("Apache-2.0", (folder / "copyright").read_text())
            self.assertIn(self.version, gzip.decompress((folder / "changelog.Debian.gz").read_bytes()).decode())
        self.assertTrue(pathlib.Path("/usr/share/doc/slipstack/docs/log-format.md").is_file())
        self.assertTrue(pathlib.Path("/usr/share/octave/site/m/slipstack/slipstack.m").is_file())


if __name__ == "__main__":
    Installed.repository, Installed.version = pathlib.Path(sys.argv[1]), sys.argv[2]
    unittest.main(argv=sys.argv[:1])
