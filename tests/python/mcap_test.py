# SPDX-License-Identifier: Apache-2.0
"""slipstack.mcap on files that Foxglove's libraries wrote (tests/data/foreign/make_with_mcap.mjs)."""

import math
import pathlib
import random
import struct

import conftest
import numpy
import program
import pytest
import slipstack.mcap
import slipstack.ros_messages

FOREIGN = program.REPOSITORY / "tests/data/foreign"
COUNT, STEP_S = 300, 0.002
DATA_END = b"\x0f\x04\0\0\0\0\0\0\0"  # before the checksum of the data, where an index follows
PACKAGES = {"mcap_ros2.mcap": "zstandard", "mcap_ros1.mcap": "lz4.frame", "mcap_json.mcap": "json"}


def written(name):
    """The bytes of a file of tests/data/foreign; skipped where what its chunks are compressed by is not installed."""
    pytest.importorskip(PACKAGES[name])
    return (FOREIGN / name).read_bytes()


def run(capsys, *arguments):
    """(status, standard output, standard error)."""
    status = slipstack.mcap.main([str(argument) for argument in arguments])
    return status, *capsys.readouterr()


def refused(capsys, *arguments):
    """The line of an input that cannot be used."""
    status, out, line = run(capsys, *arguments, "--out", "refused.csv")
    assert (status, out, line.count("\n")) == (2, "", 1), line
    assert not pathlib.Path("refused.csv").exists()
    return line


@pytest.mark.parametrize("name", PACKAGES)
def test_the_motion_that_went_in(here, capsys, name):
    written(name)
    assert run(capsys, FOREIGN / name, "--topic", "/joint_states", "--out", "table.csv") == (0, "", "")
    done = program.run("import", "table.csv", "--out", "log.csv", "--columns",
                       "time [s]=time_s,position[slide]=position_m,effort[slide]=force_N", cwd=here)
    assert done.returncode == 0, done.stderr
    _, log = conftest.read_log(here / "log.csv")
    phase = 2.0 * math.pi * 1.5 * STEP_S * numpy.arange(COUNT)
    assert numpy.max(numpy.abs(log["time_s"] - STEP_S * numpy.arange(COUNT))) < 1e-9
    assert numpy.max(numpy.abs(log["position_m"] - (0.0125 + 0.003 * numpy.sin(phase)))) < 1e-15
    assert numpy.max(numpy.abs(log["force_N"] - 3.0 * numpy.tanh(50.0 * numpy.cos(phase)))) < 1e-12


def test_every_kind_of_number(here, capsys):
    written("mcap_ros2.mcap")
    status, out, _ = run(capsys, FOREIGN / "mcap_ros2.mcap", "--topic", "/mixed", "--out", "-")
    head, *rows = out.splitlines()
    assert status == 0 and head == "time [s],on,small,single,bytes[0],bytes[1],bytes[2],large,some[0],some[1],last"
    assert len(rows) == COUNT // 10
    for i, row in enumerate(rows):
        assert [float(field) for field in row.split(",")] == pytest.approx([0.02 * i, 1, -2, 0.5, 1, 2, 3, -(2**40), 1.5, 10 * i, -7])


def test_a_further_topic_keeps_its_last_value(here, capsys):
    written("mcap_ros2.mcap")
    _, out, _ = run(capsys, FOREIGN / "mcap_ros2.mcap", "--topic", "/joint_states", "--topic", "/mixed", "--out", "-")
    head, *rows = out.splitlines()
    column = head.split(",").index("/mixed some[1]")
    # At the instants of both the joint state is the earlier message.
    assert [float(row.split(",")[column]) for row in rows] == [10.0 * ((i - 1) // 10) for i in range(1, COUNT)]


def test_what_cannot_be_used_is_said_in_one_line(here, capsys):
    written("mcap_ros2.mcap")
    assert "say --topic; there are /joint_states, /mixed" in refused(capsys, FOREIGN / "mcap_ros2.mcap")
    assert "has no topic /joints" in refused(capsys, FOREIGN / "mcap_ros2.mcap", "--topic", "/joints")
    assert "good.csv: is no MCAP file" in refused(capsys, "good.csv")
    assert "No such file" in refused(capsys, "none.mcap")
    other = bytearray(written("mcap_json.mcap").replace(b"\x04\0\0\0json", b"\x04\0\0\0prot"))
    (here / "proto.mcap").write_bytes(other)
    assert "its data does not fit its checksum" in refused(capsys, "proto.mcap")
    end = other.rindex(DATA_END) + len(DATA_END)
    other[end:end + 4] = bytes(4)  # no checksum
    (here / "proto.mcap").write_bytes(other)
    assert "its messages are prot, defined by jsonschema" in refused(capsys, "proto.mcap")
    assert "slipstack.mcap" in program.run("diagnose", FOREIGN / "mcap_json.mcap", cwd=here).stderr.decode()


@pytest.mark.parametrize("name", PACKAGES)
def test_a_file_that_was_cut_off(here, capsys, name):
    whole = written(name)
    for length in sorted({*range(1, 60), *range(60, whole.rindex(DATA_END), 997)}):
        (here / "cut.mcap").write_bytes(whole[:length])
        line = refused(capsys, "cut.mcap", "--topic", "/joint_states")
        assert "is no MCAP file" in line if length < 8 else "damaged" in line, (length, line)


@pytest.mark.parametrize("name", PACKAGES)
def test_changed_bytes_are_noticed(here, capsys, name):
    whole, draws = written(name), random.Random(20)
    noticed, tried = 0, 150
    for _ in range(tried):
        damaged = bytearray(whole)
        damaged[draws.randrange(8, len(whole) * 9 // 10)] ^= 1 << draws.randrange(8)
        (here / "damaged.mcap").write_bytes(damaged)
        status, _, error = run(capsys, "damaged.mcap", "--topic", "/joint_states", "--out", "damaged.csv")
        assert (status, error.count("\n")) in ((0, 0), (2, 1)), error
        noticed += status == 2
    # Behind the data stands an index, which is not read; the data of the writer carry checksums.
    assert noticed > tried * 0.8, noticed


def test_definitions_that_lie():
    for text, told in (("Missing value", "lacks the type"), ("wstring word", "wide text"), ("Loop again\n" + "=" * 80 + "\nMSG: a/Loop\nLoop loop", "no end")):
        with pytest.raises(slipstack.ros_messages.Unreadable, match=told):
            slipstack.ros_messages.Definition("a/msg/Top", text, ros2=True)
    read = slipstack.ros_messages.Definition("a/msg/Top", "float64[] values\nstring word", ros2=True).read
    for data in (b"", b"\0\1\0\0", b"\0\1\0\0" + struct.pack("<I", 2**31), b"\0\7\0\0" + bytes(16), b"\0\1\0\0" + struct.pack("<II", 0, 99)):
        with pytest.raises(slipstack.ros_messages.Unreadable):
            read(data)
    big = b"\0\0\0\0" + struct.pack(">I4xd", 1, 2.5) + struct.pack(">I", 3) + b"ab\0"
    assert read(big) == {"values": (2.5,), "word": "ab"}
