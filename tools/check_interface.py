#!/usr/bin/env python3
"""Checks that the interfaces to C and Fortran 77 are what their documents say.

    tools/check_interface.py    prints each difference; status 1 if any

- include/gracecg.h against the bind(C) procedures of src/interface, and include/gracecg_level1.h
  against those of level1/src/interface: the same functions, with arguments of the same types in the
  same order; the same fields of the structures and the same numbers of the status. The headers are
  compiled as C99 and C++11.
- The table of docs/api.md against the two f77.f90: the same routines, the same arguments, and what
  the table shows in bold is what the routine sets.
- The Fortran chapter of docs/api.md against src/gracecg.f90 and level1/src/gracecg_level1.f90: every
  public name stands there. Its C chapter against the headers: every function stands there.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
HEADERS = {ROOT / "include/gracecg.h": ROOT / "src/interface",
           ROOT / "include/gracecg_level1.h": ROOT / "level1/src/interface"}
TABLE = ROOT / "docs/api.md"
UMBRELLAS = (ROOT / "src/gracecg.f90", ROOT / "level1/src/gracecg_level1.f90")
STRUCTURES = {"gracecg_error": "c_error_t", "gracecg_utc": "c_utc_t",
              "gracecg_samples": "c_samples_t", "gracecg_solution": "c_solution_t", "gracecg_beliefs": "c_beliefs_t",
              "gracecg_bound": "c_bound_t", "gracecg_joint": "c_joint_t", "gracecg_fit_tests": "c_fit_tests_t",
              "gracecg_level1_offset": "c_level1_offset_t", "gracecg_rod": "c_rod_t",
              "gracecg_design_settings": "c_design_settings_t", "gracecg_design": "c_design_t"}
C_TYPES = {"double": "real(c_double)", "int32_t": "integer(c_int32_t)",
           "size_t": "integer(c_size_t)", "char": "character(kind=c_char)",
           "gracecg_status": "integer(c_int)"}
RESULTS = {"gracecg_status": "integer(c_int)", "int32_t": "integer(c_int32_t)",
           "const char *": "type(c_ptr)"}


def header_text(headers=tuple(HEADERS)):
    text = "".join(re.sub(r"/\*.*?\*/", "", header.read_text(encoding="utf-8"), flags=re.S) for header in headers)
    return re.sub(r"^\s*#.*$", "", text, flags=re.M)


def c_argument(text):
    """(Fortran type, how it is passed) of an argument in C."""
    const, kind, stars, array = re.match(
        r"(const )?([\w ]+?)\s*(\**)\s*\w+(\[\w*\])?$", text).groups()
    if kind in STRUCTURES:
        return f"type({STRUCTURES[kind]})", "in" if const else "inout"
    if kind in C_TYPES:
        if not stars and not array:
            return C_TYPES[kind], "value"
        return C_TYPES[kind], "in" if const else "inout"
    return "integer(c_intptr_t)", "value" if len(stars) == 1 else "inout"     # a handle


def c_functions(*headers):
    """Of each function of headers: result and arguments."""
    pattern = r"(?:^|\n)\s*(gracecg_status|const char \*|int32_t)\s*(gracecg_\w+)\(([^)]*)\);"
    for result, name, text in re.findall(pattern, header_text(headers)):
        arguments = [] if text.strip() in ("", "void") else " ".join(text.split()).split(", ")
        yield name, (RESULTS[result], [c_argument(a) for a in arguments])


def fortran_sources(*folders):
    for path in sorted(path for folder in folders or HEADERS.values() for path in folder.glob("c_*.f90")):
        yield re.sub(r"&\n\s*", "", re.sub(r"!.*", "", path.read_text(encoding="utf-8")))


def names_of(text):
    return re.findall(r"(\w+)(?:\([^)]*\))?(?:\s*,\s*|$)", text.strip())


def declarations(body):
    """Type and way of passing of each declared name."""
    found = {}
    for kind, attributes, names in re.findall(
            r"^\s*([a-z]+\([\w=*]+\))((?:, [a-z() ]+)*) :: (.*)$", body, flags=re.M):
        way = "value" if "value" in attributes else \
            "inout" if "inout" in attributes else "in"
        if way != "value" and "intent" in attributes and "optional" not in attributes:
            way = "not optional"
        found.update({name: (kind, way) for name in names_of(names)})
    return found


def fortran_functions(folder):
    pattern = r"^[ ]*([\w()]+ )?function \w+\(([^)]*)\)\s*result\((\w+)\)\s*bind\(c, name='(\w+)'\)" \
              r"(.*?)^\s*end function"
    for text in fortran_sources(folder):
        for kind, arguments, result, name, body in re.findall(pattern, text, flags=re.M | re.S):
            declared = declarations(body)
            result_type = kind.strip() or declared[result][0]
            yield name, (result_type, [declared[a] for a in names_of(arguments)])


def structure_fields():
    """Of each structure the fields in order, in C and in Fortran."""
    in_c = {name: re.findall(r"(\*?)(\w+)(?:\[\w+\])*;", body) for body, name in
            re.findall(r"typedef struct \w+ \{(.*?)\} (\w+);", header_text(), flags=re.S)}
    fortran = "\n".join(fortran_sources())
    for c_name, name in STRUCTURES.items():
        body = re.search(rf"type, bind\(c\) :: {name}\n(.*?)end type", fortran, flags=re.S).group(1)
        fields = [f for line in re.findall(r"::(.*)", body) for f in names_of(line)]
        yield c_name, [field for _, field in in_c[c_name]], fields


def check_functions(header, in_c, in_fortran):
    if not in_c or not in_fortran:
        yield f"{header.name}: no functions were found"
    for name in sorted(in_c.keys() | in_fortran.keys()):
        if name not in in_fortran:
            yield f"{name} stands in {header.name} only"
        elif name not in in_c:
            yield f"{name} stands in Fortran, but not in {header.name}"
        elif in_c[name] != in_fortran[name]:
            yield f"{name}: {header.name} has {in_c[name]}, Fortran {in_fortran[name]}"
    for language, standard in (("c", "c99"), ("c++", "c++11")):
        compiler = "gcc" if language == "c" else "g++"
        done = subprocess.run([compiler, f"-std={standard}", "-Wall", "-Wextra", "-Wpedantic",
                               "-Werror", "-fsyntax-only", "-x", language, str(header)],
                              capture_output=True, text=True, check=False)
        if done.returncode:
            yield f"{header.name} as {standard}: {done.stderr}"


def check_c():
    for header, folder in HEADERS.items():
        yield from check_functions(header, dict(c_functions(header)), dict(fortran_functions(folder)))
    for name, c_fields, fields in structure_fields():
        if c_fields != fields:
            yield f"{name}: fields {c_fields} in C, {fields} in Fortran"
    fortran = "\n".join(fortran_sources())
    status = dict(re.findall(r"GRACECG_([A-Z_]*[A-Z]) = (\d+)", header_text()))
    if status != dict(re.findall(r"STATUS_(\w+) = (\d+)", fortran)):
        yield "the numbers of the status differ"
    size = re.search(r"#define GRACECG_MESSAGE_SIZE (\d+)", next(iter(HEADERS)).read_text(encoding="utf-8"))
    if size.group(1) != re.search(r"MESSAGE_SIZE = (\d+)", fortran).group(1):
        yield "the sizes of a message differ"


def table_routines():
    """Of each call in the table: arguments, and which of them are results."""
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if match := re.match(r"\| `(GC\w+)\(`(.*?)`\)` \|", line):
            name, text = match.groups()
            text = re.sub(r"\([^)]*\)", "", text).replace("`", "")
            arguments, results = [], set()
            for argument in (a.strip() for a in text.split(",")):
                if argument == "...":
                    arguments += ["ISTAT", "MSG"]
                    results |= {"ISTAT", "MSG"}
                else:
                    arguments.append(argument.strip("*"))
                    if argument.startswith("**"):
                        results.add(arguments[-1])
            yield name, (arguments, results)


def f77_routines():
    text = "\n".join(re.sub(r"!.*", "", (folder / "f77.f90").read_text(encoding="utf-8")) for folder in HEADERS.values())
    for name, arguments, body in re.findall(r"^subroutine (\w+)\((.*?)\)\n(.*?)^end subroutine", text,
                                            flags=re.M | re.S):
        results = set()
        for names in re.findall(r"intent\((?:out|inout)\) :: (.*)$", body, flags=re.M):
            results |= {n.upper() for n in names_of(names)}
        yield name.upper(), ([a.strip().upper() for a in arguments.split(",")], results)


def check_f77():
    table, source = dict(table_routines()), dict(f77_routines())
    for name in sorted(table.keys() | source.keys()):
        if table.get(name) != source.get(name):
            yield f"{name}: docs/api.md has {table.get(name)}, the source {source.get(name)}"
        if len(name) > 6:
            yield f"{name}: Fortran 77 allows six characters"


def chapter(title):
    text = TABLE.read_text(encoding="utf-8")
    return re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", text, flags=re.M | re.S).group(1)


def c_table_names():
    """The functions of the table of the C chapter: `_evaluate` goes on from the last full name."""
    for cells in re.findall(r"^\| (`.*`) \|", chapter("C"), flags=re.M):
        for family in cells.split(";"):
            words = re.findall(r"`(\w+)`", family)
            stem = words[0].rsplit("_", 1)[0]
            for word in words:
                yield "gracecg_" + (stem + word if word.startswith("_") else word)


def check_chapters():
    for umbrella in UMBRELLAS:
        public = re.findall(r"^    public :: (.*)$", umbrella.read_text(encoding="utf-8"), flags=re.M)
        for name in re.findall(r"\w+", " ".join(public)):
            if f"`{name}`" not in chapter("Fortran"):
                yield f"{name} is public in {umbrella.stem}, but not in the Fortran chapter of docs/api.md"
    functions = {name for name, _ in c_functions(*HEADERS) if not name.endswith("_free")}
    for name in sorted(functions ^ set(c_table_names())):
        yield f"{name} stands in a header or in the C chapter of docs/api.md, but not in both"


def main():
    found = [*check_c(), *check_f77(), *check_chapters()]
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
