"""Cases, simulation, observation sets, estimates, bound, planning, Monte Carlo."""
from __future__ import annotations

import concurrent.futures
import itertools
import os
from dataclasses import astuple, dataclass, field
from typing import Any, Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import NOT_CONVERGED, Handle, array, call, exactly, ffi, lib, named, numbers, pointer, text_of
from .models import Utc

Array = NDArray[np.float64]
Options = "str | Mapping[str, Mapping[str, Any]]"


def _names(of: str) -> list[str]:
    pointers = (lib.gracecg_name(of.encode(), i) for i in itertools.count())
    return [text_of(name) for name in itertools.takewhile(lambda name: name != ffi.NULL, pointers)]


def algorithms() -> list[str]:
    """The estimators by name."""
    return _names("algorithm")


def case_names() -> list[str]:
    """The built-in cases."""
    return _names("case")


def _namelist(options: Options) -> bytes:
    """The text of a file of options, of itself or of {group: {key: value}}."""
    if isinstance(options, str):
        return options.encode()

    def written(value: Any) -> str:
        if isinstance(value, (bool, np.bool_)):
            return ".true." if value else ".false."
        if isinstance(value, str):
            return "'" + value.replace("'", "''") + "'"
        if np.ndim(value) > 0:
            return ", ".join(written(item) for item in np.asarray(value).tolist())
        return repr(value.item() if isinstance(value, np.generic) else value)

    lines = []
    for group, keys in options.items():
        lines += [f"&{group}", *(f"    {key} = {written(value)}" for key, value in keys.items()), "/"]
    return ("\n".join(lines) + "\n").encode()


def _settings(text: str) -> bytes:
    """A text that cannot be taken for the name of a file: with a line break."""
    return (text + "\n").encode()


class _WithOptions(Handle):
    """What carries options of the estimators."""

    @property
    def options(self) -> str:
        """How to estimate, as the text of a file of options."""
        return self._text("options")

    def with_options(self, options: Options):
        """The same object with other options.

        Parameters
        ----------
        options : str or mapping
            The text of a file of options, or ``{group: {key: value}}`` with the groups "estimation", "optimal",
            "sequential"; what is not said has its default.
        """
        return self._made("options_replace", self._handle, _namelist(options))


@dataclass(frozen=True)
class Solution:
    """The result of an estimator.

    Attributes
    ----------
    offset : ndarray, (3,)
        d, from the centre of mass to the proof mass, body axes, m.
    sigma : ndarray, (3,)
        Square roots of the diagonal of the covariance, m.
    covariance : ndarray, (3, 3)
        Of the offset under the instruments' noise, m^2.
    drift, bias : ndarray, (3,)
        Of the non-gravitational acceleration's straight line, m/s^3, and its value at the epoch, m/s^2.
    quaternion : ndarray, (4,)
        Attitude at the epoch, inertial to body, scalar last.
    angular_velocity : ndarray, (3,)
        At the epoch, body axes, rad/s.
    residual_rms : ndarray, (3,)
        Of the accelerometer, m/s^2.
    condition : float
        Of the scaled normal matrix.
    variance_factor : float
        Weighted squares of the residuals over their redundancy; 0 of the report's four estimators.
    noise_level, noise_corner : ndarray, (3,)
        Of the accelerometer, as weighted with: m^2 s^-4/Hz, Hz.
    star_camera_sigma : ndarray, (3,)
        About camera x, y, boresight, rad.
    parameters : dict
        Name: (value, standard deviation) of the parameters beside the offset, SI units.
    edited : ndarray, (2,)
        Samples left out: accelerometer (by axis), star camera.
    iterations : int
    converged : bool
        If not, the offset is not to be relied upon.
    warnings : list of str
    """

    offset: Array = array(3)
    sigma: Array = array(3)
    covariance: Array = array(3, 3)
    drift: Array = array(3)
    bias: Array = array(3)
    quaternion: Array = array(4)
    angular_velocity: Array = array(3)
    residual_rms: Array = array(3)
    condition: float
    variance_factor: float
    noise_level: Array = array(3)
    noise_corner: Array = array(3)
    star_camera_sigma: Array = array(3)
    parameters: dict[str, tuple[float, float]]
    edited: Array = array(2)
    iterations: int
    converged: bool
    warnings: list[str]


@dataclass(frozen=True)
class FitTests:
    """What a fit tells of model and noise, by accelerometer axis where there are three.

    Attributes
    ----------
    torque_factor, torque_sigma : float
        Of the rods' torque that would fit the rotation best, and its standard deviation; sigma 0: not compared.
    attitude_misfit : float
        RMS of the attitude's residuals, standard deviations; 0: the noise is not known.
    rms, expected_rms : ndarray, (3,)
        Of the residuals, and of the setup's noise, m/s^2.
    ratio, ratio_sigma : ndarray, (3,)
        RMS of the whitened residuals, 1 if the noise is that of the setup; its standard deviation by chance.
    probability : ndarray, (3,)
        That white noise has such autocorrelations (Ljung and Box).
    worst, worst_time : ndarray, (3,)
        The largest residual, m/s^2, and its time, s.
    peak_frequency, peak_ratio : ndarray, (3,)
        Where the spectrum is farthest above the expected one, Hz, and the quotient there.
    bound : ndarray, (3,)
        Sigma of d that the accelerometer allows if the rotation is known, m; 0: not determined.
    information_share : ndarray, (axis, component)
    source_share : ndarray, (5, component)
        Of the variance: noise of accelerometer x, y, z, of the star camera, a-priori knowledge.
    semi_axis, direction : ndarray, (3,), (3, 3)
        Of the error ellipsoid of one sigma, longest first, m; rows are unit vectors, body axes.
    """

    torque_factor: float = named("test_torque_factor")
    torque_sigma: float = named("test_torque_sigma")
    attitude_misfit: float = named("test_attitude_misfit")
    rms: Array = array(3, item="test_rms")
    expected_rms: Array = array(3, item="test_expected_rms")
    ratio: Array = array(3, item="test_ratio")
    ratio_sigma: Array = array(3, item="test_ratio_sigma")
    probability: Array = array(3, item="test_probability")
    worst: Array = array(3, item="test_worst")
    worst_time: Array = array(3, item="test_worst_time")
    peak_frequency: Array = array(3, item="test_peak_frequency")
    peak_ratio: Array = array(3, item="test_peak_ratio")
    bound: Array = array(3, item="test_bound")
    information_share: Array = array(3, 3, item="test_information_share")
    source_share: Array = array(5, 3, item="test_source_share")
    semi_axis: Array = array(3, item="test_semi_axis")
    direction: Array = array(3, 3, item="test_direction")


class Fit(Handle):
    """An estimate with all that it can tell of itself; made by `Observations.fit`."""

    def __init__(self, algorithm: str, observations: "Observations") -> None:
        super().__init__("estimate", algorithm.encode(), observations._handle, allowed=[NOT_CONVERGED])

    @property
    def solution(self) -> Solution:
        """The result."""
        found = zip(self._numbers("parameter_value").tolist(), self._numbers("parameter_sigma").tolist())
        return self._values(Solution, parameters=dict(zip(self._text("parameter_names").splitlines(), found)),
                            warnings=self._text("warnings").splitlines())

    @property
    def parameters(self) -> list[str]:
        """Names of the parameters, d_x, d_y, d_z first."""
        return self._text("fitted_names").splitlines()

    def series(self) -> dict[str, Array]:
        """Of the accelerometer samples that the fit keeps.

        Returns
        -------
        dict
            "time" (n,), s from the epoch; "residual" (n, 3), observed minus fitted, m/s^2; "partials" (n, 3, 3), the
            row an axis of the acceleration, the column a component of the offset, 1/s^2; "angular_acceleration"
            (n, 3), rad/s^2; body axes.
        """
        return {"time": self._numbers("time"), "residual": self._numbers("residual", -1, 3),
                "partials": self._numbers("partials", -1, 3, 3),
                "angular_acceleration": self._numbers("angular_acceleration", -1, 3)}

    def covariance(self) -> Array:
        """Covariance (parameters, parameters), SI units."""
        n = len(self.parameters)
        return self._numbers("fitted_covariance", n, n)

    def covariance_by_source(self) -> Array:
        """What of the offset's covariance comes from accelerometer x, y, z, star camera, a-priori knowledge:
        (5, 3, 3), m^2."""
        return self._numbers("covariance_by_source", 5, 3, 3)

    def state_covariance(self) -> Array:
        """Covariance (15, 15) of d, alpha, beta, omega and the attitude's small angles, SI units."""
        return self._numbers("state_covariance", 15, 15)

    def tests(self) -> FitTests:
        """Residuals, torque and attitude against what is known of the noise."""
        return self._values(FitTests)

    def running(self) -> dict[str, Array]:
        """The offset as "sequential" had it on the way: "time" (n,), s; "offset", "sigma" (n, 3), m."""
        return {"time": self._numbers("running_time"), "offset": self._numbers("running_offset", -1, 3),
                "sigma": self._numbers("running_sigma", -1, 3)}

    def beliefs(self) -> "Beliefs":
        """What the data say of rods, inertia, instruments and noise."""
        return self._values(Beliefs, contradictions=self._text("contradictions"), untestable=self._text("untestable"))


@dataclass(frozen=True)
class Beliefs:
    """What the data say of what the setup states.

    Attributes
    ----------
    undetected : ndarray, (3,)
        What a single wrong belief could move each component of the offset by, unseen, m.
    apart : ndarray, (3,)
        Part of it that is the difference from the estimate of "optimal", m.
    tested, contradicted, untested : int
        How many; untested: too weakly, they could move a component farther than is wanted.
    sign_known : bool
        The setup says that the sign of the accelerometer is confirmed.
    contradictions, untestable : str
        In words, with what would explain them; empty where there is none.
    """

    undetected: Array = array(3, item="belief_undetected")
    apart: Array = array(3, item="belief_apart")
    tested: int = named("belief_tested")
    contradicted: int = named("belief_contradicted")
    untested: int = named("belief_untested")
    sign_known: bool = named("belief_sign_known")
    contradictions: str
    untestable: str


class Setup(_WithOptions):
    """What an operator knows: satellite, manoeuvre, instruments.

    Parameters
    ----------
    path : str or path
        Of a file setup.nml.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__("setup_open", os.fsencode(path))

    @classmethod
    def parse(cls, text: str) -> "Setup":
        """From the text of a setup.nml."""
        return cls._made("setup_open", _settings(text))

    @property
    def text(self) -> str:
        """The text of setup.nml, followed by the options."""
        return self._text("text")

    def measured(self, time: ArrayLike, moment: ArrayLike) -> "Setup":
        """The same with measured moments of the rods: times (n,), s from the epoch; moments (n, 3), A m^2."""
        times, moments = numbers(time), numbers(moment, 3)
        return self._made("setup_from", self._handle, len(times), pointer(times), pointer(exactly(moments, len(times), 3)))


class Observations(_WithOptions):
    """The samples of one calibration, and what the operator knows.

    Parameters
    ----------
    folder : str or path
        As ``gracecg simulate`` writes it.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        super().__init__("observations_open", os.fsencode(folder))

    @classmethod
    def from_arrays(cls, setup: Setup, accelerometer: tuple[ArrayLike, ArrayLike],
                    star_camera: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
                    magnetometer: tuple[ArrayLike, ArrayLike] | None = None,
                    orbit: tuple[ArrayLike, ArrayLike] | None = None) -> "Observations":
        """From arrays in memory, which are copied and checked; times (n,) in s from the setup's epoch, rising.

        Parameters
        ----------
        setup : Setup
        accelerometer : (time, acceleration)
            Acceleration (n, 3), body axes, m/s^2.
        star_camera : (time, head, quaternion)
            Heads (n,) 1 or 2; quaternions (n, 4), inertial to camera, scalar last.
        magnetometer : (time, flux_density), optional
            Flux density (n, 3), body axes, T; a field model stands in where an orbit is given.
        orbit : (time, position), optional
            Position (n, 3), inertial, m.
        """
        star_camera = star_camera if star_camera is not None else ((), (), ())
        magnetometer = magnetometer if magnetometer is not None else ((), ())
        orbit = orbit if orbit is not None else ((), ())
        heads = np.ascontiguousarray(star_camera[1], dtype=np.int32)
        series = ((numbers(accelerometer[0]), numbers(accelerometer[1], 3)),
                  (numbers(star_camera[0]), heads, numbers(star_camera[2], 4)),
                  (numbers(magnetometer[0]), numbers(magnetometer[1], 3)), (numbers(orbit[0]), numbers(orbit[1], 3)))
        arguments: list[Any] = []
        for arrays in series:
            n = len(arrays[0])
            if any(len(array) != n for array in arrays):
                raise ValueError(f"arrays of {', '.join(str(len(array)) for array in arrays)} rows")
            arguments += [n, *(pointer(array) for array in arrays)]
        return cls._made("observations_create", setup._handle, *arguments)

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Into a folder, which is made if it is not there."""
        call("observations_write", self._handle, os.fsencode(folder))

    @property
    def setup(self) -> Setup:
        """What the operator knows."""
        return Setup._made("setup_from", self._handle, 0, ffi.NULL, ffi.NULL)

    @property
    def accelerometer(self) -> tuple[Array, Array]:
        """Times (n,), s, and accelerations (n, 3), body axes, m/s^2."""
        return self._numbers("accelerometer_time"), self._numbers("acceleration", -1, 3)

    @property
    def star_camera(self) -> tuple[Array, NDArray[np.int32], Array]:
        """Times (n,), s, heads (n,), quaternions (n, 4), inertial to camera, scalar last."""
        head = self._numbers("star_camera_head").astype(np.int32)
        return self._numbers("star_camera_time"), head, self._numbers("quaternion", -1, 4)

    @property
    def magnetometer(self) -> tuple[Array, Array]:
        """Times (n,), s, and flux densities (n, 3), body axes, T."""
        return self._numbers("magnetometer_time"), self._numbers("flux_density", -1, 3)

    @property
    def orbit(self) -> tuple[Array, Array]:
        """Times (n,), s, and positions (n, 3), inertial, m."""
        return self._numbers("orbit_time"), self._numbers("orbit_position", -1, 3)

    def fit(self, algorithm: str = "optimal") -> Fit:
        """An estimate with residuals, partials, covariances, tests and the running estimate."""
        return Fit(algorithm, self)

    def beliefs(self, algorithm: str = "optimal") -> Beliefs:
        """Estimates, and tells what the data say of rods, inertia, instruments and noise."""
        return self.fit(algorithm).beliefs()

    def estimate(self, algorithm: str = "optimal", options: Options | None = None) -> Solution:
        """The offset by one of `algorithms`, with the options of this set or those that are given."""
        return (self if options is None else self.with_options(options)).fit(algorithm).solution

    def estimate_chain(self, arc: float = 60.0, threads: int = 1) -> "Chain":
        """One offset of a long set, by "optimal" with the options of this set, in arcs of `arc` seconds at most."""
        found = Handle("estimate_chain", self._handle, arc, threads)
        return found._values(Chain, warnings=found._text("warnings").splitlines())


@dataclass(frozen=True)
class Joined:
    """One offset from several sets of observations, or from arcs of one.

    Attributes
    ----------
    offset, covariance : ndarray, (3,), (3, 3)
        At the time of the last, body axes, m; m^2.
    chi_square, degrees, probability : float, int, float
        Of all differences between them, degrees of freedom, probability that chance makes so much.
    consistent : bool
        They agree on one offset.
    """

    offset: Array = array(3)
    covariance: Array = array(3, 3)
    chi_square: float
    degrees: int
    probability: float
    consistent: bool


@dataclass(frozen=True)
class Chain(Joined):
    """One offset from the arcs of a long observation set.

    Attributes
    ----------
    arcs, joined : int
        How many there are, and how many are joined: the others tell no offset, or disagree.
    warnings : list of str
        Why arcs are left out, and what several arcs warn of.
    """

    arcs: int
    joined: int
    warnings: list[str]


@dataclass(frozen=True)
class Joint(Joined):
    """One offset from several observation sets.

    Attributes
    ----------
    difference, difference_sigma : ndarray, (n, 3)
        Each run alone minus all others, and its standard deviation if they agree, m.
    """

    difference: Array = array(-1, 3)
    difference_sigma: Array = array(-1, 3)


def estimate_joint(observations: Sequence[Observations]) -> Joint:
    """One offset from several observation sets, by "optimal" with the options of each."""
    handles = ffi.new("gracecg_object *[]", [one._handle for one in observations])
    return Handle("estimate_joint", len(observations), handles)._values(Joint)


class Simulator(Handle):
    """The true arc of a case and what its star cameras see: once, for any number of runs."""

    def __init__(self, case: "Case") -> None:
        super().__init__("simulator_open", case._handle)

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
        super().__init__("force_model_open", case._handle)

    def accelerations(self, seconds: ArrayLike, position: ArrayLike, velocity: ArrayLike,
                      quaternion: ArrayLike) -> dict[str, Array]:
        """Accelerations (n, 3), m/s^2, inertial axes: "gravity", "drag", "solar_radiation", "earth_radiation" and
        their sum "total", at positions (m), velocities (m/s) (n, 3), inertial, and attitudes (n, 4)."""
        where = numbers(position, 3)
        n = len(where)
        found = {name: np.empty((n, 3)) for name in
                 ("gravity", "drag", "solar_radiation", "earth_radiation", "total")}
        times = np.ascontiguousarray(np.broadcast_to(np.asarray(seconds, dtype=float), (n,)))
        speeds, attitudes = exactly(numbers(velocity, 3), n, 3), exactly(numbers(quaternion, 4), n, 4)
        call("force_model_evaluate", self._handle, n, pointer(times), pointer(where), pointer(speeds),
             pointer(attitudes), *(pointer(array) for array in found.values()))
        return found

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
        interval, else steps under control (1e-10, say; docs/theory.md, section 8), with interpolation."""
        states = np.empty((steps + 1, 13))
        call("force_model_propagate", self._handle, pointer(exactly(state, 13)), interval, steps, tolerance,
             pointer(states))
        return states

    def propagate_nadir(self, position: ArrayLike, velocity: ArrayLike, interval: float, steps: int,
                        tolerance: float = 0.0, forward: bool = True) -> Array:
        """States (steps + 1, 13) of a satellite whose z points to the centre of the Earth; x along the orbit or,
        not `forward`, against it. Position m, velocity m/s, inertial."""
        states = np.empty((steps + 1, 13))
        call("force_model_propagate_nadir", self._handle, pointer(exactly(position, 3)), pointer(exactly(velocity, 3)),
             int(forward), interval, steps, tolerance, pointer(states))
        return states


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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
                progress: Callable[[int, int], object] | None = None) -> MonteCarlo:
    """Simulates and estimates runs 1 to `runs`, as ``gracecg montecarlo`` does.

    Parameters
    ----------
    threads : int, optional
        As many as there are processors. The numbers do not depend on it.
    progress : callable, optional
        Called with the number of runs done and of all; when it gives False the work stops with KeyboardInterrupt.
    """
    simulator = case.simulator()

    def one(run: int) -> Solution:
        return simulator.observe(seed, run).estimate(algorithm)

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
