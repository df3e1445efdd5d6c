"""Torque histories: identities, the truth of a simulation, and what is refused."""
import csv
import pathlib
import shutil

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


def test_thrusters():
    """The impulse is that of the firings, wherever they begin; a balanced pair has no force."""
    response = np.array([[0.01, -0.01], [0, 0], [0, 0], [0, 0], [0.005, 0.005], [0, -0.001]])
    firings = [[1.03, 1.08, 0], [1.03, 1.08, 1], [7.0, 9.25, 0], [7.0, 9.25, 1]]
    force, torque = torques.of_thrusters(TIME, firings, response)
    assert np.allclose(force, 0, atol=1e-18)
    assert np.allclose(torque.sum(0) * 0.1, (0.05 + 2.25) * response[3:].sum(1), rtol=1e-12)
    force, _ = torques.of_thrusters(TIME, firings[2], response)
    assert np.isclose(force.sum() * 0.1, 2.25 * 0.01)
    for wrong in ([[1, 2, 2]], [[2, 1, 0]], [[1, np.nan, 0]], [[1, 2]]):
        with pytest.raises(ValueError):
            torques.of_thrusters(TIME, wrong, response)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """NGGM's shaking, simulated."""
    folder = tmp_path_factory.mktemp("nggm")
    CASE.simulator().observe(seed=4, run=1).write(folder)
    return folder


def columns(path, *names):
    with path.open() as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return np.array([[float(row[name]) for name in names] for row in rows])


def test_of_the_true_rotation(folder, tmp_path):
    """The commanded torque comes out of the rotation, and the estimate from that history is the same."""
    truth = CASE.simulator().truth()
    time, inertia = truth["time"], np.diag([183.8, 965.8, 1080.6])
    found = torques.of_rotation(time, truth["state"][:, 6:9], inertia)
    commanded = np.column_stack([amplitude * np.cos(2 * np.pi * frequency * time) for amplitude, frequency
                                 in ((3.676e-4, 0.06), (1.9316e-3, 0.08), (2.1612e-3, 0.1))])
    # the rest: gradient, light; the torque ends with the arc
    assert np.abs(found - commanded)[:-5].max() < 1e-3 * np.abs(commanded).max()
    own = tmp_path / "own"
    shutil.copytree(folder, own)
    torques.write(own / "torque.csv", time, found)
    first, other = (gracecg.Observations(path).estimate("optimal", CASE.options) for path in (folder, own))
    assert np.all(np.abs(first.offset - other.offset) < 0.5 * first.sigma)
    assert np.all(np.abs(other.offset - CASE.offset) < 4 * other.sigma)


def test_without_force(folder, tmp_path):
    """A force that was added comes off again."""
    path = tmp_path / "accelerometer.csv"
    shutil.copy(folder / "accelerometer.csv", path)
    before = columns(path, "time_s", "ax_m_s2", "ay_m_s2", "az_m_s2")
    torques.without_force(path, TIME, np.full((TIME.size, 3), [1e-6, 0, -2e-6]), 1000.0)
    after = columns(path, "time_s", "ax_m_s2", "ay_m_s2", "az_m_s2")
    assert np.allclose(before[:, 1:] - after[:, 1:], [1e-9, 0, -2e-9], rtol=0, atol=1e-22)
    assert np.array_equal(before[:, 0], after[:, 0])
    with pytest.raises(ValueError, match="equidistant"):
        torques.write(path, [0, 1, 2, 3.5, 4], np.zeros((5, 3)))
    with pytest.raises(ValueError, match="finite"):
        torques.write(path, TIME, np.full((TIME.size, 3), np.nan))
    assert np.array_equal(columns(path, "time_s")[:, 0], before[:, 0])
