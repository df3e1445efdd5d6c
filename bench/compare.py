#!/usr/bin/env python3
"""Two builds of bench/benchmark.f90 in turn, line by line: the times of both and their ratio.

    bench/compare.py [--rounds N] [--limit RATIO] [--markdown] OLD NEW

OLD and NEW are the programs (build/gfortran_.../example/benchmark after `fpm build --profile release`). A round runs each
once, the order changing from round to round; of every line the shortest time of all rounds counts, so that a machine that
others use hardly enters. A line of OLD alone is named without a ratio. Status 1 when a line takes more than the limit
(1.3) times as long in NEW as in OLD, or stands in NEW no more.
"""
import argparse
import re
import subprocess
import sys

TIME = re.compile(r"^\s*(.+?)\s+([\d.]+) (microseconds|milliseconds)$")
RATE = re.compile(r"^\s*(.+?)\s+([\d.]+) runs per second\b")
SECONDS = {"microseconds": 1e-6, "milliseconds": 1e-3}


def times(text):
    """Seconds by line; of what is given as a rate, those of one run."""
    found = {}
    for line in text.splitlines():
        if match := TIME.match(line):
            found[match[1]] = float(match[2]) * SECONDS[match[3]]
        elif match := RATE.match(line):
            found[match[1] + ", a run"] = 1 / float(match[2])
    return found


def shortest(programs, rounds):
    """The shortest times of each program, by line."""
    best = [{} for _ in programs]
    for k in range(rounds):
        order = range(len(programs)) if k % 2 == 0 else reversed(range(len(programs)))
        for i in order:
            said = subprocess.run([programs[i]], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, check=True)
            for name, seconds in times(said.stdout).items():
                best[i][name] = min(seconds, best[i].get(name, seconds))
        print(f"round {k + 1} of {rounds}", file=sys.stderr, flush=True)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--limit", type=float, default=1.3)
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("programs", nargs=2, metavar="PROGRAM")
    arguments = parser.parse_args()
    old, new = shortest(arguments.programs, arguments.rounds)
    if not old or not new:
        sys.exit("compare: no line of a benchmark was printed")
    row = "| {} | {} | {} | {} |" if arguments.markdown else "{:46} {:>10} {:>10} {:>7}"
    print(row.format("microseconds", "old", "new", "ratio"))
    if arguments.markdown:
        print(row.format("---", "--:", "--:", "--:"))
    slow = []
    for name in [*old, *(name for name in new if name not in old)]:
        values = [f"{best[name] * 1e6:.3f}" if name in best else "" for best in (old, new)]
        ratio = new[name] / old[name] if name in old and name in new else None
        print(row.format(name, *values, "" if ratio is None else f"{ratio:.2f}"))
        if name in old and (ratio is None or ratio > arguments.limit):
            slow.append(name)
    if slow:
        print(f"above {arguments.limit} times, or gone: {'; '.join(slow)}")
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
