#!/usr/bin/env python3
"""A day whose orbit and magnetic field are Orekit's (PyPI: orekit-jpype), beside gracecg's and for its estimate.

    bench/orekit_world.py GRACECG [--duration 86400] [--seed 1]

`gracecg level1 simulate` makes the files of a day with four sub-manoeuvres and no force but gravity. From its first state
Orekit flies the day with its own integrator, geopotential, precession, nutation and rotation of the Earth, and field; it
shares the coefficients of EGM96 and IGRF-14 with gracecg and no code. Printed is how far both are apart. Then the orbit goes into
the files as an OEM by way of `gracecg level1 convert`, the field into MAG1B, and `level1 estimate` works with them. Last, Orekit
reads the OEM and AEM that gracecg writes.

Needs numpy, a JDK, and orekit-jpype, which bench/peers.py gets. Status 1 where something is farther apart than LIMITS.
"""
import argparse
import csv
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np
import peers

FIELD = peers.ROOT / "data" / "igrf_1900_2030.txt"
YEAR = 2020 + 31/366        # of the epoch, 2020-02-01: the field of one date serves
DAY = "2020-02-01_C_04.txt"
QUIET = {"density_scale": "0", "solar_irradiance": "1", "earth_rings": "0", "degree": "20", "order": "20"}      # gravity alone
LIMITS = {"orbit, m": 0.05, "Earth-fixed orbit, m": 0.2, "field, nT": 0.01, "OEM, m": 1e-6, "AEM, rad": 1e-12,
          "d by Orekit's orbit, sigma": 0.01, "d by its field, sigma": 0.1}


def igrf(path):
    """Degree, order, g and h of the day, nT."""
    epochs, value = None, {}
    for words in (line.split() for line in FIELD.read_text().splitlines()):
        if words[1:2] == ["epochs"]:
            epochs = [float(word) for word in words[2:-1]]
        elif words and words[0] in "gh":
            value[words[0], int(words[1]), int(words[2])] = np.interp(YEAR, epochs, [float(w) for w in words[3:3 + len(epochs)]])
    path.write_text("".join(f"{n} {m} {value['g', n, m]:.6f} {value.get(('h', n, m), 0.0):.6f}\n"
                            for _, n, m in sorted(key for key in value if key[0] == "g")))


def records(path):
    """Header and records, as words, of a Level-1 text file."""
    head, body = path.read_text().split("# End of YAML header\n")
    return head + "# End of YAML header\n", [line.split() for line in body.splitlines()]


def axes(q):
    """Rotation matrices of quaternions with the scalar first: SRF from inertial coordinates (CSR-TM-00-01, 2-29)."""
    s, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows = [[s*s + x*x - y*y - z*z, 2*(x*y + s*z), 2*(x*z - s*y)], [2*(x*y - s*z), s*s - x*x + y*y - z*z, 2*(y*z + s*x)],
            [2*(x*z + s*y), 2*(y*z - s*x), s*s - x*x - y*y + z*z]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def write_oem(path, frame, time, states):
    """Positions and velocities, SI, at GPS times of 2020-02-01."""
    def date(t):
        t -= 633787200 - 86400
        return np.datetime_as_string(np.datetime64("2020-01-31T00:00:00") + np.timedelta64(round(t), "s"))

    lines = ["CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2026-11-28T00:00:00", "ORIGINATOR = Orekit", "META_START",
             "OBJECT_NAME = GRACE-FO 1", "OBJECT_ID = 2018-047A", "CENTER_NAME = EARTH", f"REF_FRAME = {frame}",
             "TIME_SYSTEM = GPS", f"START_TIME = {date(time[0])}", f"STOP_TIME = {date(time[-1])}", "META_STOP"]
    path.write_text("\n".join(lines + [date(t) + "".join(f" {x:.15g}" for x in row/1e3) for t, row in zip(time, states)]) + "\n")


def magnetometer(day, time, field, random):
    """Puts a field, inertial axes, nT, into MAG1B: new each second, with 5 nT of noise, by the attitude of SCA1B."""
    _, attitude = records(day / f"SCA1B_{DAY}")
    at = np.array([float(w[0]) for w in attitude])
    q = np.array([[float(x) for x in w[3:7]] for w in attitude])
    path = day / f"MAG1B_{DAY}"
    head, rows = records(path)
    tags = np.array([int(w[0]) + 1e-6*int(w[1]) for w in rows])
    tags[1::2] = tags[::2][:len(tags[1::2])]
    q = np.array([np.interp(tags, at, q[:, k]) for k in range(4)]).T
    q /= np.linalg.norm(q, axis=1)[:, None]
    b = np.array([np.interp(tags, time, field[:, k]) for k in range(3)]).T
    b = np.einsum("kij,kj->ki", axes(q), b)/1e3 + np.repeat(random.normal(size=((len(tags) + 1)//2, 3)), 2, 0)[:len(tags)]*5e-3
    for w, values in zip(rows, b):
        w[4:7] = [f"{x:.9g}" for x in values]
    path.write_text(head + "\n".join(" ".join(w) for w in rows) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("gracecg")
    parser.add_argument("--duration", type=int, default=86400)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    program = pathlib.Path(given.gracecg).resolve()
    peers.WORK.mkdir(parents=True, exist_ok=True)
    version = peers.install(peers.PACKAGES["Orekit"])
    packages = peers.WORK.glob("venv/lib/python*/site-packages/orekit_jpype/jars/*.jar")
    jars = ":".join(str(path) for path in [*packages, peers.WORK])
    peers.run(["javac", "-cp", jars, "-d", peers.WORK, peers.HERE / "OrekitWorld.java"])

    def orekit(*words):
        rows = {}
        for line in peers.run(["java", "-cp", jars, "OrekitWorld", *words]).splitlines():
            word = line.split()
            rows.setdefault(word[0], []).append([float(x) for x in word[1:]])
        return {what: np.array(of) for what, of in rows.items()}

    apart = {}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def gracecg(*words):
            done = subprocess.run([str(program), *map(str, words)], cwd=folder, capture_output=True, text=True, check=False)
            if done.returncode not in (0, 3):
                raise SystemExit(f"gracecg {' '.join(map(str, words))}: {done.stderr}")
            return done.stdout

        def estimate(*words):
            document = json.loads(gracecg("level1", "estimate", "day", "--setup", "day/setup.nml", "--format", "json", *words))
            return 1e3*np.array(document["offset_mm"]), 1e3*np.array(document["sigma_mm"])

        case = gracecg("cases", "show", "front-1")
        for key, value in QUIET.items():
            case = re.sub(rf"^    {key} = [^!\n]*", f"    {key} = {value} ", case, flags=re.M)
        (folder / "case.nml").write_text(case)
        (folder / "level1.nml").write_text(f"&level1_simulation\n duration = {given.duration}, field_error_nt = 0\n/\n")
        gracecg("level1", "simulate", "case.nml", "--level1", "level1.nml", "--out", "day", "--seed", given.seed)
        day = folder / "day"
        _, inertial = records(day / f"GNI1B_{DAY}")
        _, fixed = records(day / f"GNV1B_{DAY}")
        state = [[np.array([float(w[k]) for k in (3, 4, 5, 9, 10, 11)]) for w in rows] for rows in (inertial, fixed)]
        (folder / "gfc").mkdir()
        shutil.copy(peers.GFC, folder / "gfc" / "peer.gfc")
        igrf(folder / "field.txt")
        world = orekit("fly", folder / "gfc", folder / "field.txt", inertial[0][0], *(repr(float(x)) for x in state[0][0]),
                       len(inertial) - 1)["day"]
        apart["orbit, m"] = np.max(np.linalg.norm(world[:, 1:4] - np.array(state[0])[:, :3], axis=1))
        apart["Earth-fixed orbit, m"] = np.max(np.linalg.norm(world[:, 7:10] - np.array(state[1])[:, :3], axis=1))
        with open(day / "truth.csv", encoding="ascii") as file:
            truth = list(csv.DictReader(line for line in file if not line.startswith("#")))
        turn = axes([[float(row[f"q{k}"]) for k in (4, 1, 2, 3)] for row in truth])
        field = np.einsum("kji,kj->ki", turn, 1e9*np.array([[float(row[f"b{a}_tesla"]) for a in "xyz"] for row in truth]))
        apart["field, nT"] = np.max(np.linalg.norm(world[:, 13:16] - field, axis=1))

        gracecg("level1", "convert", f"day/GNI1B_{DAY}", "--as", "ccsds", "--out", "ours.oem")
        gracecg("level1", "convert", f"day/SCA1B_{DAY}", "--as", "ccsds", "--out", "ours.aem")
        for message in ("ours.oem", "ours.aem"):        # of EARTH as centre Orekit wants JPL's ephemerides
            text = (folder / message).read_text()
            (folder / message).write_text(text.replace("CENTER_NAME = EARTH", "CENTER_NAME = that of the Earth"))
        read = orekit("read", folder / "ours.oem", folder / "ours.aem")
        _, attitude = records(day / f"SCA1B_{DAY}")
        turn = axes([[float(x) for x in w[3:7]] for w in attitude])
        apart["OEM, m"] = np.max(abs(read["orbit"][:, 1:4] - np.array(state[0])[:, :3]))
        apart["AEM, rad"] = np.max(abs(read["attitude"][:, 1:7] - np.concatenate([turn[:, :, 0], turn[:, :, 1]], 1)))

        ours = [estimate(), estimate("--field", "magnetometer")]
        for product, frame, columns in (("GNI1B", "EME2000", slice(1, 7)), ("GNV1B", "ITRF2014", slice(7, 13))):
            write_oem(folder / "orekit.oem", frame, world[:, 0], world[:, columns])
            gracecg("level1", "convert", "orekit.oem", "--out", f"day/{product}_{DAY}")
        magnetometer(day, world[:, 0], world[:, 13:16], np.random.default_rng(given.seed))
        theirs = [estimate(), estimate("--field", "magnetometer")]
        print(f"Orekit {version}; d less truth, um (sigma)")
        days = ("gracecg's day", "  field by its magnetometer", "Orekit's orbit", "  and its field by magnetometer")
        for what, (d, sigma) in zip(days, ours + theirs):
            print(f"  {what:32}" + "".join(f"{x:8.2f} ({s:.2f})" for x, s in zip(d - [300, 400, -500], sigma)))
        apart["d by Orekit's orbit, sigma"] = np.max(abs(theirs[0][0] - ours[0][0])/ours[0][1])
        apart["d by its field, sigma"] = np.max(abs(theirs[1][0] - ours[0][0])/ours[0][1])
    for what, value in apart.items():
        print(f"{what:32}{value:12.3g}{'' if value <= LIMITS[what] else '   more than ' + str(LIMITS[what])}")
    return int(any(value > LIMITS[what] for what, value in apart.items()))


if __name__ == "__main__":
    sys.exit(main())
