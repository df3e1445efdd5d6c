#!/usr/bin/env python3
"""What the orbit misses by the forces that gracecg leaves out: third bodies, solid tides, relativity.

Formulas (O. Montenbruck, E. Gill, Satellite Orbits, 2000, sections 3.3, 3.7; IERS Conventions 2010, sections 6.2, 10.3):

    third body     GM_b ((s - r)/|s - r|^3 - s/|s|^3)
    solid tide     k2 GM_b R^5/(2 |s|^3 r^4) ((3 - 15 c^2) r/|r| + 6 c s/|s|),  c the cosine between r and s, k2 = 0.30
    relativity     GM/(c0^2 r^3) ((4 GM/r - v^2) r + 4 (r.v) v)

along a circular polar orbit of 466 km about an Earth of GM and J2, with Moon and Sun where they act most (in the orbital
plane) and where they stand for the day. Prints the greatest acceleration, and how far the position is off after 60 s and
after a day, from the same state.
"""
import math

GM, RADIUS, J2, LIGHT = 398600.4415e9, 6378136.3, 1.0826e-3, 299792458.0
BODIES = {"Moon": (4902.800e9, 384400e3), "Sun": (1.32712440018e20, 149597870700.0)}
ORBIT, LOVE, STEP = 6378136.3 + 466e3, 0.30, 30.0


def add(*vectors):
    return [sum(parts) for parts in zip(*vectors)]


def times(factor, v):
    return [factor*x for x in v]


def dot(a, b):
    return sum(x*y for x, y in zip(a, b))


def norm(v):
    return math.sqrt(dot(v, v))


def direction(angle):
    """Of a body in the orbital plane."""
    return [math.cos(angle), 0.0, math.sin(angle)]


def third_body(body, angle):
    gm, distance = BODIES[body]
    s = times(distance, direction(angle))
    return lambda r, v: times(gm, add(times(1/norm(add(s, times(-1, r)))**3, add(s, times(-1, r))), times(-1/distance**3, s)))


def tide(body, angle):
    gm, distance = BODIES[body]
    s = direction(angle)

    def acceleration(r, v):
        radius = norm(r)
        c = dot(r, s)/radius
        factor = LOVE*gm*RADIUS**5/(2*distance**3*radius**4)
        return times(factor, add(times((3 - 15*c*c)/radius, r), times(6*c, s)))
    return acceleration


def relativity(r, v):
    radius = norm(r)
    return times(GM/(LIGHT**2*radius**3), add(times(4*GM/radius - dot(v, v), r), times(4*dot(r, v), v)))


def earth(r):
    radius = norm(r)
    k = 1.5*J2*(RADIUS/radius)**2
    z = 5*(r[2]/radius)**2
    return [-GM/radius**3*r[i]*(1 + k*((3 if i == 2 else 1) - z)) for i in range(3)]


def flight(extra, seconds):
    """Position after a time, and the greatest acceleration on the way, by the classical Runge-Kutta method."""
    def rate(y):
        return y[3:] + add(earth(y[:3]), extra(y[:3], y[3:]))

    y = [ORBIT, 0.0, 0.0, 0.0, 0.0, math.sqrt(GM/ORBIT)]
    most = 0.0
    for _ in range(round(seconds/STEP)):
        most = max(most, norm(extra(y[:3], y[3:])))
        k1 = rate(y)
        k2 = rate(add(y, times(STEP/2, k1)))
        k3 = rate(add(y, times(STEP/2, k2)))
        k4 = rate(add(y, times(STEP, k3)))
        y = add(y, times(STEP/6, add(k1, times(2, k2), times(2, k3), k4)))
    return y[:3], most


def main():
    cases = {"none": [lambda r, v: [0.0, 0.0, 0.0]],
             "Moon": [third_body("Moon", math.radians(a)) for a in range(0, 180, 45)],
             "Sun": [third_body("Sun", math.radians(a)) for a in range(0, 180, 45)],
             "solid tide of the Moon": [tide("Moon", math.radians(a)) for a in range(0, 180, 45)],
             "solid tide of the Sun": [tide("Sun", math.radians(a)) for a in range(0, 180, 45)],
             "relativity": [relativity]}
    reference = {t: flight(cases["none"][0], t)[0] for t in (60, 86400)}
    print(f"{'':24s}  m/s^2     60 s        a day")
    for name, forces in cases.items():
        if name == "none":
            continue
        most, off = 0.0, {60: 0.0, 86400: 0.0}
        for force in forces:
            for t in off:
                place, greatest = flight(force, t)
                most = max(most, greatest)
                off[t] = max(off[t], norm(add(place, times(-1, reference[t]))))
        print(f"{name:24s} {most:8.1e}  {1e3*off[60]:7.3f} mm  {off[86400]:8.1f} m")


if __name__ == "__main__":
    main()
