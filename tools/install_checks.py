"""What the checks of an installed copy have in common: commands, numbers, the prefix and what is built against it."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "example"
NUMBER = re.compile(r"[-+]?\d*\.?\d+(?:[eED][-+]?\d+)?(?![\w.])")
POSITION = ["4.0e6", "-3.0e6", "4.6e6"]         # m, that of the examples
LIBRARIES = ("gracecg", "gracecg_level1")
LEVEL = "x86-64-v3"     # the newer processors that the check builds for


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


def make(target, *variables):
    return run(["make", "-C", ROOT, target, *variables])


def loader_takes_level():
    """Whether the loader of this machine looks into LEVEL's folder; None: it is another kind of machine, or not asked for."""
    if "--hwcaps" not in sys.argv or os.uname().machine != "x86_64" or not shutil.which("ldd"):
        return None
    loader = re.search(r"(/\S*ld-linux-x86-64\S*)", run(["ldd", sys.executable]))
    return bool(loader and re.search(rf"{LEVEL} \(supported, searched\)", run([loader[1], "--help"])))
