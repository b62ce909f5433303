#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures instructions per call in the emulator and holds them against budget.csv, on both sides.

  check_instructions.py --image IMAGE.elf --budget budget.csv [--update]

A count above its budget is a cost that somebody has to want; one below it is as suspicious (the work may be gone):
either way the test fails until budget.csv says the new number. --update writes the measured numbers into the file;
the limits in its last column are goals and stay.
"""

import argparse
import sys

import budget_file
import emulator

COLUMNS = ["name", "input", "min", "mean", "max", "tolerance", "limit"]


def measure(image):
    """{(name, input): (min, mean, max, calls)}"""
    measured = {}
    for line in emulator.run(image):
        word = line.split()
        if word and word[0] == "instructions":
            measured[(word[1], word[2])] = (int(word[3]), float(word[4]), int(word[5]), int(word[6]))
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
    return ", ".join(faults)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", required=True)
    parser.add_argument("--budget", required=True)
    parser.add_argument("--update", action="store_true")
    options = parser.parse_args()
    emulator.require(options.image)

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
        fault = "" if options.update else judge(row, found)
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
