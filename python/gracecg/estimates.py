"""Setups, observation sets, estimates and what they tell of themselves."""
from __future__ import annotations

import itertools
import os
import pathlib
import tempfile
import warnings
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import (NOT_CONVERGED, NOT_USABLE, Handle, array, call, exactly, ffi, lib, named, numbers, pointer, text,
                       text_of)

Array = NDArray[np.float64]
DO_NOT_USE = 4          # action_kind
Options = "str | Mapping[str, Mapping[str, Any]]"


def _names(of: str) -> list[str]:
    pointers = (lib.gracecg_name(of.encode(), i) for i in itertools.count())
    return [text_of(name) for name in itertools.takewhile(lambda name: name != ffi.NULL, pointers)]


def algorithms() -> list[str]:
    """The estimators by name."""
    return _names("algorithm")


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
    for group, keys in (options or {"estimation": {}}).items():
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

    def _with(self, options: Options | None):
        return self if options is None else self.with_options(options)


@dataclass(frozen=True, eq=False)
class Solution:
    """The result of an estimator.

    Attributes
    ----------
    action : Action
        What to do: whether the offset is to be used. It comes first; `converged` says only that there are numbers.
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

    action: "Action"
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


@dataclass(frozen=True, eq=False)
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
        super().__init__("estimate", text(algorithm, "algorithm"), Observations._of(observations),
                         allowed=[NOT_CONVERGED, NOT_USABLE])

    def __repr__(self) -> str:
        found = self.solution
        return f"<Fit: {found.action.text}; offset {found.offset} m, sigma {found.sigma} m>"

    def _told(self) -> "Fit":
        """Itself, with a warning to the caller's caller where it is not to be used."""
        if (action := self.action()).kind == DO_NOT_USE:
            warnings.warn(action.text, stacklevel=3)
        return self

    @property
    def solution(self) -> Solution:
        """The result."""
        found = zip(self._numbers("parameter_value").tolist(), self._numbers("parameter_sigma").tolist())
        return self._values(Solution, action=self.action(), parameters=dict(zip(self._text("parameter_names").splitlines(), found)),
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

    def action(self) -> "Action":
        """What to do after this calibration, and why."""
        return _action_of(self)

    def running(self) -> dict[str, Array]:
        """The offset as "sequential" had it on the way: "time" (n,), s; "offset", "sigma" (n, 3), m."""
        return {"time": self._numbers("running_time"), "offset": self._numbers("running_offset", -1, 3),
                "sigma": self._numbers("running_sigma", -1, 3)}

    def beliefs(self) -> "Beliefs":
        """What the data say of rods, inertia, instruments and noise."""
        return self._values(Beliefs, contradictions=self._text("contradictions"), untestable=self._text("untestable"))


@dataclass(frozen=True, eq=False)
class Action:
    """What to do after a calibration.

    Attributes
    ----------
    kind : int
        1 trim, 2 leave, 3 calibrate again, 4 do not use, 5 not tested: the options leave the tests out.
    sigma : ndarray, (3,)
        That it rests on, m: that of the solution, what belongs to stated errors, and to other torques than the rods'.
    trim, again : ndarray, (3,)
        1: the centre of mass is to be moved by d along this axis; 1: this axis takes another calibration.
    text : str
        All in a line, with the reason.
    """

    kind: int = named("action_kind")
    sigma: Array = array(3, item="action_sigma")
    trim: Array = array(3, item="action_trim")
    again: Array = array(3, item="action_again")
    text: str


@dataclass(frozen=True, eq=False)
class Beliefs:
    """What the data say of what the setup states.

    Attributes
    ----------
    undetected : ndarray, (3,)
        What a single wrong belief could move each component of the offset by, unseen, m.
    undetected_as_stated : ndarray, (3,)
        The same if what the setup states holds within three times its sigmas: what the action rests on.
    apart : ndarray, (3,)
        Part of both that is the difference from the estimate of "optimal", m.
    tested, contradicted, untested : int
        How many; untested: too weakly, they could move a component farther than is wanted.
    sign_known : bool
        The setup says that the sign of the accelerometer is confirmed.
    contradictions, untestable : str
        In words, with what would explain them; empty where there is none.
    """

    undetected: Array = array(3, item="belief_undetected")
    undetected_as_stated: Array = array(3, item="belief_undetected_as_stated")
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

    _measured = False

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__("setup_open", os.fsencode(path))

    @classmethod
    def parse(cls, text: str) -> "Setup":
        """From the text of a setup.nml."""
        return cls._made("setup_open", _settings(text))

    def __reduce__(self) -> Any:
        if self._measured:
            raise TypeError("a setup with measured moments cannot be pickled; pickle the observations, or setup and moments")
        return Setup.parse, (self.text,)

    @property
    def text(self) -> str:
        """The text of setup.nml, followed by the options."""
        return self._text("text")

    def measured(self, time: ArrayLike, moment: ArrayLike) -> "Setup":
        """The same with measured moments of the rods: times (n,), s from the epoch; moments (n, 3), A m^2."""
        times, moments = numbers(time), numbers(moment, 3)
        new = self._made("setup_from", self._handle, len(times), pointer(times), pointer(exactly(moments, len(times), 3)))
        new._measured = True
        return new


def _observations_of(files: dict[str, bytes]) -> "Observations":
    """Of the contents of the files of a folder."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            (pathlib.Path(folder) / name).write_bytes(content)
        made = Observations(folder)
        made._again = None      # that folder is gone
        return made


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
        """From arrays in memory, which are copied and checked; times (n,) in s from the setup's epoch, rising, those of
        the accelerometer multiples of its interval (within 1 %). Further accelerometers and angular channels come from files.

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
        for name, given, parts in (("accelerometer", accelerometer, "times, accelerations"),
                                   ("star_camera", star_camera, "times, heads, quaternions"),
                                   ("magnetometer", magnetometer, "times, flux densities"), ("orbit", orbit, "times, positions")):
            if len(given) != len(parts.split(",")):
                raise ValueError(f"{name}: expected {parts}, not {len(given)} arrays")
        heads = np.ascontiguousarray(star_camera[1], dtype=np.int32)
        if not np.array_equal(heads, star_camera[1]):
            raise ValueError("star_camera: its second array has the numbers of the heads, integers")
        series = ((numbers(accelerometer[0]), numbers(accelerometer[1], 3)),
                  (numbers(star_camera[0]), heads, numbers(star_camera[2], 4)),
                  (numbers(magnetometer[0]), numbers(magnetometer[1], 3)), (numbers(orbit[0]), numbers(orbit[1], 3)))
        arguments: list[Any] = []
        for arrays in series:
            n = len(arrays[0])
            if any(len(array) != n for array in arrays):
                raise ValueError(f"arrays of {', '.join(str(len(array)) for array in arrays)} rows")
            arguments += [n, *(pointer(array) for array in arrays)]
        return cls._made("observations_create", Setup._of(setup), *arguments)

    def __reduce__(self) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            self.write(folder)
            return _observations_of, ({file.name: file.read_bytes() for file in pathlib.Path(folder).iterdir()},)

    def __repr__(self) -> str:
        counts = self._numbers("counts").astype(int).tolist()
        return "<Observations: {} samples of the accelerometer, {} of the star camera, {} of the magnetometer, {} positions>".format(
            *counts)

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

    def fit(self, algorithm: str = "optimal", options: Options | None = None) -> Fit:
        """An estimate by one of `algorithms` with residuals, partials, covariances, tests and the running estimate.

        As everywhere, `options` take the place of those of this set for the call. What is not to be used is there for an
        examination; a Python warning says so.
        """
        return Fit(algorithm, self._with(options))._told()

    def beliefs(self, algorithm: str = "optimal", options: Options | None = None) -> Beliefs:
        """Estimates, and tells what the data say of rods, inertia, instruments and noise."""
        return Fit(algorithm, self._with(options)).beliefs()

    def estimate(self, algorithm: str = "optimal", options: Options | None = None) -> Solution:
        """The result alone of `fit`."""
        return Fit(algorithm, self._with(options))._told().solution

    def estimate_chain(self, arc: float = 60.0, threads: int = 1, options: Options | None = None) -> "Chain":
        """One offset of a long set, by "optimal", in arcs of `arc` seconds at most."""
        chosen = self._with(options)
        found = Handle("estimate_chain", chosen._handle, arc, threads)
        return found._values(Chain, action=_action_of(found), warnings=found._text("warnings").splitlines())


@dataclass(frozen=True, eq=False)
class Joined:
    """One offset from several sets of observations, or from arcs of one.

    Attributes
    ----------
    action : Action
        What to do. Arcs are not tested.
    offset, covariance : ndarray, (3,), (3, 3)
        At the time of the last, body axes, m; m^2.
    chi_square, degrees, probability : float, int, float
        Of all differences between them, degrees of freedom, probability that chance makes so much.
    consistent : bool
        They agree on one offset.
    """

    action: Action
    offset: Array = array(3)
    covariance: Array = array(3, 3)
    chi_square: float
    degrees: int
    probability: float
    consistent: bool


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
class Joint(Joined):
    """One offset from several observation sets.

    Attributes
    ----------
    difference, difference_sigma : ndarray, (n, 3)
        Each run alone minus all others, and its standard deviation if they agree, m.
    """

    difference: Array = array(-1, 3)
    difference_sigma: Array = array(-1, 3)


@dataclass(frozen=True, eq=False)
class LiveOffset:
    """What a live estimate knows.

    Attributes
    ----------
    offset, sigma, covariance : ndarray, (3,), (3,), (3, 3)
        Body axes, m; m^2. A sigma of 1 m: nothing is known.
    variance_factor : float
        Of the innovations in units of what is expected: near 1.
    time : float
        Of the last sample, s.
    counts : ndarray, (2,)
        Samples that were added, and left out (those of each axis by themselves).
    wave : ndarray, (3,)
        Of the density wave: frequency, Hz, amplitudes of sine and cosine of 2 pi f t, m/s^2.
    """

    offset: Array = array(3)
    sigma: Array = array(3)
    covariance: Array = array(3, 3)
    variance_factor: float
    time: float
    counts: Array = array(2)
    wave: Array = array(3)


class LiveEstimate(Handle):
    """The estimate while a manoeuvre goes on, fed sample by sample, in memory that does not grow: of one thread at a time.

    Parameters
    ----------
    setup : Setup
        Of its rods what they bear (ten times that is refused); samples have their moments.
    quaternion, angular_velocity : (4,), (3,)
        A guess of the attitude at the first sample, inertial to body, scalar last, and of the rotation, body axes, rad/s.
    wave_frequency : float
        Of a density wave, known to 1 % (standard deviation), Hz; 0: none.
    """

    def __init__(self, setup: Setup, quaternion: ArrayLike, angular_velocity: ArrayLike, wave_frequency: float = 0.0) -> None:
        super().__init__("live_begin", Setup._of(setup), pointer(exactly(quaternion, 4)), pointer(exactly(angular_velocity, 3)),
                         wave_frequency)
        self._again = None      # what has been added is not known

    def __repr__(self) -> str:
        known = self.now()
        return f"<LiveEstimate: offset {known.offset} m, sigma {known.sigma} m after {known.time:g} s>"

    def add(self, time: float, moment: ArrayLike, acceleration: ArrayLike | None = None, flux_density: ArrayLike | None = None,
            position: ArrayLike | None = None, star_camera: Sequence[tuple[float, int, ArrayLike]] = ()) -> None:
        """What has come in a sampling interval of the accelerometer; every interval is added.

        Parameters
        ----------
        time : float
            Of its end, s. The first call takes what came at its end alone.
        moment : (3, 3)
            Of the rods at its beginning, middle and end, body axes, A m^2.
        acceleration, flux_density, position : (3,), optional
            Body axes, m/s^2; body axes, T; inertial, m. The first call needs a flux density, and within 30 s of a call
            there must be one.
        star_camera : sequence of (time, head, quaternion)
            Of each head one at most; quaternion (4,), inertial to camera, scalar last.
        """
        arguments: list[Any] = []
        for sample in (acceleration, flux_density, position):
            row = None if sample is None else exactly(sample, 3)
            arguments += [int(row is not None), pointer(row)]
        times, heads, quaternions = (list(column) for column in zip(*star_camera)) if star_camera else ([], [], [])
        call("live_add", self._handle, time, pointer(exactly(moment, 3, 3)), *arguments, len(times), pointer(numbers(times)),
             pointer(np.asarray(heads, dtype=np.int32)), pointer(numbers(quaternions, 4)))

    def now(self) -> LiveOffset:
        """The offset with everything that has been added."""
        return self._values(LiveOffset)


def estimate_joint(observations: Sequence[Observations], options: Options | None = None) -> Joint:
    """One offset from several observation sets, by "optimal" with the options of each, or those that are given."""
    sets = [one if options is None else one.with_options(options) for one in observations]
    handles = ffi.new("gracecg_object *[]", [Observations._of(one) for one in sets])
    found = Handle("estimate_joint", len(handles), handles, allowed=[NOT_USABLE])
    if (action := _action_of(found)).kind == DO_NOT_USE:
        warnings.warn(action.text, stacklevel=2)
    return found._values(Joint, action=action)


def _action_of(estimate: Handle) -> Action:
    return estimate._values(Action, text=estimate._text("action"))
