#!/usr/bin/env python3
"""Follows the recipes of docs/development.md to the letter, in a copy of the project.

    tools/check_development.py FPM          status 1 when a change does not apply, the build fails, or a
                                            command prints something else than the document shows
    tools/check_development.py --self-test  checks the check

A recipe adds a file by a block

    ```fortran src/environment/j2_gravity.f90
    ...
    ```

changes one by a block

    ```diff
    --- a/src/environment/gravity_models.f90
    +++ b/src/environment/gravity_models.f90
    @@ ...
    ```

and shows what comes of it by blocks

    ```console
    $ gracecg model sun --date 2000-01-01T12:00:00
    x,y,z,distance_au
    ```

The changes of all recipes are applied in turn by patch(1), the program is built once, then every line
that begins with `$ ` is run: `gracecg` is the program so built, `fpm` the fpm of this check. What it prints
has to be what stands below it; a line `...` stands for any number of lines, and at the end of a line for
the rest of it.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
DOCUMENT = ROOT / "docs" / "development.md"
CHECKS = ("At line ", "Fortran runtime warning: ")
BLOCK = re.compile(r"^```(diff|console|fortran (?=\S))(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(text):
    """The (kind, path, content) of the blocks of a document, in turn; only a new file has a path."""
    return [(match.group(1).strip(), match.group(2), match.group(3)) for match in BLOCK.finditer(text)]


def commands(content):
    """The (command, lines that it prints) of a console block."""
    found = []
    for line in content.splitlines():
        if line.startswith("$ "):
            found.append((line[2:], []))
        elif found:
            found[-1][1].append(line)
    return found


def agree(shown, printed):
    """Whether lines are those shown, where `...` stands for any lines, or for the rest of one."""
    pattern = ""
    for line in map(str.rstrip, shown):
        if line == "...":
            pattern += r"(?:.*\n)*"
        elif line.endswith("..."):
            pattern += re.escape(line[:-3]) + r".*\n"
        else:
            pattern += re.escape(line) + r"\n"
    return re.fullmatch(pattern, "".join(line.rstrip() + "\n" for line in printed)) is not None


def copy_project(folder):
    """The tracked files, and what has been built of them so that little has to be compiled."""
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True,
                           check=True).stdout.split("\0")
    for name in filter(None, files):
        if (ROOT / name).is_file():
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target)
    for built in ROOT.glob("build/gfortran_*"):
        shutil.copytree(built, folder / "build" / built.name, symlinks=True)
    if (ROOT / "build" / "cache.toml").exists():
        shutil.copy2(ROOT / "build" / "cache.toml", folder / "build")


def run(command, folder, fpm, program):
    """Status and lines of a command of the document."""
    words = command.split()
    words[0] = {"gracecg": str(program), "fpm": fpm}.get(words[0], words[0])
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=600)
    # what a build with run-time checks says of itself is not printed by the program
    return done.returncode, [line for line in (done.stdout + done.stderr).splitlines() if not line.startswith(CHECKS)]


def follow(text, folder, fpm):
    """What goes wrong when a document's recipes are followed in a folder."""
    number = 0
    for kind, path, content in blocks(text):
        if kind == "fortran":
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(content, encoding="utf-8")
        if kind != "diff":
            continue
        number += 1
        patched = subprocess.run(["patch", "-p1", "--forward", "--no-backup-if-mismatch"], cwd=folder,
                                 input=content, capture_output=True, text=True)
        if patched.returncode:
            yield f"change {number} does not apply:\n{patched.stdout}{patched.stderr}"
            return
    built = subprocess.run([fpm, "install", "--profile", "debug", "--prefix", str(folder / "stage")],
                           cwd=folder, capture_output=True, text=True)
    if built.returncode:
        yield f"the changed project does not build:\n{built.stdout[-3000:]}{built.stderr[-3000:]}"
        return
    for kind, _, content in blocks(text):
        for command, shown in commands(content) if kind == "console" else ():
            status, printed = run(command, folder, fpm, folder / "stage" / "bin" / "gracecg")
            if status or not agree(shown, printed):
                yield "\n".join([f"$ {command}", f"status {status}, prints", *printed, "instead of", *shown])


def self_test():
    """What the check itself gets wrong."""
    text = "```diff\n--- a/x\n```\n```console\n$ one two\n1\n$ three\n```\n```fortran\n$ no\n```\n" \
           "```fortran src/a.f90\nend\n```\n"
    if [(kind, path) for kind, path, _ in blocks(text)] != [("diff", ""), ("console", ""),
                                                             ("fortran", "src/a.f90")]:
        yield "blocks are not found"
    if commands(blocks(text)[1][2]) != [("one two", ["1"]), ("three", [])]:
        yield "commands are not found"
    for shown, printed, same in ((["a", "..."], ["a", "b"], True), (["a"], ["a", "b"], False),
                                 (["...", "c"], ["a", "c "], True), (["a.c"], ["abc"], False), (["a..."], ["abc"], True),
                                 (["a..."], ["b"], False)):
        if agree(shown, printed) != same:
            yield f"{shown} and {printed} are taken to be {'different' if same else 'alike'}"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "x").write_text("one\n", encoding="utf-8")
        wrong = "```diff\n--- a/x\n+++ b/x\n@@ -1 +1 @@\n-two\n+three\n```\n"
        if not any("does not apply" in line for line in follow(wrong, folder, "false")):
            yield "a change that does not apply passes"
        if not any("does not build" in line for line in follow("", folder, "false")):
            yield "a build that fails passes"


def main():
    if "--self-test" in sys.argv[1:]:
        found = list(self_test())
    else:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            copy_project(folder)
            found = list(follow(DOCUMENT.read_text(encoding="utf-8"), folder, sys.argv[1] if sys.argv[1:] else "fpm"))
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
