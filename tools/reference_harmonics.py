#!/usr/bin/env python3
"""Independent values of the geopotential and the geomagnetic field for the tests (needs mpmath).

Straight from the definitions in spherical coordinates, with 60 digits: Legendre functions from their
explicit polynomials with integer coefficients, gradients by central differences with a step of
1e-12 radii (more than 30 digits are right). No formula is shared with src/.
"""
import pathlib
from math import comb, factorial

from mpmath import atan2, cos, mp, mpf, sin, sqrt

mp.dps = 60
DATA = pathlib.Path(__file__).resolve().parent.parent / "data"


def legendre(n, m, u, cos_latitude):
    """P_nm(u) without Condon-Shortley phase: (1-u^2)^(m/2) d^(n+m)/du^(n+m) (u^2-1)^n / (2^n n!)."""
    total = mpf(0)
    for k in range((n - m) // 2 + 1):
        power = 2 * n - 2 * k
        derivative = factorial(power) // factorial(power - n - m)
        total += (-1) ** k * comb(n, k) * derivative * u ** (power - n - m)
    return total * cos_latitude**m / (2**n * factorial(n))


def schmidt(n, m):
    return sqrt((1 if m == 0 else 2) * mpf(factorial(n - m)) / factorial(n + m))


def potential(coefficients, radius, normalise, x, y, z):
    """sum (R/r)^(n+1) N_nm P_nm(sin lat) [C cos m lon + S sin m lon]"""
    distance = sqrt(x * x + y * y)
    r = sqrt(x * x + y * y + z * z)
    longitude = atan2(y, x)
    total = mpf(0)
    for n, m, c, s in coefficients:
        function = normalise(n, m) * legendre(n, m, z / r, distance / r)
        total += (radius / r) ** (n + 1) * function * (c * cos(m * longitude) + s * sin(m * longitude))
    return total


def egm96(degree):
    for line in open(DATA / "egm96_deg70.gfc", encoding="utf-8"):
        words = line.split()
        if words and words[0] == "gfc" and int(words[1]) <= degree:
            yield int(words[1]), int(words[2]), mpf(words[3]), mpf(words[4])


def dgrf(fraction):
    """Between DGRF 1985 and 1990."""
    values = {}
    for line in open(DATA / "igrf_1900_2030.txt", encoding="utf-8"):
        if line[0] in "gh":
            kind, n, m, *columns = line.split()
            old, new = mpf(columns[17]), mpf(columns[18])
            values[kind, int(n), int(m)] = old + (new - old) * fraction
    for n in range(1, 11):
        for m in range(n + 1):
            yield n, m, values["g", n, m], values.get(("h", n, m), mpf(0))


def igrf95(years):
    """1995.0 with its secular variation over some years."""
    for line in open(DATA / "igrf95_original.txt", encoding="utf-8"):
        if not line.startswith("#") and line.strip():
            n, m, g, h, g_rate, h_rate = line.split()
            yield int(n), int(m), mpf(g) + years * mpf(g_rate), mpf(h) + years * mpf(h_rate)


def gradient(function, point):
    """By central differences of fourth order."""
    h = mpf(10) ** -12
    result = []
    for axis in range(3):
        def at(k):
            moved = list(point)
            moved[axis] += k * h
            return function(*moved)
        result.append((8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * h))
    return result


def show(title, point, values):
    print(title, [str(p) for p in point])
    for value in values:
        print("   ", mp.nstr(value, 20))


def main():
    mu, radius = mpf("3986004.415e8"), mpf("6378136.3")
    for degree, point in (
        (70, ("-2014520.5", "3411000.25", "5502211.75")),
        (70, ("0", "0", "6838000")),
        (70, ("0", "0", "-6800000")),
        (20, ("6700000", "-900000", "-1200000")),
        (20, ("-11000000", "38000000", "15000000")),
    ):
        coefficients = list(egm96(degree))
        place = [mpf(p) / radius for p in point]
        norm = {(n, m): schmidt(n, m) * sqrt(mpf(2 * n + 1)) for n, m, _, _ in coefficients}

        def u(x, y, z):
            return mu / radius * potential(coefficients, 1, lambda n, m: norm[n, m], x, y, z)

        show(f"EGM96 {degree}: potential, acceleration at", point, [u(*place)] + [a / radius for a in gradient(u, place)])

    for title, coefficients in (("1987.3", list(dgrf(mpf("0.46")))), ("igrf95 1998.6", list(igrf95(mpf("3.6"))))):
        for point in (("4512000", "-2708000", "-4398000"), ("-1020000", "150000", "6650000"), ("0", "0", "6850000")):
            place = [mpf(p) / 6371200 for p in point]

            def v(x, y, z):
                return potential(coefficients, 1, schmidt, x, y, z)

            show(f"{title}: B in nT at", point, [-b for b in gradient(v, place)])


if __name__ == "__main__":
    main()
