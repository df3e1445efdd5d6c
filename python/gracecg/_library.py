"""The shared libraries, called as their own headers declare them: no signature stands here a second time. The headers are
made by tools/interface.py."""
from __future__ import annotations

import ctypes
import math
import pathlib
import re
import weakref
from dataclasses import field, fields
from typing import Any, Sequence

import cffi
import numpy as np
from numpy.typing import ArrayLike, NDArray

FOLDER = pathlib.Path(__file__).resolve().parent
BAD_VALUE, NOT_CONVERGED, NOT_USABLE = 4, 6, 8      # gracecg_status


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

    def __reduce__(self) -> Any:
        return GracecgError, (self.status, str(self))


def _declarations() -> str:
    """The headers without what only a compiler wants: conditions, includes, the block for C++."""
    if not (FOLDER / "include").is_dir():
        raise ImportError("these are the sources of gracecg, without its library: pip install . in the folder above python, "
                          "and import it from another folder")
    text = "".join((FOLDER / "include" / name).read_text(encoding="utf-8") for name in ("gracecg.h", "gracecg_level1.h"))
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    text = re.sub(r'^#ifdef __cplusplus\n.*?^#endif\n', "", text, flags=re.S | re.M)
    return re.sub(r"^#(?!define \w+ \d+$).*$", "", text, flags=re.M)


def _load() -> Any:
    """The library for Level-1 data. That which it is linked with, libgracecg.so, stands beside it and is loaded first: by itself
    the loader would take another one of LD_LIBRARY_PATH. A package of a distribution has both where the loader finds them."""
    inside = sorted(FOLDER.glob("lib*/**/libgracecg_level1.*"))
    path = str(inside[0]) if inside else "libgracecg_level1.so.0"
    for own in (None, *FOLDER.glob("libgomp/*")):       # of a wheel, for a system that has no OpenMP
        try:
            for first in (own, *sorted(FOLDER.glob("lib*/**/libgracecg.*"))):
                if first is not None:
                    ctypes.CDLL(str(first))
            return ffi.dlopen(path)
        except OSError as failure:
            reason = failure
    raise ImportError(f"{path}, of gracecg: {reason}; is the package installed?")


ffi: Any = cffi.FFI()
ffi.cdef(_declarations())
lib: Any = _load()


def text_of(pointer: Any) -> str:
    """A text that ends with a zero."""
    return ffi.string(pointer).decode("utf-8", errors="replace")


def text(given: Any, what: str) -> bytes:
    """A text for the library, of what it says."""
    if not isinstance(given, str):
        raise TypeError(f"{what}: a text is expected, not {given!r}")
    return given.encode()


def call(name: str, *arguments: Any, allowed: Sequence[int] = ()) -> int:
    """Calls gracecg_NAME with these arguments and an error; raises GracecgError, but for allowed statuses.

    Other threads of Python run meanwhile.
    """
    if any(isinstance(one, bytes) and b"\0" in one for one in arguments):
        raise GracecgError(BAD_VALUE, "a text contains the character NUL")
    error = ffi.new("gracecg_error *")
    status = int(getattr(lib, "gracecg_" + name)(*arguments, error))
    if status != 0 and status not in allowed:
        raise GracecgError(status, text_of(error.message))
    return status


def plain(values: ArrayLike) -> NDArray[np.float64]:
    """Contiguous numbers; masked ones are refused, for what is below a mask is not meant."""
    if np.ma.is_masked(values):
        raise ValueError("masked values: leave these samples out, or fill them")
    return np.ascontiguousarray(values, dtype=np.float64)


def numbers(values: ArrayLike, *shape: int) -> NDArray[np.float64]:
    """A contiguous array of finite or other numbers, (n, *shape); one row without n becomes n = 1."""
    array = plain(values)
    if array.size == 0:
        array = array.reshape((0, *shape))
    if array.ndim == len(shape):
        array = array[np.newaxis]
    if array.ndim != len(shape) + 1 or array.shape[1:] != shape:
        raise ValueError(f"an array of shape (n, {', '.join(map(str, shape))}) is expected, not {np.shape(values)}"
                         if shape else f"an array of shape (n,) is expected, not {np.shape(values)}")
    return array


def alike(given: ArrayLike, *found: NDArray[np.float64]) -> tuple[Any, ...]:
    """What was found of n rows; without n where one row without n was given."""
    return tuple(one[0] for one in found) if np.ndim(given) == 1 and np.size(given) else found


def exactly(values: ArrayLike, *shape: int) -> NDArray[np.float64]:
    """A contiguous array of one shape."""
    array = plain(values)
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
    return np.ascontiguousarray(np.broadcast_to(plain(seconds), (n,)))


def _free(address: Any) -> None:
    lib.gracecg_free(address, ffi.NULL)


def _make_again(kind: Any, arguments: Any, options: Any) -> Any:
    return kind(*arguments, **options)


class Handle:
    """An object of the library, given back when Python forgets it."""

    def __new__(cls, *arguments: Any, **options: Any) -> Any:
        new = super().__new__(cls)
        new._again = (arguments, options)       # that make it again; None: it was made by something else
        return new

    def __repr__(self) -> str:
        if self._again is None:
            return f"<{type(self).__name__}, made by another object or of a text>"
        words = [*map(repr, self._again[0]), *(f"{name}={value!r}" for name, value in self._again[1].items())]
        return f"{type(self).__name__}({', '.join(words)})"

    def __reduce__(self) -> Any:
        if self._again is None:
            raise TypeError(f"this {type(self).__name__} cannot be pickled; pickle what it was made of")
        return _make_again, (type(self), *self._again)

    def __init__(self, maker: str, *arguments: Any, allowed: Sequence[int] = ()) -> None:
        address = ffi.new("gracecg_object **")
        call(maker, *arguments, address, allowed=allowed)
        self._keep(address)

    def _keep(self, address: Any) -> None:
        self._address = address
        weakref.finalize(self, _free, address)

    @classmethod
    def _made(cls, maker: str, *arguments: Any) -> Any:
        """An object of this class that a function makes."""
        new = cls.__new__(cls)
        new._again = None
        Handle.__init__(new, maker, *arguments)
        return new

    @property
    def _handle(self) -> Any:
        return self._address[0]

    @classmethod
    def _of(cls, given: Any) -> Any:
        """The handle of what has to be of this class."""
        if not isinstance(given, cls):
            raise TypeError(f"an object of the class {cls.__name__} is expected, not {given!r}")
        return given._handle

    def _numbers(self, item: str, *shape: int) -> NDArray[np.float64]:
        """The numbers of an item; -1 in the shape: as many as there are."""
        count = ffi.new("size_t *")
        call("get", self._handle, item.encode(), 0, ffi.NULL, count)
        array = np.empty(count[0])
        call("get", self._handle, item.encode(), count[0], pointer(array), ffi.NULL)
        array.flags.writeable = False
        return array.reshape(shape) if shape else array

    def _number(self, item: str) -> float:
        return float(self._numbers(item)[0])

    def _text(self, item: str) -> str:
        """A text, whose length is told first."""
        length = ffi.new("size_t *")
        call("get_text", self._handle, item.encode(), ffi.NULL, 0, length)
        buffer = ffi.new("char[]", length[0] + 1)
        call("get_text", self._handle, item.encode(), buffer, length[0] + 1, ffi.NULL)
        return text_of(buffer)

    def _items(self) -> dict[str, int | None]:
        """All items with the count of their numbers; None: a text."""
        lines = (line.split() for line in self._text("items").splitlines())
        return {name: None if size == "text" else int(size) for name, size in lines}

    def _values(self, kind: Any, **other: Any) -> Any:
        """A dataclass of items with the names of its fields; the arrays have the shapes that their metadata says. Items whose
        size is known are asked for at once."""
        values = dict(other)
        wanted = [item for item in fields(kind) if item.name not in values]
        known = {item.metadata.get("item", item.name): math.prod(item.metadata.get("shape", ())) for item in wanted
                 if -1 not in item.metadata.get("shape", ())}
        together = np.empty(sum(known.values()))
        if known:
            call("get", self._handle, " ".join(known).encode(), len(together), pointer(together), ffi.NULL)
        together.flags.writeable = False
        found = dict(zip(known, np.split(together, np.cumsum(list(known.values()))[:-1])))
        for item in wanted:
            name, shape = item.metadata.get("item", item.name), item.metadata.get("shape")
            if name not in found:
                values[item.name] = self._numbers(name, *shape)
            else:
                values[item.name] = found[name].reshape(shape) if shape else CASTS[item.type](found[name][0])
        return kind(**values)


CASTS = {"float": float, "int": int, "bool": bool}


def array(*shape: int, item: str | None = None) -> Any:
    """A field of a dataclass that is an array of this shape, of the item of another name."""
    return field(metadata={"shape": shape} if item is None else {"shape": shape, "item": item})


def named(item: str) -> Any:
    """A field of a dataclass that is a number, of the item of this name."""
    return field(metadata={"item": item})
