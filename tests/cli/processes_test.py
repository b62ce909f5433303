#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Processes that mpirun starts together give the answer of one process, and each error once."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

import program

MPIRUN = shutil.which("mpirun")
# Open MPI needs these settings on a machine with fewer processors than processes, and for root. A build with
# sanitizers would report memory that MPI keeps to the end as leaks.
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
          "OMPI_MCA_mpi_yield_when_idle": "1",
          "SOURCE_DATE_EPOCH": "1700000000", "ASAN_OPTIONS": "detect_leaks=0"}
OWN = "snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]"
IN_MEMORY_BYTES = 64 << 20
SKIPPED = 77


def pad(log, size):
    """Inserts remarks between the rows until the file has this size, so that it stays in its file and is read fast."""
    rows = log.read_bytes().split(b"\n")
    missing = size - log.stat().st_size
    remark = b"# " + b"." * 60_000
    step = max(1, (len(rows) - 20) // (missing // len(remark) + 1))
    with open(log, "wb") as file:
        for number, row in enumerate(rows[:-1]):
            file.write(row + b"\n")
            if number > 10 and number % step == 0:
                file.write(remark + b"\n")


class ProcessGroup(program.Workshop):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.logs = []
        for number, seconds in enumerate((60, 45, 8)):
            log = cls.stock / f"axis{number}.csv"
            program.simulate(log, "--effects", "viscous", "--seconds", str(seconds), "--rate", "4000", seed=11)
            cls.logs.append(log)
        # Two stay in their files, the third is held in memory.
        for log in cls.logs[:2]:
            pad(log, IN_MEMORY_BYTES // 3 + 100_000)

    def run_group(self, count, *arguments):
        command = [MPIRUN, "--quiet", "-n", str(count), program.SLIPSTACK, *map(os.fspath, arguments)]
        return subprocess.run(command, cwd=self.here, capture_output=True, timeout=program.PATIENCE_S,
                              env={**os.environ, **ENVIRONMENT}, check=False)

    def outputs(self, runner, *arguments):
        """Text and files of a run. All runs use the same folder, because its name appears in the report."""
        done = runner(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        found = {"stdout": done.stdout, "stderr": done.stderr}
        for path in self.here.glob("out.*"):
            found[path.name] = path.read_bytes()
            path.unlink()
        return found

    def assert_same(self, counts, *arguments):
        alone = self.outputs(lambda *a: self.run_here(*a, env={**os.environ, **ENVIRONMENT}), *arguments)
        self.assertEqual(alone["stderr"], b"")
        for count in counts:
            together = self.outputs(lambda *a, n=count: self.run_group(n, *a), *arguments)
            self.assertEqual(sorted(together), sorted(alone))
            for name, content in alone.items():
                self.assertTrue(together[name] == content, f"{name} of {count} processes differs")
        return alone

    @program.long
    def test_any_number_of_processes_gives_the_answer_of_one(self):
        found = self.assert_same((3,), "diagnose", *self.logs, "--stepwise", "--effect", OWN, "--json", "out.json",
                                 "--report", "out.html")
        self.assertIn("viscous", found["stdout"].decode().splitlines()[0].lower())
        self.assertRegex(found["stdout"].decode(), r"excerpt +effects searched")

    @program.long
    def test_a_fit_is_shared_like_a_diagnosis(self):
        found = self.assert_same((2, 4), "fit", *self.logs, "--effects", program.BASELINE + ",viscous", "--model", "out.toml",
                                 "--json", "out.json")
        self.assertRegex(found["stdout"].decode(), r"excerpt +shapes fitted")

    def test_short_logs_and_other_commands_are_the_same_too(self):
        self.assert_same((1, 3), "diagnose", "good.csv", "--json", "-")
        self.assert_same((2,), "fit", "good.csv", "--effects", program.BASELINE, "--model", "out.toml", "--json", "out.json")
        self.assert_same((2,), "compare", "good.csv", "--model", "good.toml")
        self.assert_same((2,), "effects", "viscous")

    @program.long
    def test_an_error_is_reported_once(self):
        damaged = self.here / "damaged.csv"
        content = self.logs[1].read_bytes()
        half = content.index(b"\n", len(content) * 3 // 4) + 1
        damaged.write_bytes(content[:half] + b"1.0,oops,2.0\n" + content[half:])
        alone = self.run_here("diagnose", self.logs[0], damaged, self.logs[2])
        for count in (2, 4):
            for arguments in (["diagnose", self.logs[0], damaged, self.logs[2], "--json", "new.json", "--report", "new.html"],
                              ["diagnose", *self.logs, "--effects", "nonsense", "--json", "new.json"],
                              ["diagnose", self.logs[0], "nowhere.csv", "--json", "new.json"],
                              ["diagnose"]):
                before = self.content()
                done = self.run_group(count, *arguments)
                self.assertEqual(done.returncode, 2, done.stderr.decode())
                self.assertEqual(done.stdout, b"")
                self.assert_one_line(done.stderr)
                if damaged in arguments:
                    self.assertEqual(done.stderr, alone.stderr)
                self.assertEqual(self.content(), before, arguments)

    @program.long
    def test_a_process_that_dies_is_an_error(self):
        for rank in (1, 3):
            command = [MPIRUN, "--quiet", "-n", "4", program.SLIPSTACK, "diagnose", *map(os.fspath, self.logs), "--json",
                       "new.json", "--report", "new.html"]
            before = self.content()
            with subprocess.Popen(command, cwd=self.here, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  env={**os.environ, **ENVIRONMENT}) as together:
                os.kill(self.at_work(rank, together), signal.SIGKILL)
                stdout, _ = together.communicate(timeout=program.PATIENCE_S)
            self.assertNotEqual(together.returncode, 0)
            self.assertEqual(stdout, b"")
            self.assertEqual(self.content(), before)

    def at_work(self, rank, together):
        """The process of that rank, once it has a log open: from then on no other process can replace it."""
        end = time.monotonic() + program.PATIENCE_S
        while time.monotonic() < end and together.poll() is None:
            for process in pathlib.Path("/proc").glob("[0-9]*"):
                try:
                    status = (process / "stat").read_text().rsplit(")", 1)[1].split()
                    if int(status[1]) != together.pid:
                        continue
                    if f"OMPI_COMM_WORLD_RANK={rank}\0" not in (process / "environ").read_text() + "\0":
                        continue
                    if any(os.readlink(entry) in map(str, self.logs) for entry in (process / "fd").iterdir()):
                        return int(process.name)
                except OSError:
                    continue  # the process has ended or closed the file
            time.sleep(0.002)
        self.fail(f"process {rank} never opened a log: {together.stderr.read()}")

    def test_an_unknown_launcher_is_refused(self):
        for rank, lines in (("0", 1), ("1", 0)):
            done = self.run_here("diagnose", "good.csv", env={**os.environ, **ENVIRONMENT, "PMI_SIZE": "2", "PMI_RANK": rank})
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stdout, b"")
            self.assertEqual(done.stderr.count(b"\n"), lines, done.stderr)


def missing_requirement():
    if MPIRUN is None:
        return "mpirun is not installed (openmpi-bin)"
    probe = program.run("--version", cwd=".", env={**os.environ, **ENVIRONMENT, "PMI_SIZE": "2"})
    return "slipstack was built without MPI (libopenmpi-dev)" if b"built without MPI" in probe.stderr else None


if __name__ == "__main__":
    if missing_requirement():
        print(f"SKIP: {missing_requirement()}")
        sys.exit(SKIPPED)
    program.main()
