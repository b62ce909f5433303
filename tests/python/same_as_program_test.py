# SPDX-License-Identifier: Apache-2.0
"""The package gives what the command line gives: JSON, text and files, byte for byte."""

import html
import re

import conftest
import program
import pytest
import slipstack

EFFECTS = program.BASELINE + ",viscous"
DATE = re.compile(r"\d{4}-\d{2}-\d{2}T\d{2}:\d{2}:\d{2}Z")


def given_by_program(*arguments, cwd):
    """(text, JSON) of the same command."""
    done = program.run(*arguments, "--json", "program.json", cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout.decode(), (cwd / "program.json").read_text()


def assert_same(result, *arguments, cwd):
    text, json = given_by_program(*arguments, cwd=cwd)
    assert DATE.sub("DATE", result.to_json()) == DATE.sub("DATE", json)
    assert result.to_text() == text


def test_diagnose(here):
    for options, arguments in (
            (dict(stepwise=True), ["--stepwise"]),
            (dict(effects=["inertia", "coulomb"], noise_N=0.3), ["--effects", "inertia,coulomb", "--noise", "0.3"]),
            (dict(effects="auto"), ["--baseline", "auto"]),
            (dict(model=here / "good.toml"), ["--model", str(here / "good.toml")]),
            (dict(effect="snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]"),
             ["--effect", "snag = A*exp(-((x-x0)/w)^2)*sign(v); A: N; x0: m; w: m in [1e-4, 1e-2]"])):
        assert_same(slipstack.diagnose("good.csv", **options), "diagnose", "good.csv", *arguments, cwd=here)


@pytest.mark.long
@pytest.mark.parametrize("name", ["hidden_effect/blind_6.csv", "emps/emps_estimation.csv"])
def test_diagnose_measured_logs(name, tmp_path):
    log = conftest.DATA / name
    if not log.is_file():
        pytest.skip(f"{log} is not there; set SLIPSTACK_SHARED")
    assert_same(slipstack.diagnose(log, stepwise=True), "diagnose", log, "--stepwise", cwd=tmp_path)


def test_several_logs(here):
    program.simulate(here / "other.csv", "--effects", "viscous", "--seconds", "8", "--rate", "500", seed=2)
    assert_same(slipstack.diagnose(["good.csv", "other.csv"], per_log="none"),
                "diagnose", "good.csv", "other.csv", "--per-log", "none", cwd=here)


def test_rotary_axis_and_then_a_linear_one(here, joint):
    found = slipstack.diagnose(joint)
    assert found.axis == "rotary"
    assert_same(found, "diagnose", joint, cwd=here)
    assert_same(slipstack.diagnose("good.csv"), "diagnose", "good.csv", cwd=here)


def test_fit_compare_add(here):
    fitted = slipstack.fit("good.csv", EFFECTS.split(","), model="package.toml")
    (here / "package.toml").rename(here / "kept.toml")
    assert_same(fitted, "fit", "good.csv", "--effects", EFFECTS, "--model", "package.toml", cwd=here)
    assert fitted.to_file() == (here / "kept.toml").read_text()
    assert DATE.sub("DATE", fitted.to_file()) == DATE.sub("DATE", (here / "package.toml").read_text())
    assert_same(slipstack.fit("good.csv", EFFECTS, criterion="simulation", horizon_s=1.0), "fit", "good.csv", "--effects",
                EFFECTS, "--criterion", "simulation", "--horizon", "1", cwd=here)

    assert_same(slipstack.compare("good.csv", "good.toml"), "compare", "good.csv", "--model", "good.toml", cwd=here)
    # The result of fit() is the model that it wrote.
    assert_same(slipstack.compare("good.csv", fitted), "compare", "good.csv", "--model", "package.toml", cwd=here)

    added = slipstack.add("good.csv", "good.toml", "viscous", out="more.toml")
    (here / "more.toml").rename(here / "kept.toml")
    assert_same(added, "add", "good.csv", "--model", "good.toml", "--effect", "viscous", "--out", "more.toml", cwd=here)
    assert added.to_file() == (here / "kept.toml").read_text()


def test_simulate_and_plan(here):
    planned = slipstack.plan("viscous", log="good.csv", seconds=10, out="package.csv")
    assert_same(planned, "experiment", "plan", "--for", "viscous", "--log", "good.csv", "--seconds", "10", "--out", "p.csv",
                cwd=here)
    assert planned.to_file() == (here / "package.csv").read_text() == (here / "p.csv").read_text()
    for options, arguments in ((dict(setpoints="p.csv"), ["--setpoints", "p.csv"]),
                               (dict(log="good.csv", end_s=2.0), ["--log", "good.csv", "--end", "2"])):
        simulated = slipstack.simulate("good.toml", out="package.csv", **options)
        assert_same(simulated, "simulate", "good.toml", *arguments, "--out", "s.csv", cwd=here)
        assert simulated.to_file() == (here / "package.csv").read_text() == (here / "s.csv").read_text()


def test_reports_are_pages(here):
    slipstack.diagnose("good.csv", stepwise=True, report="r.html", json="j.json")
    page = (here / "r.html").read_text()
    assert page.lower().startswith("<!doctype html>") and "slipstack.diagnose('good.csv', stepwise=True)" in html.unescape(page)
    assert (here / "j.json").read_text() == slipstack.diagnose("good.csv", stepwise=True).to_json()
