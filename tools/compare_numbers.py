#!/usr/bin/env python3
"""Compares the numbers of CSV files in two folders.

    tools/compare_numbers.py [--limit RELATIVE] --parts PATTERN... FOLDER FOLDER

For every pattern the greatest relative difference over all files that match: of a number, relative to the greatest
of its column (the three axes of a vector count as one column, the four numbers of a quaternion, too), so that a component near zero is measured by its
vector. Printed in one line, with " | " between. What is no number must be equal. Status 1 when a difference is above
the limit (1e-9; those of LOOSE are wider, for their reasons), or files or texts differ.
"""
import argparse
import pathlib
import re
import sys

# Columns that rounding moves by more, with the limit.
LOOSE = {
    # The offset of ASSEST: x of front 2 is hardly seen (a sigma of 1.3 mm), and the attitude fit's sums round.
    "d#_mm": 5e-9,
    # The sigma of the drift by `optimal`, of normal equations of condition 4e7, of which a rounding of 2.2e-16 makes 9e-9.
    "sigma_alpha_#_m_s3": 5e-9,
    # The effect of beliefs that no test sees: of their information as little as 1e-10 is left when the parameters have
    # taken theirs; rounding of 1e-15 of the whole is 1e-5 of that, times what there are of roundings. OpenBLAS alone, told to take
    # the kernels of another processor (OPENBLAS_CORETYPE), moves it by 4.2e-4, another build of ours by 7.6e-5.
    "undetected_#_mm": 5e-4}
UNSEEN = ("condition", "iterations")     # counts, and a number of which the size is of interest


def table(path):
    """Header and rows of a CSV file without its comments."""
    lines = [line.split(",") for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return lines[0], lines[1:]


def number(text):
    try:
        return float(text)
    except ValueError:
        return None


def difference(one, other):
    """The greatest relative difference of each column of two files; infinite when they cannot be compared."""
    (header, rows), (header2, rows2) = table(one), table(other)
    if header != header2 or len(rows) != len(rows2):
        return {"": float("inf")}
    groups = {}
    for column, name in enumerate(header):
        vector = re.sub(r"(^|_)([a-z]*)[xyz]($|_)", r"\1\2#\3", re.sub(r"^(sigma_)?q[1-4]$", r"\1q#", name))
        groups.setdefault(vector, []).append(column)
    worst = {}
    for name, columns in groups.items():
        largest = [0.0, 0.0]
        for row, row2 in zip(rows, rows2):
            for column in columns:
                a, b = number(row[column]), number(row2[column])
                if a is None or b is None or a != a or b != b:
                    if row[column] != row2[column]:
                        return {"": float("inf")}
                    continue
                largest = [max(largest[0], abs(a - b)), max(largest[1], abs(a))]
        if largest[0] > 0 and name not in UNSEEN:
            worst[name] = largest[0] / largest[1] if largest[1] else float("inf")
    return worst


def worst_differences(pattern, one, other):
    """The greatest of each column over all files of a pattern; that of "" is infinite where they cannot be compared."""
    names = sorted(str(path.relative_to(one)) for path in one.glob(pattern))
    worst = {"": 0.0 if names else float("inf")}
    for name in names:
        found = difference(one / name, other / name) if (other / name).exists() else {"": float("inf")}
        for column, value in found.items():
            worst[column] = max(worst.get(column, 0.0), value)
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--limit", type=float, default=1e-9)
    parser.add_argument("--parts", nargs="+", required=True)
    arguments = parser.parse_args()
    *patterns, one, other = arguments.parts
    one, other = pathlib.Path(one), pathlib.Path(other)
    words, fine = [], True
    for pattern in patterns:
        worst = worst_differences(pattern, one, other)
        fine = fine and all(value <= LOOSE.get(column, arguments.limit) for column, value in worst.items())
        loose = {re.sub("_?#.*", "", column): value for column, value in worst.items() if column in LOOSE}
        strict = max(value for column, value in worst.items() if column not in LOOSE)
        words.append(", ".join([f"{strict:.1e}" if strict else "0",
                                *(f"{name} {value:.1e}" for name, value in loose.items() if value)]))
    print(" | ".join(words))
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
