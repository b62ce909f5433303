#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every image sets rounding and denormals alike, once, at its reset: by disassembly.

  check_fpu.py --image IMAGE.elf [...]

reset_handler must enable the FPU (CPACR), then write 0 (round to nearest, denormals kept, no default NaN) to FPDSCR,
which exceptions begin with, and to FPSCR. No other instruction of the image may write FPSCR's control bits.
"""

import argparse
import re
import subprocess
import sys

import emulator

INSTRUCTION = re.compile(r"^\s*[0-9a-f]+:\t(?:[0-9a-f]{4} ?)+\s*\t(.*)$")
WANTED = [
    ("enable the FPU", ["ldr r0, =e000ed88", "ldr r1, [r0, #0]", "orr.w r1, r1, #f00000", "str r1, [r0, #0]", "dsb sy", "isb sy"]),
    ("set the mode of exceptions and of main", ["ldr r0, =e000ef3c", "ldr r1, =0", "str r1, [r0, #0]", "vmsr fpscr, r1"]),
]


def disassemble(image):
    listing = subprocess.run(["arm-none-eabi-objdump", "-d", image], capture_output=True, text=True, check=True).stdout
    functions, words, name = {}, {}, None
    for line in listing.splitlines():
        head = re.match(r"^[0-9a-f]+ <(.*)>:$", line)
        if head:
            name = head.group(1)
            functions[name] = []
            continue
        literal = re.match(r"^\s*([0-9a-f]+):\t[0-9a-f]{8}\s+\.word\t0x([0-9a-f]+)", line)
        if literal:
            words[int(literal.group(1), 16)] = int(literal.group(2), 16)
        found = re.match(r"^\s*([0-9a-f]+):\t[0-9a-f ]+\t(\S+)\s*([^@;<]*)", line)
        if found and name:
            functions[name].append((found.group(2), found.group(3).strip(), line))
    return functions, words


def spelled(instruction, words):
    """One instruction with what it loads from its literal pool, numbers in one form."""
    operation, operands, line = instruction
    pool = re.search(r"\(([0-9a-f]+) <", line)
    if operation.startswith("ldr") and "[pc" in operands and pool:
        return f"ldr {operands.split(',')[0]}, ={words.get(int(pool.group(1), 16), -1):x}"
    constant = re.fullmatch(r"(\w+), #(\d+)", operands)
    if operation.startswith("mov") and constant:
        return f"ldr {constant.group(1)}, ={int(constant.group(2)):x}"
    operands = re.sub(r"#(\d+)", lambda m: f"#{int(m.group(1)):x}", operands)
    operands = re.sub(r"\[(\w+)\]", r"[\1, #0]", operands)
    return f"{operation} {operands}"


def check(image):
    functions, words = disassemble(image)
    faults = []
    reset = [spelled(i, words) for i in functions.get("reset_handler", [])]
    at = 0
    for what, steps in WANTED:
        for step in steps:
            if step in reset[at:]:
                at = reset.index(step, at) + 1
            else:
                faults.append(f"reset_handler does not {what}: no '{step}' after instruction {at}")
    writers = [n for n, body in functions.items() for o, operands, _ in body if o == "vmsr" and operands.startswith("fpscr")]
    if writers != ["reset_handler"]:
        faults.append(f"FPSCR is written by {', '.join(writers) or 'nothing'}")
    if len(functions) < 10:
        faults.append("no disassembly")
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", nargs="+", required=True)
    options = parser.parse_args()
    emulator.require_tool("arm-none-eabi-objdump")
    failed = False
    for image in options.image:
        emulator.require(image)
        faults = check(image)
        print(f"{image}: {'; '.join(faults) or 'FPSCR and FPDSCR 0, set once'}")
        failed |= bool(faults)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
