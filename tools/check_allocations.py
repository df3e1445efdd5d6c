#!/usr/bin/env python3
"""Checks that a call of the force model takes nothing from the heap.

    tools/check_allocations.py FPM [VALGRIND]    status 1 when it does

Valgrind counts the allocations of a program that calls it 1000 and 3000 times: they must be as many.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
CALLS = (1000, 3000)


def allocations(fpm, valgrind, calls):
    """How many allocations the program makes in all."""
    with tempfile.NamedTemporaryFile(suffix=".log") as log:
        subprocess.run([fpm, "run", "--example", "force_model", "--profile", "release", "--runner",
                        f"{valgrind} --error-exitcode=9 --log-file={log.name}", "--", str(calls)],
                       cwd=ROOT, check=True)
        text = pathlib.Path(log.name).read_text(encoding="utf-8")
    return int(re.search(r"total heap usage: ([\d,]+) allocs", text).group(1).replace(",", ""))


def main():
    fpm = sys.argv[1] if len(sys.argv) > 1 else "fpm"
    valgrind = sys.argv[2] if len(sys.argv) > 2 else "valgrind"
    counts = [allocations(fpm, valgrind, calls) for calls in CALLS]
    for calls, count in zip(CALLS, counts):
        print(f"{calls} calls: {count} allocations")
    return 0 if counts[0] == counts[1] else 1


if __name__ == "__main__":
    sys.exit(main())
