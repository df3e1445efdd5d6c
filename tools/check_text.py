#!/usr/bin/env python3
"""Checks the form of the text files.

    tools/check_text.py    prints each violation as file:line: text; status 1 if any

Fortran lines end before column 133 (a limit of the language); sources hold no tabs and no blanks at
the end of a line; nothing names a folder of the machine it was written on; every gracecg_<floor>_<room>
that a comment or a document names is a module or a symbol of the C interface.
"""
import os
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LONGEST_LINE = 132
NOT_OURS = {".git", ".venv", "build", "out", "__pycache__"}
FORTRAN = {".f90", ".F90", ".f", ".inc"}
SOURCES = FORTRAN | {".c", ".h", ".py", ".sh", ".md", ".toml", ".yml", ".nml", ""}
WITH_TABS = {"Makefile", "rules"}
# The brackets keep this line from finding itself.
MACHINE_PATH = re.compile(r"(?<![\w.-])/(?:wor[k]|hom[e]|roo[t]|tm[p]/t)/|\.\./share[d]\b")
FLOORS = ("base files environment spacecraft observations simulation estimation planning studies interface "
          "cli level1").split()
MODULE_NAME = re.compile(r"\bgracecg_(?:" + "|".join(FLOORS) + r")_[a-z0-9]\w*")


def known_names():
    """The modules and the symbols of the C headers."""
    modules = {name for top in ("src", "app", "level1/src") for path in ROOT.glob(f"{top}/**/*.f90")
               for name in re.findall(r"^(?:module|submodule \(\w+\)) (\w+)", path.read_text(), re.M)}
    return modules | set(re.findall(r"\bgracecg_\w+", "".join(path.read_text() for path in ROOT.glob("include/*.h"))))


def text_files():
    """All files but those that are built or not text."""
    for folder, folders, names in os.walk(ROOT):
        folders[:] = sorted(set(folders) - NOT_OURS)
        for path in (pathlib.Path(folder, name) for name in sorted(names)):
            content = path.read_bytes()
            if b"\0" not in content and path.name != ".git":
                yield path.relative_to(ROOT), content.decode("utf-8", errors="replace")


def violations(path, text, known):
    if path.suffix == ".md":
        # modules that the recipes of a document make
        known = known | set(re.findall(r"^module (gracecg_\w+)$", text, re.MULTILINE))
    for number, line in enumerate(text.split("\n"), 1):
        if path.suffix in FORTRAN and len(line) > LONGEST_LINE:
            yield number, f"{len(line)} characters; {LONGEST_LINE} are allowed"
        if path.suffix in SOURCES:
            if "\t" in line and path.name not in WITH_TABS:
                yield number, "a tab"
            if line != line.rstrip():
                yield number, "blanks at the end of the line"
        if found := MACHINE_PATH.search(line):
            yield number, f"names a folder of one machine: {found.group()}"
        if path.suffix in {".f90", ".md"}:
            for name in MODULE_NAME.findall(line):
                if name not in known:
                    yield number, f"no module and no symbol of the C interface: {name}"


def main():
    known = known_names()
    found = [f"{path}:{number}: {what}"
             for path, text in text_files() for number, what in violations(path, text, known)]
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
