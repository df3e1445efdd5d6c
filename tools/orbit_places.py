#!/usr/bin/env python3
"""The errors of an estimate beside its own covariance, of one manoeuvre at random places of random orbits.

    tools/orbit_places.py [CASE] [--program build/bin/gracecg] [--places 24] [--runs 20] [--algorithm optimal] [--seed 5]
                          [--set KEY=VALUE ...] [--add 'GROUPS']

CASE states its orbit by Kepler elements; without one, a satellite of 185 kg, 310 km up, flies three rods for 90 s. Node and
mean anomaly of each place are drawn, the inclination is 51, 70 or 89 deg. --set gives a key of the case another value, --add
appends groups. Each place is a case of its own name, thus with random numbers of its own, for `gracecg montecarlo`.

Printed: of the places' mean normalised squares (3 if the covariances are honest) mean, median, 9th decile and the largest;
places without an estimate; the RMS error of the offset, mm. A place above --tell gets a line. Status 1 when all fail.
"""
import argparse
import json
import pathlib
import random
import re
import statistics
import subprocess
import sys
import tempfile

SATELLITE = """&calibration name = 'own', epoch = '2024-03-15T06:00:00', duration = 90 /
&mass_properties mass = 185, moments_of_inertia = 22, 48, 55, products_of_inertia = 0.8, -1.1, 0.5 /
&rods largest_moment = 12 /
&rod axis = 1, amplitude = 8, frequency = 0.0777777777778, stop = 90 /
&rod axis = 2, amplitude = 10, frequency = 0.1, stop = 90 /
&rod axis = 3, amplitude = 10, frequency = 0.1222222222, stop = 90 /
&truth
    offset_mm = 0.7, -0.35, 0.22
    orbit = 'kepler', semi_major_axis_km = 6700, eccentricity = 0.002
    inclination_deg = 70, node_deg = 33, perigee_deg = 40, mean_anomaly_deg = 215
    attitude = 'nadir'
/
&surface length = 2.0, height = 0.7, width_bottom = 1.2, width_top = 0.8 /
&accelerometer
    noise_level = 4e-20, 4e-20, 9e-20
    noise_corner = 0.01, 0.02, 0.005, bias = 1e-6, 2e-6, -1e-6
    scale1 = 1, 1, 1, scale2 = 0, 0, 0, scale3 = 0, 0, 0
/
&atmosphere space_weather = 'given', f107 = 180, f107_mean = 165, kp = 3 /
&operator accelerometer_scale_sigma = 0.0101, 0.0159, 0.0119, magnetometer_bias_nt_sigma = 50, 30, 25 /
"""
NUMBER = r"[-+]?[\d.][-+.\deE]*"
VALUE = rf"('[^']*'|\.(?:true|false)\.|{NUMBER}(?:, {NUMBER})*)"      # of a key: a text, a logical, or numbers


def changed(text, key, value):
    """A case file with another value of a key that it has."""
    text, count = re.subn(rf"\b{key} = {VALUE}", lambda _: f"{key} = {value}", text)
    if count != 1:
        sys.exit(f"orbit_places.py: the case has the key {key} {count} times; it is needed once, as KEY = VALUE")
    return text


def estimates(program, folder, text, arguments):
    """What `gracecg montecarlo` says of a case file, and why it does not."""
    path = pathlib.Path(folder, "place.nml")
    path.write_text(text, encoding="utf-8")
    done = subprocess.run([program, "montecarlo", path, "--format", "json", *arguments], capture_output=True, text=True,
                          check=False)
    return (json.loads(done.stdout), "") if done.returncode == 0 else (None, done.stderr.strip())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", nargs="?", type=pathlib.Path, help="case file (default: a satellite of 185 kg)")
    parser.add_argument("--program", default="build/bin/gracecg", help="(default %(default)s)")
    parser.add_argument("--places", type=int, default=24, help="how many (default %(default)s)")
    parser.add_argument("--runs", default="20", help="at each (default %(default)s)")
    parser.add_argument("--algorithm", default="optimal", help="(default %(default)s)")
    parser.add_argument("--seed", type=int, default=5, help="of the places (default %(default)s)")
    parser.add_argument("--set", nargs="+", default=[], metavar="KEY=VALUE", help="another value of a key of the case")
    parser.add_argument("--add", default="", metavar="GROUPS", help="appended to the case")
    parser.add_argument("--tell", type=float, default=15, help="places above this (default %(default)s)")
    options = parser.parse_args()

    text = options.case.read_text(encoding="utf-8") if options.case else SATELLITE
    for pair in options.set:
        text = changed(text, *pair.split("=", 1))
    draw = random.Random(options.seed)
    squares, errors, refused = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(options.places):
            elements = {"name": f"'place {number}'", "mean_anomaly_deg": f"{draw.uniform(0, 360):.1f}",
                        "node_deg": f"{draw.uniform(0, 360):.1f}", "inclination_deg": draw.choice([70, 89, 51])}
            place = text
            for key, value in elements.items():
                place = changed(place, key, value)
            result, problem = estimates(options.program, folder, place + options.add + "\n",
                                        ["--algorithms", options.algorithm, "--runs", options.runs])
            if result is None:
                refused += 1
                print(f"{elements}: {problem}", file=sys.stderr)
                continue
            squares.append(result["cases"][0]["normalised"][options.algorithm])
            errors.append([row["rms_mm"] for row in result["results"]])
            if squares[-1] > options.tell:
                print(f"{elements}: {squares[-1]:.3g}", file=sys.stderr)
    if not squares:
        sys.exit("orbit_places.py: no place has an estimate")
    squares.sort()
    print(f"squares: mean {statistics.mean(squares):.2f} median {statistics.median(squares):.2f} "
          f"9th decile {squares[int(.9*len(squares))]:.2f} largest {squares[-1]:.2f}")
    print(f"places: {len(squares)} with an estimate, {refused} refused")
    print("RMS, mm:", *(f"{statistics.mean(e[i]**2 for e in errors)**.5:.4f}" for i in range(3)))


if __name__ == "__main__":
    main()
