#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The same 10^5 steps through every observer on host and emulator, bit for bit.

  check_trace.py --image budget_trace.elf --host budget_trace

Compares checksums block by block; when one differs, both sides run that block again and the first step that differs
is shown with its position and both forces.
"""

import argparse
import struct
import subprocess
import sys

import emulator


def checksums(lines):
    return {tuple(line.split()[1:3]): line.split()[3] for line in lines if line.startswith("block ")}


def steps(lines):
    return [line.split()[1:] for line in lines if line.startswith("step ")]


def run_host(program, arguments=()):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=emulator.TIMEOUT_S)
    if done.returncode != 0:
        emulator.fail(f"{program} ended with status {done.returncode}")
    return done.stdout.splitlines()


def as_force(word):
    return struct.unpack(">f", bytes.fromhex(word))[0]


def show_first_difference(options, observer, block):
    host = steps(run_host(options.host, (observer, block)))
    target = steps(emulator.run(options.image, (observer, block)))
    for ours, theirs in zip(host, target):
        if ours != theirs:
            x = int.from_bytes(bytes.fromhex(ours[1]), "big", signed=True)
            print(f"  {observer}: first difference at step {ours[0]}, position {x}:")
            print(f"    host   {ours[2]} = {as_force(ours[2]):.9g} N")
            print(f"    target {theirs[2]} = {as_force(theirs[2]):.9g} N (position word {theirs[1]})")
            return
    print(f"  {observer}: block {block} differs by its checksum only; {len(host)} and {len(target)} steps")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", required=True)
    parser.add_argument("--host", required=True)
    options = parser.parse_args()
    emulator.require(options.image)

    host = checksums(run_host(options.host))
    target = checksums(emulator.run(options.image))
    if not host or host.keys() != target.keys():
        emulator.fail(f"{len(host)} blocks on the host, {len(target)} on the target")
    print("host and target, 100000 steps, bit for bit")
    failed = False
    for observer in dict.fromkeys(name for name, _ in host):
        blocks = [block for name, block in host if name == observer]
        wrong = [block for block in blocks if host[observer, block] != target[observer, block]]
        print(f"{observer:<30}{len(blocks):>5} blocks  {host[observer, blocks[-1]]}  {'DIFFERS' if wrong else 'equal'}")
        if wrong:
            failed = True
            show_first_difference(options, observer, wrong[0])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
