# SPDX-License-Identifier: Apache-2.0
"""Logs and models that the tests share; made once by the programs."""

import os
import pathlib
import shutil

import numpy
import program
import pytest

DATA = pathlib.Path(os.environ.get("SLIPSTACK_SHARED", program.REPOSITORY / ".." / "shared")) / "data"


def read_log(path):
    """Header and columns of a CSV log, as a user would read them: without the package."""
    lines = pathlib.Path(path).read_text().splitlines()
    header = dict(line[1:].split(": ", 1) for line in lines if line.startswith("#"))
    header = {key.strip(): value for key, value in header.items()}
    names, *rows = [line for line in lines if not line.startswith("#")]
    table = numpy.array([[float(field) for field in row.split(",")] for row in rows])
    return header, dict(zip(names.split(","), table.T))


@pytest.fixture(scope="session")
def stock(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stock")
    program.small_log(folder / "good.csv", "viscous")
    done = program.run("fit", "good.csv", "--effects", program.BASELINE, "--model", "good.toml", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture
def here(stock, tmp_path, monkeypatch):
    """A new folder, the current one, with good.csv (viscous friction hidden) and good.toml."""
    for name in ("good.csv", "good.toml"):
        shutil.copy(stock / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def joint(here):
    """The log as that of a rotary axis: the same numbers, in rad and Nm."""
    lines = (here / "good.csv").read_text()
    for linear, rotary in (("position_m", "position_rad"), ("force_N", "torque_Nm"), ("mass_kg", "inertia_kg_m2"),
                           ("resolution_m", "resolution_rad"), ("N_per_A", "Nm_per_A"), ("pitch_m", "pitch_rad")):
        lines = lines.replace(linear, rotary)
    (here / "joint.csv").write_text(lines)
    return "joint.csv"


@pytest.fixture
def columns(here):
    return read_log(here / "good.csv")[1]


@pytest.fixture
def header(here):
    return read_log(here / "good.csv")[0]
