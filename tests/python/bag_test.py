# SPDX-License-Identifier: Apache-2.0
"""slipstack.bag on bags that ROS's own library wrote: the log that comes of it is the one that went in."""

import subprocess
import sys

import conftest
import numpy
import program
import pytest
import write_bag


def run(*arguments, cwd):
    return subprocess.run([sys.executable, "-B", "-m", "slipstack.bag", *map(str, arguments)], cwd=cwd, capture_output=True,
                          text=True, timeout=program.PATIENCE_S)


def refused(cwd, *arguments):
    """The line of an input that cannot be used."""
    done = run(*arguments, "--out", "table.csv", cwd=cwd)
    assert done.returncode == 2 and done.stdout == "", done
    assert not (cwd / "table.csv").exists()
    return done.stderr


@pytest.fixture
def bag(here):
    """axis.bag: good.csv as joint states that were recorded 0.5 ms late, a wrench at every tenth, and a topic of two kinds."""
    _, log = conftest.read_log("good.csv")
    write_bag.write("axis.bag", log)
    return here, log


def test_the_log_that_went_in(bag):
    folder, log = bag
    done = run("axis.bag", "--topic", "/joint_states", "--out", "table.csv", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    done = program.run("import", "table.csv", "--out", "log.csv", "--columns",
                       "time [s]=time_s,position[slide]=position_m,effort[slide]=force_N", "--header", "mass_kg=35.45", cwd=folder)
    assert done.returncode == 0, done.stderr
    _, got = conftest.read_log(folder / "log.csv")
    for name in ("position_m", "force_N"):
        assert numpy.array_equal(got[name], log[name]), name
    assert numpy.max(numpy.abs(got["time_s"] - (log["time_s"] - log["time_s"][0]))) < 1e-9


def test_a_further_topic_keeps_its_last_value(bag):
    folder, log = bag
    done = run("axis.bag", "--topic", "/joint_states", "--topic", "/wrench", "--out", "-", cwd=folder)
    head, *rows = done.stdout.splitlines()
    column = head.split(",").index("/wrench wrench.force.x")
    got = [float(row.split(",")[column]) for row in rows]
    assert got == [10.0 * (i // 10) for i in range(len(got))]
    assert len(rows) == len(log["time_s"])


def test_what_cannot_be_used_is_said_in_one_line(bag):
    folder, _ = bag
    assert refused(folder, "axis.bag") == "slipstack.bag: axis.bag: say --topic; there are /changing, /joint_states, /wrench\n"
    assert "has no topic /joints; there are /changing" in refused(folder, "axis.bag", "--topic", "/joints")
    assert "change their fields" in refused(folder, "axis.bag", "--topic", "/changing")
    assert "is no ROS 1 bag" in refused(folder, "good.csv")
    assert "is no file" in refused(folder, "none.bag")
    whole = (folder / "axis.bag").read_bytes()
    (folder / "cut.bag").write_bytes(whole[:len(whole) // 2])
    assert refused(folder, "cut.bag").count("\n") == 1
    assert b"python3 -m slipstack.bag" in program.run("diagnose", "axis.bag", cwd=folder).stderr
