#!/usr/bin/env python3
"""Checks the order of the house: who may use whom, and what a library must not do.

    tools/check_floors.py              prints each violation as file:line: text; status 1 if any
    tools/check_floors.py --self-test  plants violations of every rule and checks that they are found

The rules:
- src/, app/ and level1/ hold Fortran alone (.f90, no preprocessor): nothing there needs another compiler.
- src/FLOOR/ROOM.f90 (or in a folder of the floor) holds one module or submodule, gracecg_FLOOR_ROOM, so that
  a `use` tells its floor; src/gracecg.f90 holds the umbrella. A module has a `private` statement. The
  Fortran 77 entry points alone are procedures outside of modules.
  app/cli/FOLDER/ROOM.f90 holds gracecg_cli_ROOM; level1/src/FOLDER/ROOM.f90 holds gracecg_level1_ROOM.
- A module uses modules of lower floors, or of its own floor without circles. Floors that stand side by
  side do not use each other: simulation and estimation, interface and cli.
- The folders of a floor that FOLDERS lists have an order, too: every module of it lies in one of them and uses
  its own folder and lower ones; folders of one number do not use each other.
- The library reaches neither the commands (app/cli) nor Level-1; of Level-1 its commands alone reach those of app/cli.
- The estimators see observations, never the truth: by no chain of `use` do they reach the simulation;
  of environment and spacecraft they use only what ESTIMATION_MAY_USE lists.
- Below cli nothing stops the program or writes to the terminal.
- LAPACK and BLAS are called in gracecg_base_lapack only.
- A test uses modules of its own folder of test/, those in folders below it, and no others of test/: fpm sees no more.
"""
import collections
import pathlib
import re
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Two floors of one number stand side by side.
FLOORS = {"base": 0, "files": 1, "environment": 2, "spacecraft": 3, "observations": 4,
          "simulation": 5, "estimation": 5, "planning": 6, "studies": 7, "umbrella": 8,
          "interface": 9, "cli": 9, "level1": 10, "app": 11}

# The same within a floor. Simulation: what flies, and what it is seen with; what is to be flown; the simulator.
# Estimation: contract, what is asked and answered; checks, of data and beliefs; then the families of estimators;
# door, an estimator by its name; verdict, what is said of its solution. Of cli, base takes the words of the command
# line, output writes results, page and report fill pages; what lies in no folder knows all commands.
FOLDERS = {"simulation": {"dynamics": 0, "instruments": 0, "case": 1, "simulator": 2},
           "estimation": {"contract": 0, "data": 1, "model": 2, "checks": 3,
                          "report": 4, "optimal": 4, "sequential": 4, "joint": 5, "door": 6, "verdict": 7},
           "level1": {"files": 0, "estimation": 1, "simulation": 1, "": 2, "interface": 3, "commands": 3},
           "cli": {"base": 0, "output": 1, "page": 2, "commands": 3, "report": 4, "": 5}}

UMBRELLA = "src/gracecg.f90"
# Of the packages in app/ and level1/: their manifests
NO_FORTRAN = ("fpm.toml",)
# Callers without modules need procedures outside of them.
WITHOUT_MODULE = ("src/interface/f77_by_hand.f90", "src/interface/f77_entries.f90", "level1/src/interface/f77_entries.f90")

# The geomagnetic model may stand in for a failed magnetometer; to evaluate it takes the epoch and
# the place, so time and the shape of the Earth (constants of nature, nothing of the satellite's
# truth) come with it. Mass properties and torque rods are what an operator knows of the satellite.
ESTIMATION_MAY_USE = {
    "environment": {"gracecg_environment_earth_orientation", "gracecg_environment_earth_shape",
                    "gracecg_environment_geomagnetic_field", "gracecg_environment_geomagnetic_models",
                    "gracecg_environment_sun", "gracecg_environment_time"},
    "spacecraft": {"gracecg_spacecraft_mass_properties", "gracecg_spacecraft_torque_rods"},
}

MODULE = re.compile(r"(?:module\s+(?!procedure\b|subroutine\b|function\b)"
                    r"|submodule\s*\([\w\s:]+\)\s*)(\w+)$")
USE = re.compile(r"use\b\s*(?:,\s*non_intrinsic\s*)?(?:::)?\s*(\w+)")
CONDITION = r"(?:\d+\s+)?(?:if\s*\(.*\)\s*)?"
FORBIDDEN = (
    ("stops the program", re.compile(CONDITION + r"(?:error\s+)?stop\b(?!\s*[=(%])")),
    ("stops the program", re.compile(CONDITION + r"call\s+(?:exit|abort)\b")),
    ("prints", re.compile(CONDITION + r"print\s*(?:\*|''|\w+\s*(?:,|$))")),
    ("writes to the terminal",
     re.compile(CONDITION + r"write\s*\(\s*(?:unit\s*=\s*)?(?:\*|6\b|output_unit\b|error_unit\b)")),
)
# Double precision and double complex names of BLAS (levels 1 to 3) and LAPACK.
LAPACK_CALL = re.compile(
    r"\b[dz](?:dotu?|dotc|axpy|scal|copy|swap|nrm2|asum|rotg?"
    r"|(?:ge|gb|gt|po|pp|pb|pt|sy|sp|sb|st|tr|tp|tb|tz|or|he|hp|un|la)[a-z0-9]{1,4})\s*\(")

Source = collections.namedtuple("Source", "path floor statements module uses")


def statements(text):
    """Yields (line number, statement): lower case, no comments, character constants emptied."""
    pending, start = "", 0
    for number, line in enumerate(text.splitlines(), 1):
        line = re.sub(r"'[^']*'|\"[^\"]*\"", "''", line)
        line = line.split("!")[0].strip().lower()
        if not line or line.startswith("#"):
            continue
        start = start if pending else number
        if line.endswith("&"):
            pending += line.strip("&") + " "
            continue
        for part in (pending + line.lstrip("&")).split(";"):
            yield start, part.strip()
        pending = ""


def floor_of(path):
    """The floor of a source; None for one that stands on none."""
    top, below = path.parts[0], path.parts[1]
    if path.as_posix() == UMBRELLA:
        return "umbrella"
    if top == "level1":
        return top
    name = "cli" if (top, below) == ("app", "cli") else top if top == "app" else below
    return name if name in FLOORS else None


def folder_of(source):
    """The folder of a source within its floor: empty when it lies in none."""
    return source.path.parts[2] if len(source.path.parts) > 3 else ""


def side_of(source):
    """The floor of a source, or, of Level-1, its folder: simulation and estimation stand side by side there, too."""
    return folder_of(source) if source.floor == "level1" else source.floor


def module_of(path):
    """The name of the module that a source has to hold; None: any."""
    if path.as_posix() == UMBRELLA:
        return "gracecg"
    if path.parts[0] == "level1":
        return path.stem if path.stem == "gracecg_level1" else f"gracecg_level1_{path.stem}"
    if path.parts[0] == "app" and path.parts[1] != "cli":
        return None
    return f"gracecg_{path.parts[1]}_{path.stem}"


def read_sources(root):
    """All Fortran sources of the library, the program and Level-1."""
    files = [f for top in ("src", "app", "level1/src") for f in sorted((root / top).rglob("*.[fF]*"))]
    for file in files:
        path = file.relative_to(root)
        lines = list(statements(file.read_text(encoding="utf-8")))
        modules = [m.group(1) for _, s in lines if (m := MODULE.match(s))]
        uses = {}
        for number, statement in lines:
            if match := USE.match(statement):
                uses.setdefault(match.group(1), number)
        yield Source(path, floor_of(path), lines, modules, uses)


def check_form(source):
    """One module a file, named after floor and file, private; nothing that a library must not do."""
    if source.floor is None:
        yield 1, "stands on no floor"
    if source.floor in FOLDERS and folder_of(source) not in FOLDERS[source.floor]:
        yield 1, f"lies in no folder of {source.floor} that has a place in the order: " \
                 + ", ".join(FOLDERS[source.floor])
    if source.path.as_posix() in WITHOUT_MODULE:
        if source.module:
            yield 1, "holds a module; only procedures outside of modules are expected"
    elif module_of(source.path):
        if source.module != [module_of(source.path)]:
            yield 1, f"holds {', '.join(source.module) or 'no module'}; " \
                     f"one module is expected, {module_of(source.path)}"
        if not any(s == "private" or s.startswith("submodule") for _, s in source.statements):
            yield 1, "has no `private` statement"
    for number, statement in source.statements:
        if source.floor not in ("cli", "app") and folder_of(source) != "commands":
            for what, pattern in FORBIDDEN:
                if pattern.match(statement):
                    yield number, f"{what}: {statement}"
        if source.module != ["gracecg_base_lapack"] and (call := LAPACK_CALL.search(statement)):
            yield number, f"calls LAPACK or BLAS outside gracecg_base_lapack: {call.group()}...)"


def check_uses(source, home):
    """The direct uses of one module."""
    for name, number in source.uses.items():
        used = home.get(name)
        if used is None or None in (source.floor, used.floor):
            continue
        if used.floor == source.floor:
            yield from check_folders(source, used, number)
            continue
        if used.floor == "cli" and source.floor != "app" and folder_of(source) != "commands":
            yield number, f"uses {name}: nothing but the program and Level-1's commands reaches cli"
        elif FLOORS[used.floor] > FLOORS[source.floor]:
            yield number, f"uses {name} of a floor above, {used.floor}"
        elif FLOORS[used.floor] == FLOORS[source.floor]:
            yield number, f"uses {name}: {source.floor} and {used.floor} stand side by side and never meet"
        elif source.floor == "estimation" and used.floor in ESTIMATION_MAY_USE \
                and name not in ESTIMATION_MAY_USE[used.floor]:
            yield number, f"an estimator uses {name}; of {used.floor} it may use only " \
                          + ", ".join(sorted(ESTIMATION_MAY_USE[used.floor]))


def check_folders(source, used, number):
    """A use within a floor: not of a folder above, or beside."""
    order, own, other = FOLDERS.get(source.floor, {}), folder_of(source), folder_of(used)
    if own == other or own not in order or other not in order:
        return
    if order[other] > order[own]:
        yield number, f"uses {used.module[0]} of a folder above, {other}"
    elif order[other] == order[own]:
        yield number, f"uses {used.module[0]}: {own} and {other} stand side by side and never meet"


def chain_to(target, source, home):
    """The shortest chain of uses from a source to a module for which target(module) holds."""
    chains, seen = collections.deque([[source]]), {source.path}
    while chains:
        chain = chains.popleft()
        for name in chain[-1].uses:
            used = home.get(name)
            if used is None:
                continue
            if target(used):
                return chain[1:] + [used]
            if used.path not in seen:
                seen.add(used.path)
                chains.append(chain + [used])
    return None


def check_chains(source, home):
    """Circles; estimators that reach the truth, and simulations that reach an estimator."""
    targets = [("is in a circle of uses", lambda used: used.path == source.path)]
    for floor, other in (("estimation", "simulation"), ("simulation", "estimation")):
        if side_of(source) == floor:
            what = "an estimator reaches the truth" if floor == "estimation" \
                else "the simulation reaches an estimator"
            targets.append((what, lambda used, other=other: side_of(used) == other))
    for what, target in targets:
        if chain := chain_to(target, source, home):
            names = [link.module[0] for link in chain]
            yield source.uses[names[0]], f"{what}: {' -> '.join(names)}"


def other_files(root):
    """What is no Fortran in src/ and app/."""
    for top in ("src", "app", "level1"):
        for file in sorted((root / top).rglob("*")):
            if file.is_file() and file.suffix != ".f90" and file.name not in NO_FORTRAN:
                yield f"{file.relative_to(root)}:1: is no Fortran file (.f90)"


def check_tests(root):
    """Uses of modules of other folders of tests."""
    files = {file: file.read_text(encoding="utf-8") for file in sorted((root / "test").rglob("*.f90"))}
    folder = {match.group(1): file.parent for file, text in files.items()
              for _, statement in statements(text) if (match := MODULE.match(statement))}
    for file, text in files.items():
        for number, statement in statements(text):
            if (match := USE.match(statement)) and not folder.get(match.group(1), file).is_relative_to(file.parent):
                yield f"{file.relative_to(root)}:{number}: uses {match.group(1)} of another folder of tests"


def violations(root):
    yield from other_files(root)
    yield from check_tests(root)
    sources = list(read_sources(root))
    home = {name: source for source in sources for name in source.module}
    for source in sources:
        found = [*check_form(source), *check_uses(source, home), *check_chains(source, home)]
        for number, text in sorted(found):
            yield f"{source.path}:{number}: {text}"


def plant(root, path, *body, head="private"):
    file = root / path
    file.parent.mkdir(parents=True, exist_ok=True)
    name = module_of(pathlib.PurePath(path)) or file.stem
    file.write_text("\n".join([f"module {name}", *body, head, f"end module {name}"]) + "\n",
                    encoding="utf-8")


def plant_clean_house(root):
    """A house without violations, with text that only looks like some."""
    plant(root, "src/base/lapack.f90", "call dpotrf(a)", "! stop")
    plant(root, "src/environment/time.f90", "use, intrinsic :: iso_fortran_env, only: &",
          "    output_unit", "text = 'stop; print *' ! it's; stop", "write (unit, '(a)') text")
    plant(root, "src/environment/tables/table_wind.f90", "stop_time = distance(1.0)")
    plant(root, "src/environment/wind.f90", "use gracecg_environment_table_wind, only: wind")
    plant(root, "src/observations/observation_set.f90", "use gracecg_environment_time")
    plant(root, "src/simulation/dynamics/dynamics.f90", "use gracecg_environment_wind")
    plant(root, "src/simulation/instruments/accelerometer.f90")
    plant(root, "src/simulation/simulator/simulator.f90", "use gracecg_simulation_dynamics",
          "use gracecg_simulation_accelerometer")
    plant(root, "src/estimation/data/fitting_data.f90", "use gracecg_observations_observation_set")
    plant(root, "src/estimation/report/report_estimators.f90", "use gracecg_environment_time",
          "use gracecg_estimation_fitting_data")
    plant(root, "src/estimation/optimal/optimal.f90", "use gracecg_estimation_fitting_data")
    plant(root, "src/estimation/door/estimators.f90", "use gracecg_estimation_report_estimators",
          "use gracecg_estimation_optimal")
    plant(root, "src/studies/trim.f90", "use gracecg_simulation_dynamics", "use gracecg_estimation_report_estimators")
    plant(root, "src/gracecg.f90", "use gracecg_studies_trim")
    plant(root, "src/interface/handles.f90", "use gracecg")
    plant(root, "app/cli/output/table.f90", "use gracecg_estimation_report_estimators", "print *, x", "stop")
    plant(root, "app/cli/command_line.f90", "use gracecg_cli_table")
    plant(root, "level1/src/files/reader.f90", "use gracecg_environment_time")
    plant(root, "level1/src/estimation/offset.f90", "use gracecg_level1_reader", "use gracecg_estimation_report_estimators")
    plant(root, "level1/src/simulation/truth.f90", "use gracecg_simulation_dynamics")
    plant(root, "level1/src/commands/list.f90", "use gracecg_level1_reader", "use gracecg_cli_table")
    plant(root, "app/main.f90", "use gracecg_cli_table", "use gracecg_level1_list", "stop")
    plant(root, "test/files/made.f90", "use gracecg")
    plant(root, "test/main.f90", "use gracecg_files_made")


# (what is planted, where it must be found, a word of the message)
PLANTED = (
    (("test/base/a.f90", "use gracecg_files_made"), "a.f90:2:", "another folder"),
    (("src/base/up.f90", "", "use :: gracecg_environment_time"), "up.f90:3:", "above"),
    (("src/gracecg.f90", "use gracecg_interface_handles"), "gracecg.f90:2:", "above"),
    (("src/environment/tables/table_wind.f90", "use gracecg_environment_wind"),
     "/wind.f90:2:", "circle"),
    (("src/estimation/report/report_estimators.f90", "use &", "  gracecg_simulation_dynamics"),
     "report_estimators.f90:2:", "truth"),
    (("src/estimation/report/report_estimators.f90", "use gracecg_simulation_dynamics"), "report_estimators.f90:2:", "never meet"),
    (("src/simulation/dynamics/dynamics.f90", "use gracecg_estimation_fitting_data"),
     "dynamics.f90:2:", "never meet"),
    (("src/observations/observation_set.f90", "use gracecg_simulation_dynamics"),
     "observation_set.f90:2:", "above"),
    (("src/observations/observation_set.f90", "use gracecg_simulation_dynamics"),
     "report_estimators.f90:3:", "reaches the truth"),
    (("src/observations/observation_set.f90", "use gracecg_estimation_report_estimators"),
     "observation_set.f90:2:", "above"),
    (("src/interface/handles.f90", "use gracecg_cli_table"), "handles.f90:2:", "reaches cli"),
    (("src/gracecg.f90", "use gracecg_cli_table"), "gracecg.f90:2:", "reaches cli"),
    (("src/studies/trim.f90", "use gracecg_cli_table"), "trim.f90:2:", "reaches cli"),
    (("src/studies/trim.f90", "use gracecg_level1_reader"), "trim.f90:2:", "above"),
    (("app/cli/output/table.f90", "use gracecg_level1_reader"), "table.f90:2:", "above"),
    (("app/cli/base/words.f90", "use gracecg_cli_table"), "words.f90:2:", "folder above"),
    (("level1/src/files/reader.f90", "use gracecg_cli_table"), "reader.f90:2:", "reaches cli"),
    (("level1/src/files/reader.f90", "use gracecg_level1_offset"), "reader.f90:2:", "folder above"),
    (("level1/src/estimation/offset.f90", "use gracecg_simulation_dynamics"), "offset.f90:2:", "truth"),
    (("level1/src/files/reader.f90", "print *, x"), "reader.f90:2:", "prints"),
    (("app/cli/output/table.f90", "use gracecg_interface_handles"), "table.f90:2:", "never meet"),
    (("src/estimation/report/report_estimators.f90", "use gracecg_environment_wind"),
     "report_estimators.f90:2:", "may use only"),
    (("src/estimation/data/fitting_data.f90", "use gracecg_estimation_estimators"),
     "fitting_data.f90:2:", "folder above"),
    (("src/estimation/model/b.f90", "use gracecg_estimation_optimal"), "b.f90:2:", "folder above"),
    (("src/estimation/optimal/optimal.f90", "use gracecg_estimation_report_estimators"), "optimal.f90:2:", "never meet"),
    (("src/simulation/case/b.f90", "use gracecg_simulation_simulator"), "b.f90:2:", "folder above"),
    (("src/simulation/dynamics/b.f90", "use gracecg_simulation_accelerometer"), "b.f90:2:", "never meet"),
    (("src/estimation/attic/b.f90",), "b.f90:1:", "no folder"),
    (("src/estimation/b.f90",), "b.f90:1:", "no folder"),
    (("src/planning/a.f90", "end module", "module gracecg_planning_b"), "a.f90:1:", "one module"),
    (("src/planning/a.f90", "end module", "module gracecg_studies_a"), "a.f90:1:", "one module"),
    (("src/planning/a.f90", "if (any(x > 0)) error stop 1"), "a.f90:2:", "stops"),
    (("src/planning/a.f90", "call exit(1)"), "a.f90:2:", "stops"),
    (("src/planning/a.f90", "x = 1; Print '(a)', x"), "a.f90:2:", "prints"),
    (("src/planning/a.f90", "write(*,*) x"), "a.f90:2:", "terminal"),
    (("src/planning/a.f90", "write (unit=error_unit, '(a)') x"), "a.f90:2:", "terminal"),
    (("src/planning/a.f90", "y = ddot(3, a, 1, b, 1)"), "a.f90:2:", "LAPACK"),
    (("src/planning/a.f90", "call dpotrs(a)"), "a.f90:2:", "LAPACK"),
    (("src/planning/a.f90",), "a.f90:1:", "private"),
    (("src/planning/a.c", "int a;"), "a.c:1:", "no Fortran"),
    (("src/planning/a.h", "int a;"), "a.h:1:", "no Fortran"),
    (("app/a.F90", "#define A"), "a.F90:1:", "no Fortran"),
    (("src/attic/a.f90",), "a.f90:1:", "no floor"),
    (("src/interface/f77_entries.f90",), "f77_entries.f90:1:", "outside of modules"),
)


def self_test():
    """The messages of what went wrong: false alarms and violations that were not found."""
    for planted, where, word in ((None, "", ""), *PLANTED):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            plant_clean_house(root)
            if planted:
                plant(root, *planted, head="" if word == "private" else "private")
            found = list(violations(root))
        if planted is None and found:
            yield "false alarm: " + "; ".join(found)
        if planted and not any(where in line and word in line for line in found):
            yield f"not found: {word} in {planted}; found: {found}"


def main():
    found = list(self_test() if "--self-test" in sys.argv[1:] else violations(ROOT))
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
