"""Centre-of-gravity calibration of GRACE-type satellites: simulate, estimate, plan.

Numbers are SI, arrays are numpy's with one row an epoch or point. Frames: inertial is the mean equator and equinox of
J2000; Earth-fixed is turned from it by the sidereal angle; body has x along the satellite, z towards the Earth.
Quaternions turn inertial into body axes and have their scalar part last. Failures raise `GracecgError`.

>>> import gracecg
>>> solution = gracecg.Case("front-3").simulator().observe(seed=1, run=1).estimate("optimal")
>>> 1e3 * solution.offset       # mm
"""
from ._library import GracecgError, ffi as _ffi, lib as _lib, text_of as _text_of
from .calibration import (Beliefs, Bound, Case, Chain, Design, DesignSettings, Fit, FitTests, ForceModel, Joint, Map,
                          MonteCarlo, Observations, Rod, Setup, Simulator, Solution, algorithms, case_names,
                          estimate_joint, monte_carlo)
from .level1 import Level1, Level1Offset, estimate_level1
from .models import (Air, Density, EarthRadiation, Field, Gravity, Surface, Utc, Wind, earth_fixed,
                     sun_illumination, sun_position)

__version__: str = _text_of(_lib.gracecg_version())

__all__ = ["Air", "Beliefs", "Bound", "Case", "Chain", "Density", "Design", "DesignSettings", "EarthRadiation", "Field", "Fit", "FitTests",
           "ForceModel", "GracecgError", "Gravity", "Joint", "Level1", "Level1Offset", "Map", "MonteCarlo", "Observations", "Rod",
           "Setup", "Simulator", "Solution", "Surface", "Utc", "Wind", "algorithms", "case_names", "earth_fixed",
           "estimate_joint", "estimate_level1", "monte_carlo", "sun_illumination", "sun_position"]
