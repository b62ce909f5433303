#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""toolchain/flash and toolchain/check-image with good and with corrupted images, and with stand-ins for the probes' tools."""
import argparse
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

TOOLCHAIN = pathlib.Path()
FLASH = 0x08000000
VECTORS = 118


def image(size=1024, stack=0x20008000, reset=None, vectors=None, base=FLASH):
    code = base + 4 * VECTORS
    table = [stack, reset if reset is not None else code + 1] + [code + 5] * (VECTORS - 2)
    table[7] = 0  # a reserved entry may be empty
    for number, value in (vectors or {}).items():
        table[number] = value
    head = struct.pack(f"<{VECTORS}I", *table)
    return (head + b"\x70\x47" * size)[:size]


def elf(content, address=FLASH, entry=None, machine=40, end=None):
    entry = struct.unpack_from("<I", content, 4)[0] if entry is None else entry
    header = b"\x7fELF" + bytes([1, 1, 1]) + bytes(9) + struct.pack(
        "<HHIIIIIHHHHHH", 2, machine, 1, entry, 52, 0, 0, 52, 32, 1, 0, 0, 0)
    program = struct.pack("<8I", 1, 84, address, address, len(content), len(content), 5, 4)
    return (header + program + content)[:end]


def ihex(content, address=FLASH):
    def record(kind, at, payload):
        data = bytes([len(payload), at >> 8, at & 255, kind]) + payload
        return f":{(data + bytes([-sum(data) & 255])).hex().upper()}\n"
    lines, page = [], None
    for i in range(0, len(content), 16):
        if (address + i) >> 16 != page:
            page = (address + i) >> 16
            lines.append(record(4, 0, struct.pack(">H", page)))
        lines.append(record(0, (address + i) & 0xFFFF, content[i:i + 16]))
    return ("".join(lines) + record(1, 0, b"")).encode()


class Scripts(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="flash test ")
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        self.tools = self.path / "tools"
        self.tools.mkdir()
        # A path with what the script itself needs and, at first, no tool for a probe.
        (self.tools / "python3").symlink_to(sys.executable)
        for name in ("bash", "sed", "grep", "tail", "mktemp", "rm", "dirname", "cat", "env"):
            found = subprocess.run(["bash", "-c", f"command -v {name}"], capture_output=True, text=True).stdout.strip()
            (self.tools / name).symlink_to(found)

    def file(self, name, content):
        (self.path / name).write_bytes(content)
        return str(self.path / name)

    def stand_in(self, name, script):
        tool = self.tools / name
        tool.write_text("#!/usr/bin/env bash\n" + script)
        tool.chmod(0o755)

    def run_script(self, script, *arguments):
        environment = dict(os.environ, PATH=str(self.tools))
        return subprocess.run([str(TOOLCHAIN / script), *arguments], capture_output=True, text=True, timeout=60,
                              env=environment)

    def refused(self, run, text, status=2):
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        self.assertEqual(run.stderr.count("\n"), 1, f"one line: {run.stderr}")
        self.assertIn(text, run.stderr)
        self.assertNotIn("Traceback", run.stderr)

    def test_good_images_pass_and_agree(self):
        for size in (4 * VECTORS + 8, 1024, 100_000, 508 * 1024):
            content = image(size)
            files = [self.file("a.bin", content), self.file("a.elf", elf(content)), self.file("a.hex", ihex(content))]
            run = self.run_script("check-image", *files)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(run.stdout.count(f"{size} bytes of 520192, stack 0x20008000, reset 0x080001D9"), 3)

    def test_the_program_of_a_slot(self):
        for base in (0x08007200, 0x08047200):
            content = image(224 * 1024 - 512, base=base)
            files = [self.file("a.elf", elf(content, base)), self.file("a.hex", ihex(content, base)),
                     self.file("a.bin", content)]
            run = self.run_script("check-image", *files)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(run.stdout.count(f"{len(content)} bytes of 228864"), 3)
            self.refused(self.run_script("check-image", "--whole", files[0]), "without header")
            self.refused(self.run_script("flash", "--dry-run", files[0]), "without header")
            too_large = elf(image(224 * 1024 - 511, base=base), base)
            self.refused(self.run_script("check-image", self.file("b.elf", too_large)), "1 more than the 228864")
            # Linked for another place than it lies in.
            self.refused(self.run_script("check-image", self.file("c.elf", elf(image(), base, entry=FLASH + 473))),
                         "not in the image's code")
        moved = elf(image(base=0x08007400), 0x08007400)
        self.refused(self.run_script("check-image", self.file("d.elf", moved)), "begins at 0x08007400")

    def test_stack_at_the_ends_of_sram(self):
        for stack, good in ((0x20000000, False), (0x20000008, True), (0x20018000, True), (0x20018008, False),
                            (0x1FFFFFF8, False), (0, False), (0xFFFFFFFF, False), (0x20000004, False)):
            run = self.run_script("check-image", self.file("a.bin", image(stack=stack)))
            if good:
                self.assertEqual(run.returncode, 0, run.stderr)
            else:
                self.refused(run, "stack pointer")

    def test_reset_vector_odd_and_in_the_code(self):
        code = FLASH + 4 * VECTORS
        for reset, text in ((code, "even"), (code + 2, "even"), (FLASH + 1, "not in the image"), (1, "not in the image"),
                            (0, "even"), (FLASH + 1024 + 1, "not in the image"), (0x20000001, "not in the image"),
                            (0xFFFFFFFF, "not in the image")):
            self.refused(self.run_script("check-image", self.file("a.bin", image(reset=reset))), text)
            self.assertIn("reset vector", self.run_script("check-image", self.file("a.bin", image(reset=reset))).stderr)
        self.assertEqual(self.run_script("check-image", self.file("a.bin", image(reset=FLASH + 1023))).returncode, 0)

    def test_other_vectors(self):
        for number in (2, 3, 15, 16, 70, 117):
            self.refused(self.run_script("check-image", self.file("a.bin", image(vectors={number: 0x08000400}))),
                         f"vector {number} ")
        self.assertEqual(self.run_script("check-image", self.file("a.bin", image(vectors={70: 0}))).returncode, 0)

    def test_size(self):
        self.refused(self.run_script("check-image", self.file("a.bin", image(508 * 1024 + 1))), "1 more than the 520192")
        self.refused(self.run_script("check-image", self.file("a.bin", image(512 * 1024 + 4))), "outside the flash")
        self.refused(self.run_script("check-image", self.file("a.bin", image(4 * VECTORS - 1))), "less than a vector table")
        self.refused(self.run_script("check-image", self.file("a.bin", b"")), "is empty")
        self.refused(self.run_script("check-image", str(self.path / "none.bin")), "cannot be read")
        self.refused(self.run_script("check-image", self.file("a.txt", image())), "neither")
        self.refused(self.run_script("check-image"), "usage")

    def test_corrupted_elf(self):
        good = elf(image())
        self.refused(self.run_script("check-image", self.file("a.elf", elf(image(), machine=62))), "host program")
        self.refused(self.run_script("check-image", self.file("a.elf", elf(image(), address=0))), "outside the flash")
        self.refused(self.run_script("check-image", self.file("a.elf", elf(image(), entry=FLASH + 0x201))), "entry point")
        self.refused(self.run_script("check-image", self.file("a.elf", b"not an elf")), "is not an ELF file")
        for end in (5, 40, 60, 100, len(good) - 1):
            self.refused(self.run_script("check-image", self.file("a.elf", good[:end])), "a.elf")
        self.refused(self.run_script("check-image", self.file("a.elf", good[:4] + b"\x02" + good[5:])), "32-bit")

    def test_corrupted_hex(self):
        good = ihex(image())
        lines = good.decode().splitlines(keepends=True)
        self.refused(self.run_script("check-image", self.file("a.hex", good.replace(b"7047", b"7048", 1))), "checksum")
        self.refused(self.run_script("check-image", self.file("a.hex", "".join(lines[:-1]).encode())), "no end-of-file")
        self.refused(self.run_script("check-image", self.file("a.hex", good + lines[1].encode())), "after the end")
        self.refused(self.run_script("check-image", self.file("a.hex", b"x" + good)), "line 1 is no Intel HEX")
        self.refused(self.run_script("check-image", self.file("a.hex", good[:-4])), "no Intel HEX")
        self.refused(self.run_script("check-image", self.file("a.hex", b"\xff" + good)), "beyond ASCII")
        self.refused(self.run_script("check-image", self.file("a.hex", ihex(image(), address=0))), "outside the flash")
        twice = "".join(lines[:-1] + lines[1:]).encode()
        self.refused(self.run_script("check-image", self.file("a.hex", twice)), "twice")

    # Property: no flip of one bit of a hex file passes as another image, whatever it does.
    def test_hex_survives_no_bit_flip(self):
        content = image(480)
        good = bytearray(ihex(content))
        for at in range(0, len(good), 37):
            bad = bytearray(good)
            bad[at] ^= 1 << (at % 7)
            run = self.run_script("check-image", self.file("a.bin", content), self.file("a.hex", bytes(bad)))
            self.assertIn(run.returncode, (0, 2))
            self.assertNotIn("Traceback", run.stderr)

    def test_files_that_differ(self):
        content = image()
        other = content[:-1] + b"\x00"
        run = self.run_script("check-image", self.file("a.bin", content), self.file("b.hex", ihex(other)))
        self.refused(run, "not the same image")

    def test_dry_run_prints_the_command(self):
        content = image()
        run = self.run_script("flash", "--dry-run", self.file("a.bin", content))
        self.assertEqual(run.returncode, 0, run.stderr)
        command = run.stdout.splitlines()[-1]
        words = subprocess.run(["bash", "-c", f"printf '%s\\n' {command}"], capture_output=True, text=True).stdout.splitlines()
        self.assertEqual(words[:5], ["openocd", "-f", "interface/stlink.cfg", "-f", "target/stm32g4x.cfg"])
        self.assertEqual(words[6], f"program {{{self.path}/a.bin}} verify reset exit 0x08000000")
        run = self.run_script("flash", "--dry-run", "--serial", "066BFF", self.file("a.elf", elf(content)))
        self.assertIn(r"adapter\ serial\ 066BFF", run.stdout)
        self.assertNotIn("0x08000000\n", run.stdout, "an ELF file says itself where it goes")
        run = self.run_script("flash", "--dry-run", "--tool", "st-flash", self.file("a.hex", ihex(content)))
        self.assertIn("st-flash --reset --format ihex write", run.stdout)

    def test_wrong_use(self):
        good = self.file("a.bin", image())
        self.refused(self.run_script("flash"), "no image")
        self.refused(self.run_script("flash", good, good), "more than one image")
        self.refused(self.run_script("flash", "--erase", good), "unknown option --erase")
        self.refused(self.run_script("flash", "--tool"), "wants a value")
        self.refused(self.run_script("flash", "--tool", "dfu-util", good), "unknown tool")
        self.refused(self.run_script("flash", "--serial", "a;b", good), "no serial number")
        self.refused(self.run_script("flash", good), "neither openocd nor st-flash is installed")
        self.refused(self.run_script("flash", "--tool", "st-flash", good), "apt-get install stlink-tools")
        self.refused(self.run_script("flash", "--dry-run", "--tool", "st-flash", self.file("a.elf", elf(image()))), ".bin or .hex")
        self.refused(self.run_script("flash", "--dry-run", self.file("a{.bin", image())), "braces")

    def test_a_bad_image_reaches_no_tool(self):
        self.stand_in("openocd", f"echo called > '{self.path}/called'\n")
        self.refused(self.run_script("flash", self.file("a.bin", image(reset=FLASH))), "even")
        self.assertFalse((self.path / "called").exists())

    def test_the_tool_is_called_and_its_failure_told_in_one_line(self):
        good = self.file("a.bin", image())
        self.stand_in("openocd", f"printf '%s\\n' \"$@\" > '{self.path}/called'\n")
        run = self.run_script("flash", good)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("written, verified and started", run.stdout)
        self.assertIn(f"program {{{good}}} verify reset exit 0x08000000", (self.path / "called").read_text())
        self.stand_in("openocd", "echo Open On-Chip Debugger\necho 'Error: open failed' >&2\necho bye\nexit 1\n")
        self.refused(self.run_script("flash", good), "Error: open failed", status=1)
        self.stand_in("openocd", "exit 3\n")
        self.refused(self.run_script("flash", good), "no message", status=1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--toolchain", type=pathlib.Path, required=True)
    TOOLCHAIN = parser.parse_args().toolchain.resolve()
    unittest.main(argv=["flash_script_test"])
