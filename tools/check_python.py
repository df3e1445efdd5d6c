#!/usr/bin/env python3
"""Builds with CMake, once, the library and the Python package; checks both as a new user meets them.

    tools/check_python.py [--build-only | --built] [PROGRAM]

In build/python-venv: `pip install .` (without optimisation, to be quick) with its build tree kept in build/python; from
that tree `cmake --install`, and programs in Fortran and C that find the package by find_package and by FetchContent;
then the tests of python/tests, among them the digits of PROGRAM (build/bin/gracecg). The packages come from PyPI.
The last line is `N passed, N failed`. --build-only ends after the build: .ci/run begins it early, beside its other work, and
goes on with --built.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
VENV = ROOT / "build/python-venv"
TREE = ROOT / "build/python"
PYTHON = VENV / "bin/python"

CONSUMER = """cmake_minimum_required(VERSION 3.20)
project(consumer LANGUAGES C Fortran)
find_package(gracecg REQUIRED)
add_executable(in_fortran in_fortran.f90)
target_link_libraries(in_fortran PRIVATE gracecg::gracecg)
add_executable(in_c in_c.c)
target_link_libraries(in_c PRIVATE gracecg::gracecg)
add_executable(of_level1 of_level1.f90)
target_link_libraries(of_level1 PRIVATE gracecg::level1)
add_executable(level1_in_c level1_in_c.c)
target_link_libraries(level1_in_c PRIVATE gracecg::level1)
"""
FETCHING = """cmake_minimum_required(VERSION 3.20)
project(fetching LANGUAGES Fortran)
include(FetchContent)
FetchContent_Declare(gracecg SOURCE_DIR "@ROOT@")
FetchContent_MakeAvailable(gracecg)
add_executable(in_fortran in_fortran.f90)
target_link_libraries(in_fortran PRIVATE gracecg::gracecg)
get_target_property(type gracecg TYPE)
if(NOT type STREQUAL "STATIC_LIBRARY" OR TARGET gracecg-program)
    message(FATAL_ERROR "within another project only the static library is expected")
endif()
"""
# A project without Fortran
FETCHING_IN_C = """cmake_minimum_required(VERSION 3.20)
project(fetching LANGUAGES C)
add_subdirectory("@ROOT@" gracecg)
add_executable(in_c in_c.c)
target_link_libraries(in_c PRIVATE gracecg::gracecg)
"""
IN_FORTRAN = """program in_fortran
    use gracecg, only: dp, error_t, geopotential_t, egm96
    implicit none
    type(geopotential_t) :: model
    type(error_t), allocatable :: error
    real(dp) :: a(3)

    call egm96(20, 20, model, error)
    if (allocated(error)) error stop 1
    call model%acceleration([4.0e6_dp, -3.0e6_dp, 4.6e6_dp], a)
    print '(3es25.16)', a
end program in_fortran
"""
OF_LEVEL1 = """program of_level1
    use, intrinsic :: iso_fortran_env, only: int64
    use gracecg, only: dp
    use gracecg_level1, only: gps_date_text
    implicit none

    print '(a)', gps_date_text(0_int64, 0.0_dp)
end program of_level1
"""
# A tree as this project's, with a type of the library that the program uses.
SMALL = {"src/base/library.f90": """module library
    implicit none
    type held_t
        integer :: number = 1
    end type held_t
contains
    subroutine show(held)
        type(held_t), intent(in) :: held

        print '(i0)', held%number
    end subroutine show
end module library
""", "level1/src/level1.f90": """module level1
    use library, only: held_t
    implicit none
    type, extends(held_t) :: record_t
    end type record_t
end module level1
""", "app/cli/command.f90": """module command
    use library, only: held_t, show
    implicit none
contains
    subroutine run()
        type(held_t) :: held

        call show(held)
    end subroutine run
end module command
""", "app/main.f90": """program main
    use command, only: run
    implicit none
    call run()
end program main
"""}
IN_C = """#include <gracecg.h>
#include <stdio.h>
int main(void)
{
    const double position[3] = {4.0e6, -3.0e6, 4.6e6};
    double a[3];
    gracecg_object *gravity;
    if (gracecg_gravity_open("egm96", 20, 20, &gravity, NULL) != GRACECG_OK) return 1;
    if (gracecg_gravity_evaluate(gravity, 1, position, a, NULL, NULL, NULL) != GRACECG_OK) return 1;
    printf("%.16e %.16e %.16e\\n", a[0], a[1], a[2]);
    return gracecg_free(&gravity, NULL) != GRACECG_OK;
}
"""


def run(*command, **environment):
    """The output of a command; raises what it said when it failed."""
    ended = subprocess.run([str(word) for word in command], env={**os.environ, **environment}, text=True,
                           stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if ended.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}:\n{ended.stdout[-4000:]}")
    return ended.stdout


def build():
    if not PYTHON.exists():
        run(sys.executable, "-m", "venv", VENV)
    run(PYTHON, "-m", "pip", "install", "-q", "scikit-build-core", "cmake", "ninja", "cffi", "numpy", "pytest",
        "jinja2", "matplotlib", "distributed")
    run(PYTHON, "-m", "pip", "install", "-q", "--no-build-isolation", "--no-deps", "--force-reinstall",
        "-C", f"build-dir={TREE}", "-C", "cmake.build-type=None", "-C", "cmake.define.CMAKE_Fortran_FLAGS=-O0", ROOT)


def numbers(text):
    return [float(word) for word in re.findall(r"-?\d\.\d+[eE][-+]\d+", text)]


def check_consumer():
    """An installed copy, by find_package, from Fortran and C; and the sources, by FetchContent."""
    cmake = VENV / "bin/cmake"
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        run(cmake, "--install", TREE, "--prefix", work / "prefix")
        for name in ("lib/cmake/gracecg/gracecgConfig.cmake", *(name.replace("*", library) for library in (
                "gracecg", "gracecg_level1") for name in ("include/*.h", "include/gracecg/*.mod", "lib/pkgconfig/*.pc"))):
            if not (work / "prefix" / name).exists():
                raise RuntimeError(f"{name} was not installed")
        for name, text in (("CMakeLists.txt", CONSUMER), ("in_fortran.f90", IN_FORTRAN), ("in_c.c", IN_C),
                           ("of_level1.f90", OF_LEVEL1), ("level1_in_c.c", (ROOT / "example/c/level1.c").read_text())):
            (work / name).write_text(text, encoding="utf-8")
        run(cmake, "-S", work, "-B", work / "build", f"-DCMAKE_PREFIX_PATH={work / 'prefix'}")
        run(cmake, "--build", work / "build")
        one, other = (numbers(run(work / "build" / name)) for name in ("in_fortran", "in_c"))
        if len(one) != 3 or one != other:
            raise RuntimeError(f"Fortran and C give {one} and {other}")
        for name, part in (("of_level1", "2000-01-01T12:00:00"), ("level1_in_c", "2 records")):
            if part not in (said := run("env", "-C", work, work / "build" / name)):
                raise RuntimeError(f"{name} says {said}")
        (work / "fetching").mkdir()
        for name, text in (("CMakeLists.txt", FETCHING.replace("@ROOT@", str(ROOT))), ("in_fortran.f90", IN_FORTRAN)):
            (work / "fetching" / name).write_text(text, encoding="utf-8")
        run(cmake, "-S", work / "fetching", "-B", work / "fetched")
        (work / "in_c").mkdir()
        for name, text in (("CMakeLists.txt", FETCHING_IN_C.replace("@ROOT@", str(ROOT))), ("in_c.c", IN_C)):
            (work / "in_c" / name).write_text(text, encoding="utf-8")
        run(cmake, "-S", work / "in_c", "-B", work / "fetched_in_c", "-G", "Unix Makefiles")
        command = (work / "fetched_in_c/CMakeFiles/in_c.dir/link.txt").read_text(encoding="utf-8")
        if "-lgfortran" not in command:
            raise RuntimeError(f"a program in C is linked without Fortran's run-time library: {command}")


def check_documents(folder, names):
    """Licence and attributions go with what is installed."""
    for name in names:
        if not (folder / name).is_file():
            raise RuntimeError(f"{folder / name} was not installed")


def check_package_documents():
    """The same of the Python package, with the notices of what a wheel holds."""
    folder = next(VENV.glob("lib/python*/site-packages/gracecg-*.dist-info"))
    names = {path.name for path in folder.rglob("*") if path.is_file()}
    if missing := {"LICENSE", "CC-BY-4.0.txt", "README.md", "bundled.txt"} - names:
        raise RuntimeError(f"{folder} has no {', '.join(sorted(missing))}")


def check_pkg_config():
    """The pkg-config file finds the prefix from the folder of libraries, Debian's too; licence and attributions."""
    for folder in ("lib", "lib/x86_64-linux-gnu"):
        with tempfile.TemporaryDirectory() as tree:
            run(VENV / "bin/cmake", "-S", ROOT, "-B", tree, "-DCMAKE_INSTALL_PREFIX=/usr", f"-DCMAKE_INSTALL_LIBDIR={folder}")
            text = (pathlib.Path(tree) / "gracecg.pc").read_text(encoding="utf-8")
            run(VENV / "bin/cmake", "--install", tree, "--component", "documents", "--prefix", pathlib.Path(tree) / "prefix")
            check_documents(pathlib.Path(tree) / "prefix/share/doc/gracecg", ("LICENSE", "DATA.md", "LICENSES/CC-BY-4.0.txt"))
        way = re.search(r"^prefix=\$\{pcfiledir\}/(.*)$", text, re.MULTILINE)[1]
        if os.path.normpath(f"/usr/{folder}/pkgconfig/{way}") != "/usr":
            raise RuntimeError(f"below {folder} the prefix is {way}")


def check_changed_modules():
    """With Ninja, what uses a module that has changed is compiled anew."""
    with tempfile.TemporaryDirectory() as folder:
        tree = pathlib.Path(folder)
        for name in ("CMakeLists.txt", "fpm.toml", "include", "tools/cmake", "tools/commit.sh"):
            (tree / name).parent.mkdir(exist_ok=True)
            (tree / name).symlink_to(ROOT / name)
        for name, text in SMALL.items():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).write_text(text, encoding="utf-8")
        run(VENV / "bin/cmake", "-S", tree, "-B", tree / "build", "-G", "Ninja", "-DBUILD_SHARED_LIBS=OFF",
            f"-DCMAKE_MAKE_PROGRAM={VENV / 'bin/ninja'}")
        run(VENV / "bin/cmake", "--build", tree / "build")
        library = tree / "src/base/library.f90"
        library.write_text(SMALL["src/base/library.f90"].replace("integer ::", "real :: before(3) = 5\n        integer ::"),
                           encoding="utf-8")
        run(VENV / "bin/cmake", "--build", tree / "build")
        shown = run(tree / "build/gracecg").strip()
        if shown != "1":
            raise RuntimeError(f"the program shows {shown} for 1")


def check_size():
    """CMakeLists.txt has less than a hundred lines."""
    lines = len((ROOT / "CMakeLists.txt").read_text(encoding="utf-8").splitlines())
    if lines >= 100:
        raise RuntimeError(f"CMakeLists.txt has {lines} lines")


def main():
    try:
        if "--built" not in sys.argv:
            build()
    except RuntimeError as failure:
        print(f"FAILED  build: {failure}\n0 passed, 1 failed")
        return 1
    arguments = [word for word in sys.argv[1:] if not word.startswith("--")]
    if "--build-only" in sys.argv:
        return 0
    passed = failed = 0
    for check in (check_size, check_package_documents, check_pkg_config, check_consumer, check_changed_modules):
        try:
            check()
            passed += 1
            print(f"ok      {check.__doc__}")
        except RuntimeError as failure:
            failed += 1
            print(f"FAILED  {check.__doc__} {failure}")
    program = pathlib.Path(arguments[0] if arguments else ROOT / "build/bin/gracecg").resolve()
    # Without optimisation the last digits differ; those of an optimised package are equal to 1e-9
    ended = subprocess.run([PYTHON, "-m", "pytest", "-q", "-p", "no:cacheprovider", ROOT / "python/tests"], check=False,
                           env={**os.environ, "GRACECG_PROGRAM": str(program), "GRACECG_DIGITS": "1e-6",
                                "OPENBLAS_NUM_THREADS": "1"}, text=True, stdout=subprocess.PIPE, cwd=ROOT / "build")
    print(ended.stdout)
    counts = {word: int(number) for number, word in re.findall(r"(\d+) (passed|failed|error|skipped)", ended.stdout)}
    passed += counts.get("passed", 0)
    failed += counts.get("failed", 0) + counts.get("error", 0) + (ended.returncode != 0 and not counts.get("failed", 0))
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
