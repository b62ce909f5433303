#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the commands write: all of it or nothing, never over an input, never half of a file."""

import fcntl
import html
import json
import os
import pty
import resource
import select
import signal
import stat
import struct
import subprocess
import termios
import threading
import time
import unittest

import program
from program import SLIPSTACK, every_command


def slow_down(process):
    """Lets the process work a tenth of the time: what it shows on the way then does not depend on the machine."""
    while process.poll() is None:
        process.send_signal(signal.SIGSTOP)
        time.sleep(0.045)
        process.send_signal(signal.SIGCONT)
        time.sleep(0.005)


class Places(program.Workshop):
    def test_no_such_folder(self):
        for name, command in every_command().items():
            for place in ("new.html", "new.json", "new.toml"):
                if place in command:
                    with self.subTest(command=name, place=place):
                        spoilt = [f"no/such/{place}" if argument == place else argument for argument in command]
                        self.assert_refused(spoilt, f"no/such/{place}", "cannot be written", "No such file")

    def test_a_directory(self):
        (self.here / "folder").mkdir()
        for name, command in every_command().items():
            for place in ("new.html", "new.json", "new.toml"):
                if place in command:
                    with self.subTest(command=name, place=place):
                        spoilt = ["folder" if argument == place else argument for argument in command]
                        self.assert_refused(spoilt, "folder", "is a directory")

    def test_no_permission(self):
        (self.here / "locked").mkdir()
        (self.here / "kept.json").write_text("kept")
        (self.here / "locked").chmod(0o555)
        (self.here / "kept.json").chmod(0o444)
        who = {}
        if os.geteuid() == 0:  # root may write everywhere: be nobody
            self.here.chmod(0o777)
            who = {"user": 65534, "extra_groups": []}
        for place in ("locked/new.json", "kept.json"):
            try:
                self.assert_refused(["diagnose", "good.csv", "--json", place], place, "Permission denied", **who)
            except PermissionError:
                self.skipTest("the programs lie where only root may read")

    def test_one_file_for_two_outputs(self):
        for other in ("new.html", "./new.html", str(self.here / "new.html")):
            with self.subTest(other):
                self.assert_refused(["diagnose", "good.csv", "--report", "new.html", "--json", other], "two outputs")
        (self.here / "link.html").symlink_to("new.html")
        self.assert_refused(["diagnose", "good.csv", "--report", "new.html", "--json", "link.html"], "two outputs")
        self.assert_refused(["fit", "good.csv", "--effects", "inertia", "--model", "new", "--json", "new"],
                            "two outputs")
        self.assert_refused(["fit", "good.csv", "--effects", "inertia", "--model", "-", "--json", "-"], "two outputs")

    def test_inputs_are_never_written(self):
        os.link(self.here / "good.csv", self.here / "hard.csv")
        (self.here / "soft.csv").symlink_to("good.csv")
        for place in ("good.csv", "./good.csv", str(self.here / "good.csv"), "hard.csv", "soft.csv"):
            for name, command in every_command().items():
                for output in ("new.html", "new.json", "new.toml"):
                    if output in command:
                        with self.subTest(place, command=name, output=output):
                            spoilt = [place if argument == output else argument for argument in command]
                            self.assert_refused(spoilt, "is an input")
        for name in ("compare", "diagnose", "add"):
            with self.subTest("model", command=name):
                spoilt = ["good.toml" if argument == "new.json" else argument for argument in every_command()[name]]
                self.assert_refused(spoilt, "good.toml", "is an input")
        self.assert_refused(["add", "good.csv", "--model", "good.toml", "--effect", "viscous", "--out", "good.toml"],
                            "good.toml", "is an input")

    def test_a_failure_keeps_the_old_file_and_success_replaces_it(self):
        old = self.here / "new.json"
        old.write_text("old")
        old.chmod(0o640)
        self.assert_refused(["diagnose", "nothing.csv", "--json", "new.json"])
        self.assert_done("fit", "good.csv", "--effects", "inertia", "--model", "new.toml", "--json", "new.json")
        self.assertIn("holdout_rmse_N", json.loads(old.read_text()))
        self.assertEqual(old.stat().st_mode & 0o777, 0o640)

    def test_link_is_written_through(self):
        (self.here / "folder").mkdir()
        (self.here / "link.json").symlink_to("folder/real.json")
        (self.here / "folder" / "real.json").write_text("old")
        self.assert_done("compare", "good.csv", "--model", "good.toml", "--json", "link.json")
        self.assertTrue((self.here / "link.json").is_symlink())
        self.assertIn("rmse_N", json.loads((self.here / "folder" / "real.json").read_text()))

    def test_longest_name(self):
        self.assert_done("compare", "good.csv", "--model", "good.toml", "--json", "j" * 255)
        self.assert_refused(["compare", "good.csv", "--model", "good.toml", "--json", "j" * 256], "name too long")

    def test_report_contains_its_command_line(self):
        (self.here / "good.csv").rename(self.here / "it's good.csv")
        self.assert_done("compare", "it's good.csv", "--model", "good.toml", "--report", "new.html")
        line = "slipstack compare 'it'\\''s good.csv' --model good.toml --report new.html"
        self.assertIn(line, html.unescape((self.here / "new.html").read_text()))

    def test_nothing_but_what_was_asked_for(self):
        self.assert_done(*every_command()["add"])
        self.assertEqual(sorted(self.content()), ["good.csv", "good.toml", "new.html", "new.json", "new.toml"])


class Streams(program.Workshop):
    COMPARE = ["compare", "good.csv", "--model", "good.toml"]

    def device(self, name, minor):
        """One of the memory devices; for root a new node of it, because root could replace the machine's own by mistake."""
        if os.geteuid() != 0:
            return f"/dev/{name}"
        try:
            os.mknod(self.here / name, stat.S_IFCHR | 0o666, os.makedev(1, minor))
            open(self.here / name, "wb").close()
        except OSError as error:
            self.skipTest(f"no device node can be made here: {error}")
        return name

    def test_standard_output_replaces_the_table(self):
        expected = json.loads(self.assert_done(*self.COMPARE, "--json", "-").stdout)
        self.assertEqual(expected["log"], "good.csv")
        self.assertEqual(json.loads(self.assert_done(*self.COMPARE, "--json", "/dev/stdout").stdout), expected)
        with open(self.here / "out.json", "wb") as file:
            subprocess.run([SLIPSTACK, *self.COMPARE, "--json", "/dev/stdout"], cwd=self.here, stdout=file, check=True)
        self.assertEqual(json.loads((self.here / "out.json").read_text()), expected)
        model = self.assert_done("fit", "good.csv", "--effects", "inertia", "--model", "-").stdout
        self.assertIn(b"format = 'slipstack model 1'", model)

    def test_pipes_and_devices_are_not_replaced(self):
        os.mkfifo(self.here / "pipe")
        with subprocess.Popen([SLIPSTACK, *self.COMPARE, "--json", "pipe"], cwd=self.here,
                              stdout=subprocess.DEVNULL) as process:
            with open(self.here / "pipe", "rb") as pipe:
                self.assertIn("rmse_N", json.load(pipe))
        self.assertEqual(process.returncode, 0)
        self.assertTrue((self.here / "pipe").is_fifo())
        null = self.device("null", 3)
        self.assert_done(*self.COMPARE, "--json", null, "--report", null)
        self.assertTrue(os.path.exists(self.here / null) and not os.path.isfile(self.here / null))

    def test_full_device(self):
        full = self.device("full", 7)
        self.assert_refused([*self.COMPARE, "--json", full, "--report", "new.html"], full, "No space")
        self.assertFalse(os.path.isfile(self.here / full))
        before = self.content()
        with open("/dev/full", "wb") as full:
            done = subprocess.run([SLIPSTACK, *self.COMPARE, "--json", "new.json"], cwd=self.here, stdout=full,
                                  stderr=subprocess.PIPE, timeout=program.PATIENCE_S)
        self.assertEqual(done.returncode, 2)
        self.assert_one_line(done.stderr, "standard output", "No space")
        self.assertEqual(self.content(), before)

    def test_full_disk(self):
        def little_room():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
        (self.here / "new.html").write_text("old")
        for name, command in every_command().items():
            with self.subTest(command=name):
                self.assert_refused(command, "cannot be written", "File too large", preexec_fn=little_room)

    def test_reader_that_closes_its_end(self):
        before = self.content()
        reading, writing = os.pipe()
        os.close(reading)
        done = subprocess.run([SLIPSTACK, *self.COMPARE, "--json", "new.json"], cwd=self.here, stdout=writing,
                              stderr=subprocess.PIPE, timeout=program.PATIENCE_S)
        os.close(writing)
        self.assertEqual(done.returncode, -signal.SIGPIPE)
        self.assertEqual(self.content(), before)


class Signals(program.Workshop):
    def test_signal_while_it_works(self):
        program.simulate(self.here / "long.csv", "--seconds", "60")
        before = self.content()
        for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(name), subprocess.Popen(
                    [SLIPSTACK, "diagnose", "long.csv", "--report", "new.html", "--json", "new.json"], cwd=self.here,
                    stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
                threading.Thread(target=slow_down, args=[process], daemon=True).start()
                time.sleep(0.3)
                process.send_signal(name)
                stdout, stderr = process.communicate(timeout=program.PATIENCE_S)
                self.assertEqual(process.returncode, -name, "it was done before the signal came")
                self.assertEqual((stdout, stderr), (b"", b""))
                self.assertEqual(self.content(), before)

    def test_signal_while_it_writes(self):
        """A pipe that nobody reads stops the program after its files are written and before they are renamed."""
        os.mkfifo(self.here / "pipe")
        (self.here / "new.html").write_text("old")
        before = self.content()
        for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(name), subprocess.Popen(
                    [SLIPSTACK, "compare", "good.csv", "--model", "good.toml", "--report", "new.html", "--json", "pipe"],
                    cwd=self.here, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
                self.addCleanup(process.kill)
                self.wait_for_a_file_being_written()
                process.send_signal(name)
                process.communicate(timeout=program.PATIENCE_S)
                self.assertEqual(process.returncode, -name)
                self.assertEqual(self.content(), before)

    def wait_for_a_file_being_written(self):
        until = time.monotonic() + program.PATIENCE_S
        while time.monotonic() < until:
            for draft in self.here.glob(".slipstack*"):
                try:
                    if draft.stat().st_size > 0:
                        return
                except FileNotFoundError:  # the file of the test whether the place can be written
                    pass
            time.sleep(0.01)
        self.fail("no file was being written")

    def test_ignored_signal_stays_ignored(self):
        os.mkfifo(self.here / "pipe")
        process = subprocess.Popen([SLIPSTACK, "compare", "good.csv", "--model", "good.toml", "--json", "pipe"],
                                   cwd=self.here, stdout=subprocess.DEVNULL,
                                   preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        with process:
            time.sleep(0.5)
            process.send_signal(signal.SIGHUP)
            with open(self.here / "pipe", "rb") as pipe:
                self.assertIn("rmse_N", json.load(pipe))
        self.assertEqual(process.returncode, 0)


class Terminal(program.Workshop):
    def test_progress_is_shown_on_a_terminal_and_removed_before_the_result(self):
        program.simulate(self.here / "long.csv", "--seconds", "20")
        master, slave = pty.openpty()
        process = subprocess.Popen([SLIPSTACK, "diagnose", "long.csv"], cwd=self.here, stdout=slave, stderr=slave)
        os.close(slave)
        threading.Thread(target=slow_down, args=[process], daemon=True).start()
        shown = b""
        while select.select([master], [], [], program.PATIENCE_S)[0]:
            try:
                piece = os.read(master, 65536)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            shown += piece
        os.close(master)
        self.assertEqual(process.wait(program.PATIENCE_S), 0)
        progress, _, result = shown.rpartition(b"\r\x1b[K")
        self.assertRegex(progress, rb"try every effect +\d+ % +\d+\.\d s")
        self.assertRegex(result, rb"^(Missing|Complete|Unexplained): ")
        self.assertNotIn(b"\x1b", result)

    def shown_on_a_terminal(self, columns):
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        process = subprocess.Popen([SLIPSTACK, "diagnose", "good.csv"], cwd=self.here, stdout=slave,
                                   stderr=subprocess.DEVNULL)
        os.close(slave)
        shown = b""
        try:
            while piece := os.read(master, 65536):
                shown += piece
        except OSError:  # the other end is closed
            pass
        os.close(master)
        self.assertEqual(process.wait(program.PATIENCE_S), 0)
        return shown.decode().replace("\r\n", "\n")

    def test_long_lines_break_between_words_on_a_terminal_and_nowhere_else(self):
        plain = self.assert_done("diagnose", "good.csv").stdout.decode()
        self.assertTrue(any(len(line) > 100 for line in plain.splitlines()))
        for columns in (80, 60):
            shown = self.shown_on_a_terminal(columns)
            prose = [line for line in shown.splitlines() if not line.startswith("  slipstack")]
            self.assertLessEqual(max(map(len, prose)), columns)
            self.assertEqual(shown.split(), plain.split(), "the same words")
            for command in (line for line in plain.splitlines() if line.startswith("  slipstack")):
                self.assertIn(command, shown.splitlines(), "a command to copy stays on one line")
        self.assertEqual(self.shown_on_a_terminal(20), plain, "narrower than words: as it is")


if __name__ == "__main__":
    program.main()
