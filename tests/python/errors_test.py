# SPDX-License-Identifier: Apache-2.0
"""What cannot be done raises InputError with one line, the same that the command line prints, and writes nothing."""

import numpy
import program
import pytest
import slipstack


def refused(function, *arguments, **options):
    with pytest.raises(slipstack.InputError) as raised:
        function(*arguments, **options)
    line = str(raised.value)
    assert line.isprintable() and len(line) > 10, repr(line)
    assert "internal fault" not in line
    return line


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_lines_of_the_program(here):
    (here / "bad.csv").write_text("time_s,position_m,force_N\n0,0,0\n1,zwei,3\n")
    (here / "bad.toml").write_text("format = 3\n")
    before = names(here)
    for function, arguments, options, words in (
            (slipstack.diagnose, ["none.csv"], {}, ["diagnose", "none.csv"]),
            (slipstack.diagnose, ["bad.csv"], {}, ["diagnose", "bad.csv"]),
            (slipstack.diagnose, ["good.csv"], dict(effects="magic"), ["diagnose", "good.csv", "--effects", "magic"]),
            (slipstack.diagnose, [["good.csv", "good.csv"]], {}, ["diagnose", "good.csv", "good.csv"]),
            (slipstack.diagnose, ["good.csv"], dict(report="no/r.html"),
             ["diagnose", "good.csv", "--report", "no/r.html"]),
            (slipstack.diagnose, ["good.csv"], dict(json="good.csv"), ["diagnose", "good.csv", "--json", "good.csv"]),
            (slipstack.fit, ["good.csv", "inertia,inertia"], {}, ["fit", "good.csv", "--effects", "inertia,inertia"]),
            (slipstack.compare, ["good.csv", "bad.toml"], {}, ["compare", "good.csv", "--model", "bad.toml"]),
            (slipstack.add, ["good.csv", "good.toml", "inertia"], {},
             ["add", "good.csv", "--model", "good.toml", "--effect", "inertia", "--out", "new.toml"]),
            (slipstack.simulate, ["good.toml"], {}, ["simulate", "good.toml"]),
            (slipstack.simulate, ["good.toml"], dict(log="good.csv", start_s=1e6),
             ["simulate", "good.toml", "--log", "good.csv", "--start", "1e6"]),
            (slipstack.plan, ["viscous"], dict(seconds=1, out="p.csv"),
             ["experiment", "plan", "--for", "viscous", "--seconds", "1", "--out", "p.csv"])):
        done = program.run(*words, cwd=here)
        assert done.returncode == 2
        assert f"slipstack: {refused(function, *arguments, **options)}\n" == done.stderr.decode()
    assert names(here) == before


def test_wrong_definition_has_its_picture(here):
    with pytest.raises(slipstack.InputError) as raised:
        slipstack.diagnose("good.csv", effect="snag = A*foo(x); A: N")
    done = program.run("diagnose", "good.csv", "--effect", "snag = A*foo(x); A: N", cwd=here)
    line, picture = done.stderr.decode().split("\n", 1)
    assert line == f"slipstack: {raised.value}"
    if hasattr(raised.value, "__notes__"):  # Python 3.11
        assert raised.value.__notes__ == [picture]


@pytest.mark.parametrize("change, told", [
    (lambda c: c.pop("force_N"), "force"),
    (lambda c: c.update(force_kN=c.pop("force_N")), "force_kN"),
    (lambda c: c["force_N"].__setitem__(17, numpy.nan), "sample 18: column force_N is nan"),
    (lambda c: c.update(force_N=c["force_N"][:-1]), "give columns of one length"),
    (lambda c: c.update(force_N=c["force_N"] + 0j), "force_N: complex128"),
    (lambda c: c.update(force_N=c["force_N"].astype(str)), "force_N"),
    (lambda c: c.update(force_N=numpy.stack([c["force_N"]] * 2)), "force_N"),
    (lambda c: c["time_s"].__setitem__(3, 0.0), "sample 4"),
    (lambda c: c.update({key: values[:99] for key, values in c.items()}), "99 samples"),
    (lambda c: c.clear(), "no columns"),
])
def test_unusable_columns(here, columns, header, change, told):
    change(columns)
    line = refused(lambda: slipstack.diagnose(columns, header=header))
    assert line.startswith("log") and told in line, line


def test_wrong_use(here, columns):
    log = slipstack.Log(columns)
    for told, call in (
            ("ndarray has no named columns", lambda: slipstack.diagnose(columns["time_s"])),
            ("mass and header of a file", lambda: slipstack.diagnose("good.csv", mass=3.0)),
            ("to this Log", lambda: slipstack.diagnose(log, mass=3.0)),
            ("mass_kg", lambda: slipstack.diagnose(columns, mass=-3.0)),
            ("no log", lambda: slipstack.diagnose([])),
            ("named twice", lambda: slipstack.diagnose([log, log])),
            ("exclude each other", lambda: slipstack.diagnose(log, effects="inertia", model="good.toml")),
            ("noise_N", lambda: slipstack.diagnose(log, noise_N=0.0)),
            ("effects", lambda: slipstack.fit(log, [])),
            ("criterion", lambda: slipstack.fit(log, "inertia", criterion="position")),
            ("horizon_s", lambda: slipstack.fit(log, "inertia", criterion="simulation", horizon_s=0.0)),
            ("has no model", lambda: slipstack.compare(log, slipstack.compare("good.csv", "good.toml"))),
            ("model: give", lambda: slipstack.compare(log, None)),
            ("model: int", lambda: slipstack.compare(log, 3)),
            ("takes one", lambda: slipstack.simulate("good.toml", log=["good.csv", "other.csv"])),
            ("no column position_m", lambda: slipstack.simulate("good.toml", setpoints={"time_s": numpy.arange(9.0)})),
            ("uniform grid", lambda: slipstack.simulate(
                "good.toml", setpoints={"time_s": numpy.arange(9.0) ** 2, "position_m": numpy.zeros(9)}))):
        assert told in refused(call)
    assert isinstance(slipstack.InputError("x"), ValueError)


def test_nothing_is_half_written(here):
    """The second output cannot be written: the first is not either."""
    before = names(here)
    refused(slipstack.diagnose, "good.csv", report="r.html", json="/dev/full")
    assert names(here) == before
