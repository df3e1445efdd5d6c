#!/usr/bin/env python3
"""Installs gracecg into a temporary prefix and checks what a user gets.

    tools/check_install.py

Files, symbols, manual page; the programs of example/ built against the installed copy alone, run, and
their numbers compared with those of the installed command line; no leak and no invalid access under
valgrind; two threads at once; `fpm install`; what the README says of linking. Needs what `tools/setup.sh checks` installs. The last line
is `N passed, N failed`; status 1 on a failure.
"""
import gzip
import os
import pathlib
import pty
import re
import select
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "example"
NUMBER = re.compile(r"[-+]?\d*\.?\d+(?:[eED][-+]?\d+)?(?![\w.])")
STRICT_C = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"]
STRICT_CXX = ["-x", "c++", "-std=c++11", "-Wall", "-Wextra", "-pedantic", "-Werror"]
STRICT_F77 = ["-std=legacy", "-Wall", "-Wno-unused-dummy-argument", "-Werror"]
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

    def flags(self, *what, package="gracecg"):
        return shlex.split(run(["pkg-config", *what, package], **self.environment))

    def cli(self, *words):
        return run([self.program, *words], cwd=self.work)

    def table(self, *words):
        """The first row of a command's CSV output, by column; what is no number is left out."""
        lines = [line for line in self.cli(*words).splitlines() if not line.startswith("#")]
        return {column: float(value) for column, value in zip(lines[0].split(","), lines[1].split(","))
                if NUMBER.fullmatch(value)}

    def build(self, compiler, source, options, label, libraries=None):
        """Compiles and links one file with what pkg-config says of its library; the path of the program."""
        program = self.work / label.replace(" ", "-")
        package = "gracecg_level1" if "level1" in label else "gracecg"
        includes = self.flags("--cflags", package=package)
        language = ["-x", "none"] if "-x" in options else []
        run([compiler, *options, *includes, source, "-o", program, *language,
             *(self.flags("--libs", package=package) if libraries is None else libraries)])
        return program

    def output(self, program, *words):
        return run([program, *words], cwd=self.work, **self.environment)


# ---------------------------------------------------------------- what is installed


def make(target, *variables):
    return run(["make", "-C", ROOT, target, *variables])


LIBRARIES = ("gracecg", "gracecg_level1")
LEVEL = "x86-64-v3"     # the newer processors that the check builds for


def loader_takes_level():
    """Whether the loader of this machine looks into LEVEL's folder; None: it is another kind of machine."""
    if os.uname().machine != "x86_64" or not shutil.which("ldd"):
        return None
    loader = re.search(r"(/\S*ld-linux-x86-64\S*)", run(["ldd", sys.executable]))
    return bool(loader and re.search(rf"{LEVEL} \(supported, searched\)", run([loader[1], "--help"])))


def check_files(prefix):
    version = re.search(r'^version *= *"(.*)"', (ROOT / "fpm.toml").read_text(), re.M).group(1)
    expected = {name for library in LIBRARIES for name in (
        f"lib/lib{library}.a", f"lib/lib{library}.so", f"lib/lib{library}.so.{version.split('.')[0]}",
        f"lib/lib{library}.so.{version}", f"lib/pkgconfig/{library}.pc", f"include/{library}.h",
        f"include/gracecg/{library}.mod")}
    expected |= {"bin/gracecg", "share/man/man1/gracecg.1", "share/bash-completion/completions/gracecg",
                 "share/zsh/site-functions/_gracecg", "share/doc/gracecg/LICENSE", "share/doc/gracecg/DATA.md"}
    if loader_takes_level() is not None:
        expected |= {f"lib/glibc-hwcaps/{LEVEL}/{pathlib.Path(name).name}" for name in expected if ".so." in name}
    expected |= {f"share/doc/gracecg/LICENSES/{path.name}" for path in (ROOT / "LICENSES").iterdir()}
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
        for trace in (str(ROOT).encode(), b"build/gfortran", b"build/stage", b"build/library", str(prefix).encode()):
            if trace in content:
                raise Failure(f"{path} names {trace.decode()}")
    for path in (prefix / "bin/gracecg", *(prefix / f"lib/lib{name}.so" for name in LIBRARIES)):
        if re.search(r"R(UN)?PATH", run(["readelf", "-d", path])):
            raise Failure(f"{path} has a search path for libraries")


def check_loading(prefix):
    for name in LIBRARIES:
        library = prefix / "lib" / f"lib{name}.so"
        soname = re.search(r"soname: \[(.*)\]", run(["readelf", "-d", library]))
        if not soname or not (prefix / "lib" / soname.group(1)).exists():
            raise Failure(f"{library.name} has no soname, or no file of that name")
        if "not found" in (libraries := run(["ldd", library], LD_LIBRARY_PATH=str(prefix / "lib"))):
            raise Failure(libraries)


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


def check_symbols(prefix):
    """A library shows what its header declares and the F77 table lists, and nothing but interfaces."""
    listed = {name.lower() + "_" for name in
              re.findall(r"^\| `(GC\w+)\(", (ROOT / "docs" / "api.md").read_text(), re.M)}
    of_level1 = {name for name in listed if name.startswith("gcl1")}
    for name, routines, least in (("gracecg", listed - of_level1, 20), ("gracecg_level1", of_level1, 2)):
        shown = {line.split()[-1] for line in
                 run(["nm", "-D", "--defined-only", prefix / f"lib/lib{name}.so"]).splitlines()}
        header = re.sub(r"/\*.*?\*/", "", (prefix / f"include/{name}.h").read_text(), flags=re.S)
        declared = set(re.findall(r"\b(gracecg_\w+)\(", header))
        if len(declared) < least or len(routines) < least:
            raise Failure(f"{name}.h or the table of docs/api.md was not understood")
        if missing := (declared | routines) - shown:
            raise Failure(f"not in the library {name}: {sorted(missing)}")
        others = {symbol for symbol in shown - declared - routines if not symbol.startswith("__gracecg")}
        if others:
            raise Failure(f"{name} shows, but nothing documents: {sorted(others)}")


def check_without_program(prefix):
    """No object and no symbol of the program in the libraries, nothing of it in their modules; none of Level-1 in the
    library gracecg, and what both need once."""
    of_program = r"\S*gracecg_(?:cli_|level1_comm)\S*"
    for name, stem, least, strangers in (("gracecg", "src_", 50, rf"{of_program}|\S*gracecg_level1\S*"),
                                         ("gracecg_level1", "level1_src_", 20, of_program)):
        archive, shared = prefix / f"lib/lib{name}.a", prefix / f"lib/lib{name}.so"
        objects = run(["ar", "t", archive]).split()
        if f"{stem}{name}.f90.o" not in objects or len(objects) < least:
            raise Failure(f"these objects alone: {objects}")
        if others := [member for member in objects if not member.startswith(stem)]:
            raise Failure(f"objects of others in {name}: {others}")
        for library, symbols in ((archive, run(["nm", archive])), (shared, run(["nm", shared]))):
            if match := re.search(strangers, symbols):
                raise Failure(f"{library.name} has {match.group(0)}")
        if match := re.search(strangers, gzip.decompress((prefix / f"include/gracecg/{name}.mod").read_bytes()).decode()):
            raise Failure(f"{name}.mod needs a module of others: {match.group(0)}")


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


def check_completion(here):
    """bash takes the script, and completes commands, options, choices, cases, files and folders with it."""
    script = here.prefix / "share/bash-completion/completions/gracecg"
    run(["bash", "-n", script])
    (here.work / "folder of mine").mkdir(exist_ok=True)
    (here.work / "my case.nml").write_text("")

    def completed(*words):
        line = " ".join(f"'{word}'" for word in ("gracecg", *words))
        ended = subprocess.run(
            ["bash", "-c", f'source "{script}"; compopt() {{ :; }}; COMP_WORDS=({line}); COMP_CWORD={len(words)}; '
             '_gracecg; printf "%s\\n" "${COMPREPLY[@]}"'], cwd=here.work, capture_output=True, text=True, check=False,
            env=os.environ | {"PATH": f"{here.prefix}/bin:{os.environ['PATH']}"})
        if ended.returncode != 0 or ended.stderr:
            raise Failure(f"completing {words}: {ended.stderr}")
        return ended.stdout.split("\n")[:-1]

    overview = here.cli("--help").split("commands:")[1].split("\n\n")[0]
    names = {name.split()[0] for name in re.findall(r"^  ([a-z-]+(?: [a-z-]+)?)  ", overview, re.M)}
    if missing := names - set(completed("")):
        raise Failure(f"not completed: {missing}")
    for words, expected in ((["sim"], ["simulate"]), (["model", "gra"], ["gravity"]), (["help", "model", "gra"], ["gravity"]),
                            (["estimate", "--alg"], ["--algorithm"]), (["estimate", "--algorithm", "seq"], ["sequential"]),
                            (["estimate", "run1", "--format", "j"], ["json"]), (["simulate", "back-3"], ["back-3"]),
                            (["simulate", "my"], ["my case.nml"]), (["simulate", "back-1", "--out", "folder"], ["folder of mine"]),
                            (["estimate", "my"], []), (["simulate", "front-1", "--seed", "f"], []),
                            (["model", "gravity", "--ord"], ["--order"])):
        if [word for word in completed(*words) if word] != expected:
            raise Failure(f"{words} is completed as {completed(*words)}, expected {expected}")
    zsh = here.prefix / "share/zsh/site-functions/_gracecg"
    if not zsh.read_text().startswith("#compdef gracecg"):
        raise Failure(f"{zsh} does not begin with #compdef")
    if shutil.which("zsh"):
        run(["zsh", "-n", zsh])
        check_zsh(here, zsh.parent)


def check_zsh(here, folder):
    """An interactive zsh on a terminal of its own: what stands on the line, or is listed, after the tab key."""
    cases = (("gracecg sim", "gracecg simulate "), ("gracecg model gra", "gracecg model gravity"),
             ("gracecg help model gra", "gracecg help model gravity"), ("gracecg estimate --alg", "--algorithm"),
             ("gracecg estimate run1 --algorithm seq", "sequential"), ("gracecg simulate back-", "back-3"),
             ("gracecg bound --cases front-1,pri", "front-1,printed"), ("gracecg statements one", "one-rod"),
             ("gracecg montecarlo --algorithms assest-fde,opt", "assest-fde,optimal"),
             ("gracecg completion b", "gracecg completion bash"), ("gracecg simulate my", "my\\ case.nml"))
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(here.work)
        os.environ.update(TERM="dumb", PATH=f"{here.prefix}/bin:{os.environ['PATH']}")
        os.execvp("zsh", ["zsh", "-f", "-i"])

    def typed(text, seconds):
        os.write(terminal, text.encode())
        said, end = b"", time.monotonic() + seconds
        while time.monotonic() < end:
            if select.select([terminal], [], [], 0.1)[0]:
                said += os.read(terminal, 65536)
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|[\r\x07]", "", said.decode(errors="replace"))

    try:
        typed(f"stty cols 200 rows 60; fpath=({shlex.quote(str(folder))} $fpath); autoload -Uz compinit; compinit -u -D; "
              "LISTMAX=0; unsetopt beep\r", 4)
        for line, expected in cases:
            if expected not in (said := typed(line + "\t\t", 2)):
                raise Failure(f"zsh completes {line!r} as {said!r}, expected {expected!r}")
            typed("\x15\x03", 0.5)
    finally:
        os.close(terminal)
        os.waitpid(child, 0)


def check_documents(prefix):
    """The licence, and where the data come from and what their rights are."""
    folder = prefix / "share/doc/gracecg"
    for name, source in (("LICENSE", "LICENSE"), ("DATA.md", "data/README.md")):
        if (folder / name).read_text() != (ROOT / source).read_text():
            raise Failure(f"{name} is not {source}")
    if {path.name for path in (folder / "LICENSES").iterdir()} != {path.name for path in (ROOT / "LICENSES").iterdir()}:
        raise Failure("share/doc/gracecg/LICENSES is not LICENSES")


def check_destdir(work):
    """A package's tree; and `make uninstall` leaves nothing."""
    tree = work / "destdir"
    where = [f"DESTDIR={tree}", "PREFIX=/usr", "LIBDIR=/usr/lib/triplet"]
    make("install", *where)
    pkg_config = {"PKG_CONFIG_PATH": str(tree / "usr/lib/triplet/pkgconfig")}
    for name in LIBRARIES:
        folder = run(["pkg-config", "--variable=moddir", name], **pkg_config).strip()
        if not (pathlib.Path(folder) / f"{name}.mod").exists():
            raise Failure(f"{name}.pc points to {folder}")
    make("uninstall", *where)
    if left := [str(path) for path in tree.rglob("*") if not path.is_dir()]:
        raise Failure(f"make uninstall has left {left}")


# ---------------------------------------------------------------- the examples


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


def norm(vector):
    return sum(value**2 for value in vector)**0.5


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
    if "degree 99 gives status 5" not in output or "0 to 70" not in output:
        raise Failure(f"the wrong degree is not explained: {output}")


def check_c(here, program, expected):
    """The offset; the acceleration against the derivative of the true arc's velocity at the epoch."""
    output = here.output(program)
    check_offset(output, expected)
    rows = true_arc(here.work / "run1")
    slope = [sum(weight * rows[round(k * 0.1, 1)][name]
                 for k, weight in enumerate((-25, 48, -36, 16, -3))) / 1.2 for name in ("vx_m_s", "vy_m_s", "vz_m_s")]
    compare("acceleration, m/s^2", line_with(output, "total")[:3], slope, absolute=2e-9)
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


def check_fpm_install(here):
    """Program, library and modules, in a prefix of their own; `use gracecg` finds them."""
    fpm = run([ROOT / "tools/setup.sh"]).strip()
    prefix = here.work / "fpm"
    run([fpm, "install", "--profile", "release", "--prefix", prefix], cwd=ROOT)
    run([prefix / "bin/gracecg", "--version"])
    modules = {path.stem for path in (prefix / "include").glob("*.mod")}
    if strangers := {name for name in modules if not name.startswith("gracecg")}:
        raise Failure(f"modules of other programs: {sorted(strangers)}")
    program = here.work / "orbit-fpm"
    run([os.environ.get("FPM_FC", "gfortran"), EXAMPLE / "fortran/orbit.f90", f"-I{prefix / 'include'}",
         f"-L{prefix / 'lib'}", "-lgracecg", *run(["pkg-config", "--libs", "openblas"]).split(), "-fopenmp",
         "-o", program])
    check_orbit(here, program)


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
    example("calibrate (Fortran)", lambda h, p: check_offset(h.output(p), expected), fortran,
            "fortran/calibrate.f90", STRICT_FORTRAN)
    example("bound (Fortran)", check_bound, fortran, "fortran/bound.f90", STRICT_FORTRAN)
    example("design (Fortran)", check_design, fortran, "fortran/design.f90", STRICT_FORTRAN)
    example("level1 (Fortran)", check_level1, fortran, "fortran/level1.f90", STRICT_FORTRAN, "USO1B", "3 records", "uso_freq")
    level1 = example("level1 (C)", check_level1, "cc", "c/level1.c", STRICT_C, "CLK1B C", "2 records", "eps_time")
    optimal = example("optimal (C)", check_optimal, "cc", "c/optimal.c", STRICT_C)
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
                           ("optimal (C)", optimal), ("level1 (C)", level1)):
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


def check_readme(here):
    """The command lines of the README's chapter, as they stand there, in a home of its own."""
    chapter = readme_chapter()
    lines = re.findall(r"^    ((?:export|gfortran|cc|python3) .*)$", chapter, re.M)
    if len(lines) < 5:
        raise Failure(f"command lines not found: {lines}")
    home = here.work / "home"
    home.mkdir()
    (home / ".local").symlink_to(here.prefix)
    (home / "example").symlink_to(EXAMPLE)
    run(["bash", "-ec", "\n".join([*lines, "./orbit", "./models", "./calibrate"])], cwd=home, HOME=str(home),
        PYTHONDONTWRITEBYTECODE="1")


def check_fpm_package(here):
    """The README's fpm package: its manifest and program, as they stand there."""
    chapter = readme_chapter()
    manifest, program = (re.search(rf"^```{kind}\n(.*?)^```", chapter, re.M | re.S).group(1)
                         for kind in ("toml", "fortran"))
    folder = here.work / "package"
    (folder / "app").mkdir(parents=True)
    (here.work / "gracecg").symlink_to(ROOT)
    (folder / "fpm.toml").write_text(f'name = "mine"\n{manifest}')
    (folder / "app/main.f90").write_text(program)
    output = run([run([ROOT / "tools/setup.sh"]).strip(), "run"], cwd=folder)
    values = here.table("model", "gravity", "--degree", "20", "--position", *POSITION)
    compare("gravity", numbers(output.strip().splitlines()[-1])[:3], [values[name] for name in ("ax_m_s2", "ay_m_s2", "az_m_s2")],
            relative=1e-13)


def readme_chapter():
    return (ROOT / "README.md").read_text().split("## Using it as a library")[1].split("\n## ")[0]


def check_stable(here, program, expected):
    """A program of an earlier version of the interface: the numbers of the commands of this one."""
    output = here.output(program)
    values = here.table("model", "gravity", "--degree", "20", "--position", *POSITION)
    compare("gravity", line_with(output, "gravity")[:3], [values[f"a{axis}_m_s2"] for axis in "xyz"], relative=1e-11)
    compare("potential", line_with(output, "gravity")[3:], [values["potential_m2_s2"]], relative=1e-11)
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


def check_all(checks, work):
    prefix = work / "prefix"
    here = Installation(prefix, work)
    # As for a package. valgrind, too, knows no processor as new as this machine's may be.
    levels = "" if loader_takes_level() is None else LEVEL
    if checks.run("make install PORTABLE=1", make, "install", f"PREFIX={prefix}", "PORTABLE=1", f"HWCAPS={levels}") is None:
        return
    checks.run("the files", check_files, prefix)
    checks.run("no traces of the build", check_no_traces, prefix)
    checks.run("soname and dependencies", check_loading, prefix)
    checks.run("symbols of the interfaces", check_symbols, prefix)
    checks.run("the library without the program", check_without_program, prefix)
    checks.run("the manual page", check_manual, here)
    checks.run("completion in bash and zsh", check_completion, here)
    checks.run("licence and sources of the data", check_documents, here.prefix)
    check_examples(checks, here)
    checks.run("DESTDIR, LIBDIR, make uninstall", check_destdir, work)
    checks.run("fpm install", check_fpm_install, here)
    checks.run("the README's command lines", check_readme, here)
    checks.run("the README's fpm package", check_fpm_package, here)


def main():
    with tempfile.TemporaryDirectory(prefix="gracecg-install-") as folder:
        checks = Checks()
        check_all(checks, pathlib.Path(folder))
    print(f"{checks.passed} passed, {checks.failed} failed")
    return 1 if checks.failed else 0


if __name__ == "__main__":
    sys.exit(main())
