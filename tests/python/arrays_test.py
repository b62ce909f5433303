# SPDX-License-Identifier: Apache-2.0
"""Logs in memory: the same as from their files, whatever holds the columns."""

import conftest
import numpy
import pytest
import slipstack


def of_file(name="good.csv", **options):
    return slipstack.diagnose(name, **options).to_json()


def test_arrays_are_the_file(here, columns, header):
    log = slipstack.Log(columns, header=header, name="good.csv")
    assert slipstack.diagnose(log).to_json() == of_file()
    numbers = {key: float(value) if value.replace(".", "").isdigit() else value for key, value in header.items()}
    assert slipstack.diagnose(slipstack.Log(columns, header=numbers, name="good.csv")).to_json() == of_file()


def test_mass_stands_for_the_header(here, columns, header):
    mass = float(header.pop("mass_kg"))
    found = slipstack.diagnose(columns, header=header, mass=mass)
    with_name = of_file().replace('"log": "good.csv"', '"log": "log"').replace("good.csv", "log")
    assert found.to_json() == with_name
    # Without a mass it is fitted, and no payload can be found.
    effects = {one.effect for one in slipstack.diagnose(columns, header=header).candidates}
    assert "payload_mass" in {one.effect for one in found.candidates} - effects


def test_structured_array_and_strided_columns(here, columns, header):
    structured = numpy.zeros(len(columns["time_s"]), dtype=[(name, float) for name in columns])
    for name, values in columns.items():
        structured[name] = values
    assert not structured["force_N"].flags.c_contiguous
    assert slipstack.diagnose(slipstack.Log(structured, header=header, name="good.csv")).to_json() == of_file()


def test_units_of_columns(here, columns, header):
    counts = numpy.rint(columns["position_m"] / float(header["encoder_resolution_m"])).astype(numpy.int64)
    table = {"time_s": columns["time_s"], "position_counts": counts, "force_mN": 1e3 * columns["force_N"]}
    found = slipstack.diagnose(slipstack.Log(table, header=header))
    assert found.baseline.holdout_rmse_N == pytest.approx(slipstack.diagnose("good.csv").baseline.holdout_rmse_N, rel=1e-6)


def test_single_precision(here, columns, header):
    """Time in single precision is uniform to its own rounding only, which is known by its type."""
    table = dict(columns, time_s=columns["time_s"].astype(numpy.float32), force_N=columns["force_N"].astype(numpy.float32))
    found = slipstack.diagnose(slipstack.Log(table, header=header))
    assert found.baseline.holdout_rmse_N == pytest.approx(slipstack.diagnose("good.csv").baseline.holdout_rmse_N, rel=1e-4)


def test_frames(here, columns, header):
    pandas = pytest.importorskip("pandas", reason="python3-pandas is not installed")
    frame = pandas.read_csv("good.csv", comment="#", float_precision="round_trip")
    assert slipstack.diagnose(slipstack.Log(frame, header=header, name="good.csv")).to_json() == of_file()
    frame.attrs = header
    assert slipstack.diagnose(slipstack.Log(frame, name="good.csv")).to_json() == of_file()
    indexed = frame.set_index("time_s")
    assert slipstack.diagnose(slipstack.Log(indexed, header=header, name="good.csv")).to_json() == of_file()


def test_models_and_logs_without_any_file(here, columns, header):
    log = slipstack.Log(columns, header=header)
    fitted = slipstack.fit(log, "inertia,presliding_hysteresis")
    better = slipstack.add(log, fitted, "viscous")
    assert better.holdout_rmse_N < 0.97 * fitted.holdout_rmse_N
    assert slipstack.compare(log, better).rmse_N == pytest.approx(better.train_rmse_N, rel=1e-9)
    assert slipstack.diagnose(log, model=better).verdict == "complete"
    planned = slipstack.plan("viscous", log=log, model=fitted, seconds=10)
    motion = planned.columns()
    assert len(motion["time_s"]) == round(planned.summary.duration_s * planned.summary.rate_Hz)
    demand = slipstack.simulate(better, setpoints=motion)
    force_N = demand.columns()["force_N"]
    assert len(force_N) == len(motion["time_s"])
    assert numpy.abs(force_N).max() == pytest.approx(demand.summary.peak_force_N, abs=1e-6)
    (here / "motion.csv").write_text(planned.to_file())
    assert demand.summary == slipstack.simulate(better, setpoints="motion.csv").summary
    followed = slipstack.simulate(better, log=log, end_s=1.0)
    error_m = followed.columns()["position_m"] - followed.columns()["measured_position_m"]
    assert numpy.sqrt(numpy.mean(error_m**2)) == pytest.approx(followed.summary.rmse_m, abs=2e-9)
    assert sorted(path.name for path in here.iterdir()) == ["good.csv", "good.toml", "motion.csv"]


def test_two_logs_in_memory_and_one_in_a_file(here, columns, header):
    half = len(columns["time_s"]) // 2
    parts = [slipstack.Log({key: values[part] for key, values in columns.items()}, header=header, name=name)
             for name, part in (("first", slice(0, half)), ("second", slice(half, None)))]
    found = slipstack.diagnose([*parts, "good.csv"])
    assert found.log == "first, second, good.csv"
    assert [one.samples for one in found.logs] == [half, len(columns["time_s"]) - half, len(columns["time_s"])]


def test_results_are_dictionaries_with_attributes(here):
    found = slipstack.diagnose("good.csv")
    assert found["candidates"][0]["effect"] == found.candidates[0].effect == "viscous"
    assert isinstance(found, dict) and {"verdict", "candidates"} <= set(dir(found)) & set(found)
    with pytest.raises(AttributeError, match="verdict"):
        found.verdikt
    with pytest.raises(slipstack.InputError):
        found.columns()


def test_header_reader_of_these_tests_is_right(here):
    """The oracle of this file: a log that is written again from what it reads is the same log."""
    header, columns = conftest.read_log("good.csv")
    assert {"mass_kg", "encoder_resolution_m"} <= set(header)
    assert list(columns) == ["time_s", "position_m", "force_N"]
