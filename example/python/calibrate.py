#!/usr/bin/env python3
"""A calibration from Python: gravity at a point, simulated observations, and the offset they give.

    python3 calibrate.py [LIBRARY]

LIBRARY is the path of libgracecg.so, where the loader does not find it by itself. The offset is that of
`gracecg simulate front-3` and `gracecg estimate`.
"""
import sys

import gracecg_ctypes as gracecg


def main():
    library = gracecg.Library(*sys.argv[1:2])
    print(f"gracecg {library.version}")

    gravity = gracecg.Gravity(library, "egm96", degree=20, order=20)
    ax, ay, az = gravity.acceleration((4.0e6, -3.0e6, 4.6e6))
    print(f"gravity {ax:.13e} {ay:.13e} {az:.13e} m/s^2, Earth-fixed")

    simulator = gracecg.Simulator(gracecg.Case(library, "front-3"))
    fit = simulator.observe(seed=1, run=1).estimate("assest-fde")
    print(fit.text("action"))       # numbers are there also when they are not to be used
    for axis, offset, sigma in zip("xyz", fit.numbers("offset"), fit.numbers("sigma")):
        print(f"d_{axis} = {1e3 * offset:12.7f} mm +- {1e3 * sigma:10.7f} mm")
    for warning in fit.text("warnings").splitlines():
        print("warning:", warning)

    try:
        gracecg.Gravity(library, "egm96", degree=99, order=99)
    except gracecg.GracecgError as error:
        print(f"degree 99: {error}")


if __name__ == "__main__":
    main()
