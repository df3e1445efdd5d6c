"""Torque histories: identities, the truth of a simulation, and what is refused."""
import pathlib

import numpy as np
import pytest

import gracecg
from gracecg import torques

CASE = gracecg.Case(pathlib.Path(__file__).parents[2] / "example/cases/nggm.nml")
TIME = np.arange(0, 20, 0.1)


def test_wheels():
    """h = I rate e: -dh/dt - omega x h of a sine, by its derivative."""
    omega, inertia, w = np.array([0.0, -1.1e-3, 2e-4]), 0.02, 0.7
    axes = np.array([[1, 0, 0], [0, 0.6, 0.8]])
    rates = np.column_stack([np.sin(w * TIME), 2 * np.cos(w * TIME)])
    slopes = w * np.column_stack([np.cos(w * TIME), -2 * np.sin(w * TIME)])
    expected = -inertia * slopes @ axes - np.cross(omega, inertia * rates @ axes)
    found = torques.of_wheels(TIME, rates, axes, [inertia, inertia], omega)
    assert np.abs(found - expected).max() < 2 * inertia * w * (w * 0.1)**4 / 5
    assert np.abs(found - expected)[2:-2].max() < 2 * inertia * w * (w * 0.1)**4 / 29
    assert np.allclose(torques.of_wheels(TIME, rates, axes, [inertia, inertia]), found + np.cross(omega, inertia * rates @ axes))
    for wrong, words in (((rates, 10 * axes, [1, 1]), "unit vectors"), ((rates, axes, [1, -1]), "positive"),
                         ((rates * np.nan, axes, [1, 1]), "rates must be finite"), ((rates[:-1], axes, [1, 1]), "shape")):
        with pytest.raises(ValueError, match=words):
            torques.of_wheels(TIME, *wrong)


def test_thrusters():
    """The impulse is that of the firings, wherever they begin; a balanced pair has no force."""
    response = np.array([[0.01, -0.01], [0, 0], [0, 0], [0, 0], [0.005, 0.005], [0, -0.001]])
    firings = [[1.03, 1.08, 0], [1.03, 1.08, 1], [7.0, 9.25, 0], [7.0, 9.25, 1]]
    force, torque = torques.of_thrusters(TIME, firings, response)
    assert np.allclose(force, 0, atol=1e-18)
    assert np.allclose(torque.sum(0) * 0.1, (0.05 + 2.25) * response[3:].sum(1), rtol=1e-12)
    force, _ = torques.of_thrusters(TIME, firings[2], response)
    assert np.isclose(force.sum() * 0.1, 2.25 * 0.01)
    assert not np.any(torques.of_thrusters(TIME, [], response))
    for wrong, words in (([[1, 2, 2]], "0 to 1"), ([[2, 1, 0]], "end after"), ([[1, np.nan, 0]], "finite; .* row 0"),
                         ([[1, 2]], "shape"), ([[100, 110, 0]], "within the times"), ([[1, 2, 0], [1.5, 3, 0]], "overlap")):
        with pytest.raises(ValueError, match=words):
            torques.of_thrusters(TIME, wrong, response)


def test_of_the_true_rotation(tmp_path):
    """The commanded torque comes out of the rotation, and the estimate from that history is the same."""
    simulator = CASE.simulator()
    truth = simulator.truth()
    time, inertia = truth["time"], np.diag([183.8, 965.8, 1080.6])
    found = torques.of_rotation(time, truth["state"][:, 6:9], inertia)
    commanded = np.column_stack([amplitude * np.cos(2 * np.pi * frequency * time) for amplitude, frequency
                                 in ((3.676e-4, 0.06), (1.9316e-3, 0.08), (2.1612e-3, 0.1))])
    assert np.abs(found - commanded)[:-5].max() < 1e-3 * np.abs(commanded).max()    # the rest: gradient, light
    found[-5:] = commanded[-5:]     # the torque ends with the arc
    observations = simulator.observe(seed=4, run=1)
    observations.write(tmp_path)
    torques.write(tmp_path / "torque.csv", time, found)
    first, other = observations.estimate("optimal"), gracecg.Observations(tmp_path).estimate("optimal", CASE.options)
    assert np.all(np.abs(first.offset - other.offset) < 0.1 * first.sigma)
    assert np.all(np.abs(other.offset - CASE.offset) < 4 * other.sigma)


def test_without_force(tmp_path):
    """A force that was added comes off again."""
    CASE.simulator().observe(seed=4, run=1).write(tmp_path)
    samples, path, time = tmp_path / "accelerometer.csv", tmp_path / "less.csv", np.arange(0, 301.0)
    force = np.full((time.size, 3), [1e-6, 0, -2e-6])
    before = np.loadtxt(samples, delimiter=",", skiprows=1)
    torques.without_force(samples, time, force, 1000.0, path)
    after = np.loadtxt(path, delimiter=",", skiprows=1)
    assert np.allclose(before - after, [0, 1e-9, 0, -2e-9], rtol=0, atol=1e-22)
    headless = tmp_path / "headless.csv"
    headless.write_text("0,1,2,3\n1,1,2,3\n", encoding="utf-8")
    for wrong, words in (((samples, time, force, -1.0, path), "positive"), ((samples, time[:99], force[:99], 1.0, path), "all samples"),
                         ((headless, time, force, 1.0, path), "first line"), ((path, time, force, 1.0, path), "file of the samples"),
                         ((samples, time, force[:, :2], 1.0, path), "shape")):
        with pytest.raises(ValueError, match=words):
            torques.without_force(*wrong)
    with pytest.raises(ValueError, match="equidistant"):
        torques.write(path, [0, 1, 2, 3.5, 4], np.zeros((5, 3)))
    with pytest.raises(ValueError, match="finite"):
        torques.write(path, TIME, np.full((TIME.size, 3), np.nan))
    with pytest.raises(ValueError, match="shape"):
        torques.write(path, TIME, np.ones((TIME.size, 2)))
    assert np.array_equal(np.loadtxt(path, delimiter=",", skiprows=1), after)
