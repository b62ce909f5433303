# SPDX-License-Identifier: Apache-2.0
"""The examples beside docs/python.md run; what the page itself says is typed by tests/documents."""

import inspect
import os
import pathlib
import re
import subprocess
import sys

import conftest
import program
import pytest
import slipstack

EXAMPLES = program.REPOSITORY / "docs/python"


def run(words, cwd, **environment):
    done = subprocess.run(words, cwd=cwd, env={**os.environ, **environment}, capture_output=True, text=True,
                          timeout=program.PATIENCE_S)
    assert done.returncode == 0, done.stderr
    return done.stdout


def example(name, *arguments, cwd):
    return run([sys.executable, "-B", str(EXAMPLES / name), *map(str, arguments)], cwd=cwd)


def test_emps_example(tmp_path):
    log = conftest.DATA / "emps/emps_estimation.csv"
    if not log.is_file():
        pytest.skip(f"{log} is not there; set SLIPSTACK_SHARED")
    pytest.importorskip("pandas", reason="python3-pandas is not installed")
    text = example("emps.py", log, cwd=tmp_path)
    found = {name: (float(value), float(published)) for name, value, published in
             re.findall(r"^(\w+) +(-?[\d.]+) \S.*? published (-?[\d.]+)", text, re.MULTILINE)}
    assert set(found) == {"inertia", "viscous", "coulomb", "offset_force"}
    for value, published in found.values():
        assert value == pytest.approx(published, abs=max(0.02 * abs(published), 0.3))
    assert "missing: direction_asymmetry" in text


def test_hidden_effect_example(here):
    truth = here / "truth.json"
    program.simulate("log.csv", "--effects", "force_ripple", "--seconds", "20", "--rate", "1000", truth=truth)
    text = example("hidden_effect.py", "log.csv", cwd=here)
    assert "force_ripple" in text.splitlines()[0]
    before_N, after_N, floor_N = (float(value) for value in re.findall(r"([\d.]+) N", text.splitlines()[-1]))
    assert after_N < 0.97 * before_N and after_N < 1.3 * floor_N
    assert pathlib.Path("better.toml").is_file() and pathlib.Path("better.html").is_file()


def test_every_public_name_has_a_docstring():
    """Of the package and of its classes, those in C++ too; pybind11 alone would leave the signature."""
    bare = []
    for name in slipstack.__all__:
        value = getattr(slipstack, name)
        found = {name: value}
        if isinstance(value, type) and not issubclass(value, Exception):
            found |= {f"{name}.{member}": getattr(value, member) for member in vars(value) if not member.startswith("_")}
        bare += [path for path, one in found.items() if not re.sub(r"^\w+\(.*\) -> .*\n*", "", inspect.getdoc(one) or "").strip()]
    assert bare == []
