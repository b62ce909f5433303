#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""toolchain/make-update: the update file and the file for a new board, read back by their documented layout."""
import argparse
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import zlib


def run(source, *arguments):
    return subprocess.run([sys.executable, "-B", str(source / "toolchain/make-update"), *map(str, arguments)],
                          capture_output=True, text=True)


def images_of(data):
    """Header words and program of every image of an update file."""
    at = 0
    while at < len(data):
        words = struct.unpack_from("<16I", data, at)
        assert words[15] == zlib.crc32(data[at:at + 60]), "check of the header"
        program = data[at + 64:at + 64 + words[7]]
        assert len(program) == words[7]
        yield words, program
        at += 64 + words[7]


def memory_of(text):
    """Bytes by address of an Intel HEX file."""
    memory, upper = {}, 0
    for line in text.split():
        record = bytes.fromhex(line[1:])
        assert line[0] == ":" and sum(record) & 0xFF == 0 and len(record) == 5 + record[0]
        address, kind, payload = int.from_bytes(record[1:3], "big"), record[3], record[4:-1]
        if kind == 4:
            upper = int.from_bytes(payload, "big") << 16
        elif kind == 0:
            for i, byte in enumerate(payload):
                assert upper + address + i not in memory, "a byte twice"
                memory[upper + address + i] = byte
    return memory


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--source", required=True, type=pathlib.Path)
    source = parser.parse_args().source
    header = source / "firmware/update/image_header.h"
    generator = random.Random(5)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        programs = [generator.randbytes(70001), generator.randbytes(66000)]
        boot = generator.randbytes(6831)
        for name, data in (("a.bin", programs[0]), ("b.bin", programs[1]), ("boot.bin", boot), ("empty.bin", b""),
                           ("large.bin", bytes(224 * 1024 - 511)), ("fits.bin", bytes(224 * 1024 - 512))):
            (folder / name).write_bytes(data)
        addresses = [0x08007000, 0x08047000]
        common = ["--header", header, "--board", "G474"]
        done = run(source, *common, "--image", hex(addresses[0]), folder / "a.bin", "--image", hex(addresses[1]),
                   folder / "b.bin", "--out", folder / "u.update", "--boot", "0x08000000", folder / "boot.bin",
                   "--notes", "0x08046800", "0x08006800", "--new", folder / "new.hex")
        assert done.returncode == 0, done.stderr
        images = list(images_of((folder / "u.update").read_bytes()))
        assert len(images) == 2
        for (words, program), wanted, address in zip(images, programs, addresses):
            assert program == wanted
            board = int.from_bytes(b"G474", "little")
            assert words[:9] == (0x49504C53, 1, 0, 0x534C4B31, board, 0x00010000, address, len(wanted),
                                 zlib.crc32(wanted)), words
        memory = memory_of((folder / "new.hex").read_text())
        at = lambda begin, size: bytes(memory[begin + i] for i in range(size))
        assert at(0x08000000, len(boot)) == boot
        assert at(0x08007000, 64) == (folder / "u.update").read_bytes()[:64]
        assert at(0x08007040, 8) == struct.pack("<II", 1, 0xFFFFFFFE), "install number 1"
        assert at(0x08007200, len(programs[0])) == programs[0]
        # Nothing of older installs is left: the other slot's header and both notes are overwritten.
        assert at(0x08046800, 8) == struct.pack("<II", 0x43000001, 0xBCFFFFFE), "install 1 is confirmed"
        assert at(0x08006800, 8) == bytes(8) and at(0x08047000, 8) == bytes(8)
        assert not any(0x0803F000 <= a < 0x08040000 or a >= 0x0807F000 for a in memory), "parameters are left alone"

        out = folder / "no.update"
        for image, reason in (("large.bin", "a slot takes"), ("empty.bin", "is empty"), ("none.bin", "No such file")):
            done = run(source, *common, "--image", "0x08007000", folder / image, "--out", out)
            assert done.returncode == 2 and reason in done.stderr and done.stderr.count("\n") == 1, done.stderr
            assert not out.exists()
        done = run(source, *common, "--image", "0x08007000", folder / "fits.bin", "--out", out)
        assert done.returncode == 0, done.stderr
    print("update file and new board's file are as documented")


if __name__ == "__main__":
    sys.exit(main())
