#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Unusable logs: every command says in one line where and what to do, exits with 2 and writes nothing."""

import os
import unittest

import program
from program import every_command

HEADER = 5  # `# key: value` lines of a simulated log, then the header row, then the samples
NAMES = HEADER + 1
SAMPLE = 700  # line number of the sample that is damaged


def replace_field(lines, line, column, value):
    fields = lines[line - 1].split(",")
    fields[column] = value
    lines[line - 1] = ",".join(fields)


def names(text):
    def change(lines):
        lines[NAMES - 1] = text
    return change


def field(column, value):
    def change(lines):
        replace_field(lines, SAMPLE, column, value)
    return change


def header(text):
    def change(lines):
        lines.insert(0, text)
    return change


def header_value(key, value):
    def change(lines):
        line = next(i for i in range(HEADER) if key in lines[i])
        lines[line] = f"# {key}: {value}"
    return change


def without_column(column):
    def change(lines):
        for i in range(NAMES - 1, len(lines)):
            fields = lines[i].split(",")
            del fields[column]
            lines[i] = ",".join(fields)
    return change


def with_column(name, value):
    def change(lines):
        lines[NAMES - 1] += "," + name
        for i in range(NAMES, len(lines)):
            lines[i] += "," + value
    return change


def in_milliseconds(lines):
    for line in range(NAMES + 1, len(lines) + 1):
        replace_field(lines, line, 0, f"{1e3 * float(lines[line - 1].split(',')[0]):.3f}")


def every_sample(column, value):
    def change(lines):
        for line in range(NAMES + 1, len(lines) + 1):
            replace_field(lines, line, column, value)
    return change


def gap(lines):
    del lines[SAMPLE - 1:SAMPLE + 99]


def keep_samples(count):
    def change(lines):
        del lines[NAMES + count:]
    return change


def time_of(line_shift):
    def change(lines):
        replace_field(lines, SAMPLE, 0, lines[SAMPLE - 1 + line_shift].split(",")[0])
    return change


def decimal_commas(lines):
    for i in range(NAMES - 1, len(lines)):
        lines[i] = lines[i].replace(",", ";").replace(".", ",")


# what is wrong: (change to the lines, what the message must say)
SPOILT = {
    "missing time": (without_column(0), [f"bad.csv:{NAMES}", "time_s is missing"]),
    "missing position": (without_column(1), [f"bad.csv:{NAMES}", "position column is missing", "position_m"]),
    "missing force": (without_column(2), [f"bad.csv:{NAMES}", "force column is missing", "force_N"]),
    "unknown column": (with_column("humidity", "40"), [f"bad.csv:{NAMES}", "'humidity' is unknown", "remove", "slipstack import"]),
    "column twice": (with_column("force_N", "1"), [f"bad.csv:{NAMES}", "force_N", "twice"]),
    "two positions": (with_column("position_um", "1"), [f"bad.csv:{NAMES}", "position_um", "remove one"]),
    "unknown unit": (names("time_s,position_inch,force_N"), [f"bad.csv:{NAMES}", "unknown unit 'inch'", "position_mm", "slipstack import"]),
    "no unit": (names("time_s,position,force_N"), [f"bad.csv:{NAMES}", "no unit", "position_m"]),
    "unit of the header": (header("# mass_g: 35450"), ["bad.csv:1", "'g'", "mass_kg"]),
    "text in the header": (header_value("magnet_pitch_m", "wide"), ["bad.csv:3", "magnet_pitch_m", "'wide'"]),
    "NaN": (field(2, "nan"), [f"bad.csv:{SAMPLE}", "force_N", "nan"]),
    "infinity": (field(1, "inf"), [f"bad.csv:{SAMPLE}", "position_m", "inf"]),
    "minus infinity": (field(1, "-Infinity"), [f"bad.csv:{SAMPLE}", "position_m", "Inf"]),
    "overflow": (field(2, "1e999"), [f"bad.csv:{SAMPLE}", "force_N"]),
    "text in a number": (field(2, "12.5N"), [f"bad.csv:{SAMPLE}", "force_N", "'12.5N'"]),
    "empty field": (field(1, ""), [f"bad.csv:{SAMPLE}", "position_m", "empty"]),
    "escape codes": (field(1, "\x1b[31mred"), [f"bad.csv:{SAMPLE}", "position_m"]),
    "a field too few": (field(2, "1,2"), [f"bad.csv:{SAMPLE}", "4 fields", "3"]),
    "time goes back": (time_of(-2), [f"bad.csv:{SAMPLE}", "time_s", "goes back"]),
    "time repeats": (time_of(-1), [f"bad.csv:{SAMPLE}", "time_s", "repeats"]),
    "time in milliseconds": (in_milliseconds, ["bad.csv", "time_s", "milliseconds", "write seconds"]),
    "gap": (gap, [f"bad.csv:{SAMPLE}", "gap", "sampling: irregular"]),
    "too few samples": (keep_samples(99), ["bad.csv", "99 samples", "at least 100"]),
    "too few after filtering": (keep_samples(150), ["bad.csv", "150 samples", "record longer"]),
    "no samples": (keep_samples(0), ["bad.csv", "0 samples"]),
    "position never moves": (every_sample(1, "0.25"), ["bad.csv", "position_m", "never moves"]),
    "position never moves from -0": (every_sample(1, "-0"), ["bad.csv", "never moves (it is always 0 m)"]),
    "force never changes": (every_sample(2, "1.5"), ["bad.csv", "force_N", "never changes"]),
    "numbers without names": (names("0.0,0.1,0.2"), [f"bad.csv:{NAMES}", "header row"]),
    "decimal commas": (decimal_commas, [f"bad.csv:{NAMES}", "comma", "slipstack import"]),
    "counts without their size": (lambda lines: (lines.__setitem__(NAMES - 1, "time_s,position_counts,force_N"),
                                                 lines.pop(3)), ["bad.csv:5", "encoder_resolution_m"]),
    "current without its constant": (lambda lines: (lines.__setitem__(NAMES - 1, "time_s,position_m,current_A"),
                                                    lines.pop(1)), ["bad.csv:5", "motor_constant_N_per_A"]),
}


class BadLog(program.Workshop):
    def refuse_everywhere(self, *expected):
        for name, command in every_command(log="bad.csv").items():
            with self.subTest(command=name):
                self.assert_refused(command, *expected)

    def test_spoilt_text(self):
        good = (self.here / "good.csv").read_text().splitlines()
        self.assertTrue(good[NAMES - 1].startswith("time_s,"))
        for what, (change, expected) in SPOILT.items():
            lines = list(good)
            change(lines)
            (self.here / "bad.csv").write_text("\n".join(lines) + "\n")
            with self.subTest(what):
                self.refuse_everywhere(*expected)

    def test_fewer_instants_than_parameters(self):
        lines = (self.here / "good.csv").read_text().splitlines()
        known = self.run_here("fit", "--help").stdout.decode().split("Effects:\n")[1].split("\n\n")[0]
        effects = ",".join(line.split()[0] for line in known.splitlines())
        self.assertIn("presliding_hysteresis,", effects)
        command = ["fit", "bad.csv", "--effects", effects, "--model", "new.toml"]
        # The shortest log that is long enough for some fit is not for one of the whole catalogue.
        for count in range(300, 2000, 50):
            (self.here / "bad.csv").write_text("\n".join(lines[:NAMES + count]) + "\n")
            if b"than the 100 that a fit needs" not in self.run_here(*command).stderr:
                break
        self.assert_refused(command, "bad.csv", "parameters", "record longer or fit fewer")

    def test_zero_bytes(self):
        (self.here / "bad.csv").write_bytes(b"")
        self.refuse_everywhere("bad.csv", "empty")

    def test_sparse_two_gigabytes(self):
        with open(self.here / "bad.csv", "wb") as file:
            file.truncate(2 << 30)
        self.refuse_everywhere("bad.csv:1")

    def test_directory(self):
        (self.here / "bad.csv").mkdir()
        self.refuse_everywhere("bad.csv", "directory")

    def test_not_there(self):
        self.refuse_everywhere("bad.csv", "No such file")

    def test_device_and_pipe(self):
        (self.here / "bad.csv").symlink_to("/dev/zero")
        self.refuse_everywhere("bad.csv", "not a regular file")
        (self.here / "bad.csv").unlink()
        os.mkfifo(self.here / "bad.csv")
        self.refuse_everywhere("bad.csv", "not a regular file")

    def test_random_bytes(self):
        (self.here / "bad.csv").write_bytes(bytes((i * i * 31 + i // 7) % 256 for i in range(100000)))
        self.refuse_everywhere("bad.csv:1")

    def test_cut_off_mat_file(self):
        (self.here / "bad.csv").write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"\x0e\0\0\0\xff\0\0\0")
        self.refuse_everywhere("bad.csv")

    def test_name_with_escape_codes_stays_one_line(self):
        name = "bad\n\x1b[31m\xff.csv".encode("latin-1")
        self.assert_refused([b"diagnose", name], "No such file")


class LineEnds(program.Workshop):
    """Line ends and marks of other systems are accepted."""

    def test_crlf_and_byte_order_mark(self):
        plain = (self.here / "good.csv").read_bytes()
        crlf = plain.replace(b"\n", b"\r\n")
        mark = b"\xef\xbb\xbf"
        result = {}
        for name, content in {"plain": plain, "crlf": crlf, "mark": mark + plain, "both": mark + crlf,
                              "no last line end": plain[:-1], "blank lines": plain + b"\n\r\n"}.items():
            (self.here / "log.csv").write_bytes(content)
            for command in (["fit", "log.csv", "--effects", program.BASELINE, "--model", "m.toml"],
                            ["diagnose", "log.csv"], ["compare", "log.csv", "--model", "good.toml"]):
                with self.subTest(name, command=command[0]):
                    done = self.assert_done(*command, "--json", "-")
                    self.assertEqual(done.stdout, result.setdefault(command[0], done.stdout))


if __name__ == "__main__":
    program.main()
