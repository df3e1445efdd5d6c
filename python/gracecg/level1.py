"""Level-1 data of GRACE and GRACE-FO."""
from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from ._library import Handle, call, exactly, ffi, pointer, text_from

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

    kind = "level1"

    def __init__(self, path: str | os.PathLike[str], span: tuple[float, float] | None = None) -> None:
        super().__init__("level1_read", os.fsencode(path),
                         ffi.NULL if span is None else pointer(exactly(span, 2)))
        counts = [ffi.new("size_t *") for _ in range(3)]
        call("level1_counts", self._handle, *counts)
        self._records = counts[0][0]
        self.about = text_from("level1_about", self._handle)
        self.fields = [text_from("level1_field", self._handle, i) for i in range(counts[1][0])]
        self.warnings = [text_from("level1_warning", self._handle, i) for i in range(counts[2][0])]

    def __len__(self) -> int:
        return self._records

    def times(self) -> tuple[Array, Array]:
        """Time tags (n,): whole seconds past 2000-01-01 12:00:00, and the rest, 0 <= fraction < 1 s."""
        seconds, fraction = np.empty(len(self)), np.empty(len(self))
        call("level1_times", self._handle, len(self), pointer(seconds), pointer(fraction))
        return seconds, fraction

    def __getitem__(self, field: str) -> Array:
        """The values (n,) of a field, in the units of the file; NaN where a record has none."""
        values = np.empty(len(self))
        call("level1_values", self._handle, field.encode(), len(self), pointer(values))
        return values

    def to_pandas(self):
        """A pandas.DataFrame with a column for each field, indexed by time (s past 2000-01-01 12:00:00)."""
        import pandas

        seconds, fraction = self.times()
        return pandas.DataFrame({name: self[name] for name in self.fields},
                                index=pandas.Index(seconds + fraction, name="time_s"))
