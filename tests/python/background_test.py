# SPDX-License-Identifier: Apache-2.0
"""While a command works: progress, the end by Ctrl-C or by the listener, other threads."""

import os
import signal
import threading
import time

import program
import pytest
import slipstack


@pytest.fixture(scope="module")
def long_log(tmp_path_factory):
    """Long enough to be interrupted on any machine."""
    path = tmp_path_factory.mktemp("long") / "long.csv"
    program.simulate(path, "--effects", "viscous,force_ripple", "--seconds", "15", "--rate", "2000")
    return path


def test_progress(long_log):
    told = []
    caller = threading.get_ident()

    def listen(stage, fraction):
        assert threading.get_ident() == caller
        told.append((stage, fraction))

    slipstack.diagnose(long_log, progress=listen)
    stages = [stage for stage, _ in told]
    assert stages[0] == "read the log" and len(set(stages)) >= 4
    fractions = [fraction for _, fraction in told if fraction is not None]
    assert fractions and all(0.0 <= fraction <= 1.0 for fraction in fractions)
    assert any(fraction is None for _, fraction in told)


def time_of(work):
    start = time.monotonic()
    work()
    return time.monotonic() - start


def test_ctrl_c(long_log, tmp_path):
    whole_s = time_of(lambda: slipstack.diagnose(long_log))

    def interrupted():
        timer = threading.Timer(0.2 * whole_s, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            slipstack.diagnose(long_log, report=tmp_path / "r.html")
        timer.join()

    assert time_of(interrupted) < 0.8 * whole_s
    assert list(tmp_path.iterdir()) == []
    # And the next command works.
    assert slipstack.diagnose(long_log).candidates


def test_a_listener_that_raises_ends_the_work(long_log, tmp_path):
    class Enough(Exception):
        pass

    calls = []

    def listen(stage, fraction):
        calls.append(stage)
        if len(calls) == 2:
            raise Enough

    with pytest.raises(Enough):
        slipstack.diagnose(long_log, json=tmp_path / "j.json", progress=listen)
    assert len(calls) == 2
    assert list(tmp_path.iterdir()) == []


def test_the_interpreter_is_free_meanwhile(long_log):
    turns = 0
    ended = threading.Event()

    def count():
        nonlocal turns
        while not ended.wait(0.005):
            turns += 1

    counter = threading.Thread(target=count)
    counter.start()
    whole_s = time_of(lambda: slipstack.diagnose(long_log))
    ended.set()
    counter.join()
    assert turns > whole_s / 0.005 / 10  # held for all of the work it would turn once or twice


def test_commands_of_several_threads_take_turns(here, joint):
    """One linear and one rotary axis at once: each has its own units."""
    logs = ["good.csv", joint] * 3
    wanted = {log: slipstack.diagnose(log).to_json() for log in set(logs)}
    found = {}

    def work(index):
        found[index] = slipstack.diagnose(logs[index]).to_json()

    threads = [threading.Thread(target=work, args=(index,)) for index in range(len(logs))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {index: wanted[log] for index, log in enumerate(logs)}
