"""The C interface of gracecg from Python: ctypes, and nothing but the standard library.

A small wrapper, to be copied and extended: what include/gracecg.h declares becomes a method, a failure
an exception. Arrays are sequences of floats; numpy's work too, but are not needed.
"""
import ctypes
import ctypes.util
from ctypes import POINTER, byref, c_char, c_char_p, c_double, c_int32, c_size_t, c_void_p


class GracecgError(Exception):
    """What went wrong, in the library's words; `status` is its number."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


class _Error(ctypes.Structure):
    _fields_ = [("status", c_int32), ("message", c_char * 1020)]


class Utc(ctypes.Structure):
    """An instant: modified Julian day number and seconds of the day, UTC."""

    _fields_ = [("mjd", c_int32), ("seconds", c_double)]


class Library:
    """The shared library; `path` where the loader does not find it by itself."""

    def __init__(self, path=None):
        self._dll = ctypes.CDLL(path or ctypes.util.find_library("gracecg") or "libgracecg.so.0")
        self._dll.gracecg_version.restype = c_char_p

    @property
    def version(self):
        return self._dll.gracecg_version().decode()

    def call(self, name, *arguments):
        """Calls gracecg_NAME with these arguments and an error structure, and raises what it reports."""
        error = _Error()
        function = getattr(self._dll, "gracecg_" + name)
        function.restype = c_int32
        if function(*arguments, byref(error)) != 0:
            raise GracecgError(error.status, error.message.decode(errors="replace"))

    def utc(self, text):
        """The instant of an ISO 8601 text."""
        utc = Utc()
        self.call("utc_parse", text.encode(), byref(utc))
        return utc


class Handle:
    """An object of the library, given back when Python forgets it."""

    def __init__(self, library, maker, *arguments):
        self.library = library
        self.pointer = c_void_p()
        library.call(maker, *arguments, byref(self.pointer))

    def __del__(self):
        if getattr(self, "pointer", None):
            self.library.call("free", byref(self.pointer))

    def numbers(self, item):
        """The numbers of an item, as gracecg.h lists them."""
        count = c_size_t()
        self.library.call("get", self.pointer, item.encode(), c_size_t(0), None, byref(count))
        values = (c_double * count.value)()
        self.library.call("get", self.pointer, item.encode(), count, values, None)
        return list(values)

    def text(self, item):
        """A text by the name of its item."""
        length = c_size_t()
        self.library.call("get_text", self.pointer, item.encode(), None, c_size_t(0), byref(length))
        text = ctypes.create_string_buffer(length.value + 1)
        self.library.call("get_text", self.pointer, item.encode(), text, c_size_t(len(text)), None)
        return text.value.decode(errors="replace")


class Gravity(Handle):
    """A gravity field: "egm96", "point-mass" or the path of a .gfc file."""

    def __init__(self, library, name, degree, order):
        super().__init__(library, "gravity_open", name.encode(), c_int32(degree), c_int32(order))

    def acceleration(self, position):
        """m/s^2 at a position in m, both Earth-fixed."""
        result = (c_double * 3)()
        self.library.call("gravity_evaluate", self.pointer, c_size_t(1), (c_double * 3)(*position), result,
                          None, None)
        return tuple(result)


class Case(Handle):
    """A calibration case: a built-in one by name, or a case file by path."""

    def __init__(self, library, name_or_file):
        super().__init__(library, "case_open", name_or_file.encode())


class Simulator(Handle):
    """The true arc of a case."""

    def __init__(self, case):
        super().__init__(case.library, "simulator_open", case.pointer)

    def observe(self, seed=1, run=1):
        """An observation set with the noise of a seed and run."""
        return Observations(self.library, "simulate", self.pointer, c_int32(seed), c_int32(run))


class Observations(Handle):
    """The samples of one calibration, and what an operator knows."""

    @classmethod
    def read(cls, library, folder):
        """Those of a folder that `gracecg simulate` has written."""
        return cls(library, "observations_open", str(folder).encode())

    def estimate(self, algorithm):
        """An estimate, whose items are "offset", "sigma", "warnings" ..."""
        return Handle(self.library, "estimate", algorithm.encode(), self.pointer)
