# SPDX-License-Identifier: Apache-2.0
"""slipstack.candump on what candump wrote while `slipstack record` recorded the same stream: both give the same log."""

import csv
import subprocess
import sys

import conftest
import numpy
import program
import pytest

FOREIGN = program.REPOSITORY / "tests/data/foreign"
EDS = program.REPOSITORY / "docs/slipstack.eds"
TICK_S = 1e-4  # 1000h: 10 kHz, as the recording says


def run(*arguments, cwd):
    return subprocess.run([sys.executable, "-B", "-m", "slipstack.candump", *map(str, arguments)], cwd=cwd, capture_output=True,
                          text=True, timeout=program.PATIENCE_S)


def converted(folder, *options):
    done = run(FOREIGN / "candump.log", "--eds", EDS, "--out", "table.csv", *options, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    with open(folder / "table.csv", newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return head, numpy.array(rows, dtype=float)


def test_the_same_as_record(tmp_path):
    head, _ = converted(tmp_path, "--clock", f"2210:05={TICK_S}")
    position = next(name for name in head if "6063:00" in name)
    current = next(name for name in head if "2200:0B" in name)
    limit_A = 20.0
    done = program.run("import", "table.csv", "--out", "log.csv", "--columns",
                       f"time [s]=time_s,{position}=position_counts,{current}=current_A*{limit_A / 32767}",
                       "--header", "motor_constant_N_per_A=60", "--header", "encoder_resolution_m=1e-6", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    _, log = conftest.read_log(tmp_path / "log.csv")
    _, recorded = conftest.read_log(FOREIGN / "candump_record.csv")
    count = len(recorded["time_s"])
    assert count > 100
    # The capture may go on for some frames after the recording.
    assert len(log["time_s"]) - count in range(20)
    start = int(numpy.flatnonzero(log["position_counts"] == recorded["position_counts"][0])[0])
    for name in recorded:
        scale = max(1e-9, numpy.max(numpy.abs(recorded[name])))
        got = log[name][start:start + count] - (log[name][start] if name == "time_s" else 0.0)
        assert numpy.max(numpy.abs(got - recorded[name])) < 1e-6 * scale, name


def test_objects_of_other_pdos_have_their_last_value(tmp_path):
    alone, _ = converted(tmp_path, "--pdo", 3)
    head, rows = converted(tmp_path, "--pdo", 3, "--pdo", 1)
    assert set(alone) < set(head)
    assert len(rows) > 100
    state = next(name for name in head if "6041:00" in name)
    assert set(rows[:, head.index(state)]) == {float(0x8250)}, "switch on disabled, remote, target reached"


def test_stamps_of_the_capture(tmp_path):
    _, by_clock = converted(tmp_path, "--clock", f"2210:05={TICK_S}")
    _, by_stamp = converted(tmp_path, "--pdo", 3)
    assert numpy.array_equal(by_clock[:, 1:], by_stamp[:, 1:])
    assert numpy.max(numpy.abs(numpy.diff(by_clock[:, 0]) - 0.005)) < 1e-9
    assert 1e-4 < numpy.max(numpy.abs(by_clock[:, 0] - by_stamp[:, 0])) < 0.05, "a bus has delays"


def test_the_other_form_of_candump(tmp_path):
    lines = []
    for line in (FOREIGN / "candump.log").read_text().splitlines():
        stamp, interface, frame = line.split()
        identifier, data = frame.split("#")
        lines.append(f" {stamp}  {interface}  {identifier}   [{len(data) // 2}]  "
                     + " ".join(data[i:i + 2] for i in range(0, len(data), 2)))
    (tmp_path / "spaced.log").write_text("\n".join(lines))
    done = run(tmp_path / "spaced.log", "--eds", EDS, "--out", "spaced.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    converted(tmp_path)
    assert (tmp_path / "spaced.csv").read_text() == (tmp_path / "table.csv").read_text()


@pytest.mark.parametrize("arguments, told", [
    (["none.log", "--eds", EDS], "none.log: cannot be read"),
    ([FOREIGN / "pandas_ns.csv", "--eds", EDS], "candump -L"),
    ([FOREIGN / "candump.log", "--eds", "none.eds"], "none.eds"),
    ([FOREIGN / "candump.log", "--eds", EDS, "--node", "9"], "--node"),
    ([FOREIGN / "candump.log", "--eds", EDS, "--pdo", "7"], "--pdo 7"),
    ([FOREIGN / "candump.log", "--eds", EDS, "--clock", "1000:00=1"], "there are 6041:00"),
])
def test_what_cannot_be_used_is_one_line(tmp_path, arguments, told):
    done = run(*arguments, "--out", "table.csv", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert told in done.stderr
    assert not (tmp_path / "table.csv").exists()
