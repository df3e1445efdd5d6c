"""Level-1 data of GRACE and GRACE-FO."""
from __future__ import annotations

import os
import warnings
from dataclasses import dataclass

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import NOT_USABLE, Handle, array, exactly, ffi, numbers, pointer

Array = NDArray[np.float64]


class Level1(Handle):
    """The records of a Level-1 file in order of time, each epoch once.

    Parameters
    ----------
    path : str or path
        A file, text or binary, of any product that ``gracecg level1 list`` knows.
    span : (float, float), optional
        First and last time tag that are wanted, s past 2000-01-01 12:00:00 in the file's own time frame.

    Attributes
    ----------
    about : str
        Product, satellite and time frame, as "MAG1A C R".
    fields : list of str
    warnings : list of str
        What is unusual about the file.
    """

    def __init__(self, path: str | os.PathLike[str], span: tuple[float, float] | None = None) -> None:
        super().__init__("level1_open", os.fsencode(path), ffi.NULL if span is None else pointer(exactly(span, 2)))
        self.about = self._text("about")
        self.fields = self._text("fields").splitlines()
        self.warnings = self._text("warnings").splitlines()

    def __len__(self) -> int:
        return len(self._numbers("time_seconds"))

    def times(self) -> tuple[Array, Array]:
        """Time tags (n,): whole seconds past 2000-01-01 12:00:00, and the rest, 0 <= fraction < 1 s."""
        return self._numbers("time_seconds"), self._numbers("time_fraction")

    def __getitem__(self, field: str) -> Array:
        """The values (n,) of a field, in the units of the file; NaN where a record has none."""
        return self._numbers(field)

    def to_pandas(self):
        """A pandas.DataFrame with a column for each field, indexed by time (s past 2000-01-01 12:00:00)."""
        import pandas

        seconds, fraction = self.times()
        return pandas.DataFrame({name: self[name] for name in self.fields},
                                index=pandas.Index(seconds + fraction, name="time_s"))


@dataclass(frozen=True, eq=False)
class Level1Offset:
    """The offset of a calibration manoeuvre from Level-1 files, in the satellite's frame (SRF).

    Attributes
    ----------
    offset, covariance : ndarray, (3,), (3, 3)
        From the centre of mass to the proof mass, m, m^2: noise, leakage of the rods, and what is known of scales, gains
        and field.
    time : float
        Middle of the manoeuvre, GPS s past 2000-01-01 12:00:00.
    gain, gain_sigma : ndarray, (3,)
        Of the rods by the attitude, A m^2/mA.
    torque_delay, torque_delay_sigma, accelerometer_delay, accelerometer_delay_sigma : float
        Behind the tags, s; sigma 0: not estimated.
    condition : float
        Of the scaled normal matrix with leakage.
    residual_rms : ndarray, (3,)
        In the band of the estimate, of `optimal` at all frequencies, m/s^2.
    chi_square, degrees : float, int
        Of the spans about the offset, and its degrees of freedom; 0 with one span.
    spans, samples : int
        That are used.
    leakage : int
        0: left out, 1: by its a-priori sigma, 2: estimated.
    flag : int
        0: good, 1: to be used with care, 2: not to be used.
    text : str
        Why the flag is not 0, then what is wrong, a line each.
    """

    offset: Array = array(3)
    covariance: Array = array(3, 3)
    time: float
    gain: Array = array(3)
    gain_sigma: Array = array(3)
    torque_delay: float
    torque_delay_sigma: float
    accelerometer_delay: float
    accelerometer_delay_sigma: float
    condition: float
    residual_rms: Array = array(3)
    chi_square: float
    degrees: int
    spans: int
    samples: int
    leakage: int
    flag: int
    text: str


def estimate_level1(folder: str | os.PathLike[str], setup: str | os.PathLike[str], satellite: str | None = None,
                    spans: ArrayLike | None = None, day: str | None = None) -> Level1Offset:
    """Estimates the offset as ``gracecg level1 estimate`` does.

    Parameters
    ----------
    folder, setup : str or path
        Of the Level-1 files; namelist with mass_properties and level1.
    satellite : str, optional
        "A" to "D"; the only one, or the first, that has files.
    spans : array_like, (n, 2), optional
        Start (GPS s past 2000-01-01 12:00:00) and duration (s) of the sub-manoeuvres; those of the SOE file in the
        folder, or by the currents.
    day : str, optional
        The manoeuvre that this day, as "2020-02-01", has part of, with the days before and behind it; of all files.
    """
    def given(text: str | None) -> Any:
        return ffi.NULL if text is None else text.encode()

    pairs = numbers([] if spans is None else spans, 2)
    found = Handle("level1_estimate", os.fsencode(folder), os.fsencode(setup), given(satellite), given(day), len(pairs),
                   pointer(pairs), allowed=[NOT_USABLE])
    if found._number("flag") == 2:
        warnings.warn("do not use: " + found._text("text").splitlines()[0], stacklevel=2)
    return found._values(Level1Offset, text=found._text("text"))
