#!/usr/bin/env python3
"""Round trips through simulated Level-1 files: how well `gracecg level1 estimate` gives back what was put in.

    tools/level1_study.py [--gracecg PROGRAM] [--seeds 20] [--first-seed 1] [--scenario NAME ...] [--case CASE] [--out FILE]
    tools/level1_study.py --faults ...      puts faults into the files of each seed and looks whether each is told by its name
    tools/level1_study.py --scenario as-flown ...   days like those flown, |d| below 0.1 mm: what plain fits of one line make of
                                            them beside what was published of such days (needs numpy)

Each scenario is a namelist for `gracecg level1 simulate`; each seed draws gains, inertia, leakage, scales, field, clocks
and all noise anew. Reported: for the result, and without some instruments, how many of the seeds that claim it (flag 0) are within
10 um on all axes; those within 4 sigma + 3 um; the mean normalised squares, which are 3 within their sampling error if sigma is
right; gains within 0.5 %, delays within 10 ms. Exit status 1 when a standard is missed.
"""
import argparse
import csv
import glob
import json
import math
import os
import re
import subprocess
import sys
import tempfile

SEVEN = "".join(f"&level1_span\n start = {300 + 806*i}, span_duration = 180, amplitude_ma = {a}, cycles = 15, 15, 15\n/\n"
                for i, a in enumerate(["120, 0, 0", "0, 120, 0", "0, 0, 120", "120, 0, 0", "0, 120, 0", "0, 0, 120", "120, 0, 0"]))
SCENARIOS = {
    # name: (settings, spans, delays that are true: torque, accelerometer)
    "four60": ("", "", 0.0, 0.0),
    "seven180": ("spans = 7, spacing = 806, span_duration = 180, cycles = 15, 18, 21", "", 0.0, 0.0),
    "seven180-single": ("", SEVEN, 0.0, 0.0),
    "jumps": ("phase_deg = 50, 110, 260, amplitude_ma = 120, 90, 110", "", 0.0, 0.0),
    "delays": ("torque_delay = 0.12, accelerometer_delay = 0.06", "", 0.12, 0.06),
    "dirty": ("staircase = .true., accelerometer_delay = 0.1, firings_inside = 1, gaps = 1, flagged = 5, rod_gain_error = 0.04, "
              "stuck = 1710, 30", "", 0.0, 0.1),
    "grace": ("satellite = 'A'", "", 0.0, 0.0),
    "grace-held": ("satellite = 'A', staircase = .true., accelerometer_delay = 0.1", "", 0.0, 0.1),
    "grace-fo-d": ("satellite = 'D'", "", 0.0, 0.0),
}
# Days on which rods are driven all the time, with the controller's currents and some 600 firings; taken when asked for
WHISPER = ("spans = 0, duration = 86400, whisper_ma = 4, 4, 4, rod_control = .true., control_hz = 8e-4, science_ma = 0, "
           "firing_interval = 60, 228")
LONG_SCENARIOS = {
    "whisper": (WHISPER, "", 0.0, 0.0),
    "whisper-trim": (WHISPER + ", moved_at = 43200, moved_um = 20, 0, 0", "", 0.0, 0.0),
    # The controller's own currents alone, no tones
    "passive": ("spans = 0, duration = 86400, rod_control = .true., firing_interval = 60, 228", "", 0.0, 0.0),
}
# Seven spans of 180 s, period 12 s, one rod after the other, as GRACE-FO flies them; with what may add to the scatter
FLOWN = {"": "", "-leakage": "leakage = 5e-13, 1.5e-11", "-alignment": "alignment_deg = 0.04",
         "-drift": "drift_um_h = 2, 2, 2", "-scale": "angular_scale_error = 0.1",
         "-both": "leakage = 5e-13, 1.5e-11, angular_scale_error = 0.1"}
FLOWN_SCENARIOS = {"as-flown" + name: (settings, SEVEN, 0.0, 0.0) for name, settings in FLOWN.items()}
FLOWN_OFFSET = "0.06, -0.04, 0.05"      # mm
# RMS of what was published of GRACE-FO C against JPL's d, um: Liu et al. 2024 by the accelerometer alone and with the attitude;
# Huang et al. 2022
PUBLISHED = (("accelerometer", "7.4, 3.8, 4.7 (Liu et al. 2024)"), ("attitude", "9.6, 9.3, 7.9 (Liu et al. 2024)"))
SOURCES = ["optimal", "no-gyros", "no-channels"]


# Faults: what is changed (a key of the setup with its value; or files and what becomes of the words of their lines), what
# must be told of it, and the least flag
IN_PHASE = ", spans = 1, amplitude_ma = 0, 120, 120, cycles = 0, 6, 6"
QUIET = ", spans = 0, duration = 1200"
FAULTS = {
    "rod-sign": ("rod_sign = 1, -1, 1", "wrong sign of rod y", 2),
    "af-as-srf": ("accelerometer_axes = 1, 2, 3", "AF taken as SRF", 2),
    "obc-tags": ({"ACC1A": lambda w: [*w[:2], "G", *w[3:]]}, "left in OBC time", 0),
    "obc-currents": ({"MAG1B": None, "MAG1A": lambda w: ["G" if v == "R" else v for v in w]}, "left in OBC time", 0),
    "b-sign": ({"MAG1?": lambda w: [*w[:10], *(str(-float(v)) for v in w[10:13]), *w[13:]]}, "B currents with the wrong sign", 0),
    "transplanted": ({"ACC1A": lambda w: [*w[:9], "0", "0", "0", *w[12:]]}, "transplanted", 2),
    "other-time": ({"ACC1A": lambda w: [str(int(w[0]) - 300), *w[1:]]}, "transplanted", 2),
    "in-phase": (IN_PHASE, "not separable", 1),
    "no-manoeuvre": (QUIET, "no manoeuvre found", None),
}


def number(text, key):
    """The numbers of a key of a namelist."""
    match = re.search(rf"^\s*{key} = ([^!\n]*)", text, re.M)
    return [float(word) for word in match.group(1).replace(",", " ").split()]


def run(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    if done.returncode not in (0, 3):      # 3: done, but not to be used
        raise RuntimeError(f"{' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


def simulate(program, case, settings, spans, seed, folder, binary=False):
    """The folder of the files of a seed."""
    namelist = os.path.join(folder, "level1.nml")
    with open(namelist, "w") as file:
        file.write(f"&level1_simulation\n {settings}\n/\n{spans}")
    day = os.path.join(folder, "day")
    run(program, "level1", "simulate", case, "--level1", namelist, "--out", day, "--seed", str(seed),
        *(["--binary"] if binary else []))
    return day


def change(day, fault):
    """Puts a fault into setup or files; what they were."""
    before = {}
    if isinstance(fault, str):
        path = os.path.join(day, "setup.nml")
        with open(path) as file:
            before[path] = file.read()
        with open(path, "w") as file:
            file.write(re.sub(rf"^ *{fault.split()[0]} .*$", " " + fault, before[path], flags=re.M))
        return before
    for product, words in fault.items():
        for path in glob.glob(os.path.join(day, product + "_*")):
            with open(path) as file:
                before[path] = file.read()
            if words is None:
                os.remove(path)
                continue
            lines = before[path].splitlines()
            first = 1 + next(i for i, line in enumerate(lines) if line.startswith(("# End of YAML header", "END OF HEADER")))
            with open(path, "w") as file:
                file.write("\n".join([*lines[:first], *(" ".join(words(line.split())) for line in lines[first:])]) + "\n")
    return before


def told(program, day, words, least_flag):
    """Whether an estimate says these words, with such a flag; and what it says."""
    done = subprocess.run([program, "level1", "estimate", day, "--setup", os.path.join(day, "setup.nml"), "--format", "json"],
                          capture_output=True, text=True)
    if least_flag is None:
        return done.returncode == 1 and words in done.stderr, done.stderr
    if done.returncode not in (0, 3) or not done.stdout:
        return words in done.stderr, done.stderr
    document = json.loads(done.stdout)
    said = "\n".join([*document["findings"], *document["warnings"], document["reason"]])
    return words in said and document["flag"] >= least_flag, f"flag {document['flag']}: {said}"


def study_faults(options):
    """Every fault in every seed of every scenario; what was not told."""
    missed = []
    for name in options.scenario:
        settings, spans = SCENARIOS[name][:2]
        satellite = settings if settings.startswith("satellite") else "clock_drift = -1.5e-8"
        counts = dict.fromkeys(FAULTS, (0, 0))
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            with tempfile.TemporaryDirectory() as folder:
                day = simulate(options.gracecg, options.case, settings, spans, seed, folder)
                for fault, (what, words, least_flag) in FAULTS.items():
                    if what in (IN_PHASE, QUIET):
                        with tempfile.TemporaryDirectory() as other:
                            found = told(options.gracecg, simulate(options.gracecg, options.case, satellite + what, "", seed, other),
                                         words, least_flag)
                    elif fault == "obc-currents" and not glob.glob(os.path.join(day, "MAG1A_*")):
                        continue        # GRACE's MAG1A is in the magnetometer's own axes and is not used
                    else:
                        before = change(day, what)
                        found = told(options.gracecg, day, words, least_flag)
                        for path, text in before.items():
                            with open(path, "w") as file:
                                file.write(text)
                    counts[fault] = (counts[fault][0] + found[0], counts[fault][1] + 1)
                    if not found[0]:
                        missed.append(f"{name}, seed {seed}, {fault}: {found[1]}")
        print(f"{name:16}", ", ".join(f"{fault} {a} of {n}" for fault, (a, n) in counts.items() if n), flush=True)
    return missed


def flown_case(program, case, folder):
    """The case with a d as flown."""
    path = os.path.join(folder, "case.nml")
    with open(path, "w") as file:
        file.write(re.sub(r" offset_mm = [^!\n]*", f" offset_mm = {FLOWN_OFFSET} ", run(program, "cases", "show", case)))
    return path


def records(day, product):
    """The records of a product, as words."""
    with open(glob.glob(os.path.join(day, product + "_*"))[0]) as file:
        lines = file.read().split("# End of YAML header\n")[1].splitlines()
    return [line.split() for line in lines]


def plain_fits(day):
    """d by least squares of the line of the rods in each span, um: a = w' x d, with w' of the accelerometer or of the attitude."""
    import numpy as np

    frequency = 1/12        # Hz

    def line(time, values, about):
        """Cosine and sine, each a row, with a cubic beside them."""
        t, x = time - about, 2*np.pi*frequency*(time - about)
        columns = np.array([np.cos(x), np.sin(x), *(((t/90)**k) for k in range(4))]).T
        return np.linalg.lstsq(columns, values, rcond=None)[0][:2]

    clock = float(records(day, "CLK1B")[0][3])
    data = [(int(w[0]) + 1e-6*int(w[1]) + clock, *map(float, w[6:12])) for w in records(day, "ACC1A")]
    data = np.array(data)[:, [0, 3, 1, 2, 6, 4, 5]]         # of AF to SRF
    attitude = np.array([(float(w[0]), *map(float, w[3:7])) for w in records(day, "SCA1B")])
    time, s, v = attitude[:, 0], attitude[:, 1], attitude[:, 2:]
    rate = 2*(s[:-1, None]*v[1:] - s[1:, None]*v[:-1] + np.cross(v[1:], v[:-1]))     # of q2 q1*, less than 1e-6 of it is cubic
    rate *= np.sign(s[:-1]*s[1:] + np.sum(v[:-1]*v[1:], 1))[:, None]
    rate *= np.pi*frequency/np.sin(np.pi*frequency)         # means of a second
    sides = {"accelerometer": [], "attitude": []}
    with open(os.path.join(day, "SOE.txt")) as file:
        starts = [float(text.split()[0]) for text in file if text.split()[2:5] == ["CMCAL", "1", "1"]]
    for start in starts:
        inside = (data[:, 0] > start + 1) & (data[:, 0] < start + 179)
        both = line(data[inside, 0], data[inside, 1:], start)
        middle = (time[1:] + time[:-1])/2
        inside = (middle > start + 1) & (middle < start + 179)
        cosine, sine = line(middle[inside], rate[inside], start)
        turning = {"accelerometer": both[:, 3:], "attitude": 2*np.pi*frequency*np.array([sine, -cosine])}
        for source, of_span in turning.items():
            for a, w in zip(both[:, :3], of_span):
                sides[source].append((np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]), a))
    return {source: 1e6*np.linalg.lstsq(np.vstack([m for m, _ in rows]), np.concatenate([a for _, a in rows]), rcond=None)[0]
            for source, rows in sides.items()}


def report_plain(errors):
    """What plain fits make of days as flown, beside what was published."""
    for source, published in PUBLISHED:
        rms = [math.sqrt(sum(e[source][k]**2 for e in errors)/len(errors)) for k in range(3)]
        print(f"  plain fits, by the {source}: rms " + ", ".join(f"{v:.2f}" for v in rms) + f" um; published {published}")


def one(program, case, settings, spans, seed, folder, binary, flown, *how):
    """Simulates a seed and estimates; truth, estimate, and of days as flown the plain fits."""
    if flown:
        case = flown_case(program, case, folder)
    day = simulate(program, case, settings, spans, seed, folder, binary)
    plain = plain_fits(day) if flown else None
    with open(os.path.join(day, "truth.nml")) as file:
        truth = file.read()
    document = json.loads(run(program, "level1", "estimate", day, "--setup", os.path.join(day, "setup.nml"), "--format", "json",
                              *how))
    for name in os.listdir(day):
        os.remove(os.path.join(day, name))
    return truth, document, plain


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gracecg", default="gracecg")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--scenario", nargs="*", default=list(SCENARIOS), choices=[*SCENARIOS, *LONG_SCENARIOS, *FLOWN_SCENARIOS])
    parser.add_argument("--case", default="front-1")
    parser.add_argument("--binary", action="store_true")
    parser.add_argument("--out", help="a CSV file with all errors")
    parser.add_argument("--faults", action="store_true", help="faults in place of errors")
    options = parser.parse_args()
    if options.faults:
        missed = study_faults(options)
        for line in missed:
            print("missed:", line)
        return 1 if missed else 0
    rows, missed = [], []
    for name in options.scenario:
        settings, spans, torque_delay, accelerometer_delay = {**SCENARIOS, **LONG_SCENARIOS, **FLOWN_SCENARIOS}[name]
        how = ["--every", "5640"] if name in LONG_SCENARIOS else []
        errors = {source: [] for source in SOURCES}
        gains, torque_delays, accelerometer_delays, leaks, plain = [], [], [], [], []
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            with tempfile.TemporaryDirectory() as folder:
                truth, document, fits = one(options.gracecg, options.case, settings, spans, seed, folder, options.binary,
                                            name in FLOWN_SCENARIOS, *how)
            offset = number(truth, "offset_mm")
            if fits:
                plain.append({source: [v - 1e3*b for v, b in zip(d, offset)] for source, d in fits.items()})
            if how:
                print(f"  seed {seed}:", {**document["movement"], "in_the_end_mm": document["offset_in_the_end_mm"],
                                          "sigma_in_the_end_mm": document["sigma_in_the_end_mm"]}, flush=True)
            said = number(truth, "inertia_said")[0]
            true_gain = [said*g for g in number(truth, "rod_gain")[:3]]
            for source, solution in zip(document["sources"], document["results"]):
                error = [1e3*(solution[f"d{axis}_mm"] - b) for axis, b in zip("xyz", offset)]
                sigma = [1e3*solution[f"sigma_{axis}_mm"] for axis in "xyz"]
                mean = square(error, source["covariance_mm2"])
                errors[solution["source"]].append((error, sigma, solution["flag"], mean))
                rows.append([name, seed, solution["source"], solution["flag"], *error, *sigma])
            gains.append(max(abs(a/b - 1) for a, b in zip(document["rod_gain"], true_gain)))
            leaks += leak_squares(document, truth)
            torque_delays.append(abs(document["torque_delay_s"] - torque_delay))
            accelerometer_delays.append(abs(document["accelerometer_delay_s"] - accelerometer_delay))
        missed += report(name, errors, gains, torque_delays, accelerometer_delays, leaks)
        if plain:
            report_plain(plain)
    if options.out:
        with open(options.out, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow("scenario seed source flag error_x_um error_y_um error_z_um sigma_x_um sigma_y_um sigma_z_um".split())
            writer.writerows(rows)
    for line in missed:
        print("missed:", line)
    return 1 if missed else 0


def square(error, covariance):
    """e^T C^-1 e, e in um, C in mm^2."""
    (a, b, c), (_, d, e), (_, _, f) = [[1e6*value for value in row] for row in covariance]
    determinant = a*(d*f - e*e) - b*(b*f - c*e) + c*(b*e - c*d)
    inverse = [[d*f - e*e, c*e - b*f, b*e - c*d], [c*e - b*f, a*f - c*c, b*c - a*e], [b*e - c*d, b*c - a*e, a*d - b*b]]
    return sum(error[i]*inverse[i][k]*error[k] for i in range(3) for k in range(3))/determinant


def leak_squares(document, truth):
    """The squared errors of the leakage's elements in units of their sigmas; none where it was not estimated."""
    squares = []
    for what, unit in (("leakage", "m_s2_ma"), ("leakage_rate", "m_s_ma")):
        true = [number(truth, f"{what}_rod_{rod}") for rod in (1, 2, 3)]
        for axis, (found, sigmas) in enumerate(zip(document[f"{what}_{unit}"], document[f"{what}_sigma_{unit}"])):
            squares += [((value - true[rod][axis])/sigma)**2 for rod, (value, sigma) in enumerate(zip(found, sigmas)) if sigma > 0]
    return squares


def report(name, errors, gains, torque_delays, accelerometer_delays, leaks):
    """Prints a scenario; what misses a standard."""
    missed = []
    print(f"{name}")
    print("  source      seeds  flag 0  within 10 um  4 sigma + 3 um  rms x, y, z um       sigma x, y, z um      mean square")
    for source in SOURCES:
        found = errors[source]
        if not found:
            continue
        claims = [e for e in found if e[2] == 0]
        near = sum(max(abs(v) for v in e[0]) < 10 for e in claims)
        within = sum(all(abs(v) < 4*s + 3 for v, s in zip(e[0], e[1])) for e in found)
        rms = [math.sqrt(sum(e[0][k]**2 for e in found)/len(found)) for k in range(3)]
        sigma = [math.sqrt(sum(e[1][k]**2 for e in found)/len(found)) for k in range(3)]
        mean = sum(e[3] for e in found)/len(found)
        print(f"  {source:11} {len(found):5}  {len(claims):6}  {near:12}  {within:14}  " + " ".join(f"{v:6.2f}" for v in rms) + "  " +
              " ".join(f"{v:6.2f}" for v in sigma) + f"  {mean:8.2f}")
        if near < len(claims):
            missed.append(f"{name}, {source}: {len(claims) - near} of {len(claims)} that claim it are not within 10 um")
        if within < 0.95*len(found):
            missed.append(f"{name}, {source}: {within} of {len(found)} within 4 sigma + 3 um")
        if source == "optimal" and abs(mean - 3) > 3*math.sqrt(6/len(found)):
            missed.append(f"{name}, {source}: mean normalised square {mean:.2f}, 3 +- {math.sqrt(6/len(found)):.2f}")
    print(f"  largest error of gains {100*max(gains):.2f} %, delays: torque {1e3*max(torque_delays):.1f} ms, "
          f"accelerometer {1e3*max(accelerometer_delays):.1f} ms")
    if leaks:
        print(f"  leakage: mean normalised square {sum(leaks)/len(leaks):.2f} of {len(leaks)} elements, 1 expected")
    for what, worst, limit in (("gains", max(gains), 0.005), ("torque delay", max(torque_delays), 0.01),
                               ("accelerometer delay", max(accelerometer_delays), 0.01)):
        if worst > limit:
            missed.append(f"{name}: {what} off by {worst:.4f}, limit {limit}")
    return missed


if __name__ == "__main__":
    sys.exit(main())
