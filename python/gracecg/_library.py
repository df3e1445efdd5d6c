"""The shared libraries, called as their own headers declare them: no signature stands here a second time."""
from __future__ import annotations

import pathlib
import re
import weakref
from typing import Any, Sequence

import cffi
import numpy as np
from numpy.typing import ArrayLike, NDArray

FOLDER = pathlib.Path(__file__).resolve().parent
NOT_CONVERGED = 6       # gracecg_status


class GracecgError(Exception):
    """What went wrong, in the library's words.

    Attributes
    ----------
    status : int
        The number of the failure, a ``gracecg_status`` of gracecg.h.
    """

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


def _declarations() -> str:
    """The headers without what only a compiler wants: conditions, includes, the block for C++."""
    text = "".join((FOLDER / "include" / name).read_text(encoding="utf-8") for name in ("gracecg.h", "gracecg_level1.h"))
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    text = re.sub(r'^#ifdef __cplusplus\n.*?^#endif\n', "", text, flags=re.S | re.M)
    return re.sub(r"^#(?!define \w+ \d+$).*$", "", text, flags=re.M)


def _path() -> str:
    """The library for Level-1 data; that which it is linked with, libgracecg.so, stands beside it and is loaded with it."""
    found = sorted(FOLDER.glob("lib*/**/libgracecg_level1.so*"))
    if not found:
        raise ImportError(f"libgracecg_level1.so is not below {FOLDER}: is the package installed?")
    return str(found[0])


ffi: Any = cffi.FFI()
ffi.cdef(_declarations())
lib: Any = ffi.dlopen(_path())


def text_of(pointer: Any) -> str:
    """A text that ends with a zero."""
    return ffi.string(pointer).decode("utf-8", errors="replace")


def call(name: str, *arguments: Any, allowed: Sequence[int] = ()) -> int:
    """Calls gracecg_NAME with these arguments and an error; raises GracecgError, but for allowed statuses.

    Other threads of Python run meanwhile.
    """
    error = ffi.new("gracecg_error *")
    status = int(getattr(lib, "gracecg_" + name)(*arguments, error))
    if status != 0 and status not in allowed:
        raise GracecgError(status, text_of(error.message))
    return status


def numbers(values: ArrayLike, *shape: int) -> NDArray[np.float64]:
    """A contiguous array of finite or other numbers, (n, *shape); one row without n becomes n = 1."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.size == 0:
        array = array.reshape((0, *shape))
    if array.ndim == len(shape):
        array = array[np.newaxis]
    if array.ndim != len(shape) + 1 or array.shape[1:] != shape:
        raise ValueError(f"an array of shape (n, {', '.join(map(str, shape))}) is expected, not {np.shape(values)}"
                         if shape else f"an array of shape (n,) is expected, not {np.shape(values)}")
    return array


def exactly(values: ArrayLike, *shape: int) -> NDArray[np.float64]:
    """A contiguous array of one shape."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"an array of shape {shape} is expected, not {array.shape}")
    return array


def pointer(array: NDArray[Any] | None) -> Any:
    """The address of an array's first number; NULL of None."""
    if array is None:
        return ffi.NULL
    kind = {"float64": "double[]", "int32": "int32_t[]"}[array.dtype.name]
    return ffi.from_buffer(kind, array)


def spread(seconds: ArrayLike, n: int) -> NDArray[np.float64]:
    """Times (n,) of one time or n."""
    return np.ascontiguousarray(np.broadcast_to(np.asarray(seconds, dtype=np.float64), (n,)))


def text_from(name: str, *arguments: Any) -> str:
    """The text that a function writes into a buffer, whose length it tells first."""
    length = ffi.new("size_t *")
    call(name, *arguments, ffi.NULL, 0, length)
    buffer = ffi.new("char[]", length[0] + 1)
    call(name, *arguments, buffer, length[0] + 1, ffi.NULL)
    return text_of(buffer)


def value_of(field: Any) -> Any:
    """A component of a structure: a number, a text, or an array (of arrays)."""
    if isinstance(field, (int, float)):
        return field
    kind = ffi.typeof(field)
    if kind.kind == "array" and kind.item.cname == "char":
        return text_of(field)
    if kind.kind == "array" and kind.item.kind == "array" and kind.item.item.cname == "char":
        return [text_of(item) for item in field]
    return np.array([value_of(item) for item in field])


def components(structure: Any) -> dict[str, Any]:
    """The components of a structure by name."""
    return {name: value_of(getattr(structure, name)) for name, _ in ffi.typeof(structure[0]).fields}


def _free(kind: str, address: Any) -> None:
    getattr(lib, f"gracecg_{kind}_free")(address, ffi.NULL)


class Handle:
    """An object of the library, given back when Python forgets it."""

    kind = ""

    def __init__(self, maker: str, *arguments: Any) -> None:
        address = ffi.new(f"gracecg_{self.kind} **")
        call(maker, *arguments, address)
        self._keep(address)

    def _keep(self, address: Any) -> None:
        self._address = address
        weakref.finalize(self, _free, self.kind, address)

    @classmethod
    def _of(cls, address: Any) -> Any:
        """An object of a handle that a function has made."""
        new = cls.__new__(cls)
        new._keep(address)
        return new

    @property
    def _handle(self) -> Any:
        return self._address[0]
