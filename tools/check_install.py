#!/usr/bin/env python3
"""Installs gracecg into a temporary prefix and checks what a user gets.

    tools/check_install.py [--hwcaps]      also the library for newer processors, which takes another build

Files, symbols, manual page; the programs of example/ built against the installed copy alone, run, and
their numbers compared with those of the installed command line; no leak and no invalid access under
valgrind; two threads at once; `fpm install`; what the README says of linking. Needs what `tools/setup.sh checks` installs. The last line
is `N passed, N failed`; status 1 on a failure.
"""
import gzip
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from install_checks import (EXAMPLE, LEVEL, LIBRARIES, POSITION, ROOT, Checks, Failure, Installation, compare, loader_takes_level,
                            make, numbers, run)
from install_examples import check_examples, check_orbit


def check_files(prefix):
    version = re.search(r'^version *= *"(.*)"', (ROOT / "fpm.toml").read_text(), re.M).group(1)
    expected = {name for library in LIBRARIES for name in (
        f"lib/lib{library}.a", f"lib/lib{library}.so", f"lib/lib{library}.so.{version.split('.')[0]}",
        f"lib/lib{library}.so.{version}", f"lib/pkgconfig/{library}.pc", f"include/{library}.h",
        f"include/gracecg/{library}.mod")}
    expected |= {f"lib/cmake/gracecg/gracecgConfig{name}.cmake" for name in ("", "Version")}
    expected |= {"bin/gracecg", "share/man/man1/gracecg.1", "share/bash-completion/completions/gracecg",
                 "share/doc/gracecg/LICENSE", "share/doc/gracecg/DATA.md"}
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
        if re.search(r"R(UN)?PATH.*\[(?!\$ORIGIN\])", run(["readelf", "-d", path])):
            raise Failure(f"{path} has a search path for libraries")


def check_loading(prefix):
    for name in LIBRARIES:
        library = prefix / "lib" / f"lib{name}.so"
        soname = re.search(r"soname: \[(.*)\]", run(["readelf", "-d", library]))
        if not soname or not (prefix / "lib" / soname.group(1)).exists():
            raise Failure(f"{library.name} has no soname, or no file of that name")
        if "not found" in (libraries := run(["ldd", library])):
            raise Failure(libraries)


def check_symbols(prefix):
    """A library shows what its header declares and the F77 table lists, and nothing but interfaces."""
    listed = {name.lower() + "_" for name in
              re.findall(r"^\| `(GC\w+)\(", (ROOT / "docs/interface/fortran77.md").read_text(), re.M)}
    of_level1 = {name for name in listed if name.startswith("gcl1")}
    for name, routines, least in (("gracecg", listed - of_level1, 20), ("gracecg_level1", of_level1, 2)):
        shown = {line.split()[-1] for line in
                 run(["nm", "-D", "--defined-only", prefix / f"lib/lib{name}.so"]).splitlines()}
        header = re.sub(r"/\*.*?\*/", "", (prefix / f"include/{name}.h").read_text(), flags=re.S)
        declared = set(re.findall(r"\b(gracecg_\w+)\(", header))
        if len(declared) < least or len(routines) < least:
            raise Failure(f"{name}.h or the table of docs/interface was not understood")
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
    """bash takes the script, and completes commands and options with it."""
    script = here.prefix / "share/bash-completion/completions/gracecg"
    run(["bash", "-n", script])

    def completed(*words):
        line = " ".join(f"'{word}'" for word in ("gracecg", *words))
        ended = subprocess.run(
            ["bash", "-c", f'source "{script}"; COMP_WORDS=({line}); COMP_CWORD={len(words)}; '
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
                            (["estimate", "--alg"], ["--algorithm"]), (["estimate", "run1", "--format", "j"], []),
                            (["model", "gravity", "--ord"], ["--order"])):
        if [word for word in completed(*words) if word] != expected:
            raise Failure(f"{words} is completed as {completed(*words)}, expected {expected}")


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
    checks.run("completion in bash", check_completion, here)
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
