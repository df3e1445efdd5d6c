#!/usr/bin/env python3
"""Tries the installed Python package beside numpy, scipy and scikit-learn, which bring libraries of their own for threads.

    PYTHON tools/check_wheel.py      PYTHON: of an environment that has all four

Five processes, of which some load gracecg first and some last, give the same bytes; estimates lie where their errors say.
Prints which libraries of OpenMP, BLAS and Fortran were loaded; status 1 when a process fails or its bytes differ.
"""
import subprocess
import sys

PROCESS = """
import hashlib, pathlib, re
for name in {order}:
    __import__(name)
import gracecg, numpy as np, scipy.linalg, sklearn.cluster
rows = np.random.default_rng(1).normal(size=(20000, 8))
sklearn.cluster.KMeans(8, n_init=1, random_state=1).fit(rows)       # threads of OpenMP
scipy.linalg.svd(rows[:1500])                                       # threads of OpenBLAS
case = gracecg.Case("front-3")
solution = case.simulator().observe(seed=1, run=1).estimate("optimal")
assert np.all(np.abs(solution.offset - 1e-3 * np.array([0.3, 0.4, -0.5])) < 5 * solution.sigma), solution
rms = gracecg.monte_carlo(case, "assest-fde", runs=8).rms
sums = hashlib.sha256(solution.offset.tobytes() + solution.sigma.tobytes() + rms.tobytes()).hexdigest()
maps = pathlib.Path("/proc/self/maps")
loaded = re.findall(r"\\S+/(\\S*(?:gomp|blas|gfortran)\\S*\\.so\\S*)", maps.read_text()) if maps.exists() else []
print(sums, *sorted(set(loaded)))
"""


def main():
    names = ["numpy", "scipy.linalg", "sklearn.cluster", "gracecg"]
    found = []
    for k in range(5):
        order = names[::-1] if k % 2 else names
        done = subprocess.run([sys.executable, "-c", PROCESS.format(order=order)], text=True, stdout=subprocess.PIPE)
        if done.returncode != 0:
            print(f"check_wheel: a process that loads {', '.join(order)} ended with status {done.returncode}")
            return 1
        found.append(done.stdout.split())
        print(*found[-1][:1], *found[-1][1:], sep="\n    ")
    if different := len({sums for sums, *_ in found}) - 1:
        print(f"check_wheel: {different} of five processes differ")
    return min(different, 1)


if __name__ == "__main__":
    sys.exit(main())
