# SPDX-License-Identifier: Apache-2.0
"""A bounded run of a libFuzzer target from its corpus: the same inputs every time; what is new is thrown away, but for
an input that fails, which is named."""

import argparse
import pathlib
import subprocess
import sys
import tempfile

SKIPPED = 77


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--corpus", type=pathlib.Path, required=True)
    parser.add_argument("--runs", type=int, required=True)
    arguments = parser.parse_args()
    if not arguments.program.is_file():
        print("SKIP: no clang with a fuzzer runtime; install clang and libclang-rt-14-dev, and configure anew")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="slipstack-fuzz-") as scratch:
        failing = arguments.program.with_suffix(".failed-")
        done = subprocess.run([arguments.program, "-seed=1", f"-runs={arguments.runs}", "-max_len=1000",
                               "-verbosity=0", "-print_final_stats=1", f"-artifact_prefix={failing}", scratch,
                               arguments.corpus], capture_output=True, text=True, errors="replace")
    print(done.stderr[-6000:])
    executed = [line for line in done.stderr.splitlines() if "number_of_executed_units" in line]
    if done.returncode == 0 and not executed:
        print("the fuzzer says nothing of what it ran")
        return 1
    # libFuzzer ends with 77 when an input fails, which ctest would take for a skip.
    return 0 if done.returncode == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
