#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks the core on purpose: how many of 200 mutants of firmware/control, canopen and friction the quick tests kill.

    python3 tests/bench/mutation/mutate.py all [--seed N...] [--mutants N] [--jobs N]
    tests/bench/mutation/mutate.py prepare|refresh|build|reach|run|report [--folder build/mutation]

  prepare  a copy of the project with all mutants in its headers (rewrite.py); which one runs is asked at run time
  build    its quick tests, once
  reach    runs each test alone, without a mutant: how long it takes and which mutants it comes past. Of some
           --programs only: those of the others stay
  run      each mutant against the tests that come past it, the shortest first, until one fails, crashes or takes ten
           times as long as without. What has been run is not run again. --longest SECONDS leaves out the longer tests:
           sooner done, and no more mutants are killed than by all
  report   the ratio by folder, and the survivors beside the reasons in survivors.txt; status 1 below 90 %

A change that leaves the same program is no mutant: equivalent.txt names those that were drawn, with the reason, and the
next in the order takes their place. A folder of results belongs to one state of the sources, its seeds and one number
of mutants: delete it for another. --mutants 60 is a sample in the same proportions, for a look between two full runs.

The build is what costs, and it is one for any number of mutants: `prepare --seed 1 2` writes two samples into it, one to
learn from and one that stays unseen until the tests are better; `run --seed 1` and `report --seed 1` take one of them.
After that, `refresh` copies the tests that have changed and `build` compiles only these.

Needs python3-clang-14 (toolchain/install full). A quarter of an hour on two cores without other work, hours
beside it; each step continues where it was stopped.
"""

import argparse
import collections
import concurrent.futures
import dataclasses
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(HERE))
import rewrite  # noqa: E402
import sites  # noqa: E402

QUOTAS = {"firmware/control": 90, "firmware/canopen": 70, "firmware/friction": 40}
LEAST_KILLED = 0.9
ARGUMENTS = ["-x", "c++", "-std=c++20", "-I/usr/include/eigen3"]
# What compiles and instantiates them: checked before the long build.
CHECKED = ["firmware/control/controller.cpp", "firmware/canopen/node.cpp", "firmware/canopen/drive.cpp",
           "tests/can/profile/drive_test.cpp", "tests/can/machine/storage_test.cpp", "tests/can/telemetry/trace_test.cpp",
           "tests/property/friction/equality_test.cpp", "tests/property/friction/fast_forms_test.cpp",
           "tests/unit/friction/memory_stack_test.cpp", "tests/unit/control/point_to_point_test.cpp",
           "tests/unit/control/parts_test.cpp"]
# The programs of quick tests that run the firmware on the host: the nearest first.
PROGRAMS = ["friction_unit_test", "friction_property_test", "control_test", "effects_test", "canopen_test",
            "loop_test", "cyclic_position_test", "soak_test", "adaptation_test", "observer_test", "energy_test",
            "can_master_test", "bus_commission_test"]
BATCHES_S = (2.0, 20.0)


class Bench:
    def __init__(self, options):
        self.options = options
        self.folder = pathlib.Path(options.folder).resolve()
        self.tree = self.folder / "tree"
        self.build_folder = self.folder / "build"

    def mutants(self):
        data = json.loads((self.folder / "mutants.json").read_text())
        sample = json.loads((self.folder / "samples.json").read_text())
        wanted = {number for seed in self.options.seed for number in sample[str(seed)]}
        return {int(number): sites.Site(**site) for number, site in data.items() if int(number) in wanted}

    def prepare(self):
        rewrite.copy_sources(ROOT, self.tree)
        found = sites.find(ROOT, list(QUOTAS), ARGUMENTS)
        compilers = [["g++", "-std=c++20", "-w", "-fsyntax-only", "-isystem/usr/include/eigen3", f"-I{self.tree}", "-fmax-errors=0",
                      name] for name in CHECKED]
        same = read_reasons(HERE / "equivalent.txt")
        quotas = {folder: round(quota * self.options.mutants / sum(QUOTAS.values())) for folder, quota in QUOTAS.items()}
        mutants, samples, refused = rewrite.accepted(ROOT, self.tree, found, quotas, self.options.seed, compilers, same)
        (self.folder / "mutants.json").write_text(
            json.dumps({number: dataclasses.asdict(site) for number, site in mutants.items()}, indent=1))
        (self.folder / "samples.json").write_text(json.dumps(samples))
        print(f"{len(found)} places, {len(mutants)} mutants chosen, {len(refused - set(same))} refused by the compiler")

    def refresh(self):
        rewrite.copy_sources(ROOT, self.tree, "tests/")

    def build(self):
        subprocess.run(["cmake", "-S", self.tree, "-B", self.build_folder, "-G", "Ninja", "--log-level=WARNING",
                        "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O1 -Wno-error -w"], check=True)
        subprocess.run(["cmake", "--build", self.build_folder, f"-j{self.options.jobs}", "--target", *self.options.programs], check=True)

    def program(self, name):
        return str(self.build_folder / "bin" / name)

    def quick_tests(self):
        """(program, test) of what toolchain/test runs of the programs: without the labels that it leaves out."""
        listed = subprocess.run(["ctest", "--test-dir", self.build_folder, "--show-only=json-v1"], check=True, capture_output=True)
        wanted = {self.program(name): name for name in self.options.programs}
        found = []
        for test in json.loads(listed.stdout)["tests"]:
            command = test.get("command", [""])
            labels = next((one["value"] for one in test["properties"] if one["name"] == "LABELS"), [])
            if command[0] in wanted and not {"long", "on_demand"} & set(labels):
                found.append((wanted[command[0]], command[1].removeprefix("--gtest_filter=")))
        return found

    def measure(self, job):
        program, test = job
        passed = self.folder / f"passed-{os.getpid()}-{abs(hash(job))}"
        begin = time.monotonic()
        done = subprocess.run([self.program(program), f"--gtest_filter={test}", "--gtest_brief=1"], cwd=self.folder,
                              capture_output=True, env={**os.environ, "SLIPSTACK_MUTANTS_PASSED": str(passed)})
        spent = time.monotonic() - begin
        bytes_passed = passed.read_bytes() if passed.exists() else b""
        passed.unlink(missing_ok=True)
        return {"program": program, "test": test, "seconds": spent, "fails": done.returncode != 0,
                "mutants": [number for number, byte in enumerate(bytes_passed) if byte]}

    def reach(self):
        jobs = self.quick_tests()
        with concurrent.futures.ThreadPoolExecutor(self.options.jobs) as pool:
            measured = list(pool.map(self.measure, jobs))
        file = self.folder / "reach.json"
        others = [one for one in json.loads(file.read_text()) if one["program"] not in self.options.programs] if file.exists() else []
        file.write_text(json.dumps(others + measured))
        failing = [one["test"] for one in measured if one["fails"]]
        print(f"{len(measured)} tests, {sum(one['seconds'] for one in measured):.0f} s; left out, as they fail without a "
              f"mutant: {' '.join(failing) or 'none'}")

    def batches(self, number, measured):
        """Lists of tests that come past a mutant, by program; quick ones of all programs first."""
        tests = [one for one in measured
                 if number in one["mutants"] and not one["fails"] and one["seconds"] <= self.options.longest]
        low = 0.0
        for high in (*BATCHES_S, 1e9):
            by_program = collections.defaultdict(list)
            for one in tests:
                if low <= one["seconds"] < high:
                    by_program[one["program"]].append(one)
            yield from sorted(by_program.items(), key=lambda pair: PROGRAMS.index(pair[0]))
            low = high

    def kill(self, number, measured):
        """How a mutant ends: the test that failed, 'time', or '' where nothing kills it."""
        tried = 0
        for program, tests in self.batches(number, measured):
            tried += len(tests)
            limit = 10.0 * sum(one["seconds"] for one in tests) + 10.0
            command = [self.program(program), "--gtest_filter=" + ":".join(one["test"] for one in tests),
                       "--gtest_fail_fast", "--gtest_brief=1"]
            try:
                done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=limit, errors="replace",
                                      env={**os.environ, "SLIPSTACK_MUTANT": str(number)})
            except subprocess.TimeoutExpired:
                return {"killed": True, "by": f"{program}: time", "tests": tried}
            if done.returncode != 0:
                failed = re.search(r"\[  FAILED  \] (\S+?)(,| \()", done.stdout)
                return {"killed": True, "by": failed[1] if failed else f"{program}: status {done.returncode}", "tests": tried}
        return {"killed": False, "by": "", "tests": tried}

    def run(self):
        results_file = self.folder / "results.json"
        results = json.loads(results_file.read_text()) if results_file.exists() else {}
        measured = json.loads((self.folder / "reach.json").read_text())
        mutants = self.mutants()
        left = [number for number, site in mutants.items() if site.key() not in results]
        if self.options.again:
            left += [number for number, site in mutants.items() if not results.get(site.key(), {"killed": True})["killed"]]
        # Drawn: what was run by the time it is stopped is a sample too.
        random.Random(1).shuffle(left)
        with concurrent.futures.ThreadPoolExecutor(self.options.jobs) as pool:
            running = {pool.submit(self.kill, number, measured): number for number in left}
            for done in concurrent.futures.as_completed(running):
                results[mutants[running[done]].key()] = done.result()
                results_file.write_text(json.dumps(results, indent=1))
        print(f"{len(left)} run")

    def report(self):
        mutants = self.mutants()
        by_key = json.loads((self.folder / "results.json").read_text())
        results = {str(number): by_key[site.key()] for number, site in mutants.items() if site.key() in by_key}
        reasons = read_reasons(HERE / "survivors.txt")
        survivors = []
        for folder in QUOTAS:
            here = [number for number, site in mutants.items() if site.path.startswith(folder + "/")]
            run = [number for number in here if str(number) in results]
            killed = [number for number in run if results[str(number)]["killed"]]
            survivors += [number for number in run if number not in killed]
            print(f"{folder:20} {len(killed):3} of {len(run):3} killed, {100.0 * len(killed) / max(1, len(run)):5.1f} %")
        all_run = [number for number in mutants if str(number) in results]
        ratio = 1.0 - len(survivors) / max(1, len(all_run))
        print(f"{'all':20} {len(all_run) - len(survivors):3} of {len(all_run):3} killed, {100.0 * ratio:5.1f} %")
        for number in survivors:
            site = mutants[number]
            print(f"{site.path}:{site.line} [{number}] {site.kind}, {results[str(number)]['tests']} tests\n"
                  f"    {site.key()}\n    {reasons.get(site.key(), 'NO REASON')}")
        unexplained = [number for number in survivors if mutants[number].key() not in reasons]
        return 0 if ratio >= LEAST_KILLED and len(all_run) == len(mutants) and not unexplained else 1


def read_reasons(path):
    """Survivor by key: a line with the key, an indented line or more with the reason."""
    reasons, key = {}, ""
    for line in path.read_text().splitlines() if path.exists() else ():
        if not line.strip() or line.startswith("#"):
            continue
        if line[0] != " ":
            key = line.strip()
            reasons[key] = ""
        else:
            reasons[key] = (reasons[key] + " " + line.strip()).strip()
    return reasons


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", choices=["all", "prepare", "refresh", "build", "reach", "run", "report"])
    parser.add_argument("--folder", default=str(ROOT / "build" / "mutation"))
    parser.add_argument("--seed", type=int, nargs="+", default=[1])
    parser.add_argument("--mutants", type=int, default=sum(QUOTAS.values()), help="how many: prepare")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--programs", nargs="+", choices=PROGRAMS, default=PROGRAMS, help="fewer are built sooner, and kill less")
    parser.add_argument("--longest", type=float, default=1e9, help="run: without tests that take more seconds; kills no more than all do")
    parser.add_argument("--again", action="store_true", help="run: the survivors once more, after new tests")
    options = parser.parse_args()
    bench = Bench(options)
    bench.folder.mkdir(parents=True, exist_ok=True)
    steps = ["prepare", "build", "reach", "run", "report"] if options.step == "all" else [options.step]
    status = 0
    for step in steps:
        status = getattr(bench, step)() or 0
    return status


if __name__ == "__main__":
    sys.exit(main())
