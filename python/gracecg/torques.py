"""Torque histories (`torque.csv`) of satellites without rods: of wheels, of thrusters, or of a measured rotation.

Arrays have one row an epoch, body axes, SI units; shapes, ranges and NaN are refused by ValueError. Such a history stands beside
the observations, or is the `torque_file` of `&torquers` in a case: simulate, bound, estimates and beliefs are then as with rods,
with gain, direction and delay of the torque about each axis as what may be wrong.
"""
from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

SAMPLES = "time_s,ax_m_s2,ay_m_s2,az_m_s2"
Array = NDArray[np.float64]


def of_wheels(time: ArrayLike, rates: ArrayLike, axes: ArrayLike, inertia: ArrayLike, omega: ArrayLike | None = None) -> Array:
    """-dh/dt - omega x h of reaction wheels with h = sum of I_k rate_k axis_k, N m, (n, 3).

    `rates` (n, wheels) in rad/s at equidistant times, `axes` (wheels, 3) unit vectors, `inertia` (wheels) in kg m^2 about them,
    `omega` (3) or (n, 3) of the satellite in rad/s; without it the second term is left out.
    """
    t = _times(time)
    moments = _checked("inertia", inertia, None)
    directions = _checked("axes", axes, moments.size, 3)
    if np.any(np.abs(np.linalg.norm(directions, axis=1) - 1) > 1e-4):
        raise ValueError("axes must be unit vectors, within 1e-4")
    if not np.all(moments > 0):
        raise ValueError("inertia must be positive")
    momentum = _checked("rates", rates, t.size, moments.size) @ (moments[:, None] * directions)
    torque = -_slope(t, momentum)
    if omega is None:
        return torque
    turning = np.broadcast_to(omega, (t.size, 3)) if np.ndim(omega) == 1 else omega
    return torque - np.cross(_checked("omega", turning, t.size, 3), momentum)


def of_thrusters(time: ArrayLike, firings: ArrayLike, response: ArrayLike) -> tuple[Array, Array]:
    """Force (N) and torque (N m) of thrusters, each (n, 3): means over the interval about every one of the equidistant times.

    `firings` (m, 3) are start, end (s) and number (from 0) of a thruster, `response` (6, thrusters) its force and torque. Firings
    outside the times, and of a thruster that fires already, are refused. A force that comes with the torque looks like an offset of
    J/(m r) for an arm r, metres: fire balanced pairs, take what is known of their imbalance from the samples (`without_force`), and
    trust the offset as far as that is known.
    """
    t, effect = _times(time), _checked("response", response, 6, None)
    fired = _checked("firings", np.reshape(firings, (-1, 3)) if np.size(firings) in (0, 3) else firings, None, 3)
    fired = fired[np.lexsort((fired[:, 0], fired[:, 2]))]
    half = (t[1] - t[0]) / 2
    if np.any((fired[:, 1] < fired[:, 0]) | (fired[:, 0] < t[0] - half) | (fired[:, 1] > t[-1] + half)):
        raise ValueError(f"firings must end after they start, and lie within the times, {t[0]} to {t[-1]} s")
    if np.any(fired[:, 2] != np.round(fired[:, 2])) or np.any((fired[:, 2] < 0) | (fired[:, 2] >= effect.shape[1])):
        raise ValueError(f"numbers of thrusters must be 0 to {effect.shape[1] - 1}")
    if np.any((fired[1:, 2] == fired[:-1, 2]) & (fired[1:, 0] < fired[:-1, 1])):
        raise ValueError("a thruster cannot fire while it fires: two firings overlap")
    on = np.zeros((t.size, effect.shape[1]))
    for start, end, thruster in fired:
        on[:, int(thruster)] += np.clip(np.minimum(end, t + half) - np.maximum(start, t - half), 0, None) / (2 * half)
    means = on @ effect.T
    return means[:, :3], means[:, 3:]


def of_rotation(time: ArrayLike, omega: ArrayLike, inertia: ArrayLike) -> Array:
    """J d omega/dt + omega x J omega of a rotation that gyros or star cameras measured, N m, (n, 3): (2-16).

    `omega` (n, 3) in rad/s at equidistant times, smoothed as its noise asks for; `inertia` (3, 3) in kg m^2. The gravity gradient's
    torque is in it, nearly constant, and a constant torque is estimated.
    """
    t = _times(time)
    rate, tensor = _checked("omega", omega, t.size, 3), _checked("inertia", inertia, 3, 3)
    return _slope(t, rate) @ tensor.T + np.cross(rate, rate @ tensor.T)


def write(path: str | Path, time: ArrayLike, torque: ArrayLike) -> None:
    """Writes a history (n, 3), N m, as `torque.csv` has it."""
    t = _times(time)
    _save(path, "time_s,tx_n_m,ty_n_m,tz_n_m", np.column_stack([t, _checked("torque", torque, t.size, 3)]))


def without_force(samples: str | Path, time: ArrayLike, force: ArrayLike, mass: float, out: str | Path) -> None:
    """Writes samples as `accelerometer.csv` has them without the acceleration by a force (n, 3), N, linear between its times.

    The times reach over the samples; `out` is another file than `samples`.
    """
    t = _times(time)
    known = _checked("force", force, t.size, 3)
    if not 0 < mass < np.inf:
        raise ValueError("mass must be positive, kg")
    if Path(out).exists() and Path(out).samefile(samples):
        raise ValueError(f"{out}: is the file of the samples")
    lines = [line for line in Path(samples).read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    if not lines or lines[0] != SAMPLES:
        raise ValueError(f"{samples}: its first line is not {SAMPLES}")
    rows = _checked(str(samples), [[float(word) for word in line.split(",")] for line in lines[1:]], None, 4)
    if rows.size and (rows[:, 0].min() < t[0] or rows[:, 0].max() > t[-1]):
        raise ValueError(f"the force is known from {t[0]} to {t[-1]} s, not over all samples")
    rows[:, 1:] -= np.column_stack([np.interp(rows[:, 0], t, column) for column in known.T]) / mass
    _save(out, SAMPLES, rows)


def _save(path: str | Path, header: str, rows: Array) -> None:
    """A file of numbers that can be read back exactly; it gets its name when it is complete."""
    np.savetxt(f"{path}.part", rows, "%.17g", ",", header=header, comments="")
    Path(f"{path}.part").replace(path)


def _checked(name: str, values: ArrayLike, *shape: int | None) -> Array:
    """Finite numbers of a shape; None: any length."""
    array = np.array(values, float)
    if array.ndim != len(shape) or any(wanted not in (None, found) for wanted, found in zip(shape, array.shape)):
        wanted = ", ".join("n" if length is None else str(length) for length in shape)
        raise ValueError(f"{name} must have the shape ({wanted}), not {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} must be finite; it is not in row {np.argwhere(~np.isfinite(array))[0][0]}")
    return array


def _times(time: ArrayLike) -> Array:
    t = _checked("time", time, None)
    if t.size < 5 or not t[1] > t[0] or not np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6, atol=0):
        raise ValueError("time must be five equidistant, increasing numbers or more")
    return t


def _slope(time: Array, values: Array) -> Array:
    """Derivatives by the polynomials through five neighbours: error h^4/30 times the fifth derivative, h^4/5 at the ends."""
    n = time.size
    first = np.clip(np.arange(n) - 2, 0, n - 5)
    powers = np.arange(5)
    # weights for the derivative at each of the five places: columns of the inverse of Vandermonde's matrix
    weights = np.array([np.linalg.solve(np.vander(powers - at, increasing=True).T, powers == 1) for at in range(5)], float)
    return np.einsum("nk,nkj->nj", weights[np.arange(n) - first], values[first[:, None] + powers]) / (time[1] - time[0])
