#!/usr/bin/env python3
"""How fast pandas reads the day of ACC1A that bench/level1_reading.f90 has made.

    bench/level1_pandas.py [FOLDER]     needs pandas; the best of three, by its C parser

The columns must be alike in all records, which prod_flag does not promise.
"""
import pathlib
import sys
import time

import pandas

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/level1-bench")
path = folder / "ACC1A_2020-02-01_C_04.txt"
with path.open(encoding="ascii") as lines:
    header = next(i for i, line in enumerate(lines, 1) if line.startswith("# End of YAML header"))
best, processor = float("inf"), float("inf")
for _ in range(3):
    start, used = time.perf_counter(), time.process_time()
    table = pandas.read_csv(path, sep=r"\s+", skiprows=header, header=None, dtype={4: str, 5: str})
    best = min(best, time.perf_counter() - start)
    processor = min(processor, time.process_time() - used)
print(f"pandas {pandas.__version__}: {best:.3f} s, {len(table) / best:.3g} records/s, of the processor {processor:.3f} s, "
      f"{len(table) / processor:.3g} records/s, sum of lin_accl_x {table[6].sum():.2e}")
