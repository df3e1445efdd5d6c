#!/usr/bin/env python3
"""Writes the interfaces to C and Fortran 77 from their table, and what that of Fortran is from the sources.

    tools/interface.py            writes what is out of date
    tools/interface.py --check    writes nothing; status 1 when something is out of date

The table is tools/interface.txt, which says how it is written and what is made of it. The module of a Fortran name is
found by the `public` statements of the two folders.
"""
import math
import re
import sys
import textwrap

from interface_f77 import Entry, f77, f77_interfaces, f77_table
from interface_fortran import fortran_interface
from interface_table import ROOT, Mistake, read_table
from interface_text import KINDS, MADE, WIDTH, comment, folded, shape, uses, words

FOLDERS = {"gracecg": ROOT / "src/interface", "gracecg_level1": ROOT / "level1/src/interface"}
SHELLS = {"gracecg": "gracecg_interface_c_functions", "gracecg_level1": "gracecg_level1_c_functions"}


# ---------------------------------------------------------------- C


def parameters(a):
    """The parameters of C that an argument is: name, declaration in C, and in the shell."""
    intent, const = ("intent(in)", "const ") if a.way == "in" else ("intent(inout)", "")
    name = a.name
    if a.way == "make":
        return [(name, f"gracecg_object **{name}", f"integer(c_intptr_t), intent(inout), optional :: {name}")]
    if a.is_handle:
        return [(name, f"const gracecg_object *{name}", f"integer(c_intptr_t), intent(in), value :: {name}")]
    if a.kind in ("text", "settings"):
        text = [(name, f"{const}char *{name}", f"character(kind=c_char), {intent}, optional :: {name}(*)")]
        return text if a.way == "in" else text + [size_t("size"), size_t("length", "*")]
    if a.kind == "numbers":
        return [size_t("capacity"), (name, f"double *{name}", f"real(c_double), {intent}, optional :: {name}(*)"),
                size_t("count", "*")]
    if a.kind == "count":
        return [size_t(name)]
    if a.kind == "time":
        return [(name, f"{const}gracecg_utc *{name}", f"type(c_utc_t), {intent}, optional :: {name}")]
    if a.kind == "handles":
        return [(name, f"gracecg_object *const *{name}", f"integer(c_intptr_t), intent(in), optional :: {name}(*)")]
    kind, fortran = ("int32_t", "integer(c_int32_t)") if a.kind == "integer" else ("double", "real(c_double)")
    if a.way == "in" and not a.sizes:
        return [(name, f"{kind} {name}", f"{fortran}, intent(in), value :: {name}")]
    fixed = len(a.sizes) == 1 and a.sizes[0].isdigit()
    return [(name, f"{const}{kind} {name}[{a.sizes[0]}]" if fixed else f"{const}{kind} *{name}",
             f"{fortran}, {intent}, optional :: {name}{shape(a.sizes)}")]


def size_t(name, pointer=""):
    """A size_t as a parameter, or a pointer to one that goes out."""
    fortran = "intent(inout), optional" if pointer else "intent(in), value"
    return name, f"size_t {pointer}{name}", f"integer(c_size_t), {fortran} :: {name}"


def names_of(function):
    """The names of its parameters, without the last one."""
    return [name for a in function.arguments for name, *_ in parameters(a)]


def header(package, objects):
    yield f"/* {MADE} */"
    for item in package:
        if item.kind == "verbatim":
            yield item.text
        elif item.kind == "chapter":
            yield f"/* {'-' * 66} {item.text} */"
            yield ""
        elif item.kind == "object":
            if item.items:
                more = f", and those of a {objects[item.parent].title}" if item.parent else ""
                article = "an" if item.title[0] in "aeiou" else "a"
                yield from boxed(f"Items of {article} {item.title}{more}:", [(i.shown, i.meaning) for i in item.items])
        else:
            yield from boxed(item.text)
            call = f"gracecg_status gracecg_{item.name}("
            arguments = [declared for a in item.arguments for _, declared, _ in parameters(a)] + ["gracecg_error *error"]
            lines = textwrap.wrap(call + ", ".join(argument.replace(" ", "~") for argument in arguments) + ");", WIDTH,
                                  subsequent_indent=" " * len(call))
            yield from (line.replace("~", " ") for line in lines)
            yield ""


def boxed(text, rows=()):
    lines = textwrap.wrap(text, WIDTH, initial_indent="/* ", subsequent_indent="   ", break_on_hyphens=False)
    for name, meaning in rows:
        start = f"     {name:<30} " if meaning else f"     {name}"
        lines += textwrap.wrap(meaning, WIDTH - 3, initial_indent=start, subsequent_indent=" " * 36, break_on_hyphens=False) \
            or [start]
    lines[-1] += " */"
    yield from lines
    if rows:
        yield ""


# ---------------------------------------------------------------- the shells for C


def elements(a):
    """How many numbers an array has, as Fortran has it; None when nobody knows."""
    if "*" in a.sizes:
        return None
    sizes = [f"({size[2:]} + 1)" if size.startswith("0:") else size for size in a.sizes]
    fixed = math.prod(int(size) for size in sizes if size.isdigit())
    variable = [size for size in sizes if not size.isdigit()]
    if not variable:
        return f"{fixed}_c_size_t"
    return variable[0] if fixed == 1 else f"{fixed}*{variable[0]}"


def logical(value):
    return ".true." if value else ".false."


def checks(a, counts):
    """The statements that check an argument and convert it."""
    quoted = f"'{a.name}'"
    counted = [size for size in a.sizes if size in counts]
    needed = logical(not a.optional or counted)
    low, high = a.range or (None, None)
    if a.way == "make":
        yield f"call start_handle({a.name}, {quoted}, outcome)"
    elif a.way == "out":
        if a.kind == "real" and not a.optional:
            there = f"present({a.name})" + "".join(f" .or. {size} == 0" for size in counted)
            yield f"call need({there}, {quoted}, outcome)"
        elif a.kind == "time":
            yield f"call need(present({a.name}), {quoted}, outcome)"
    elif a.kind in ("text", "settings"):
        longest = "LONGEST_NAME" if a.kind == "text" else "LONGEST_TEXT"
        yield f"call take_text({a.name}, {longest}, {quoted}, {needed}, {a.name}_in, outcome)"
    elif a.kind == "count":
        yield f"call check_count({a.name}, {quoted}, {low or 0}, {high or 'huge(0)'}, outcome)"
    elif a.kind == "time":
        yield f"call take_time({a.name}, {quoted}, {needed}, {a.name}_in, outcome)"
    elif a.kind == "integer" and a.range:
        yield f"call check_integer(int({a.name}), {quoted}, {low}, {high}, outcome)"
    elif a.kind in ("integer", "handles") and a.sizes:
        yield f"call need(present({a.name})" + "".join(f" .or. {size} == 0" for size in counted) + f", {quoted}, outcome)"
    elif a.kind in ("position", "attitude"):
        yield f"call check_{a.kind}s({a.name}, {a.sizes[1] if a.sizes[1:] else '1_c_size_t'}, {quoted}, outcome)"
    elif a.kind == "state":
        yield f"call check_state_vector({a.name}, {quoted}, outcome)"
    elif a.kind == "real" and a.sizes:
        yield f"call check_numbers({a.name}, {elements(a)}, {quoted}, {needed}, outcome)"
    elif a.kind == "real":
        bounds = {">": f", above={high}.0_dp", ">=": f", low={high}.0_dp"}.get(
            low, f", low={low}.0_dp, high={high}.0_dp") if a.range else ""
        yield f"call check_number({a.name}, {quoted}, outcome{bounds})"


def handed(a):
    """An argument as the work gets it."""
    if a.way == "make":
        return "made"
    if a.kind in ("text", "settings", "time", "numbers") or a.is_handle:
        return f"{a.name}_{'in' if a.way == 'in' else 'found'}"
    if a.kind == "count" or (a.kind == "integer" and not a.sizes):
        return f"int({a.name})"
    return a.name


def work_of(function, local):
    """The statements of the work."""
    if not function.work:
        return [f"call {function.name}({', '.join([*(handed(a) for a in function.arguments), 'outcome'])})"]
    text = function.work
    for a in function.arguments:
        text = re.sub(rf"(?<![\w%]){a.name}\b", handed(a), text)
    if function.status:
        local.append("type(error_t), allocatable :: failure")
        return [f"call {text[:-1]}, failure)", f"call outcome%take(failure, STATUS_{function.status})"]
    if re.search(r"\bi\)", text):
        local.append("integer :: i")
        return ["do i = 1, int(n)", "    " + text, "end do"]
    return [text]


def shell(function, objects):
    """The Fortran function that C calls."""
    arguments = function.arguments
    counts = {a.name for a in arguments if a.kind == "count"}
    made = next((a for a in arguments if a.way == "make"), None)
    used = next((a for a in arguments if a.is_handle and a.way == "in"), None)
    names = [*names_of(function), "error"]
    local = ["type(outcome_t) :: outcome"]
    before = [line for a in sorted(arguments, key=lambda a: a.way != "make") for line in checks(a, counts)]
    after = []
    for a in arguments:
        if a.kind in ("text", "settings"):
            local.append(f"character(:), allocatable :: {handed(a)}")
        if a.kind == "time":
            local.append(f"type(utc_t){', allocatable' if a.way == 'in' else ''} :: {handed(a)}")
        if a.kind == "numbers":
            local.append(f"real(dp), allocatable :: {a.name}_found(:)")
            after.append(f"call give_numbers({a.name}_found, capacity, {a.name}, count, outcome)")
        if a.way != "out":
            continue
        if a.kind == "text":
            after.append(f"call give_text({a.name}_found, {a.name}, size, length, outcome)")
        if a.kind == "time":
            after.append(f"if (outcome%good()) {a.name} = c_utc_t({a.name}_found%mjd, {a.name}_found%seconds)")
        if a.kind == "real" and not a.sizes:
            after.append(f"call check_result({a.name}, '{a.name}', outcome)")
        elif a.kind == "real" and (n := elements(a)):
            after.append(f"call check_results({a.name}, {n}, '{a.name}', outcome)")
    work = work_of(function, local)
    if made:
        any_kind = made.kind == "object"
        local += [f"{'class(object_t)' if any_kind else f'type({objects[made.kind].type})'}, pointer :: made"]
        if any_kind:
            after = [f"call keep(made, {made.name}, outcome)"]
            before.append("made => null()")
        else:
            local += ["class(object_t), pointer :: made_object", "integer :: memory"]
            before.append("made_object => null()")
            after = [f"call keep(made_object, {made.name}, outcome)"]
            work = ["allocate (made, stat=memory)", "call check_memory(memory, outcome)", "if (outcome%good()) then",
                    "    made_object => made", *("    " + line for line in work), "end if"]
    if used:
        local.append(f"class(object_t), pointer :: {used.name}_in")
        title = objects[used.kind].title if used.kind in objects else "gracecg object"
        refused = f"call refuse_handle('{title}', outcome)"
        if used.kind == "object":
            cases = [("type is (no_object_t)", [refused]), ("class default", work)]
        else:
            cases = [(f"class is ({objects[used.kind].type})", work), ("class default", [refused])]
        work = [f"call acquire(int({used.name}, i8), {used.name}_in)", f"select type ({used.name}_in)"]
        for guard, lines in cases:
            work += [guard, *("    " + line for line in lines)]
        work += ["end select", f"call release(int({used.name}, i8), {used.name}_in)"]
    something = " .and. n > 0" if "n" in counts and not made else ""
    body = [*before, f"if (outcome%good(){something}) then", *("    " + line for line in work), "end if", *after,
            "status = reported(outcome, error)"]
    yield from comment(f"gracecg_{function.name}", "!> ", "    ")
    yield from folded(f"function c_{function.name}({', '.join(names)}) result(status) "
                      f"bind(c, name='gracecg_{function.name}')", "    ")
    for a in arguments:
        for *_, line in parameters(a):
            yield from folded(line, " " * 8)
    yield "        type(c_error_t), intent(inout), optional :: error"
    yield "        integer(c_int) :: status"
    yield ""
    for line in local:
        yield " " * 8 + line
    yield ""
    for line in body:
        depth = len(line) - len(line.lstrip())
        yield from folded(line.lstrip(), " " * (8 + depth))
    yield f"    end function c_{function.name}"
    yield ""


def shells(name, functions, objects, modules):
    lines = [line for function in functions for line in shell(function, objects)]
    own = {f"c_{function.name}" for function in functions}
    dummies = {a.name for function in functions for a in function.arguments}
    works = {function.name for function in functions if not function.work}
    yield f"! {MADE}"
    yield f"!> The C interface of {name}.h: every function checks and converts its arguments, and calls its work, the procedure of"
    yield "!> the same name."
    yield f"module {SHELLS[name]}"
    for line in uses(words(lines) - (dummies - works), modules, own):
        yield from folded(line, "    ")
    yield "    implicit none"
    yield "    private"
    for line in textwrap.wrap(", ".join(sorted(own)), WIDTH - 15):
        yield f"    public :: {line.rstrip(',')}"
    yield ""
    yield "contains"
    yield ""
    yield from lines[:-1]
    yield f"end module {SHELLS[name]}"


# ---------------------------------------------------------------- what the tests call


def c_declarations(functions):
    yield f"! {MADE}"
    yield "!> The C interface as the headers declare it, for tests that call it as C does. An absent argument is NULL."
    yield "module c_declarations"
    yield "    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_intptr_t, c_size_t"
    yield "    implicit none"
    yield ""
    yield "    type, bind(c) :: error_struct"
    yield "        integer(c_int32_t) :: status = -1"
    yield "        character(kind=c_char) :: message(1020) = '?'"
    yield "    end type error_struct"
    yield ""
    yield "    type, bind(c) :: utc_struct"
    yield "        integer(c_int32_t) :: mjd = 0"
    yield "        real(c_double) :: seconds = 0"
    yield "    end type utc_struct"
    yield ""
    yield "    interface"
    for function in functions:
        names = [*names_of(function), "error"]
        lines = [line.replace("c_utc_t", "utc_struct") for a in function.arguments for *_, line in parameters(a)]
        lines += ["type(error_struct), intent(inout), optional :: error", "integer(c_int) :: status"]
        lines = [re.sub(r"(real\(c_double\).*:: \w+)\(.*\)", r"\1(*)", line) for line in lines]
        imports = [name for name in (*KINDS, "error_struct", "utc_struct") if name in words(lines)]
        yield from folded(f"function gracecg_{function.name}({', '.join(names)}) result(status) "
                          f"bind(c, name='gracecg_{function.name}')", " " * 8)
        yield f"            import :: {', '.join(imports)}"
        for line in lines:
            yield from folded(line, " " * 12)
        yield f"        end function gracecg_{function.name}"
        yield ""
    yield "    end interface"
    yield "end module c_declarations"


# ---------------------------------------------------------------- the documentation


def c_table(packages):
    """The functions by the chapters of the headers, which have the rest."""
    chapters = {"every object": ["version", "interface_version", "status_text", "name", "free"]}
    names = chapters["every object"]
    for item in (item for package in packages.values() for item in package):
        if item.kind == "chapter":
            names = chapters.setdefault(item.text, [])
        elif item.kind == "function":
            names.append(item.name)
    yield "| chapter of the header | functions, behind `gracecg_` |"
    yield "|---|---|"
    for title, found in chapters.items():
        yield f"| {title} | {', '.join(f'`{name}`' for name in found)} |"


def document(packages):
    path = ROOT / "docs/api.md"
    table = "\n".join(c_table(packages))
    text, found = re.subn(r"(<!-- C: made by tools/interface.py -->\n).*?(<!-- end -->)",
                          lambda match: match.group(1) + table + "\n" + match.group(2), path.read_text(encoding="utf-8"),
                          flags=re.S)
    if found != 1:
        raise Mistake("docs/api.md has no marks for the table of C")
    return path, text


# ---------------------------------------------------------------- all together


def exported():
    """The module of every public name of the interfaces."""
    umbrella = (ROOT / "src/gracecg.f90").read_text(encoding="utf-8")
    found = {name: "gracecg" for line in re.findall(r"^    public :: (.*)$", umbrella, flags=re.M) for name in re.findall(r"\w+", line)}
    found.update(dp="gracecg_base_kinds", i8="gracecg_base_kinds")
    for folder in FOLDERS.values():
        for path in sorted(folder.glob("*.f90")):
            text = re.sub(r"&\s*\n\s*", "", re.sub(r"!.*", "", path.read_text(encoding="utf-8")))
            module = re.search(r"^module (\w+)", text, flags=re.M)
            if module and module.group(1) not in SHELLS.values():
                for names in re.findall(r"^    public :: (.*)$", text, flags=re.M):
                    found.update({name: module.group(1) for name in re.findall(r"\w+", names)})
    return found


def debian_symbols(headers, entries):
    """debian/libgracecg0.symbols: what a later library may not lack. Of the procedures of modules there is no list: their names
    are no interface."""
    version = re.search(r'^version = "(.*)"', (ROOT / "fpm.toml").read_text(encoding="utf-8"), flags=re.M).group(1)
    for package, text in headers.items():
        yield f"lib{package}.so.{version.split('.')[0]} libgracecg0 #MINVER#"
        yield "* Build-Depends-Package: libgracecg-dev"
        yield f' (regex|optional)"^__gracecg.*@Base$" {version}'
        names = re.findall(r"^[a-z]\w+ [^;(]*?\*?(gracecg_\w+)\(", text, flags=re.M)
        names += [f"{entry.name.lower()}_" for entry in entries[package]]
        for path in FOLDERS[package].glob("f77_by_hand.f90"):
            names += [f"{name}_" for name in re.findall(r"^subroutine (\w+)", path.read_text(encoding="utf-8"), flags=re.M)]
        for name in sorted(names):
            yield f" {name}@Base {version}"


def generate():
    packages = read_table()
    headers, entries_of = {}, {}
    modules, objects, all_functions, all_entries = exported(), {}, [], []
    for package in packages.values():
        objects.update({item.name: item for item in package if item.kind == "object"})
    for name, package in packages.items():
        functions = [item for item in package if item.kind == "function"]
        entries = [Entry(line, function, objects) for function in functions for line in function.f77]
        for function in functions:
            if not function.work and function.name not in modules:
                raise Mistake(f"no module of the interfaces has a public {function.name}")
        headers[name], entries_of[name] = "\n".join(header(package, objects)) + "\n", entries
        yield ROOT / f"include/{name}.h", headers[name]
        yield FOLDERS[name] / "c_functions.f90", "\n".join(shells(name, functions, objects, modules)) + "\n"
        of_shells = modules | {f"c_{function.name}": SHELLS[name] for function in functions}
        yield FOLDERS[name] / "f77_entries.f90", "\n".join(f77(entries, of_shells)) + "\n"
        all_functions += functions
        all_entries += entries
    if long := [entry.name for entry in all_entries if len(entry.name) > 6]:
        raise Mistake(f"Fortran 77 allows six characters: {long}")
    yield ROOT / "tools/testing/src/c_declarations.f90", "\n".join(c_declarations(all_functions)) + "\n"
    yield ROOT / "tools/testing/src/f77_interfaces.f90", "\n".join(f77_interfaces(all_entries)) + "\n"
    yield ROOT / "debian/libgracecg0.symbols", "\n".join(debian_symbols(headers, entries_of)) + "\n"
    for name in packages:
        yield ROOT / f"docs/interface/{name}.txt", "\n".join(fortran_interface(name)) + "\n"
    yield ROOT / "docs/interface/fortran77.md", "\n".join(f77_table(all_entries)) + "\n"
    yield document(packages)


def main():
    check, status = "--check" in sys.argv[1:], 0
    try:
        files = list(generate())
    except Mistake as mistake:
        print(f"tools/interface.txt: {mistake}")
        return 1
    for path, text in files:
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        status = int(check)
        if not check:
            path.write_text(text, encoding="utf-8")
        print(("out of date: " if check else "written: ") + str(path.relative_to(ROOT)))
    return status


if __name__ == "__main__":
    sys.exit(main())
