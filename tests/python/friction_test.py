# SPDX-License-Identifier: Apache-2.0
"""The friction core on arrays: bit for bit the equations of its headers, and fast."""

import math
import threading
import time

import numpy
import pytest
import slipstack


def random_motion(seed, count=20000):
    """Steps of all sizes, with many reversals."""
    draw = numpy.random.default_rng(seed)
    return numpy.cumsum(draw.normal(0.0, 1.0, count) * draw.choice([0.01, 0.1, 1.0], count))


def maxwell_slip(x, slip_distance, stiffness):
    """The equations of firmware/friction/maxwell_slip.h, one number after the other."""
    anchor = [0.0] * len(slip_distance)
    force = []
    for position in x:
        total = 0.0
        for i, (limit, k) in enumerate(zip(slip_distance, stiffness)):
            stretch = position - anchor[i]
            z = min(max(stretch, -limit), limit)
            if z != stretch:
                anchor[i] = position - z
            total += k * z
        force.append(total)
    return numpy.array(force)


@pytest.mark.parametrize("count", [1, 10, 11, 32])
def test_maxwell_slip_is_its_equations(count):
    draw = numpy.random.default_rng(count)
    slip_distance = numpy.sort(draw.uniform(0.01, 5.0, count))
    stiffness = draw.uniform(0.0, 3.0, count)
    x = random_motion(count, 3000)
    model = slipstack.MaxwellSlip(slip_distance, stiffness)
    force = model.step(x)
    assert force.shape == x.shape
    assert (force == maxwell_slip(x.tolist(), slip_distance.tolist(), stiffness.tolist())).all()
    model.reset()
    stretches = model.stretches(x)
    assert stretches.shape == (len(x), count)
    assert numpy.abs(stretches).max(axis=0) == pytest.approx(numpy.minimum(slip_distance, numpy.abs(stretches).max(axis=0)))
    numpy.testing.assert_allclose(stretches @ stiffness, force, rtol=0, atol=1e-12 * numpy.abs(force).max())
    assert model.stored_energy == pytest.approx(0.5 * stretches[-1] ** 2 @ stiffness)


def rational(x, height_N, length):
    return height_N * (1.0 - (length / (x + length)) ** 2)


def test_memory_stack_on_its_curve_and_back():
    """Rule I from the virgin state, Rule II after the first reversal."""
    stack = slipstack.MemoryStack.rational(height_N=8.0, length=2.0)
    out = numpy.linspace(0.0, 10.0, 101)
    numpy.testing.assert_allclose(stack.step(out), rational(out, 8.0, 2.0), rtol=1e-13, atol=1e-15)
    assert stack.depth == 0
    back = numpy.linspace(9.9, -9.9, 50)
    numpy.testing.assert_allclose(stack.step(back), rational(10.0, 8.0, 2.0) - 2.0 * rational((10.0 - back) / 2.0, 8.0, 2.0),
                                  rtol=1e-12, atol=1e-13)
    assert stack.depth == 1
    stack.reset(3.0)
    assert stack.depth == 0 and stack.step(numpy.array([3.0]))[0] == 0.0


def test_both_descriptions_agree():
    """A piecewise-linear virgin curve is Maxwell-slip: knots at the slip distances."""
    slip_distance = numpy.array([0.5, 1.0, 2.0, 4.0])
    stiffness = numpy.array([3.0, 1.0, 0.5, 0.25])
    knots_N = [float(sum(k * min(x, d) for k, d in zip(stiffness, slip_distance))) for x in slip_distance]
    x = random_motion(3)
    stack = slipstack.MemoryStack.piecewise(slip_distance, knots_N)
    difference = stack.step(x) - slipstack.MaxwellSlip(slip_distance, stiffness).step(x)
    assert stack.overflow_count == 0 or numpy.abs(difference).max() <= stack.overflow_height_N
    if stack.overflow_count == 0:
        assert numpy.abs(difference).max() < 1e-9


@pytest.mark.parametrize("make", [lambda: slipstack.MaxwellSlip([0.5, 2.0], [3.0, 1.0]),
                                  lambda: slipstack.MemoryStack.rational(8.0, 2.0)])
def test_state_lasts_from_call_to_call(make):
    x = random_motion(4)
    whole = make().step(x)
    in_parts = make()
    parts = [in_parts.step(part) for part in numpy.array_split(x, [1, 1, 500, 7777])]
    assert (numpy.concatenate(parts) == whole).all()
    assert (make().step(x.astype(numpy.float32).astype(float)) == make().step(x.astype(numpy.float32))).all()
    assert (make().step(numpy.repeat(x, 2)[::2]) == whole).all()  # not contiguous
    assert (make().step(list(x)) == whole).all()


def test_refused():
    for call, told in ((lambda: slipstack.MaxwellSlip([1.0], [1.0, 2.0]), "length"),
                       (lambda: slipstack.MaxwellSlip([-1.0], [1.0]), "negative"),
                       (lambda: slipstack.MaxwellSlip([1.0], [math.nan]), "finite"),
                       (lambda: slipstack.MaxwellSlip(numpy.ones(33), numpy.ones(33)), "32"),
                       (lambda: slipstack.MaxwellSlip([[1.0]], [1.0]), "dimension"),
                       (lambda: slipstack.MemoryStack.rational(1.0, 0.0), "length"),
                       (lambda: slipstack.MemoryStack.piecewise([2.0, 1.0], [1.0, 2.0]), "ascend"),
                       (lambda: slipstack.MaxwellSlip([1.0], [1.0]).step([0.0, math.inf]), "element 1 is inf"),
                       (lambda: slipstack.MemoryStack.rational(1.0, 1.0).step([[0.0]]), "dimension")):
        with pytest.raises(slipstack.InputError, match=told):
            call()


def fastest_s(work):
    times = []
    for _ in range(5):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


@pytest.mark.parametrize("make", [lambda: slipstack.MaxwellSlip(numpy.arange(1.0, 11.0), numpy.ones(10)),
                                  lambda: slipstack.MemoryStack.rational(8.0, 2.0)])
def test_an_array_costs_no_python_per_sample(make):
    x = random_motion(5, 100_000)
    model = make()
    few = [x[i:i + 1] for i in range(1000)]
    per_sample_s = fastest_s(lambda: [model.step(one) for one in few]) / len(few)
    per_element_s = fastest_s(lambda: model.step(x)) / len(x)
    print(f"{1e9 * per_element_s:.1f} ns for an element of an array, {1e9 * per_sample_s:.0f} ns for a call")
    assert per_element_s < 0.2 * per_sample_s


def test_two_threads_share_a_model():
    """Their arrays come one after the other, in either order."""
    x = random_motion(6, 200_000)
    orders = []
    for order in ((x, -x), (-x, x)):
        model = slipstack.MaxwellSlip([0.5, 2.0], [3.0, 1.0])
        orders.append([model.step(part) for part in order])
    model = slipstack.MaxwellSlip([0.5, 2.0], [3.0, 1.0])
    found = {}
    threads = [threading.Thread(target=lambda sign=sign: found.update({sign: model.step(sign * x)})) for sign in (1, -1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    first = (found[1] == orders[0][0]).all() and (found[-1] == orders[0][1]).all()
    second = (found[-1] == orders[1][0]).all() and (found[1] == orders[1][1]).all()
    assert first or second
