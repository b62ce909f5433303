#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures instructions per call in the emulator and holds them against budget.csv, on both sides.

  check_instructions.py --image IMAGE.elf --budget budget.csv [--update]
  check_instructions.py --image IMAGE.elf --worst LIMIT NAME... [--ticks N]

A count above its budget is a cost that somebody has to want; one below it is as suspicious (the work may be gone):
either way the test fails until budget.csv says the new number. So it does where an input never reaches the work that is
measured: a tick that does not drive the axis is short. --update writes the measured numbers into the file;
the limits in its last column are goals and stay. --worst looks for a call of these that takes more than the limit, in
N random steps each, and writes nothing: 600000 by SLIPSTACK_WORST_TICKS=600000.
"""

import argparse
import os
import sys

import budget_file
import emulator

# Of the calls, so many must have done what is measured: for a tick, that the axis was driven.
LEAST_WORK = 0.02
COLUMNS = ["name", "input", "min", "mean", "max", "tolerance", "limit"]


def measure(image, arguments=()):
    """{(name, input): (min, mean, max, calls, those that did what is measured)}"""
    measured = {}
    for line in emulator.run(image, arguments):
        word = line.split()
        if word and word[0] == "instructions":
            measured[(word[1], word[2])] = (int(word[3]), float(word[4]), int(word[5]), int(word[6]), int(word[7]))
    if not measured:
        emulator.fail("the image printed no measurement")
    return measured


def judge(row, found):
    """What is wrong with a measurement, or an empty text."""
    tolerance = float(row["tolerance"])
    faults = []
    for column, value in zip(("min", "mean", "max"), found):
        difference = value - float(row[column])
        if abs(difference) > tolerance:
            faults.append(f"{column} {'rose' if difference > 0 else 'fell'} by {abs(difference):g}")
    if row["limit"] and found[2] > int(row["limit"]):
        faults.append(f"over the limit {row['limit']}")
    return ", ".join(faults + idle(found))


def idle(found):
    """What is wrong with how much of a measurement did the work."""
    calls, worked = found[3:]
    return [] if worked >= LEAST_WORK * calls else [f"only {worked} of {calls} calls did the work"]


def look_for_worst(image, limit, names, ticks):
    emulator.TIMEOUT_S = 300 + ticks // 500
    failed = False
    for name in names:
        found = measure(image, (name, str(ticks)))[(name, "random")]
        low, _, high, calls, driven = found
        print(f"{name:<30}{low:>5} to {high} instructions in {calls} ticks, {driven} driven, limit {limit}")
        failed |= high > limit or bool(idle(found))
    return 1 if failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", required=True)
    parser.add_argument("--budget")
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--worst", nargs="+", metavar=("LIMIT", "NAME"))
    parser.add_argument("--ticks", type=int, default=int(os.environ.get("SLIPSTACK_WORST_TICKS", "100000")))
    options = parser.parse_args()
    emulator.require(options.image)
    if options.worst:
        return look_for_worst(options.image, int(options.worst[0]), options.worst[1:], options.ticks)
    if not options.budget:
        parser.error("--budget or --worst")

    comments, rows = budget_file.read(options.budget)
    measured = measure(options.image)

    print("instructions per call, Cortex-M4F (emulated mps2-an386)")
    print(f"{'observer':<30}{'input':<13}{'min':>5}{'mean':>9}{'max':>5}{'calls':>8}{'budget':>8}{'limit':>7}")
    failed = False
    for row in rows:
        key = (row["name"], row["input"])
        found = measured.pop(key, None)
        if found is None:
            print(f"{key[0]:<30}{key[1]:<13} not measured")
            failed = True
            continue
        fault = ", ".join(idle(found)) if options.update else judge(row, found)
        failed |= bool(fault)
        print(f"{key[0]:<30}{key[1]:<13}{found[0]:>5}{found[1]:>9.2f}{found[2]:>5}{found[3]:>8}"
              f"{row['max']:>8}{row['limit'] or '-':>7}  {fault}".rstrip())  # fmt: skip
        if options.update:
            row["min"], row["mean"], row["max"] = found[0], f"{found[1]:.2f}", found[2]
    for key, found in measured.items():
        print(f"{key[0]:<30}{key[1]:<13}{found[0]:>5}{found[1]:>9.2f}{found[2]:>5}{found[3]:>8}  no budget")
        failed |= not options.update
        rows.append(dict(zip(COLUMNS, [*key, found[0], f"{found[1]:.2f}", found[2], "0.5", ""])))
    if options.update:
        budget_file.write(options.budget, comments, COLUMNS, rows)
        return 0
    if failed:
        print(f"FAIL: see the right-hand column; the budget is {options.budget}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
