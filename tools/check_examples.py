#!/usr/bin/env python3
"""Runs every example that the program and its documents show, as printed.

    tools/check_examples.py [--program build/bin/gracecg]   status 1 if one fails
    tools/check_examples.py --self-test                     checks the check, with a stand-in program

Examples are
- the lines below `example:` in the help of the program and of every command that it lists (a command
  without an example is a failure);
- in README.md and docs/user-guide.md, every line that begins with `$ ` of a ```console block: what stands
  below it, up to the next one, is all that the command prints (standard output, then standard error), but for a
  file that is typed in: the lines from `$ cat > FILE <<'END'` to `END` belong to the command. As in
  docs/development.md a line `...` stands for any number of lines, and at the end of a line for the rest of it;
- there, in other code blocks (fenced or indented), the lines that begin with `gracecg ` or
  `build/bin/gracecg `: whatever they print.

The examples of one help, and those of one document, run in their order, from the first to the last, in one
folder of their own that is empty in the beginning. So each help is complete in itself, and a document builds on
what it has made before, and on nothing else. No command of a document writes a file or folder that an
earlier one has written, unless it goes on with it (--resume).

What is printed is what is run, but for two short lists: HELPS makes work of the helps smaller, and leaves out
what needs files of a data centre; DOCUMENTED names what another check runs.
"""
import argparse
import contextlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

from check_development import agree

ROOT = pathlib.Path(__file__).resolve().parent.parent
DOCUMENTS = ("README.md", "docs/user-guide.md")
PROGRAM = "build/bin/gracecg"

# (what is printed, what is run)
DOCUMENTED = (
    # a minute's work: tools/check_report.py runs this very command; its help stands in for it here
    (re.compile(r"gracecg report (?!--help).*"), "gracecg report --help"),
    # what it does when everything is built
    (re.compile(r"^make run$"), PROGRAM + " montecarlo"),
)
# The work grows in proportion to the runs, the way through the program is the same.
HELPS = DOCUMENTED + (
    (re.compile(r"--runs (\d{2,})\b"), "--runs 5"),
    # files of a data centre are not at hand; the user guide has simulated ones
    (re.compile(r"gracecg level1 (list|dump|check|convert|estimate|prepare|trend) (?!--help).*"), r"gracecg level1 \1 --help"),
)
LONGEST = 120       # seconds for one example
# What a command writes
WRITTEN = re.compile(r"(?:--(?:out|runs-out|report|running|map) |(?<![>-])> ?)([\w.%/-]+)")


def commands_of(overview):
    """The names that `gracecg --help` lists, and the lines of its own example."""
    names, inside = [], False
    for line in overview.splitlines():
        if line == "commands:":
            inside = True
        elif inside and line.startswith("  "):
            names.append(re.split(r"  +", line.strip())[0])
        elif inside:
            break
    return names


def help_examples(text):
    """The command lines below `example:`."""
    lines = text.splitlines()
    starts = [i for i, line in enumerate(lines) if line.startswith("example:")]
    if not starts:
        return []
    found = []
    for line in lines[starts[-1] + 1:]:
        if not line.startswith("  "):
            break
        found.append(line.strip())
    return found


def document_examples(text):
    """(line number, command, lines shown below it or None) of the code blocks of a Markdown text."""
    fence, before, block, typed_in = None, "", False, False
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        command = line.strip()
        if command.startswith("```"):
            fence = command[3:] if fence is None else None
        elif fence == "console":
            if typed_in:
                found[-1] = (found[-1][0], f"{found[-1][1]}\n{line}", [])
                typed_in = line != "END"
            elif line.startswith("$ "):
                found.append((number, line[2:], []))
                typed_in = line.endswith("<<'END'")
            elif found:
                found[-1][2].append(line)
        else:
            if fence is None:
                block = line.startswith("    ") and (block or not before)
                before = command
            if (fence is not None or block) and command.startswith(("gracecg ", PROGRAM + " ")):
                found.append((number, command, None))
    return found


def written_twice(examples):
    """(line number, what) of commands that write what an earlier one has written."""
    seen = set()
    for number, command, _ in examples:
        names = set(WRITTEN.findall(command.split(" #")[0]))
        if "--resume" not in command:
            yield from ((number, name) for name in sorted(names & seen))
        seen |= names


def as_run(command, substitutions):
    for printed, run in substitutions:
        command = printed.sub(run, command)
    return command


@contextlib.contextmanager
def scratch(program):
    """An empty folder that has the program below it, at its usual place."""
    with tempfile.TemporaryDirectory(prefix="gracecg-examples-") as folder:
        home = pathlib.Path(folder, PROGRAM)
        home.parent.mkdir(parents=True)
        home.symlink_to(program)
        yield folder


def run(command, folder, longest=LONGEST):
    """Status of a command in such a folder, and what it prints."""
    home = pathlib.Path(folder, PROGRAM).parent
    environment = dict(os.environ, PATH=f"{home}{os.pathsep}{os.environ['PATH']}")
    try:
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, errors="replace", timeout=longest, check=False)
    except subprocess.TimeoutExpired:
        return f"none after {longest} s", ""
    return done.returncode, done.stdout + done.stderr


def failures(where, examples, program, substitutions):
    """Runs (place, command, lines shown) in an empty folder; gives what went wrong with the first that fails."""
    with scratch(program) as folder:
        for place, printed, shown in examples:
            command = as_run(printed, substitutions)
            started = time.monotonic()
            status, output = run(command, folder)
            print(f"{time.monotonic() - started:6.1f} s  {printed}")
            if status != 0:
                yield f"{where}{place}: status {status} of: {command}\n{output.rstrip()}"
                return
            if shown is not None and not agree(shown, output.splitlines()):
                yield "\n".join([f"{where}{place}: {command} prints", output.rstrip(), "instead of", *shown])


def help_of(program, words):
    done = subprocess.run([program, *words, "--help"], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, check=False)
    return done.stdout if done.returncode == 0 else ""


def check(program, root):
    """Everything that is wrong with the examples."""
    overview = help_of(program, [])
    names = commands_of(overview)
    if not names:
        yield f"{program} --help lists no commands"
        return
    for name in ["", *names]:
        title = f"gracecg {name}".strip() + " --help"
        lines = help_examples(help_of(program, name.split()))
        print(f"== {title}")
        if not lines:
            yield f"{title}: shows no example"
        elif not all(line.startswith("gracecg ") for line in lines):
            yield f"{title}: an example is no gracecg command: {lines}"
        elif name and not any(line.startswith(f"gracecg {name}") for line in lines):
            yield f"{title}: its example does not use the command"
        else:
            yield from failures(title, [("", line, None) for line in lines], program, HELPS)
    for document in DOCUMENTS:
        examples = document_examples((root / document).read_text(encoding="utf-8"))
        print(f"== {document}")
        if not examples:
            yield f"{document}: no example was found"
        for number, name in written_twice(examples):
            yield f"{document}:{number}: writes {name} a second time"
        yield from failures(document, [(f":{number}", *rest) for number, *rest in examples], program, DOCUMENTED)


STAND_IN = """#!/bin/sh
case "$*" in
    --help) printf 'usage\\n\\ncommands:\\n  make it     makes it\\n  use         uses it\\n\\n%s' "$OVERVIEW";;
    'make it --help') printf 'x\\n\\nexample:\\n  gracecg make it > it\\n';;
    'use --help') printf 'x\\n\\nexample:\\n  gracecg make it > it\\n  gracecg %s it --runs 500\\n' "$VERB";;
    'make it') echo it;;
    'make it --out '*) echo it >"$4"; echo "written: $4"; echo 'warning: made' >&2;;
    'use it --runs 5') cat it;;
    'use it --runs 2000') cat it; echo well used;;
    *) echo "unknown: $*"; exit 2;;
esac
"""
DOCUMENT = """Text `gracecg no`:

    {make} > it      # comment
    $EDITOR it

and

```
{use} it --runs 2000
```
```console
$ {make} --out {out}
written: it2
...
$ {use} it --runs 2000 | tail -n 1
{shown}
```
"""


def self_test():
    """What the check overlooks or invents, tried with a program that plays gracecg."""
    good = {"OVERVIEW": "example:\n  gracecg make it\n", "VERB": "use", "make": "gracecg make it",
            "use": "build/bin/gracecg use", "out": "it2", "shown": "well u..."}
    tried = (({}, None), ({"VERB": "use not"}, "unknown: use not it"),
             ({"VERB": "lose"}, "does not use the command"), ({"OVERVIEW": ""}, "gracecg --help: shows no example"),
             ({"make": "gracecg break it"}, "README.md:3"), ({"use": "gracecg lose"}, "README.md:9"),
             ({"shown": "it"}, "README.md:15: build/bin/gracecg use it"), ({"out": "it"}, "README.md:12: writes it a second time"),
             ({"shown": "well used\n$ exit 3"}, "README.md:17: status 3"),
             ({"document": "text\n    gracecg make it\n"}, "no example was found"))
    for change, expected in tried:
        case = {**good, **change}
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs").mkdir()
            for document in DOCUMENTS:
                (root / document).write_text(case.get("document", DOCUMENT).format(**case), encoding="utf-8")
            program = root / "gracecg"
            program.write_text(STAND_IN, encoding="utf-8")
            program.chmod(0o755)
            os.environ.update(OVERVIEW=case["OVERVIEW"], VERB=case["VERB"])
            found = list(check(str(program), root))
        if expected is None and found:
            yield f"false alarm: {found}"
        elif expected is not None and not any(expected in text for text in found):
            yield f"not found: {expected}; found: {found}"


def main():
    parser = argparse.ArgumentParser(description="Runs every example of the help and the documents.")
    parser.add_argument("--program", default=str(ROOT / PROGRAM))
    parser.add_argument("--self-test", action="store_true")
    arguments = parser.parse_args()
    program = pathlib.Path(arguments.program).resolve()
    if not arguments.self_test and not program.is_file():
        print(f"{program}: no such program; make build")
        return 1
    found = list(self_test() if arguments.self_test else check(str(program), ROOT))
    for text in found:
        print(f"\nFAILED {text}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
