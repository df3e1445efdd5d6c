"""Builds the programs of example/ against an installed copy, and compares their numbers with the command line's."""
import os
import pathlib
import re
import sys

from install_checks import EXAMPLE, LEVEL, LIBRARIES, POSITION, ROOT, Failure, compare, line_with, loader_takes_level, numbers, run

STRICT_C = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"]
STRICT_CXX = ["-x", "c++", "-std=c++11", "-Wall", "-Wextra", "-pedantic", "-Werror"]
STRICT_F77 = ["-std=legacy", "-Wall", "-Wno-unused-dummy-argument", "-Werror"]
STRICT_FORTRAN = ["-std=f2018", "-Wall", "-Wextra", "-Werror"]
DATE = "1989-01-02T06:00:00"


def expected_offset(here):
    """Offset and sigma in mm of what the examples estimate, by the command line."""
    here.cli("simulate", "front-3", "--out", "run1")
    values = here.table("estimate", "run1", "--algorithm", "assest-fde", "--format", "csv")
    return [[values[f"d{axis}_mm"], values[f"sigma_{axis}_mm"]] for axis in "xyz"]


def check_offset(output, expected):
    for axis, pair in zip("xyz", expected):
        compare(f"d_{axis}, mm", line_with(output, f"d_{axis} = "), pair, absolute=1e-7)


def check_orbit(here, program):
    """Positions every ten seconds of one's own integrator against the true arc."""
    output = here.output(program)
    here.cli("simulate", "front-1", "--out", "arc")
    truth = true_arc(here.work / "arc")
    found = [values for values in map(numbers, output.split("t, s")[1].splitlines()[1:]) if len(values) == 4]
    if [values[0] for values in found] != [0, 10, 20, 30, 40, 50, 60]:
        raise Failure(f"not the epochs that were expected: {output}")
    for values in found:
        row = truth[values[0]]
        compare(f"position after {values[0]} s, m", values[1:], [row["rx_m"], row["ry_m"], row["rz_m"]],
                absolute=2e-5)


def true_arc(folder):
    """The rows of truth.csv by time, each by column."""
    lines = (folder / "truth.csv").read_text().splitlines()
    rows = [dict(zip(lines[0].split(","), map(float, line.split(",")))) for line in lines[1:]]
    return {row["time_s"]: row for row in rows}


def check_models(here, program):
    """The F77 example against the model commands."""
    output = here.output(program)
    where = ["--position", *POSITION]
    when = ["--date", DATE]

    def expect(label, command, *columns):
        values = here.table(*command)
        compare(label, line_with(output, label), [values[column] for column in columns], relative=1e-12)

    gravity = ["model", "gravity", "--degree", "20", *where]
    expect("gravity, m/s^2", gravity, "ax_m_s2", "ay_m_s2", "az_m_s2")
    expect("potential, m^2/s^2", gravity, "potential_m2_s2")
    expect("field, T", ["model", "field", *when, *where], "bx_tesla", "by_tesla",
           "bz_tesla")
    expect("density, kg/m^3", ["model", "density", *when, *where], "density_kg_m3")
    expect("temperature, K", ["model", "density", *when, *where], "temperature_kelvin")
    expect("wind E, N, m/s", ["model", "wind", *when, *where], "east_m_s", "north_m_s")
    expect("Sun, inertial, m", ["model", "sun", *when], "x_m", "y_m", "z_m")
    if "degree 99 gives status 4" not in output or "0 to 70" not in output:
        raise Failure(f"the wrong degree is not explained: {output}")


def check_acceleration(here, output):
    """The line `total` against the derivative of the true arc's velocity at the epoch."""
    rows = true_arc(here.work / "run1")
    slope = [sum(weight * rows[round(k * 0.1, 1)][name]
                 for k, weight in enumerate((-25, 48, -36, 16, -3))) / 1.2 for name in ("vx_m_s", "vy_m_s", "vz_m_s")]
    compare("acceleration, m/s^2", line_with(output, "total")[:3], slope, absolute=2e-9)


def check_calibration(here, program, expected):
    """The action and the offset."""
    output = here.output(program)
    if "trim: move the centre of mass by " not in output:
        raise Failure(f"what to do is not said: {output}")
    check_offset(output, expected)
    return output


def check_c(here, program, expected):
    """The same, and the acceleration."""
    output = check_calibration(here, program, expected)
    check_acceleration(here, output)
    if "front-9: " not in output:
        raise Failure(f"the wrong case is not explained: {output}")


BOUND_COLUMNS = [f"sigma_{axis}_mm" for axis in "xyz"]


def check_bound(here, program):
    """The bound of front-2 against the command's; a case without rods is explained."""
    output = here.output(program)
    values = here.table("bound", "front-2", "--format", "csv")
    compare("sigma, mm", line_with(output, "sigma"), [values[name] for name in BOUND_COLUMNS], relative=1e-8)
    compare("worst, mm", line_with(output, "worst"), [values["worst_sigma_mm"]], relative=1e-8)
    compare("direction", line_with(output, "along"), [values[f"worst_{axis}"] for axis in "xyz"], absolute=1e-7)
    if "rods are off" not in output:
        raise Failure(f"the case without rods is not explained: {output}")


def check_design(here, program):
    """The manoeuvre, its errors and its map against the command's, and the bound of the planned case
    against that of the case file that the command writes."""
    output = here.output(program)
    values = here.table("design", "front-2", "--waveforms", "sine", "--step", "600", "--out", "best.nml",
                        "--map", "map.csv", "--threads", "2", "--format", "csv")
    for what in ("sigma", "wave", "force"):
        compare(f"{what}, mm", line_with(output, what), [values[f"{what}_{axis}_mm"] for axis in "xyz"],
                relative=1e-8)
    values = here.table("bound", "best.nml", "--format", "csv")
    compare("bound, mm", line_with(output, "bound"), [values[name] for name in BOUND_COLUMNS], relative=1e-7)
    lines = (here.work / "map.csv").read_text().splitlines()
    names = lines[0].split(",")
    rows = [{name: float(field) for name, field in zip(names, line.split(",")) if name != "utc"} for line in lines[1:10]]
    found = [numbers(line) for line in output.split("time, s")[1].splitlines()[1:]]
    if len(found) != 9:
        raise Failure(f"not the map that was expected: {output}")
    for one, row in zip(found, rows):
        compare("time, s", one[:1], [row["time_s"]])
        compare("latitude, deg", one[1:2], [row["latitude_deg"]], absolute=1e-3)
        compare("sigma along the orbit, mm", one[2:], [row[name] for name in BOUND_COLUMNS], relative=1e-8)


def check_optimal(here, program):
    """Estimate and bound against the commands'; the variance factor and the torque are those printed."""
    output = here.output(program)
    here.cli("simulate", "front-3", "--out", "run1")
    values = here.table("estimate", "run1", "--algorithm", "optimal", "--format", "csv")
    bound = here.table("bound", "front-3", "--format", "csv")
    check_offset(output, [[values[f"d{axis}_mm"], values[f"sigma_{axis}_mm"], bound[f"sigma_{axis}_mm"]]
                          for axis in "xyz"])
    text = here.cli("estimate", "run1", "--algorithm", "optimal")
    compare("variance factor", line_with(output, "variance factor"), line_with(text, "variance factor")[:1],
            absolute=1e-4)
    for axis in "xyz":
        name = f"torque_{axis}"
        compare(name, line_with(output, name)[:1], line_with(text, name)[:1], relative=1e-3)


def check_live(here, program):
    """After all samples the live estimate is that of `sequential`, which has them all at once: its sigmas within a tenth, the
    offset within one sigma."""
    last = numbers(here.output(program).splitlines()[-1].split("d")[-1])
    here.cli("simulate", "front-3", "--out", "run1")
    values = here.table("estimate", "run1", "--algorithm", "sequential", "--format", "csv")
    for axis, offset, sigma in zip("xyz", last[0::2], last[1::2]):
        compare(f"sigma of {axis}, mm", [sigma], [values[f"sigma_{axis}_mm"]], relative=0.1)
        compare(f"d_{axis}, mm", [offset], [values[f"d{axis}_mm"]], absolute=values[f"sigma_{axis}_mm"])


def check_python(here, expected):
    output = run([sys.executable, "-B", EXAMPLE / "python/calibrate.py", here.library / "libgracecg.so"],
                 **here.environment)
    check_offset(output, expected)
    values = here.table("model", "gravity", "--degree", "20", "--position", *POSITION)
    compare("gravity", line_with(output, "gravity")[:3], [values[name] for name in ("ax_m_s2", "ay_m_s2", "az_m_s2")],
            relative=1e-12)
    if "degree 99: " not in output:
        raise Failure(f"no exception: {output}")


def check_level1(here, program, *parts):
    """The example of Level-1 data reads the file that it has written."""
    output = here.output(program)
    if missing := [part for part in parts if part not in output]:
        raise Failure(f"{missing} is not in: {output}")


def check_memory(here, program):
    """No block left, no invalid access, no jump on a value that was never set."""
    run(["valgrind", "--quiet", "--error-exitcode=99", "--leak-check=full",
         "--show-leak-kinds=all", "--errors-for-leak-kinds=all", f"--suppressions={ROOT / 'tools/valgrind.supp'}",
         program], cwd=here.work, **here.environment)


def check_level(here, program):
    """The loader takes the library of the best level that the processor runs, and the other where that is masked; both
    give the same to rounding."""
    def taken(*options):
        loader = re.search(r"(/\S*ld-linux-x86-64\S*)", run(["ldd", program], **here.environment))[1]
        libraries = run([loader, *options, "--list", program], **here.environment)
        path = pathlib.Path(re.search(r"libgracecg\.so\.\d+ => (\S+)", libraries)[1])
        return path.parent, run([loader, *options, program], cwd=here.work, **here.environment)

    folder, output = taken()
    expected = here.library / "glibc-hwcaps" / LEVEL if loader_takes_level() else here.library
    if folder != expected:
        raise Failure(f"the loader takes the library in {folder} instead of {expected}")
    masked, other = taken("--glibc-hwcaps-mask", "none")
    if masked != here.library:
        raise Failure(f"with the levels masked the loader takes the library in {masked}")
    compare("gravity", line_with(output, "gravity, m/s^2"), line_with(other, "gravity, m/s^2"), relative=1e-12)


def check_stable(here, program, expected):
    """A program of an earlier version of the interface: the numbers of the commands of this one."""
    output = here.output(program)
    values = here.table("model", "gravity", "--degree", "20", "--position", *POSITION)
    compare("gravity", line_with(output, "gravity")[:3], [values[f"a{axis}_m_s2"] for axis in "xyz"], relative=1e-11)
    compare("potential", line_with(output, "gravity")[3:], [values["potential_m2_s2"]], relative=1e-11)
    check_acceleration(here, output)
    values = here.table("bound", "front-3", "--format", "csv")
    compare("sigma", line_with(output, "sigma"), [1e-3*values[name] for name in BOUND_COLUMNS], relative=1e-8)
    compare("offset", line_with(output, "offset"), [1e-3*offset for offset, _ in expected], absolute=1e-10)


def check_threads(here, program, expected):
    output = here.output(program)
    if "two threads at once" not in output:
        raise Failure(output)
    compare("seed 1, mm", line_with(output, "seed 1: d = "), [offset for offset, _ in expected], absolute=1e-7)


def check_static_level1(here, program):
    if "libgracecg" in run(["readelf", "-d", program]):
        raise Failure("the program needs a shared library")
    check_level1(here, program, "CLK1B C", "2 records", "eps_time")


def check_static(here, program, expected):
    if "libgracecg" in run(["readelf", "-d", program]):
        raise Failure("the program needs the shared library")
    check_offset(run([program], cwd=here.work), expected)


def check_examples(checks, here):
    """Builds every example with strict options, runs it, compares its numbers."""
    fortran = os.environ.get("FPM_FC", "gfortran")
    expected = checks.run("the command line's own estimate", expected_offset, here)

    def example(label, check, compiler, source, options, *arguments):
        program = checks.run(f"{label} builds", here.build, compiler, EXAMPLE / source, options, label)
        if program is not None:
            checks.run(f"{label} gives the command line's numbers", check, here, program, *arguments)
        return program

    example("orbit (Fortran)", check_orbit, fortran, "fortran/orbit.f90", STRICT_FORTRAN)
    example("calibrate (Fortran)", check_calibration, fortran, "fortran/calibrate.f90", STRICT_FORTRAN, expected)
    example("bound (Fortran)", check_bound, fortran, "fortran/bound.f90", STRICT_FORTRAN)
    example("design (Fortran)", check_design, fortran, "fortran/design.f90", STRICT_FORTRAN)
    example("level1 (Fortran)", check_level1, fortran, "fortran/level1.f90", STRICT_FORTRAN, "USO1B", "3 records", "uso_freq")
    level1 = example("level1 (C)", check_level1, "cc", "c/level1.c", STRICT_C, "CLK1B C", "2 records", "eps_time")
    optimal = example("optimal (C)", check_optimal, "cc", "c/optimal.c", STRICT_C)
    live = example("live (C)", check_live, "cc", "c/live.c", [*STRICT_C, "-Wl,--no-as-needed", "-lm"])
    models = example("models (F77)", check_models, fortran, "f77/models.f", STRICT_F77)
    calibrate = example("calibrate (C)", check_c, "cc", "c/calibrate.c", STRICT_C, expected)
    example("version 1 (C)", check_stable, "cc", "version_1/version_1.c", STRICT_C, expected)
    example("version 1 (F77)", check_stable, fortran, "version_1/version_1.f", STRICT_F77, expected)
    example("calibrate (C++)", check_c, "c++", "c/calibrate.c", STRICT_CXX, expected)
    example("threads (C)", check_threads, "cc", "c/threads.c", [*STRICT_C, "-pthread"], expected)
    checks.run("calibrate (Python) gives the command line's numbers", check_python, here, expected)
    if models is not None and loader_takes_level() is not None:
        checks.run("the loader takes the library for this processor", check_level, here, models)
    for label, program in (("models (F77)", models), ("calibrate (C)", calibrate),
                           ("optimal (C)", optimal), ("live (C)", live), ("level1 (C)", level1)):
        if program is not None:
            checks.run(f"{label} under valgrind", check_memory, here, program)
    static = checks.run("level1 (C) links the static libraries", here.build, "cc", EXAMPLE / "c/level1.c", STRICT_C,
                        "level1 static", [*(here.library / f"lib{name}.a" for name in reversed(LIBRARIES)),
                                          *here.flags("--static", "--libs")])
    if static is not None:
        checks.run("it needs no shared library of both", check_static_level1, here, static)
    static = checks.run("calibrate (C) links the static library", here.build, "cc", EXAMPLE / "c/calibrate.c",
                        STRICT_C, "static", [here.library / "libgracecg.a", *here.flags("--static", "--libs")])
    if static is not None:
        checks.run("it needs no shared libgracecg", check_static, here, static, expected)
