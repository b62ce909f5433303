#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The boot loader's image in the emulator, from slot to slot: an update, a program that does not report in or crashes,
damaged programs, power cut while the update is written and while a start or the confirmation is noted.

  check_boot.py --source DIR --bin DIR [--every]      --every: the supply fails at every operation, not at a sample

The program flash lies in a file (hal/mps2/program_map.h): it survives resets and the end of the emulator.
"""

import argparse
import pathlib
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "budget"))
import emulator  # noqa: E402

# hal/mps2/program_map.h, and tests/boot/program.cpp for what lies behind the flash; from the begin of the PSRAM.
PSRAM, PSRAM_BYTES = 0x21000000, 16 << 20
FLASH = 0x800000
PAGE, BANK = 2048, 128 * 2048
SLOT = [FLASH + 14 * PAGE, FLASH + BANK + 14 * PAGE]
NOTES = [FLASH + BANK + 13 * PAGE, FLASH + 13 * PAGE]
SUPPLY, ORDERS, FILE = FLASH + 2 * BANK, FLASH + 2 * BANK + 64, FLASH + 0x100000
HEADER, BLOCK = 64, 512
CUT, NO_PROGRAM, REFUSED, FAULT = 75, 76, 77, 70
CONFIRMED, CHECKSUM = "state 2", "update 7"
MAGIC_CONFIRMED = 0x43000000
TRIAL_STARTS = 3


def mark(word):
    return struct.pack("<II", word, word ^ 0xFFFFFFFF)


class Board:
    """A board as it leaves its debug probe: boot loader, the first program in slot 0, confirmed."""

    def __init__(self, boot, images, file):
        self.boot, self.images, self.path = boot, images, file
        memory = bytearray(b"\xff" * (2 * BANK))
        header, program = images[0]
        self.put(memory, SLOT[0], header + mark(1))
        self.put(memory, SLOT[0] + BLOCK, program)
        self.put(memory, NOTES[0], mark(MAGIC_CONFIRMED | 1))
        with open(file, "wb") as out:
            out.truncate(PSRAM_BYTES)
            out.seek(FLASH)
            out.write(memory)

    @staticmethod
    def put(memory, at, data):
        memory[at - FLASH : at - FLASH + len(data)] = data

    def write(self, at, data):
        with open(self.path, "r+b") as out:
            out.seek(at)
            out.write(data)

    def read(self, at, count):
        with open(self.path, "rb") as into:
            into.seek(at)
            return into.read(count)

    def order(self, update=b"", silent=0, crashes=0, cut=0):
        self.write(FILE, update)
        self.write(ORDERS, struct.pack("<III", len(update), silent, crashes))
        self.write(SUPPLY, struct.pack("<II", cut, 0))

    def operations(self):
        return struct.unpack("<II", self.read(SUPPLY, 8))[1]

    def power(self):
        """From power on until the emulator ends: its status and what was printed."""
        command = [emulator.QEMU, "-M", "mps2-an386,memory-backend=ram", "-object",
                   f"memory-backend-file,id=ram,share=on,size=16M,mem-path={self.path}", "-display", "none", "-monitor", "none",
                   "-serial", "stdio", "-semihosting-config", "enable=on,target=native,arg=image", "-kernel", self.boot]  # fmt: skip
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
        except subprocess.TimeoutExpired:
            emulator.fail("the emulator did not end within 60 s")
        return done.returncode, done.stdout.split("\n")[:-1]

    def whole(self, slot):
        return self.read(SLOT[slot] + BLOCK, len(self.images[slot][1])) == self.images[slot][1]


def programs(lines):
    """The slots of the programs that were started, in their order."""
    return [int(line[-1]) for line in lines if line.startswith("program in slot ")]


def expect(what, got, wanted):
    if got != wanted:
        emulator.fail(f"{what}: {got}, expected {wanted}")
    print(f"{what}: ok")


def life(new_board, update):
    """Boot loader, slot 0, update, slot 1 confirmed; then back by another update. Operations up to the first confirmation."""
    board = new_board()
    board.order()
    expect("new board starts slot 0", board.power(), (0, ["boot", "program in slot 0", CONFIRMED]))
    board.order(update)
    status, lines = board.power()
    expect("update goes to slot 1", (status, lines), (0, ["boot", "program in slot 0", CONFIRMED, "update 0", "boot", "program in slot 1", CONFIRMED]))
    operations = board.operations()
    board.order(update)
    expect("next update goes back to slot 0", programs(board.power()[1]), [1, 0])
    board.order()
    expect("and stays there", programs(board.power()[1]), [0])
    return operations


def falls_back(new_board, update):
    board = new_board()
    board.order(update, silent=0b10)
    status, lines = board.power()
    expect("a program that does not report in: three starts, then the old one", (status, programs(lines)), (0, [0] + TRIAL_STARTS * [1] + [0]))
    board.order()
    expect("the old one stays", programs(board.power()[1]), [0])
    # A fault ends the emulator, as the watchdog would reset the part: power comes again each time.
    board = new_board()
    board.order(update, crashes=0b10)
    starts = []
    for _ in range(TRIAL_STARTS + 1):
        status, lines = board.power()
        starts += programs(lines)
    expect("a program that crashes: the same", (status, starts), (0, [0] + TRIAL_STARTS * [1] + [0]))


def damaged(new_board, update):
    board = new_board()
    bad = bytearray(update)
    bad[-1] ^= 1  # of the second image, which is the one for slot 1
    board.order(bytes(bad))
    status, lines = board.power()
    expect("an update with a wrong CRC is refused", (status, lines[-1]), (REFUSED, CHECKSUM))
    expect("and slot 0 goes on", programs(board.power()[1]), [0])
    board = new_board()
    board.order(update)
    board.power()
    board.write(SLOT[1] + BLOCK + 1000, bytes([board.read(SLOT[1] + BLOCK + 1000, 1)[0] ^ 4]))
    expect("a bit of the confirmed program in slot 1 lost: slot 0", programs(board.power()[1]), [0])
    board.write(SLOT[0] + BLOCK + 1000, bytes([board.read(SLOT[0] + BLOCK + 1000, 1)[0] ^ 4]))
    expect("of both: none is started", board.power(), (NO_PROGRAM, ["boot", "no program"]))


def cut(new_board, update, operations, every):
    """Power fails during an operation; when it is back, a whole program runs, and one more update succeeds."""
    last = 4  # header, install number, start, confirmation: the old and the new program
    chosen = [n for n in range(1, operations + 1) if every or n <= 2 or n > operations - last or n % 23 == 0]
    ran = {0: 0, 1: 0}
    for n in chosen:
        board = new_board()
        board.order(update, cut=n)
        status, _ = board.power()
        if status != CUT:
            emulator.fail(f"operation {n} of {operations}: status {status}, the supply did not fail")
        board.order()
        status, lines = board.power()
        slots = programs(lines)
        if status != 0 or len(slots) != 1 or not board.whole(slots[0]) or lines[-1] != CONFIRMED:
            emulator.fail(f"cut at operation {n} of {operations}: {status} {lines}")
        # Up to the install number it must be the old one.
        if n <= operations - 3 and slots != [0] or n > operations - 2 and slots != [1]:
            emulator.fail(f"cut at operation {n} of {operations}: slot {slots[0]}")
        ran[slots[0]] += 1
        if n % 2 == 0 or n > operations - last:
            board.order(update)
            status, lines = board.power()
            if status != 0 or programs(lines) != [slots[0], slots[0] ^ 1] or lines[-1] != CONFIRMED:
                emulator.fail(f"update after a cut at operation {n}: {status} {lines}")
    print(f"power cut at {len(chosen)} of {operations} operations: slot 0 {ran[0]} times, slot 1 {ran[1]} times: ok")
    if min(ran.values()) == 0:
        emulator.fail("the cuts did not come on both sides of the install")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--source", required=True, type=pathlib.Path)
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--every", action="store_true")
    options = parser.parse_args()
    boot = options.bin / "slipstack-mps2-an386-boot.elf"
    emulator.require(boot)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        command = [sys.executable, "-B", options.source / "toolchain" / "make-update", "--board", "MPS2", "--out", folder / "two.update",
                   "--header", options.source / "firmware" / "update" / "image_header.h"]  # fmt: skip
        for slot in (0, 1):
            command += ["--image", hex(PSRAM + SLOT[slot]), options.bin / f"boot_program_slot{slot + 1}.bin"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        update = (folder / "two.update").read_bytes()
        first = HEADER + len((options.bin / "boot_program_slot1.bin").read_bytes())
        images = [(update[:HEADER], update[HEADER:first]), (update[first : first + HEADER], update[first + HEADER :])]

        def new_board():
            return Board(str(boot), images, folder / "psram")

        operations = life(new_board, update)
        falls_back(new_board, update)
        damaged(new_board, update)
        cut(new_board, update, operations, options.every)
    return 0


if __name__ == "__main__":
    sys.exit(main())
