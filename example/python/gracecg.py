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


class Solution(ctypes.Structure):
    """The result of an estimator: lengths in m, body axes; see gracecg.h."""

    _fields_ = [("offset", c_double * 3), ("sigma", c_double * 3), ("covariance", c_double * 9),
                ("drift", c_double * 3), ("bias", c_double * 3), ("quaternion", c_double * 4),
                ("angular_velocity", c_double * 3), ("residual_rms", c_double * 3),
                ("condition", c_double), ("variance_factor", c_double), ("noise_level", c_double * 3),
                ("noise_corner", c_double * 3), ("star_camera_sigma", c_double * 3),
                ("parameter_value", c_double * 16), ("parameter_sigma", c_double * 16),
                ("parameter_name", (ctypes.c_char * 16) * 16), ("parameter_count", c_int32),
                ("edited", c_int32 * 2), ("iterations", c_int32), ("converged", c_int32),
                ("warning_count", c_int32)]


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
    """An object of the library, given back when Python forgets it. A subclass names its `kind`."""

    kind = ""

    def __init__(self, library, maker, *arguments):
        self.library = library
        self.pointer = c_void_p()
        library.call(maker, *arguments, byref(self.pointer))

    def __del__(self):
        if getattr(self, "pointer", None):
            self.library.call(self.kind + "_free", byref(self.pointer))


class Gravity(Handle):
    """A gravity field: "egm96", "point-mass" or the path of a .gfc file."""

    kind = "gravity"

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

    kind = "case"

    def __init__(self, library, name_or_file):
        super().__init__(library, "case_open", name_or_file.encode())


class Simulator(Handle):
    """The true arc of a case."""

    kind = "simulator"

    def __init__(self, case):
        super().__init__(case.library, "simulator_open", case.pointer)

    def observe(self, seed=1, run=1):
        """An observation set with the noise of a seed and run."""
        return Observations(self.library, "observations_simulate", self.pointer, c_int32(seed),
                            c_int32(run))


class Observations(Handle):
    """The samples of one calibration, and what an operator knows."""

    kind = "observations"

    @classmethod
    def read(cls, library, folder):
        """Those of a folder that `gracecg simulate` has written."""
        return cls(library, "observations_read", str(folder).encode())

    def estimate(self, algorithm):
        """A Solution and the list of its warnings."""
        solution = Solution()
        warnings = ctypes.create_string_buffer(4000)
        self.library.call("estimate", algorithm.encode(), self.pointer, byref(solution), warnings,
                          c_size_t(len(warnings)))
        return solution, warnings.value.decode(errors="replace").splitlines()
