"""Centre-of-gravity calibration of GRACE-type satellites: simulate, estimate, plan.

Numbers are SI, arrays are numpy's with one row an epoch or point. Frames: inertial is the mean equator and equinox of
J2000; Earth-fixed is turned from it by the sidereal angle; body has x along the satellite, z towards the Earth.
Quaternions turn inertial into body axes and have their scalar part last. Failures raise `GracecgError`.

>>> import gracecg
>>> solution = gracecg.Case("front-3").simulator().observe(seed=1, run=1).estimate("optimal")
>>> solution.action.text        # what to do: whether to use the numbers
>>> 1e3 * solution.offset       # mm
"""
from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import distributed, pages, plot, report, torques
    from ._library import GracecgError
    from .calibration import (Action, Beliefs, Bound, Case, Chain, Design, DesignSettings, Fit, FitTests, ForceModel, Joint,
                              LiveEstimate, LiveOffset, Map, MonteCarlo, Observations, Rod, Setup, Simulator, Solution,
                              algorithms, case_names, estimate_joint, monte_carlo)
    from .level1 import Level1, Level1Offset, estimate_level1
    from .models import (Air, Density, EarthRadiation, Field, Gravity, Utc, Wind, sun_illumination,
                         sun_position)

    __version__: str

__all__ = ["Action", "Air", "Beliefs", "Bound", "Case", "Chain", "Density", "Design", "DesignSettings", "EarthRadiation",
           "Field", "Fit", "FitTests", "ForceModel", "GracecgError", "Gravity", "Joint", "Level1", "Level1Offset",
           "LiveEstimate", "LiveOffset", "Map", "MonteCarlo", "Observations", "Rod", "Setup", "Simulator", "Solution", "Utc",
           "Wind", "algorithms", "case_names", "estimate_joint", "distributed", "estimate_level1", "monte_carlo",
           "sun_illumination", "sun_position", "torques"]

_MODULES = ("calibration", "level1", "models", "_library")
_PARTS = ("distributed", "pages", "plot", "report", "torques")


def __getattr__(name: str) -> Any:
    """The public names, found when they are first used: pages and figures do without the shared library."""
    if name in _PARTS:
        return importlib.import_module("." + name, __name__)
    if name == "__version__":
        library = importlib.import_module("._library", __name__)
        return library.text_of(library.lib.gracecg_version())
    if name in __all__:
        for module in _MODULES:
            found = getattr(importlib.import_module("." + module, __name__), name, None)
            if found is not None:
                globals()[name] = found
                return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *_PARTS, *(name for name in globals() if name.startswith("__"))})
