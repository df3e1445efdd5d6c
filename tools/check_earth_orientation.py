#!/usr/bin/env python3
"""Compares the Earth's orientation with ERFA (PyPI pyerfa), IAU 2006/2000A with UT1 and pole of the IERS.

    tools/check_earth_orientation.py PROGRAM FINALS [N]

PROGRAM is gracecg, FINALS a file finals2000A.all. At N (60) dates of the file, at the epoch and up to a day after the
constants were computed, a position of 6844 km is turned by both; prints the greatest distance in m, and what that does to
the geomagnetic field: gradient times distance plus field times angle, in nT. Status 1 above 10 m or 0.1 nT. Not part of
the tests: run it after a change of gracecg_environment_earth_orientation.
"""
import subprocess
import sys

import erfa
import numpy as np

RADIUS, FIELD, GRADIENT = 6844e3, 5e4, 3*5e4/6844e3     # m; nT; nT/m of a dipole
ARCSECOND = np.pi/648000


def rows(path):
    """MJD, x, y (arcsec), UT1-UTC (s) of finals2000A."""
    found = []
    for line in open(path, encoding="ascii"):
        if line[58:68].strip() == "":
            break
        found.append([float(line[a:b]) for a, b in ((7, 15), (18, 27), (37, 46), (58, 68))])
    return np.array(found)


def by_erfa(table, mjd):
    """GCRS to ITRS at a UTC day with fraction; UT1-TAI is linear between the days."""
    day = int(mjd)
    near = np.searchsorted(table[:, 0], day)
    table = table[near:near + 3]
    tai = np.array([erfa.dat(*erfa.jd2cal(2400000.5, row)[:3], 0.0) for row in table[:, 0]])
    offset = erfa.dat(*erfa.jd2cal(2400000.5, day)[:3], 0.0)
    x, y = (np.interp(mjd, table[:, 0], table[:, k])*ARCSECOND for k in (1, 2))
    ut1 = np.interp(mjd, table[:, 0], table[:, 3] - tai) + offset
    tt = mjd - day + (offset + 32.184)/86400
    return erfa.c2t06a(2400000.5 + day, tt, 2400000.5 + day, mjd - day + ut1/86400, x, y)


def by_gracecg(program, path, mjd, after):
    year, month, day, _ = erfa.jd2cal(2400000.5, int(mjd))
    seconds = round((mjd - int(mjd))*86400)
    date = f"{year:04d}-{month:02d}-{day:02d}T{seconds//3600:02d}:{seconds//60 % 60:02d}:{seconds % 60:02d}"
    text = subprocess.run([program, "model", "orientation", "--date", date, "--file", path, "--after", str(after)],
                          check=True, capture_output=True, text=True).stdout
    return np.array([float(x) for x in text.splitlines()[-1].split(",")]).reshape(3, 3)


def main():
    program, path = sys.argv[1:3]
    n = int(sys.argv[3]) if len(sys.argv) > 3 else 60
    table = rows(path)
    random = np.random.default_rng(1)
    worst = {0: 0.0, 3600: 0.0, 43200: 0.0, 82800: 0.0}
    for _ in range(n):
        mjd = random.integers(table[1, 0], table[-4, 0]) + random.integers(0, 86400)/86400
        for after in worst:
            angle = np.abs(by_gracecg(program, path, mjd, after) - by_erfa(table, mjd + after/86400))
            worst[after] = max(worst[after], float(np.linalg.norm(angle, 2)))
    failed = False
    for after, angle in worst.items():
        distance, field = angle*RADIUS, GRADIENT*angle*RADIUS + FIELD*angle
        failed |= distance > 10 or field > 0.1
        print(f"{after:6d} s after the epoch: {1e3*angle/ARCSECOND:8.3f} mas, {distance:8.3f} m, {field:.4f} nT")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
