#!/usr/bin/env python3
"""Checks that the interfaces to C and Fortran 77 are what their table says.

    tools/check_interface.py    prints each difference; status 1 if any

- What tools/interface.py makes of tools/interface.txt is up to date.
- The headers compile as C99 and C++11; so does example/version_1/version_1.c, a program of the interface's version 1.
- The numbers of the status, the size of a message and the version of the interface are those of the headers.
- The Fortran chapter of docs/api.md against src/gracecg.f90 and level1/src/gracecg_level1.f90: every public name stands there.
"""
import pathlib
import re
import subprocess
import sys

import interface

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCES = (ROOT / "include/gracecg.h", ROOT / "include/gracecg_level1.h", ROOT / "example/version_1/version_1.c")
UMBRELLAS = (ROOT / "src/gracecg.f90", ROOT / "level1/src/gracecg_level1.f90")


def check_made():
    for path, text in interface.generate():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            yield f"{path.relative_to(ROOT)} is out of date: tools/interface.py"


def check_headers():
    for source in SOURCES:
        for compiler, language, standard in (("gcc", "c", "c99"), ("g++", "c++", "c++11")):
            done = subprocess.run([compiler, f"-std={standard}", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only",
                                   f"-I{ROOT / 'include'}", "-x", language, str(source)],
                                  capture_output=True, text=True, check=False)
            if done.returncode:
                yield f"{source.name} as {standard}: {done.stderr}"


def check_constants():
    header = SOURCES[0].read_text(encoding="utf-8")
    outcome, general = ((ROOT / f"src/interface/{name}.f90").read_text(encoding="utf-8") for name in ("outcome", "general"))
    if dict(re.findall(r"GRACECG_([A-Z_]*[A-Z]) = (\d+)", header)) != dict(re.findall(r"STATUS_(\w+) = (\d+)", outcome)):
        yield "the numbers of the status differ"
    for name, constant, text in (("MESSAGE_SIZE", "MESSAGE_SIZE", outcome), ("INTERFACE_VERSION", "INTERFACE_VERSION", general)):
        size = re.search(rf"#define GRACECG_{name} (\d+)", header).group(1)
        if size != re.search(rf"{constant} = (\d+)", text).group(1):
            yield f"GRACECG_{name} differs"


def check_chapters():
    text = (ROOT / "docs/api.md").read_text(encoding="utf-8")
    chapter = re.search(r"^## Fortran\n(.*?)(?=^## |\Z)", text, flags=re.M | re.S).group(1)
    for umbrella in UMBRELLAS:
        public = re.findall(r"^    public :: (.*)$", umbrella.read_text(encoding="utf-8"), flags=re.M)
        for name in re.findall(r"\w+", " ".join(public)):
            if f"`{name}`" not in chapter:
                yield f"{name} is public in {umbrella.stem}, but not in the Fortran chapter of docs/api.md"


def main():
    found = [*check_made(), *check_headers(), *check_constants(), *check_chapters()]
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
