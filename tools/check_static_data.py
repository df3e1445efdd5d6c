#!/usr/bin/env python3
"""Checks that the compiled library keeps no state that threads would share.

    tools/check_static_data.py [ARCHIVE...]    prints each finding; status 1 if any

The archives are the libraries as they are installed, without the program; by default they are made in build/library
(tools/install.sh --library). No module may have a writable variable but for the few that are known here.
And nothing may call a function that returns a text of deferred length (character(:), allocatable): gfortran
keeps that length in static memory. The commands may: only one thread runs them.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
WRITABLE = "bBdDC"
COMPILERS_OWN = re.compile(r"__(?:vtab|def_init|vtype|copy|final)_")
# The table of handles, which is guarded; constant texts; indices of constant arrays.
KNOWN = {"gracecg_interface_handles": {"slots", "nothing", "last_slot", "alive"},
         "gracecg_interface_general": {"algorithm_names", "builtin_cases", "status_names", "version_text", "k"},
         "gracecg_base_coloured_noise": {"i_pole"}, "gracecg_files_run_record": {"files", "command", "commit"},     # kept by the program alone
         "gracecg_observations_parameters": {"i_row", "i_member"}, "gracecg_base_runge_kutta": {"node"}}


def findings(archive):
    names = subprocess.run(["nm", str(archive)], capture_output=True, text=True, check=True).stdout
    source = archive.name
    for line in filter(None, names.splitlines()):
        if line.endswith(".o:"):
            source = line[:-1]
            continue
        kind, symbol = line.split()[-2:]
        if kind not in WRITABLE or COMPILERS_OWN.search(symbol):
            continue
        if match := re.match(r"__(\w+)_MOD_(\w+)$", symbol):
            module, variable = match.groups()
            if variable not in KNOWN.get(module, ()):
                yield f"{source}: module variable {variable}"
        elif symbol.startswith("slen."):
            yield f"{source}: the length of a text that a function returns, {symbol}"


def main():
    if sys.argv[1:]:
        archives = [pathlib.Path(word) for word in sys.argv[1:]]
    else:
        subprocess.run([ROOT / "tools/install.sh", "--library"], check=True)
        archives = [ROOT / f"build/library/lib{name}.a" for name in ("gracecg", "gracecg_level1")]
    # The tests with several threads must not share such a length themselves.
    tests = sorted(ROOT.glob("build/gfortran_*/gracecg/test_interface_test_threads.f90.o"),
                   key=lambda a: a.stat().st_mtime)
    found = [line for objects in [*archives, *tests[-1:]] for line in findings(objects)]
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
