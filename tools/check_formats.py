#!/usr/bin/env python3
"""What the commands print and write for programs: JSON and CSV.

    tools/check_formats.py PROGRAM      runs the commands; status 1 when something is not as it should be
    tools/check_formats.py --self-test  plants faults and sees that they are found

JSON has to be strict (RFC 8259: no NaN, no key twice), to name program, version and command, and to have a row of
numbers for each row of the CSV that the same command prints, equal digit by digit. A CSV file has its header in
the first line, as many fields in every row, no comments, and the unit of every physical quantity in the name of
its column; pandas.read_csv takes it as it is, and is asked where it is installed. Beside a file FILE.meta.json
tells of version and settings.
"""
import csv
import io
import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import pandas
except ImportError:
    pandas = None

PLACE = ["--position", "6837865", "0", "0"]
DATE = ["--date", "1989-01-02T00:00:00"]
# Command, and members that its JSON has beside those of every command.
COMMANDS = [
    (["cases"], []),
    (["estimate", "run1", "--algorithm", "assest-fde"], ["case", "observations", "epoch_utc", "covariance", "parameters"]),
    (["estimate", "run1", "--algorithm", "assest-rde", "--verbose"], ["covariance", "history"]),
    (["estimate", "run1", "--algorithm", "ascfest"], ["covariance"]),
    (["estimate", "run1", "--algorithm", "ascrest", "--verbose"], ["covariance", "history"]),
    (["estimate", "run1", "--algorithm", "optimal", "--verbose"], ["covariance", "parameters", "noise", "history"]),
    (["estimate", "run1", "--algorithm", "sequential", "--verbose"], ["covariance", "parameters", "noise", "history"]),
    (["bound", "front-1", "back-3"], ["cases"]),
    (["errors", "--runs", "2"], ["case", "algorithm", "seed"]),
    (["reliability", "front-3", "--only", "quaternions", "--runs", "1"], ["algorithms", "seed"]),
    (["magnetometer-loss", "--runs", "2"], ["seed", "field_error_nt"]),
    (["timing", "--step", "300"], ["satellite", "epoch_utc", "cases", "best_places"]),
    (["design", "--manoeuvre", "front-1"], ["case", "rods", "limits", "map"]),
    (["montecarlo", "--cases", "front-3", "--runs", "2"], ["seed", "runs", "cases", "agreement"]),
    (["merge", "runs.csv"], ["seed", "runs", "cases", "agreement"]),
    (["verify", "front-1", "back-2"], []),
    (["trim", "front-3", "--threshold-mm", "0.1"], ["case", "algorithm", "seed", "threshold_mm"]),
    (["trim", "front-3", "--runs", "2"], ["case", "algorithm", "seed", "runs"]),
    (["model", "gravity", *PLACE], []),
    (["model", "field", *DATE, *PLACE], []),
    (["model", "density", *DATE, *PLACE], []),
    (["model", "wind", *DATE, *PLACE], ["note"]),
    (["model", "sun", *DATE], []),
]
# Files that commands write.
WRITERS = [
    (["simulate", "front-3", "--out", "run1"], ["run1/truth.csv", "run1/accelerometer.csv", "run1/star_camera.csv",
                                                "run1/magnetometer.csv", "run1/orbit.csv"]),
    (["estimate", "run1", "--algorithm", "sequential", "--running", "growth.csv", "--report", "page.html"],
     ["growth.csv", "page_files/residuals.csv", "page_files/spectrum.csv", "page_files/manoeuvre.csv"]),
    (["montecarlo", "--cases", "front-3", "--runs", "3", "--out", "table.csv", "--runs-out", "runs.csv"],
     ["table.csv", "runs.csv"]),
    (["merge", "runs.csv", "--out", "merged.csv"], ["merged.csv"]),
    (["errors", "--runs", "2", "--out", "errors.csv"], ["errors.csv"]),
    (["magnetometer-loss", "--runs", "2", "--out", "loss.csv"], ["loss.csv"]),
    (["timing", "--step", "300", "--out", "timing.csv"], ["timing.csv"]),
    (["trim", "front-3", "--threshold-mm", "0.1", "--out", "trim.csv"], ["trim.csv"]),
    (["design", "--manoeuvre", "front-1", "--step", "1200", "--map", "map.csv"], ["map.csv"]),
    (["verify", "front-1", "--out", "curves"], ["curves/verify_front-1.csv"]),
]
ENDINGS = ("_mm", "_s", "_deg", "_nt", "_tesla", "_m", "_m_s", "_m_s2", "_m_s3", "_m2_s2", "_rad_s", "_rad_s2", "_rad",
           "_deg_s", "_hz", "_n_m", "_a_m2", "_m_s2_sqrt_hz", "_kg_m3", "_kelvin", "_per_m3", "_km", "_h", "_au", "_arcsec",
           "_sfu")
# Columns of words, of numbers that count, and of pure numbers.
WITHOUT_UNIT = {"case", "satellite", "epoch_utc", "utc", "algorithm", "axis", "source", "magnetometer", "converged", "normalised", "iterations",
                "condition", "runs", "run", "camera", "q1", "q2", "q3", "q4", "sigma_q1", "sigma_q2", "sigma_q3", "sigma_q4",
                "worst_x", "worst_y", "worst_z", "variance_factor", "edited_accelerometer", "edited_star_camera", "stars",
                "unit", "least", "greatest", "mean", "low", "high", "on_ticks",
                "attitude_only", "near_centre", "excess", "centre_difference", "round", "day", "kp", "figure", "quantity", "inside", "fill", "place",
                "contradicted", "belief", "size", "detectable_values", "refused", "own_test", "own_test_stated", "named", "silently_wrong", "worst_sigmas",
                "action", "trim_axes", "trim", "harmful_trim"}


class Wrong(Exception):
    """Something is not as it should be."""


def no_constant(name):
    raise Wrong(f"JSON has {name}")


def no_twins(pairs):
    names = [name for name, _ in pairs]
    if len(names) != len(set(names)):
        raise Wrong(f"JSON has a key twice in {names}")
    return dict(pairs)


def numbers_as_text(text):
    """The document with its numbers as they are written."""
    return json.loads(text, parse_float=str, parse_int=str, parse_constant=no_constant, object_pairs_hook=no_twins)


def check_table(text, name):
    """A CSV text: its rows, each by column."""
    lines = text.splitlines()
    if not text.endswith("\n") or "#" in text:
        raise Wrong(f"{name}: a comment, or a last line without its end")
    rows = list(csv.reader(io.StringIO(text), strict=True))
    if len(rows) < 2 or len(rows) != len(lines):
        raise Wrong(f"{name}: {len(rows)} rows of {len(lines)} lines")
    header = rows[0]
    if len(header) != len(set(header)):
        raise Wrong(f"{name}: a column twice in {header}")
    for column in header:
        if column not in WITHOUT_UNIT and not column.endswith(ENDINGS):
            raise Wrong(f"{name}: the column {column} does not tell its unit")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(header):
            raise Wrong(f"{name}:{number}: {len(row)} fields, expected {len(header)}")
    found = [dict(zip(header, row)) for row in rows[1:]]
    for column in header:
        if column == "converged":
            if not {row[column] for row in found} <= {"true", "false"}:
                raise Wrong(f"{name}: converged is neither true nor false")
        elif column.endswith(ENDINGS):
            for row in found:
                if row[column] != "":
                    float(row[column])
    if pandas is not None:
        frame = pandas.read_csv(io.StringIO(text))
        if list(frame.columns) != header or len(frame) != len(found):
            raise Wrong(f"{name}: pandas reads it otherwise")
        for column in header:
            if column.endswith(ENDINGS) and frame[column].dtype == object:
                raise Wrong(f"{name}: pandas takes the column {column} for texts")
    return found


def as_field(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value


def check_json(text, words, members, table):
    """The JSON of a command against what every command has, and against its CSV."""
    document = numbers_as_text(text)
    command = " ".join(words[:2] if words[0] == "model" else words[:1])
    for member, expected in (("program", "gracecg"), ("command", command)):
        if document.get(member) != expected:
            raise Wrong(f"{command}: {member} is {document.get(member)!r}")
    for member in ["version", "results", "results_units", "warnings", *members]:
        if member not in document:
            raise Wrong(f"{command}: the member {member} is missing")
    rows = document["results"]
    if len(rows) != len(table):
        raise Wrong(f"{command}: {len(rows)} rows of JSON, {len(table)} of CSV")
    for one, other in zip(rows, table):
        if {name: as_field(value) for name, value in one.items()} != other:
            raise Wrong(f"{command}: JSON has {one}, CSV {other}")
    for column in table[0]:
        if column.endswith(ENDINGS) and column not in document["results_units"]:
            raise Wrong(f"{command}: no unit of {column}")
    if "covariance" in document:
        check_covariance(document, rows[0], command)


def check_covariance(document, row, command):
    """It is symmetric, and its first diagonal elements are the squares of the sigmas."""
    names, matrix = document["covariance"]["names"], document["covariance"]["matrix"]
    matrix = [[float(value) for value in line] for line in matrix]
    if len(names) != 15 or len(matrix) != 15 or {len(line) for line in matrix} != {15}:
        raise Wrong(f"{command}: the covariance is not 15 x 15")
    for place, axis in enumerate("xyz"):
        sigma = 1e3 * matrix[place][place]**0.5
        if abs(sigma / float(row[f"sigma_{axis}_mm"]) - 1) > 1e-9:
            raise Wrong(f"{command}: sigma_{axis}_mm is not that of the covariance")
    for i in range(15):
        for k in range(i):
            if abs(matrix[i][k] - matrix[k][i]) > 1e-9 * (matrix[i][i] * matrix[k][k])**0.5:
                raise Wrong(f"{command}: the covariance is not symmetric")


def check_side_file(path):
    """FILE.meta.json, where there is one."""
    side = path.with_name(path.name + ".meta.json")
    if not side.exists():
        return False
    about = numbers_as_text(side.read_text())
    if about["program"] != "gracecg" or about["file"] != path.name or not about["about"] or not about["command_line"] or \
            "input_hashes" not in about:
        raise Wrong(f"{side.name} does not tell of {path.name}")
    return True


def run(program, words, folder):
    ended = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        raise Wrong(f"{' '.join(words)}: {ended.stderr}")
    return ended.stdout


def check_all(program):
    with tempfile.TemporaryDirectory(prefix="gracecg-formats-") as name:
        folder, told = pathlib.Path(name), 0
        for words, files in WRITERS:
            run(program, words, folder)
            for file in files:
                check_table((folder / file).read_text(), file)
                told += check_side_file(folder / file)
        if told < 8:
            raise Wrong(f"only {told} files have a .meta.json beside them")
        for words, members in COMMANDS:
            table = check_table(run(program, [*words, "--format", "csv"], folder), " ".join(words))
            check_json(run(program, [*words, "--format", "json"], folder), words, members, table)
    print(f"{len(COMMANDS)} commands, {sum(len(files) for _, files in WRITERS)} files"
          f"{'' if pandas else ' (pandas is not installed: read by the csv module alone)'}")


def self_test():
    good = "case,dx_mm,converged\nfront-1,0.5,true\n"
    table = check_table(good, "good")
    document = {"program": "gracecg", "version": "1", "command": "x", "results": [{"case": "front-1", "dx_mm": 0.5, "converged": True}],
                "results_units": {"dx_mm": "mm"}, "warnings": []}
    check_json(json.dumps(document), ["x"], [], table)
    faults = [lambda: check_table("# seed 1\n" + good, "t"), lambda: check_table(good[:-1], "t"),
              lambda: check_table(good.replace("dx_mm", "dx"), "t"), lambda: check_table(good.replace("true", "T"), "t"),
              lambda: check_table(good + "front-1,0.5\n", "t"), lambda: check_table(good.replace("dx_mm", "case"), "t"),
              lambda: check_json(json.dumps({**document, "results_units": {}}), ["x"], [], table),
              lambda: check_json(json.dumps({**document, "command": "y"}), ["x"], [], table),
              lambda: check_json(json.dumps(document), ["x"], ["seed"], table),
              lambda: check_json(json.dumps(document).replace("0.5", "0.25"), ["x"], [], table),
              lambda: check_json(json.dumps(document).replace("0.5", "NaN"), ["x"], [], table),
              lambda: check_json(json.dumps(document).replace('"version"', '"program"'), ["x"], [], table)]
    for number, fault in enumerate(faults, 1):
        try:
            fault()
        except (Wrong, ValueError):
            continue
        sys.exit(f"check_formats: fault {number} was not found")
    print(f"{len(faults)} faults found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
    elif len(sys.argv) == 2:
        try:
            check_all(str(pathlib.Path(sys.argv[1]).resolve()))
        except Wrong as wrong:
            sys.exit(f"check_formats: {wrong}")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
