#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What rewrite.py makes of a header: the same program without a mutant, another with each, and nothing where the compiler
computes. And that each entry of the lists is of a place that there is. Status 77 without python3-clang-14."""

import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import mutate  # noqa: E402
import rewrite  # noqa: E402
import sites  # noqa: E402

HEADER = """#pragma once
#include <array>
namespace sample {
inline constexpr int kSteps = 4;
constexpr int squared(int value) { return value * value; }
inline constexpr std::array<int, squared(2)> kTable = {1, squared(3), 7, 5};
static_assert(squared(3) == 9);
inline int g_count = 0;
struct Counter {
  int count = 0;
  void up(int by) {
    if (by > 0 && by < 9) count += by;  // a comment
    g_count = count;
  }
};
inline int sum(int limit) {
  Counter counter;
  for (int i = 0; i < kSteps; ++i) {
    if (i == limit) return counter.count;
    counter.up(i + kTable[i % 4] -
               1);
  }
  return counter.count;
}
inline bool odd(int value) { return value % 2 != 0; }
template <int N>
int times(int value) { return N * value; }
template <int N>
inline constexpr int kTwice = 2 * N;
inline int table(int value) { return times<5>(value) + kTwice<11>; }
}  // namespace sample
"""
MAIN = """#include <cstdio>
#include "firmware/sample/sample.h"
int main() {
  for (int limit = -1; limit < 6; ++limit)
    std::printf("%d %d %d ", sample::sum(limit), sample::odd(limit), sample::table(limit));
  std::printf("%d\\n", sample::g_count);
}
"""


def run(program, mutant=0, passed=""):
    done = subprocess.run([program], capture_output=True, text=True, timeout=5,
                          env={**os.environ, "SLIPSTACK_MUTANT": str(mutant), "SLIPSTACK_MUTANTS_PASSED": passed}
                          if passed else {**os.environ, "SLIPSTACK_MUTANT": str(mutant)})
    return done.returncode, done.stdout


def fails(condition, what):
    if condition:
        print(f"FAIL: {what}")
    return 1 if condition else 0


def not_there():
    """Entries of the two lists whose place is in the sources no more, or that stand in both lists."""
    places = {site.key() for site in sites.find(mutate.ROOT, list(mutate.QUOTAS), mutate.ARGUMENTS)}
    same, survivors = (mutate.read_reasons(HERE / name) for name in ("equivalent.txt", "survivors.txt"))
    return [key for key in [*same, *survivors] if key not in places or (key in same and key in survivors)]


def main():
    if sites.clang is None:
        print("SKIP: python3-clang-14 is not installed (toolchain/install full)")
        return 77
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for path, text in (("firmware/sample/sample.h", HEADER), ("main.cpp", MAIN)):
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text)
        active = folder / "tests/bench/mutation/active.h"
        active.parent.mkdir(parents=True)
        active.write_text((HERE / "active.h").read_text())
        compiler = ["g++", "-std=c++20", f"-I{folder}", "main.cpp", "-o"]
        subprocess.run([*compiler, "original"], cwd=folder, check=True)
        found = sites.find(folder, ["firmware/sample"], ["-x", "c++", "-std=c++20"])
        quotas = {"firmware/sample": 1000}
        mutants = rewrite.choose(found, quotas, 1)
        rewrite.write(folder, mutants)
        subprocess.run([*compiler, "mutants"], cwd=folder, check=True)
        original, program = run(folder / "original"), str(folder / "mutants")
        passed_file = folder / "passed"
        unchanged = run(program, passed=str(passed_file))
        other, endless = [], []
        for number, site in mutants.items():
            try:
                if run(program, number) != original:
                    other.append(site.key())
            except subprocess.TimeoutExpired:
                endless.append(site.key())
        same = [site.key() for site in mutants.values() if site.key() not in other + endless]
        passed = [number for number, byte in enumerate(passed_file.read_bytes()) if byte]
        kinds = {site.kind for site in mutants.values()}
        print(f"{len(found)} places, {len(mutants)} mutants: {len(other)} differ, {len(endless)} do not end, same: {same}")
        stale = not_there()
        missing = [path for path in mutate.CHECKED + list(mutate.QUOTAS) if not (mutate.ROOT / path).exists()]
        return max(
            fails(missing, f"not where the bench looks for them: {missing}"),
            fails(stale, f"listed, and not in the sources: {stale}"),
            fails(unchanged != original, "another program without a mutant"),
            fails(kinds != {"comparison", "arithmetic", "logic", "constant", "statement"}, f"kinds: {kinds}"),
            fails(len(mutants) < 25, "too few mutants"),
            # Adding nothing is the same as not adding.
            fails(len(same) > 4, "mutants that change nothing"),
            fails("sample::sum: i < kSteps -> (i <= kSteps)" not in other + endless, "a known mutant is not there or does nothing"),
            fails("Counter::up: g_count = count; -> nothing" not in other, "a statement does not go"),
            fails(set(passed) != set(mutants), "mutants that were come past are not noted"),
            fails([s.key() for s in rewrite.choose(found, quotas, 1).values()] != [s.key() for s in mutants.values()],
                  "another choice with the same seed"),
            fails(rewrite.choose(found, {"firmware/sample": 10}, 1) == rewrite.choose(found, {"firmware/sample": 10}, 2),
                  "the same choice with another seed"),
            fails(any(site.original in ("5", "11") for site in mutants.values()), "a mutant in a template argument"),
            fails(any(site.function == "squared" for site in mutants.values()), "a mutant where only the compiler is"))


if __name__ == "__main__":
    sys.exit(main())
