"""Cases, simulation, bound, planning, Monte Carlo; and the names of estimates.py, with observation sets and estimates."""
from __future__ import annotations

import concurrent.futures
import os
from dataclasses import astuple, dataclass, field
from typing import Any, Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import Handle, alike, array, call, exactly, ffi, numbers, pointer, spread
from .estimates import (Action, Array, Beliefs, Chain, Fit, FitTests, Joined, Joint, LiveEstimate, LiveOffset, Observations,
                        Options, Setup, Solution, _names, _settings, _WithOptions, algorithms, estimate_joint)
from .models import Utc

__all__ = ["Action", "Array", "Beliefs", "Bound", "Case", "Chain", "Design", "DesignSettings", "Fit", "FitTests", "ForceModel",
           "Joined", "Joint", "LiveEstimate", "LiveOffset", "Map", "MonteCarlo", "Observations", "Options", "Rod", "Setup",
           "Simulator", "Solution", "algorithms", "case_names", "estimate_joint", "monte_carlo"]


def case_names() -> list[str]:
    """The built-in cases."""
    return _names("case")


class Simulator(Handle):
    """The true arc of a case and what its star cameras see: once, for any number of runs."""

    def __init__(self, case: "Case") -> None:
        super().__init__("simulator_open", Case._of(case))

    def observe(self, seed: int = 1, run: int = 1) -> Observations:
        """Simulated observations, those of ``gracecg simulate --seed SEED --run RUN``."""
        return Observations._made("simulate", self._handle, seed, run)

    def truth(self) -> dict[str, Array]:
        """The true arc, without the run's density wave.

        Returns
        -------
        dict
            "time" (n,), s from the epoch; "state" (n, 13): position m, velocity m/s (inertial), angular velocity
            rad/s (body), quaternion; "angular_acceleration" rad/s^2, "flux_density" T, "non_gravitational" m/s^2
            (n, 3), body axes.
        """
        three = ("angular_acceleration", "flux_density", "non_gravitational")
        return {"time": self._numbers("time"), "state": self._numbers("state", -1, 13)} | \
            {name: self._numbers(name, -1, 3) for name in three}


class ForceModel(Handle):
    """One satellite with all its models, built from a case; times are s from the case's epoch."""

    def __init__(self, case: "Case") -> None:
        super().__init__("force_model_open", Case._of(case))

    def accelerations(self, seconds: ArrayLike, position: ArrayLike, velocity: ArrayLike,
                      quaternion: ArrayLike) -> dict[str, Array]:
        """Accelerations (n, 3), m/s^2, inertial axes: "gravity", "drag", "solar_radiation", "earth_radiation" and
        their sum "total", at positions (m), velocities (m/s) (n, 3), inertial, and attitudes (n, 4)."""
        where = numbers(position, 3)
        n = len(where)
        found = {name: np.empty((n, 3)) for name in
                 ("gravity", "drag", "solar_radiation", "earth_radiation", "total")}
        speeds, attitudes = exactly(numbers(velocity, 3), n, 3), exactly(numbers(quaternion, 4), n, 4)
        call("force_model_evaluate", self._handle, n, pointer(spread(seconds, n)), pointer(where), pointer(speeds),
             pointer(attitudes), *map(pointer, found.values()))
        return dict(zip(found, alike(position, *found.values())))

    def torques(self, seconds: float, state: ArrayLike) -> dict[str, Array]:
        """Torques (3,), N m, body axes, about the centre of mass: "aerodynamic", "solar", "gravity_gradient",
        "magnetic"; and "flux_density", T, for one state (13,)."""
        torques, flux = np.empty((4, 3)), np.empty(3)
        call("force_model_loads", self._handle, seconds, pointer(exactly(state, 13)), pointer(torques), pointer(flux),
             ffi.NULL, ffi.NULL)
        return dict(zip(("aerodynamic", "solar", "gravity_gradient", "magnetic", "flux_density"), [*torques, flux]))

    def orientation(self, seconds: float, state: ArrayLike) -> Array:
        """The rotation (3, 3) from inertial to Earth-fixed axes that the model has at a time; `state` (13,) a state then."""
        rotation = np.empty((3, 3))
        call("force_model_loads", self._handle, seconds, pointer(exactly(state, 13)), ffi.NULL, ffi.NULL, ffi.NULL,
             pointer(rotation))
        return rotation

    def rate(self, seconds: float, state: ArrayLike) -> Array:
        """The time derivative (13,) of a state (13,)."""
        rate = np.empty(13)
        call("force_model_loads", self._handle, seconds, pointer(exactly(state, 13)), ffi.NULL, ffi.NULL, pointer(rate),
             ffi.NULL)
        return rate

    def propagate(self, state: ArrayLike, interval: float, steps: int, tolerance: float = 0.0) -> Array:
        """States (steps + 1, 13) every `interval` s from time 0, the attitude free; tolerance 0: one step an
        interval of up to 60 s, else steps under control (1e-11; docs/theory.md, section 8), with interpolation."""
        return self._states(exactly(state, 13), 0, interval, steps, tolerance)

    def propagate_nadir(self, position: ArrayLike, velocity: ArrayLike, interval: float, steps: int,
                        tolerance: float = 0.0, forward: bool = True) -> Array:
        """States (steps + 1, 13) of a satellite whose z points to the centre of the Earth; x along the orbit or,
        not `forward`, against it. Position m, velocity m/s, inertial."""
        state = np.concatenate([exactly(position, 3), exactly(velocity, 3), np.zeros(6), [1.0]])
        return self._states(state, 1 if forward else 2, interval, steps, tolerance)

    def _states(self, state: Array, pointing: int, interval: float, steps: int, tolerance: float) -> Array:
        if steps < 0:
            raise ValueError(f"steps = {steps}: 0 or more are allowed")
        states = np.empty((steps + 1, 13))
        call("force_model_propagate", self._handle, pointer(state), pointing, interval, steps, tolerance, pointer(states))
        return states


@dataclass(frozen=True, eq=False)
class Bound:
    """The least covariance of the offset with a case's manoeuvre and noise; body axes.

    Attributes
    ----------
    covariance : ndarray, (3, 3)
        m^2.
    sigma : ndarray, (3,)
        m.
    principal_sigma, direction : ndarray, (3,), (3, 3)
        Ascending, m; rows are unit vectors, the last one the worst.
    consider_sigma : ndarray, (3,)
        With what is known only within limits, m.
    by_source : ndarray, (5, 3)
        Added by scale factors, rod gain, magnetometer bias, inertia, unmodelled torque, m.
    """

    covariance: Array = array(3, 3)
    sigma: Array = array(3)
    principal_sigma: Array = array(3)
    direction: Array = array(3, 3)
    consider_sigma: Array = array(3)
    by_source: Array = array(5, 3)


@dataclass(frozen=True)
class Rod:
    """The moment of a torque rod from start to stop.

    Attributes
    ----------
    amplitude : float
        A m^2.
    frequency : float
        Hz.
    phase : float
        rad.
    start, stop : float
        s from the case's epoch.
    taper, rise_time : float
        Of a smooth start and stop, of the edges of a square wave, s.
    axis : int
        Body axis 1, 2 or 3.
    waveform : int
        1 sine, 2 cosine, 3 tapered, 4 square.
    """

    amplitude: float
    frequency: float
    phase: float
    start: float
    stop: float
    taper: float
    rise_time: float
    axis: int
    waveform: int


@dataclass
class DesignSettings:
    """What the planner may do; `Case.design_settings` has the defaults of a case.

    Attributes
    ----------
    start, duration : float
        Of the calibration, s from the case's epoch; of the arc, 10 to 600 s.
    amplitude : float
        Of each rod, A m^2, at most 30.
    lowest_frequency, highest_frequency : float
        Hz.
    taper, rise_time : float
        s.
    rate_limit, pointing_limit : float
        rad/s, rad.
    rod_used : sequence of 3
        Along body x, y, z.
    waveform_used : sequence of 4
        Sine, cosine, tapered, square.
    threads : int
        1 to 1024; the result does not depend on it.
    """

    start: float
    duration: float
    amplitude: float
    lowest_frequency: float
    highest_frequency: float
    taper: float
    rise_time: float
    rate_limit: float
    pointing_limit: float
    rod_used: Sequence[int]
    waveform_used: Sequence[int]
    threads: int = 1


@dataclass(frozen=True, eq=False)
class Design:
    """A designed manoeuvre: errors of the offset in m, body axes.

    Attributes
    ----------
    case : Case
        With that manoeuvre at that place.
    sigma, wave, force : ndarray, (3,)
        The limit under the accelerometer's noise, RMS error by the density wave, error by curved drag and radiation.
    worst : float
        Greatest sqrt(sigma^2 + wave^2 + force^2) of the axes.
    rate, excursion : float
        Greatest angular velocity, rad/s; greatest turn away from the nominal attitude, rad.
    evaluations : int
    start : float
        Of the arc of `case`, s from the epoch of the case that was given.
    """

    case: "Case"
    sigma: Array = array(3)
    wave: Array = array(3)
    force: Array = array(3)
    worst: float
    rate: float
    excursion: float
    evaluations: int
    start: float


@dataclass(frozen=True, eq=False)
class Map:
    """A manoeuvre at n places of an orbit.

    Attributes
    ----------
    seconds : ndarray, (n,)
        Start of the calibration from the case's epoch.
    latitude, longitude : ndarray, (n,)
        Geodetic, rad.
    sigma, wave, force : ndarray, (n, 3)
        As in `Design`, m.
    worst_sigma, worst_direction : ndarray, (n,), (n, 3)
        Standard deviation of the worst direction, m, and that direction; DBL_MAX where it stays unseen.
    """

    seconds: Array
    latitude: Array
    longitude: Array
    sigma: Array = array(-1, 3)
    worst_sigma: Array
    worst_direction: Array
    wave: Array = array(-1, 3)
    force: Array = array(-1, 3)


class Case(_WithOptions):
    """A calibration case: satellite, orbit, models, instruments and manoeuvre.

    Parameters
    ----------
    name : str or path
        A built-in case (`case_names`), or a case file.
    """

    def __init__(self, name: str | os.PathLike[str]) -> None:
        super().__init__("case_open", os.fsencode(name))

    @classmethod
    def parse(cls, text: str) -> "Case":
        """From the text of a case file."""
        return cls._made("case_open", _settings(text))

    def __reduce__(self) -> Any:
        return Case.parse, (self.text,)

    @property
    def text(self) -> str:
        """The case file's text, with every setting, its unit and meaning."""
        return self._text("text")

    @property
    def epoch(self) -> Utc:
        """Time 0."""
        day, seconds = self._numbers("epoch")
        return Utc(int(day), float(seconds))

    @property
    def duration(self) -> float:
        """Of the true arc, s."""
        return self._number("duration")

    @property
    def state(self) -> Array:
        """Initial state (13,): position m, velocity m/s (inertial), angular velocity rad/s (body), quaternion."""
        return self._numbers("state")

    @property
    def offset(self) -> Array:
        """The true d (3,), from the centre of mass to the proof mass, body axes, m."""
        return self._numbers("offset")

    @property
    def rods(self) -> list[Rod]:
        """The manoeuvre."""
        kinds = self._numbers("rod_kinds", -1, 2).astype(int).tolist()
        return [Rod(*rod, *kind) for rod, kind in zip(self._numbers("rods", -1, 7).tolist(), kinds)]

    def simulator(self) -> Simulator:
        """The true arc, and what the instruments see."""
        return Simulator(self)

    def force_model(self) -> ForceModel:
        """Forces, torques and propagation."""
        return ForceModel(self)

    def bound(self) -> Bound:
        """The least error that an estimate can have."""
        return Handle("case_bound", self._handle)._values(Bound)

    def design_settings(self) -> DesignSettings:
        """Those of ``gracecg design``."""
        choices = self._numbers("design_choices").astype(int).tolist()
        return DesignSettings(*self._numbers("design_settings").tolist(), choices[:3], choices[3:7], choices[7])

    def design(self, settings: DesignSettings | None = None) -> Design:
        """The manoeuvre with the best worst axis at one place of the orbit; takes seconds."""
        return self._search(settings, 1, 1)

    def design_anywhere(self, settings: DesignSettings | None = None, revolutions: int = 1) -> Design:
        """The same at the start that is best on 1 to 150 revolutions; `Design.start` tells it."""
        return self._search(settings, 2, revolutions)

    def design_everywhere(self, settings: DesignSettings | None = None, revolutions: int = 1) -> Design:
        """One manoeuvre with the best worst axis at all places of 1 to 150 revolutions."""
        return self._search(settings, 3, revolutions)

    def _search(self, settings: DesignSettings | None, place: int, revolutions: int) -> Design:
        *values, rods, waveforms, threads = astuple(settings or self.design_settings())
        if (len(rods), len(waveforms)) != (3, 4):
            raise ValueError(f"rod_used has 3 values and waveform_used 4, not {len(rods)} and {len(waveforms)}")
        choices = np.array([*map(bool, rods), *map(bool, waveforms), threads], dtype=np.int32)
        planned = Case._made("design", self._handle, pointer(exactly(values, 9)), pointer(choices), place, revolutions)
        return planned._values(Design, case=planned)

    def map(self, seconds: ArrayLike, threads: int = 1) -> Map:
        """The manoeuvre where it starts `seconds` (n,) from the epoch."""
        times = numbers(seconds)
        found = Handle("map", self._handle, len(times), pointer(times), threads)
        place, worst = found._numbers("place", -1, 2), found._numbers("worst", -1, 4)
        return found._values(Map, seconds=times, latitude=place[:, 0], longitude=place[:, 1], worst_sigma=worst[:, 0],
                             worst_direction=worst[:, 1:])


@dataclass(frozen=True, eq=False)
class MonteCarlo:
    """Estimates of many runs.

    Attributes
    ----------
    truth : ndarray, (3,)
        The case's d, m.
    offset : ndarray, (runs, 3)
        m.
    converged : ndarray of bool, (runs,)
    """

    truth: Array
    offset: Array
    converged: NDArray[np.bool_]
    error: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "error", self.offset - self.truth)

    @property
    def rms(self) -> Array:
        """RMS of the error (3,), m."""
        return np.sqrt(np.mean(self.error**2, axis=0))


def monte_carlo(case: Case, algorithm: str = "optimal", runs: int = 15, seed: int = 1, threads: int | None = None,
                progress: Callable[[int, int], object] | None = None, options: Options | None = None) -> MonteCarlo:
    """Simulates and estimates runs 1 to `runs`, as ``gracecg montecarlo`` does.

    Parameters
    ----------
    threads : int, optional
        As many as there are processors. The numbers do not depend on it.
    progress : callable, optional
        Called with the number of runs done and of all; when it gives False the work stops with KeyboardInterrupt.
    options : str or mapping, optional
        In place of the case's.
    """
    if not isinstance(case, Case):
        raise TypeError(f"an object of the class Case is expected, not {case!r}")
    if runs < 1:
        raise ValueError(f"runs is {runs}; 1 or more are allowed")
    simulator = case._with(options).simulator()

    def one(run: int) -> Solution:
        return Fit(algorithm, simulator.observe(seed, run)).solution

    with concurrent.futures.ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        waiting = [pool.submit(one, run) for run in range(1, runs + 1)]
        try:
            for done, _ in enumerate(concurrent.futures.as_completed(waiting), start=1):
                if progress is not None and progress(done, runs) is False:
                    raise KeyboardInterrupt(f"stopped after {done} of {runs} runs")
        finally:
            for item in waiting:
                item.cancel()
        solutions = [item.result() for item in waiting]
    return MonteCarlo(case.offset, np.array([one.offset for one in solutions]).reshape(-1, 3),
                      np.array([one.converged for one in solutions], dtype=bool))
