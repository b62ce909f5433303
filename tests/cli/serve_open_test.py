#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`slipstack serve --open`: the browser is given a page that this user alone can read, and never the address itself."""

import os
import pathlib
import re
import signal
import subprocess
import time
import unittest

import program

PATIENCE_S = 20.0


class ServeOpen(program.Workshop):
    def serve(self, folder):
        return subprocess.Popen([program.SLIPSTACK, "serve", "--open", "--session", "session", "good.csv"], cwd=self.here,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})

    def opener(self):
        """A folder with an xdg-open that notes its arguments, and the mode and content of the page."""
        opener = self.here / "bin/xdg-open"
        opener.parent.mkdir()
        opener.write_text(f'#!/bin/sh\nexec > {self.here}/opened.new\necho "$@"\nstat -c %a "$1"\ncat "$1"\n'
                          f'mv {self.here}/opened.new {self.here}/opened\n')
        opener.chmod(0o755)
        return opener.parent

    def test_the_browser_is_led_to_the_address(self):
        server = self.serve(self.opener())
        try:
            address = server.stdout.readline().strip()
            self.assertRegex(address, r"^http://127\.0\.0\.1:\d+/#token=\w+$")
            opened = self.here / "opened"
            deadline = time.monotonic() + PATIENCE_S
            while not opened.exists() and time.monotonic() < deadline:
                time.sleep(0.02)
            arguments, mode, page = opened.read_text().split("\n", 2)
            self.assertEqual(pathlib.Path(arguments), self.here / "session/open.html")
            self.assertEqual(mode, "600")
            self.assertEqual(re.findall(r"url=([^\"]+)", page), [address])
        finally:
            server.send_signal(signal.SIGINT)
            server.communicate(timeout=PATIENCE_S)
        self.assertEqual(server.returncode, 0)
        self.assertFalse((self.here / "session/open.html").exists(), "the page is left behind")

    def test_a_page_of_somebody_else_is_not_written_into(self):
        (self.here / "session").mkdir()
        (self.here / "other").write_text("mine")
        (self.here / "session/open.html").symlink_to(self.here / "other")
        server = self.serve(self.opener())
        server.stdout.readline()
        server.send_signal(signal.SIGINT)
        server.communicate(timeout=PATIENCE_S)
        self.assertEqual((self.here / "other").read_text(), "mine")

    def test_an_interrupt_ends_it_as_soon_as_the_address_is_there(self):
        for _ in range(10):
            server = subprocess.Popen([program.SLIPSTACK, "serve", "--session", "session"], cwd=self.here, stdout=subprocess.PIPE)
            server.stdout.readline()
            server.send_signal(signal.SIGINT)
            server.communicate(timeout=PATIENCE_S)
            self.assertEqual(server.returncode, 0)

    def test_without_a_browser(self):
        done = subprocess.run([program.SLIPSTACK, "serve", "--open", "--session", "session", "good.csv"], cwd=self.here,
                              capture_output=True, env={**os.environ, "PATH": "/nowhere"}, timeout=program.PATIENCE_S)
        self.assertEqual((done.returncode, done.stdout), (2, b""))
        self.assert_one_line(done.stderr, "xdg-utils", "leave out --open")
        self.assertFalse((self.here / "session/open.html").exists())


if __name__ == "__main__":
    program.main()
