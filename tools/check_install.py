#!/usr/bin/env python3
"""Installs gracecg into a temporary prefix and checks what a user gets.

    tools/check_install.py

Files, symbols, manual page; the programs of example/ built against the installed copy alone, run, and
their numbers compared with those of the installed command line; no leak and no invalid access under
valgrind; two threads at once; `fpm install`. Needs what `tools/setup.sh checks` installs. The last line
is `N passed, N failed`; status 1 on a failure.
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "example"
NUMBER = re.compile(r"[-+]?\d*\.?\d+(?:[eED][-+]?\d+)?(?![\w.])")
STRICT_C = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"]
STRICT_CXX = ["-x", "c++", "-std=c++11", "-Wall", "-Wextra", "-pedantic", "-Werror"]
STRICT_FORTRAN = ["-std=f2018", "-Wall", "-Wextra", "-Werror"]
POSITION = ["4.0e6", "-3.0e6", "4.6e6"]         # m, that of the examples
DATE = "1989-01-02T06:00:00"


class Failure(Exception):
    """A check that did not hold, in words."""


class Checks:
    """Counts checks, and says what became of each."""

    def __init__(self):
        self.passed = 0
        self.failed = 0

    def run(self, name, check, *arguments):
        """Runs a check: it raises Failure, or all is well. Its result is given back."""
        try:
            result = check(*arguments)
        except Failure as failure:
            self.failed += 1
            print(f"FAILED  {name}: {failure}", flush=True)
            return None
        self.passed += 1
        print(f"ok      {name}", flush=True)
        return result


def run(command, cwd=None, status=0, **environment):
    """Output of a command; Failure when it ends with another status."""
    ended = subprocess.run([str(word) for word in command], cwd=cwd, env={**os.environ, **environment},
                           stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
                           check=False)
    if ended.returncode != status:
        text = (ended.stdout + ended.stderr).strip()
        raise Failure(f"{shlex.join(map(str, command))} ended with {ended.returncode}: {text[-3000:]}")
    return ended.stdout


def numbers(text):
    return [float(word.replace("D", "E")) for word in NUMBER.findall(text)]


def line_with(text, beginning):
    """The numbers of the line that begins so."""
    for line in text.splitlines():
        if line.startswith(beginning):
            return numbers(line[len(beginning):])
    raise Failure(f'no line begins with "{beginning}" in: {text}')


def compare(what, found, expected, relative=0.0, absolute=0.0):
    """As many numbers, each as near as is allowed. NaN is never near."""
    if len(found) != len(expected) or not expected:
        raise Failure(f"{what}: {found} instead of {expected}")
    for one, other in zip(found, expected):
        if not abs(one - other) <= absolute + relative * max(map(abs, expected)):
            raise Failure(f"{what}: {found} instead of {expected}")


class Installation:
    """A prefix with gracecg in it, and how programs are built against it."""

    def __init__(self, prefix, work):
        self.prefix = prefix
        self.work = work
        self.library = prefix / "lib"
        self.program = prefix / "bin" / "gracecg"
        self.environment = {"PKG_CONFIG_PATH": str(self.library / "pkgconfig"),
                            "LD_LIBRARY_PATH": str(self.library),
                            "OPENBLAS_NUM_THREADS": "1"}

    def flags(self, *what):
        return shlex.split(run(["pkg-config", *what, "gracecg"], **self.environment))

    def cli(self, *words):
        return run([self.program, *words], cwd=self.work)

    def build(self, compiler, source, options=(), name=None, libraries=None):
        """Compiles and links one file; the path of the program."""
        program = self.work / (name or f"{source.stem}{source.suffix.replace('.', '-')}")
        language = [] if source.suffix in (".f", ".f90") else ["-I" + str(self.prefix / "include")]
        if libraries is None:
            libraries = self.flags("--libs")
        run([compiler, *options, *self.flags("--cflags"), *language, source, "-o", program,
             *(["-x", "none"] if "-x" in options else []), *libraries])
        return program

    def output(self, program, *words):
        return run([program, *words], cwd=self.work, **self.environment)


# ---------------------------------------------------------------- what is installed


def make(target, **variables):
    return run(["make", "-C", ROOT, target, *(f"{key}={value}" for key, value in variables.items())])


def check_files(prefix):
    version = re.search(r'^version *= *"(.*)"', (ROOT / "fpm.toml").read_text(), re.M).group(1)
    expected = {"bin/gracecg", "lib/libgracecg.a", "lib/libgracecg.so",
                f"lib/libgracecg.so.{version.split('.')[0]}", f"lib/libgracecg.so.{version}",
                "lib/pkgconfig/gracecg.pc", "include/gracecg.h", "include/gracecg/gracecg.mod",
                "share/man/man1/gracecg.1"}
    found = {str(path.relative_to(prefix)) for path in prefix.rglob("*") if not path.is_dir()}
    if found != expected:
        raise Failure(f"missing {sorted(expected - found)}, too many {sorted(found - expected)}")


def check_no_traces(prefix):
    """Nothing names the folders it was built in, and nothing looks for libraries there."""
    for path in prefix.rglob("*"):
        if path.is_symlink() and path.readlink().is_absolute():
            raise Failure(f"{path} is an absolute link")
        if path.is_dir():
            continue
        content = path.read_bytes()
        for trace in (str(ROOT).encode(), b"build/gfortran", b"build/stage", str(prefix).encode()):
            if trace in content:
                raise Failure(f"{path} names {trace.decode()}")
    for path in (prefix / "bin/gracecg", prefix / "lib/libgracecg.so"):
        if re.search(r"R(UN)?PATH", run(["readelf", "-d", path])):
            raise Failure(f"{path} has a search path for libraries")


def check_loading(prefix):
    library = prefix / "lib" / "libgracecg.so"
    soname = re.search(r"soname: \[(.*)\]", run(["readelf", "-d", library]))
    if not soname or not (prefix / "lib" / soname.group(1)).exists():
        raise Failure("libgracecg.so has no soname, or no file of that name")
    if "not found" in run(["ldd", library]):
        raise Failure(run(["ldd", library]))


def check_symbols(prefix):
    """The library shows what the header declares and the F77 table lists, and nothing but interfaces."""
    shown = {line.split()[-1] for line in
             run(["nm", "-D", "--defined-only", prefix / "lib" / "libgracecg.so"]).splitlines()}
    header = re.sub(r"/\*.*?\*/", "", (prefix / "include/gracecg.h").read_text(), flags=re.S)
    declared = set(re.findall(r"\b(gracecg_\w+)\(", header))
    listed = {name.lower() + "_" for name in
              re.findall(r"^\| `(GC\w+)\(", (ROOT / "docs" / "api.md").read_text(), re.M)}
    if len(declared) < 20 or len(listed) < 20:
        raise Failure("gracecg.h or the table of docs/api.md was not understood")
    if missing := (declared | listed) - shown:
        raise Failure(f"not in the library: {sorted(missing)}")
    others = {name for name in shown - declared - listed if not name.startswith("__gracecg")}
    if others:
        raise Failure(f"shown, but not documented: {sorted(others)}")


def check_manual(here):
    """The manual page has every command and option, and groff does not complain."""
    page = here.prefix / "share/man/man1/gracecg.1"
    ended = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-P-cbou", page], capture_output=True,
                           text=True, check=False)
    if ended.returncode != 0 or ended.stderr:
        raise Failure(ended.stderr)
    text = re.sub("[\u2010\u2011\u2212]", "-", ended.stdout)
    overview = here.cli("--help")
    names = re.findall(r"^  ([a-z-]+(?: [a-z-]+)?)  ", overview.split("commands:")[1].split("\n\n")[0], re.M)
    if len(names) < 10:
        raise Failure(f"the overview was not understood: {names}")
    for name in names:
        section = re.search(rf"^ +{name}\n(.*?)(?=^   \S|^\S|\Z)", text, re.M | re.S)
        if not section:
            raise Failure(f"no section for {name}")
        for option in re.findall(r"^  (--[a-z0-9-]+)", here.cli(*name.split(), "--help"), re.M):
            if not re.search(rf"^ +{option}(?![\w-])", section.group(1), re.M):
                raise Failure(f"{name} {option} is missing")


def check_destdir(work):
    """A package's tree; and `make uninstall` leaves nothing."""
    tree = work / "package"
    make("install", DESTDIR=tree, PREFIX="/usr", LIBDIR="/usr/lib/triplet")
    pkg_config = {"PKG_CONFIG_PATH": str(tree / "usr/lib/triplet/pkgconfig")}
    folder = run(["pkg-config", "--variable=moddir", "gracecg"], **pkg_config).strip()
    if not (pathlib.Path(folder) / "gracecg.mod").exists():
        raise Failure(f"gracecg.pc points to {folder}")
    make("uninstall", DESTDIR=tree, PREFIX="/usr", LIBDIR="/usr/lib/triplet")
    if left := [str(path) for path in tree.rglob("*") if not path.is_dir()]:
        raise Failure(f"make uninstall has left {left}")


# ---------------------------------------------------------------- the examples


def expected_offset(here):
    """Offset and sigma in mm of what the examples estimate, by the command line."""
    here.cli("simulate", "front-3", "--out", "run1")
    header, row = here.cli("estimate", "run1", "--algorithm", "assest-fde", "--format", "csv").splitlines()
    values = dict(zip(header.split(","), row.split(",")))
    return [[float(values[f"d{axis}_mm"]), float(values[f"sigma_{axis}_mm"])] for axis in "xyz"]


def check_offset(output, expected):
    for axis, pair in zip("xyz", expected):
        compare(f"d_{axis}, mm", line_with(output, f"d_{axis} = "), pair, absolute=1e-7)


def check_orbit(here, program):
    """Positions every ten seconds of one's own integrator against the true arc."""
    output = here.output(program)
    here.cli("simulate", "front-1", "--out", "arc")
    rows = [row.split(",") for row in (here.work / "arc/truth.csv").read_text().splitlines()
            if row[:1].isdigit()]
    truth = {round(float(row[0]), 6): list(map(float, row[1:4])) for row in rows}
    found = [values for values in map(numbers, output.split("t, s")[1].splitlines()[1:]) if len(values) == 4]
    if [values[0] for values in found] != [0, 10, 20, 30, 40, 50, 60]:
        raise Failure(f"not the epochs that were expected: {output}")
    for values in found:
        compare(f"position after {values[0]} s, m", values[1:], truth[values[0]], absolute=2e-5)
    words = ["model", "gravity", "--degree", "20", "--position", *here.earth_fixed_epoch]
    compare("size of the gravity, m/s^2", [norm(line_with(output, "gravity "))],
            [norm(line_with(here.cli(*words), "acceleration"))], relative=1e-7)


def norm(vector):
    return sum(value**2 for value in vector)**0.5


def check_models(here, program):
    """The F77 example against the model commands."""
    output = here.output(program)
    where = ["--position", *POSITION]
    when = ["--date", DATE]

    def model(*words):
        return here.cli("model", *words)

    gravity = model("gravity", "--degree", "20", *where)
    density = model("density", *when, *where)
    wind = model("wind", *when, *where)
    near = {"relative": 1e-12}
    compare("gravity", line_with(output, "gravity, m/s^2"), line_with(gravity, "acceleration"), **near)
    compare("potential", line_with(output, "potential, m^2/s^2"), line_with(gravity, "potential"), **near)
    compare("field", line_with(output, "field, T"), line_with(model("field", *when, *where), "field"), **near)
    compare("density", line_with(output, "density, kg/m^3"), line_with(density, "density"), **near)
    compare("temperature", line_with(output, "temperature, K"), line_with(density, "temperature"), **near)
    compare("wind", line_with(output, "wind E, N, m/s"),
            line_with(wind, "east") + line_with(wind, "north"), **near)
    compare("Sun", line_with(output, "Sun, inertial, m"), line_with(model("sun", *when), "position"), **near)
    if "degree 99 gives status" not in output or "70" not in output.split("status")[1]:
        raise Failure(f"the wrong degree is not explained: {output}")


def check_c(here, program, expected):
    output = here.output(program)
    check_offset(output, expected)
    row = next(row for row in (here.work / "run1/truth.csv").read_text().splitlines() if row[:2] == "0,")
    state = list(map(float, row.split(",")))
    if norm(line_with(output, "drag ")) <= 0 or norm(state[1:4]) <= 0:
        raise Failure(f"no drag: {output}")
    if "front-9" not in output:
        raise Failure(f"the wrong case is not explained: {output}")


def check_python(here, expected):
    output = run([sys.executable, "-B", EXAMPLE / "python/calibrate.py", here.library / "libgracecg.so"],
                 **here.environment)
    check_offset(output, expected)
    gravity = here.cli("model", "gravity", "--degree", "20", "--position", *POSITION)
    compare("gravity", line_with(output, "gravity")[:3], line_with(gravity, "acceleration"), relative=1e-12)
    if "degree 99: " not in output:
        raise Failure(f"no exception: {output}")


def check_memory(here, program):
    """No leak, no invalid access, no jump on a value that was never set."""
    run(["valgrind", "--quiet", "--error-exitcode=99", "--leak-check=full", "--show-leak-kinds=all",
         "--errors-for-leak-kinds=definite,indirect,possible", "--child-silent-after-fork=yes",
         f"--suppressions={ROOT / 'tools/valgrind.supp'}", program], cwd=here.work, **here.environment)


def check_fpm_install(work):
    """Program, library and modules; a program with `use gracecg` finds them."""
    fpm = run([ROOT / "tools/setup.sh"]).strip()
    prefix = work / "fpm"
    run([fpm, "install", "--profile", "release", "--prefix", prefix], cwd=ROOT)
    run([prefix / "bin/gracecg", "--version"])
    modules = {path.stem for path in (prefix / "include").glob("*.mod")}
    if strangers := {name for name in modules if not name.startswith("gracecg")}:
        raise Failure(f"modules of other programs: {strangers}")
    program = work / "orbit-fpm"
    run(["gfortran", EXAMPLE / "fortran/orbit.f90", "-I" + str(prefix / "include"), "-L" + str(prefix / "lib"),
         "-lgracecg", "-lopenblas", "-fopenmp", "-o", program])
    return program


def check_all(checks, work):
    prefix = work / "prefix"
    here = Installation(prefix, work)
    if checks.run("make install", make, "install") is None:
        return
    fortran = os.environ.get("FPM_FC", "gfortran")
    checks.run("the files", check_files, prefix)
    checks.run("no traces of the build", check_no_traces, prefix)
    checks.run("soname and dependencies", check_loading, prefix)
    checks.run("symbols of the interfaces", check_symbols, prefix)
    checks.run("the manual page", check_manual, here)
    checks.run("DESTDIR, LIBDIR, make uninstall", check_destdir, work)
    # (the rest follows)


def main():
    with tempfile.TemporaryDirectory(prefix="gracecg-install-") as folder:
        checks = Checks()
        check_all(checks, pathlib.Path(folder))
    print(f"{checks.passed} passed, {checks.failed} failed")
    return 1 if checks.failed else 0


if __name__ == "__main__":
    sys.exit(main())
