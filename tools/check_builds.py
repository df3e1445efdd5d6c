#!/usr/bin/env python3
"""The numbers of builds for different processors agree.

    tools/check_builds.py FPM PROGRAM           PROGRAM (that of `make build`) against plain fpm's release build, for any
                                                processor of its kind, which FPM builds where it is not there
    tools/check_builds.py --compute PROGRAM FOLDER
                                                leaves in FOLDER what is compared (tools/compilers.sh takes it, too)
    tools/check_builds.py --self-test

Compared number by number, relative to the greatest of its column and vector (tools/compare_numbers.py): the curves of
`verify`, the bounds, the files of simulated runs, the estimates by all algorithms from one and the same files, and a
campaign. Status 1 when a difference is above its limit of LIMITS, or files or words differ.
"""
import pathlib
import subprocess
import sys
import tempfile

import compare_numbers

ALGORITHMS = ("assest-fde", "assest-rde", "ascfest", "ascrest", "optimal", "sequential")
CASES = ("front-1", "front-2", "front-3", "back-1", "back-2", "back-3")
ROUNDING = 1e-12
# Sines, exponentials and logarithms of many numbers at once are the C library's for the width of the vectors, and differ in
# their last bit. Of such a rounding of the observations ASSEST, of the partials `optimal`, whose normal equations have a
# condition of 4e7, make 1e-9, less than 1e-9 sigma.
AMPLIFIED = 1e-9
UNDETECTED = {"undetected_#_mm": compare_numbers.LOOSE["undetected_#_mm"]}
# What is compared, its files, the limit, and columns with another, for the reasons given in tools/compare_numbers.py.
LIMITS = (("curves", "verify*/verify_*.csv", ROUNDING, {}), ("bounds", "bound_*.csv", ROUNDING, {}),
          ("simulations", "run_*/*.csv", ROUNDING, {}), ("estimates, report", "estimate_*_as*.csv", ROUNDING, UNDETECTED),
          ("estimates, sequential", "estimate_*_sequential.csv", ROUNDING, UNDETECTED),
          ("estimates, optimal", "estimate_*_optimal.csv", AMPLIFIED, compare_numbers.LOOSE),
          ("campaign", "campaign*.csv", AMPLIFIED, {}))


def compute(program, folder, runs=None):
    """What is compared, in a new folder; the estimates from the simulated runs of another one if it is named."""
    folder.mkdir(parents=True)

    def gracecg(*words, to=None):
        with open(folder / to if to else "/dev/null", "w", encoding="utf-8") as output:
            subprocess.run([str(program), *map(str, words)], cwd=folder, stdin=subprocess.DEVNULL, stdout=output,
                           stderr=subprocess.DEVNULL, check=True)

    gracecg("verify", "--out", "verify", to="verify.txt")
    for case in CASES:
        gracecg("bound", case, "--format", "csv", to=f"bound_{case}.csv")
        gracecg("simulate", case, "--out", f"run_{case}", "--seed", "77")
        for algorithm in ALGORITHMS:
            gracecg("estimate", (runs or folder) / f"run_{case}", "--algorithm", algorithm, "--format", "csv",
                    to=f"estimate_{case}_{algorithm}.csv")
    gracecg("montecarlo", "--runs", "15", "--out", "campaign.csv", "--runs-out", "campaign_runs.csv")


def failures(one, other, limits=LIMITS):
    """Prints the greatest difference of each kind; the kinds with one above the limit, in words."""
    for what, pattern, limit, others in limits:
        worst = compare_numbers.worst_differences(pattern, one, other)
        column = max((name for name in worst if name not in others), key=worst.get)
        print(f"{what}: {worst[column]:.1e} ({column or 'files or words'})")
        for name, value in worst.items():
            if not value <= others.get(name, limit):
                yield f"{what}: {name or 'files or words'} by {value:.1e}, limit {others.get(name, limit)}"


def self_test():
    """What the check itself gets wrong."""
    with tempfile.TemporaryDirectory() as name:
        one, other = pathlib.Path(name) / "one", pathlib.Path(name) / "other"
        one.mkdir()
        other.mkdir()
        text = "case,dx_mm,dy_mm\na,1.0,{}\n"
        limits = (("these", "x*.csv", ROUNDING, {}),)
        (one / "x1.csv").write_text(text.format("0.5"), encoding="utf-8")
        for other_text, fine in ((text.format("0.5"), True), (text.format("0.5000000000005"), True),
                                 (text.format("0.500000000002"), False), (text.format("NaN"), False),
                                 (text.format("0.5").replace("a,", "b,"), False), (text.format("0.5") + "a,1.0,1.0\n", False)):
            (other / "x1.csv").write_text(other_text, encoding="utf-8")
            if bool(list(failures(one, other, limits))) == fine:
                yield f"{other_text!r} is found {'different' if fine else 'alike'}"
        (other / "x1.csv").unlink()
        if not list(failures(one, other, limits)):
            yield "a file that is missing passes"
        if not list(failures(one, other, (("those", "y*.csv", 1.0, {}),))):
            yield "nothing to compare passes"


def main():
    words = sys.argv[1:]
    if words == ["--self-test"]:
        found = list(self_test())
    elif words[:1] == ["--compute"] and len(words) == 3:
        compute(pathlib.Path(words[1]).resolve(), pathlib.Path(words[2]).resolve())
        return 0
    elif len(words) == 2:
        root = pathlib.Path(__file__).resolve().parent.parent
        said = subprocess.run([words[0], "run", "--profile", "release", "--runner", "echo"], cwd=root, text=True,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, check=True)
        portable = root / said.stdout.splitlines()[-1].strip()
        with tempfile.TemporaryDirectory() as name:
            one, other = pathlib.Path(name) / "portable", pathlib.Path(name) / "this"
            compute(portable, one)
            compute(pathlib.Path(words[1]).resolve(), other, one)
            found = list(failures(one, other))
    else:
        sys.exit(__doc__)
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
