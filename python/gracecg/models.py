"""Models of the environment, one by one: time, gravity, field, air, wind, Sun, Earth's light.

For one position of shape (3,) the results have no n, either.
"""
from __future__ import annotations

import datetime
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import Handle, alike, call, exactly, ffi, numbers, pointer, spread, text, text_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Utc:
    """An instant of UTC, from 1900 to 2100.

    Attributes
    ----------
    mjd : int
        Modified Julian day number.
    seconds : float
        Of that day, s; in a day that ends with a leap second less than 86401.
    """

    mjd: int
    seconds: float

    @classmethod
    def of(cls, when: "Utc | str | datetime.datetime | np.datetime64") -> "Utc":
        """An instant from itself, an ISO 8601 text, or a datetime or datetime64 (without zone: UTC)."""
        if isinstance(when, Utc):
            return when
        if isinstance(when, datetime.datetime):
            if when.tzinfo is not None:
                when = when.astimezone(datetime.timezone.utc).replace(tzinfo=None)
            when = when.isoformat()
        elif isinstance(when, (datetime.date, np.datetime64)):
            seconds = np.datetime64(when).astype("datetime64[s]")
            when = str(seconds if seconds == when else when)
        utc = ffi.new("gracecg_utc *")
        call("utc_parse", text(when, "time"), utc)
        return cls(utc.mjd, utc.seconds)

    def _c(self):
        return ffi.new("gracecg_utc *", {"mjd": self.mjd, "seconds": self.seconds})

    def __str__(self) -> str:
        buffer = ffi.new("char[32]")
        call("utc_text", self._c(), buffer, len(buffer), ffi.NULL)
        return text_of(buffer)

    def plus(self, seconds: float) -> "Utc":
        """So many SI seconds later, leap seconds counted; seconds of GPS count from 1980-01-06."""
        later = ffi.new("gracecg_utc *")
        call("utc_plus", self._c(), seconds, later)
        return Utc(later.mjd, later.seconds)

    def since(self, other: "When") -> float:
        """SI seconds from another time to this one."""
        seconds = ffi.new("double *")
        call("utc_difference", Utc.of(other)._c(), self._c(), seconds)
        return seconds[0]

    def sidereal_angle(self, ut1_minus_utc: float = 0.0) -> float:
        """Greenwich mean sidereal time (IAU 1982), rad; UT1-UTC in s."""
        angle = ffi.new("double *")
        call("sidereal_angle", self._c(), ut1_minus_utc, angle)
        return angle[0]

    def earth_orientation(self, file: str | os.PathLike[str] | None = None, *, seconds: float = 0.0,
                          ut1_minus_utc: float = 0.0, pole: ArrayLike = (0.0, 0.0)) -> Array:
        """The rotation from inertial (GCRS) to Earth-fixed axes by IAU 2006/2000B.

        Parameters
        ----------
        file : str or path, optional
            Of the IERS, finals2000A or EOP C04: UT1 and pole, in place of the two arguments below.
        seconds : float
            After this time, at which the constants are computed; half a day at most.
        ut1_minus_utc : float
            s.
        pole : array_like, (2,)
            x and y, rad.

        Returns
        -------
        ndarray, (3, 3)
            To be multiplied by an inertial column.
        """
        xy, offset = exactly(pole, 2).copy(), ut1_minus_utc
        if file is not None:
            found = ffi.new("double *")
            call("earth_parameters", os.fsencode(file), self._c(), found, pointer(xy))
            offset = found[0]
        rotation = np.empty((3, 3))
        call("earth_orientation", self._c(), offset, pointer(xy), seconds, pointer(rotation))
        return rotation


When = "Utc | str | datetime.datetime | np.datetime64"


class Gravity(Handle):
    """The Earth's gravity.

    Parameters
    ----------
    name : str
        "egm96" (to degree 70), "point-mass" (degree and order 0), or the path of an ICGEM .gfc file.
    degree, order : int
        Up to which the harmonics are used.
    """

    def __init__(self, name: str = "egm96", degree: int = 20, order: int | None = None) -> None:
        super().__init__("gravity_open", os.fsencode(name), degree, degree if order is None else order)

    def evaluate(self, position: ArrayLike) -> tuple[Array, Array, Array]:
        """Acceleration, potential and second derivatives.

        Parameters
        ----------
        position : array_like, (n, 3)
            Earth-fixed, m.

        Returns
        -------
        acceleration : ndarray, (n, 3)
            Earth-fixed, without the centrifugal part, m/s^2.
        potential : ndarray, (n,)
            m^2/s^2.
        gradient : ndarray, (n, 3, 3)
            1/s^2.
        """
        where = numbers(position, 3)
        n = len(where)
        acceleration, potential, gradient = np.empty((n, 3)), np.empty(n), np.empty((n, 3, 3))
        call("gravity_evaluate", self._handle, n, pointer(where), pointer(acceleration), pointer(potential),
             pointer(gradient))
        return alike(position, acceleration, potential, gradient)

    def acceleration(self, position: ArrayLike) -> Array:
        """Acceleration (n, 3), m/s^2, at positions (n, 3), m, Earth-fixed: in a third of the time of evaluate."""
        where = numbers(position, 3)
        acceleration = np.empty_like(where)
        call("gravity_evaluate", self._handle, len(where), pointer(where), pointer(acceleration), pointer(None),
             pointer(None))
        return alike(position, acceleration)[0]


class Field(Handle):
    """The geomagnetic field at a date.

    Parameters
    ----------
    name : str
        "igrf95" (1985 to 2000), "igrf14" (1900 to 2030, extrapolated to 2040), or the path of an SHC file.
    date : Utc, str or datetime
    """

    def __init__(self, name: str, date: When) -> None:
        super().__init__("field_open", os.fsencode(name), Utc.of(date)._c())

    def evaluate(self, position: ArrayLike) -> Array:
        """Flux density (n, 3), T, Earth-fixed, at positions (n, 3), m, Earth-fixed."""
        where = numbers(position, 3)
        flux = np.empty_like(where)
        call("field_evaluate", self._handle, len(where), pointer(where), pointer(flux))
        return alike(position, flux)[0]


@dataclass(frozen=True, eq=False)
class Air:
    """The thermosphere at n points.

    Attributes
    ----------
    density : ndarray, (n,)
        kg/m^3.
    temperature : ndarray, (n,)
        K.
    number_density : ndarray, (n, 3)
        Of He, O and N2, 1/m^3.
    """

    density: Array
    temperature: Array
    number_density: Array


class Density(Handle):
    """A thermosphere with the solar activity of a date, or with given indices.

    Parameters
    ----------
    name : str
        "dtm77", "dtm78", "dtm94" or "exponential".
    date : Utc, str or datetime, optional
        Takes F10.7 and Kp from the embedded table.
    f107, f107_mean : float, optional
        F10.7 of the day before and its mean of 81 days, sfu; in place of a date.
    kp : float, optional
        Kp three hours before, 0 to 9; 2 when it is left out.
    """

    def __init__(self, name: str = "dtm77", date: When | None = None, *, f107: float | None = None,
                 f107_mean: float | None = None, kp: float | None = None) -> None:
        if date is not None and (f107 is not None or f107_mean is not None or kp is not None):
            raise ValueError("a date takes F10.7 and Kp from the table: give it, or f107, f107_mean and kp, not both")
        if date is not None:
            super().__init__("density_open", text(name, "name"), Utc.of(date)._c(), ffi.NULL)
        elif f107 is not None:
            indices = exactly([f107, f107 if f107_mean is None else f107_mean, 2.0 if kp is None else kp], 3)
            super().__init__("density_open", text(name, "name"), ffi.NULL, pointer(indices))
        else:
            raise ValueError("give a date, or f107 (with f107_mean and kp)")

    def evaluate(self, epoch: When, position: ArrayLike, seconds: ArrayLike = 0.0) -> Air:
        """The air at Earth-fixed positions (n, 3), m, `seconds` (one or n) after the epoch."""
        where = numbers(position, 3)
        n = len(where)
        found = np.empty(n), np.empty(n), np.empty((n, 3))
        call("density_evaluate", self._handle, Utc.of(epoch)._c(), n, pointer(spread(seconds, n)), pointer(where),
             *map(pointer, found))
        return Air(*alike(position, *found))


class Wind(Handle):
    """Wind of the thermosphere: "hwm93" (the embedded table) or the path of a table."""

    def __init__(self, name: str = "hwm93") -> None:
        super().__init__("wind_open", os.fsencode(name))

    def evaluate(self, epoch: When, position: ArrayLike, seconds: ArrayLike = 0.0) -> Array:
        """Eastward and northward wind (n, 2), m/s, relative to the turning Earth, at Earth-fixed positions, m."""
        where = numbers(position, 3)
        wind = np.empty((len(where), 2))
        call("wind_evaluate", self._handle, Utc.of(epoch)._c(), len(where), pointer(spread(seconds, len(where))),
             pointer(where), pointer(wind))
        return alike(position, wind)[0]


def sun_position(epoch: When, seconds: ArrayLike = 0.0) -> Array:
    """The Sun (n, 3), m, inertial, from the Earth's centre, `seconds` (n,) after the epoch; (3,) at one time."""
    times = np.atleast_1d(np.ascontiguousarray(seconds, dtype=np.float64))
    position = np.empty((len(times), 3))
    call("sun_position", Utc.of(epoch)._c(), len(times), pointer(times), pointer(position))
    return position if np.ndim(seconds) else position[0]


def sun_illumination(position: ArrayLike, sun: ArrayLike) -> Array:
    """The part (n,) of the Sun's disc, 0 to 1, that the Earth leaves free; both (n, 3), m, in the same axes."""
    where, light = numbers(position, 3), numbers(sun, 3)
    light = np.ascontiguousarray(np.broadcast_to(light, where.shape))
    free = np.empty(len(where))
    call("sun_illumination", len(where), pointer(where), pointer(light), pointer(free))
    return alike(position, free)[0]


class EarthRadiation(Handle):
    """The Earth's light and heat (Knocke's model).

    Parameters
    ----------
    constants : str
        "report", "knocke" or "constant-emissivity".
    rings : int
        Of segments around the cap, 0 to 7.
    solar_irradiance : float
        At 1 au, W/m^2.
    """

    def __init__(self, constants: str = "knocke", rings: int = 2, solar_irradiance: float = 1367.0) -> None:
        super().__init__("earth_radiation_open", text(constants, "constants"), rings, solar_irradiance)

    def flux(self, epoch: When, position: ArrayLike, seconds: ArrayLike = 0.0) -> Array:
        """Net flux (n, 3), W/m^2, inertial, away from the Earth, at inertial positions (n, 3), m."""
        where = numbers(position, 3)
        flux = np.empty_like(where)
        call("earth_radiation_evaluate", self._handle, Utc.of(epoch)._c(), len(where),
             pointer(spread(seconds, len(where))), pointer(where), pointer(flux))
        return alike(position, flux)[0]
