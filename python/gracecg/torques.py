"""Torque histories (`torque.csv`) of satellites without rods: of wheels, of thrusters, or of a measured rotation.

Arrays have one row an epoch, body axes, SI units. Such a history stands beside the observations, or is the `torque_file` of
`&torquers` in a case: simulate, bound, estimates and beliefs are then as with rods, with gain, direction and delay of the torque
about each axis as what may be wrong.
"""
from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

EARTH_GM = 3.986004415e14   # EGM96, m^3/s^2
Array = NDArray[np.float64]


def of_wheels(time: ArrayLike, rates: ArrayLike, axes: ArrayLike, inertia: ArrayLike, omega: ArrayLike | None = None) -> Array:
    """-dh/dt - omega x h of reaction wheels with h = sum of I_k rate_k axis_k, N m, (n, 3).

    `rates` (n, wheels) in rad/s at equidistant times, `axes` (wheels, 3) unit vectors, `inertia` (wheels) in kg m^2 about them,
    `omega` (3) or (n, 3) of the satellite; without it the second term is left out.
    """
    momentum = np.asarray(rates, float) @ (np.asarray(inertia, float)[:, None] * np.asarray(axes, float))
    torque = -_slope(_times(time), momentum)
    return torque if omega is None else torque - np.cross(np.broadcast_to(np.asarray(omega, float), momentum.shape), momentum)


def of_thrusters(time: ArrayLike, firings: ArrayLike, response: ArrayLike) -> tuple[Array, Array]:
    """Force (N) and torque (N m) of thrusters, each (n, 3): means over the interval about every one of the equidistant times.

    `firings` (m, 3) are start, end (s) and number (from 0) of a thruster, `response` (6, thrusters) its force and torque. A force
    that comes with the torque looks like an offset of J/(m r) for an arm r, metres: fire balanced pairs, take what is known of
    their imbalance from the samples (`without_force`), and trust the offset as far as that is known.
    """
    t, fired, response = _times(time), np.atleast_2d(np.asarray(firings, float)), np.asarray(response, float)
    if response.ndim != 2 or response.shape[0] != 6 or fired.shape[1] != 3:
        raise ValueError("response must be (6, thrusters), firings (m, 3)")
    if not np.all(np.isfinite(fired)) or np.any(fired[:, 1] < fired[:, 0]):
        raise ValueError("firings must be finite and end after they start")
    if np.any(fired[:, 2] != np.round(fired[:, 2])) or np.any((fired[:, 2] < 0) | (fired[:, 2] >= response.shape[1])):
        raise ValueError(f"numbers of thrusters must be 0 to {response.shape[1] - 1}")
    half = (t[1] - t[0]) / 2
    on = np.zeros((t.size, response.shape[1]))
    for start, end, thruster in fired:
        on[:, int(thruster)] += np.clip(np.minimum(end, t + half) - np.maximum(start, t - half), 0, None) / (2 * half)
    means = on @ response.T
    return means[:, :3], means[:, 3:]


def of_rotation(time: ArrayLike, omega: ArrayLike, inertia: ArrayLike, position: ArrayLike | None = None) -> Array:
    """J d omega/dt + omega x J omega of a rotation that gyros or star cameras measured, N m, (n, 3): (2-16).

    `omega` (n, 3) in rad/s at equidistant times, smoothed as its noise asks for; `inertia` (3, 3) in kg m^2. With the geocentric
    `position` (n, 3) in body axes, m, less the torque of the gravity gradient (2-23), which the estimators have in their model.
    """
    rate, tensor = np.asarray(omega, float), np.asarray(inertia, float)
    torque = _slope(_times(time), rate) @ tensor.T + np.cross(rate, rate @ tensor.T)
    if position is not None:
        distance = np.linalg.norm(position, axis=1, keepdims=True)
        up = np.asarray(position, float) / distance
        torque -= 3 * EARTH_GM / distance**3 * np.cross(up, up @ tensor.T)
    return torque


def write(path: str | Path, time: ArrayLike, torque: ArrayLike) -> None:
    """Writes a history as `torque.csv` has it."""
    _save(path, "time_s,tx_n_m,ty_n_m,tz_n_m", np.column_stack([_times(time), torque]))


def without_force(path: str | Path, time: ArrayLike, force: ArrayLike, mass: float) -> None:
    """Takes the acceleration by a force (n, 3), N, from the samples of a file as `accelerometer.csv`, by linear interpolation."""
    header = next(line for line in Path(path).read_text().splitlines() if not line.startswith("#"))
    samples = np.loadtxt(path, delimiter=",", skiprows=0, comments=("#", "time_s"))
    for axis in range(3):
        samples[:, 1 + axis] -= np.interp(samples[:, 0], _times(time), np.asarray(force, float)[:, axis]) / mass
    _save(path, header, samples)


def _save(path: str | Path, header: str, rows: Array) -> None:
    """A file of numbers that can be read back exactly; it gets its name when it is complete."""
    if not np.all(np.isfinite(rows)):
        raise ValueError("every number must be finite")
    part = Path(f"{path}.part")
    np.savetxt(part, rows, "%.17g", ",", header=header, comments="")
    part.replace(path)


def _times(time: ArrayLike) -> Array:
    t = np.asarray(time, float)
    if t.ndim != 1 or t.size < 5 or not np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6, atol=0) or not t[1] > t[0]:
        raise ValueError("time must be five equidistant, increasing numbers or more")
    return t


def _slope(time: Array, values: Array) -> Array:
    """Derivatives by the polynomials through five neighbours: error h^4/30 times the fifth derivative, h^4/5 at the ends."""
    if values.shape[0] != time.size:
        raise ValueError(f"{values.shape[0]} rows for {time.size} times")
    n = time.size
    first = np.clip(np.arange(n) - 2, 0, n - 5)
    powers = np.arange(5)
    # weights for the derivative at each of the five places: columns of the inverse of Vandermonde's matrix
    weights = np.array([np.linalg.solve(np.vander(powers - at, increasing=True).T, powers == 1) for at in range(5)], float)
    return np.einsum("nk,nkj->nj", weights[np.arange(n) - first], values[first[:, None] + powers]) / (time[1] - time[0])
