#!/usr/bin/env python3
"""Runs the commands that print the numbers of the documents, and lists what differs.

    tools/check_claims.py [--all] [--program build/bin/gracecg] [DOCUMENT ...]   status 1 if a number differs
    tools/check_claims.py --self-test                                           checks the check

Below the text, in the same section, an invisible comment says what prints its numbers:

    Both together know d to 7.23, 0.94, 6.36 um.
    <!-- $ gracecg bound front-2 front-3 --joint --format csv
    "know d to" 1000 * joint # # #
    -->

The command is typed in a folder that all commands share. A line below it has in quotation marks the text (once in the
section) after which the numbers stand, or the heading of a column of a table; a factor, for another unit; and the line
that is printed: `#` is a number that is claimed, `*` any word, `#3` and `*3` are three of them; blanks and commas part words,
what follows is free, and after `...` what stands before.
Lines that are alike are taken in turn, and as many numbers of the text as are printed. A number is right if what is
printed, rounded as the text rounds, is the same; after `~5 %` if it is so near. `elapsed #` is the time in seconds.

A comment in the shell's way behind the command and two blanks, `# 7 min`, says how long it takes: it runs with --all only.

Numbers that no command prints stand beside `Source: ` (who, what program, when); where a paragraph of a section begins
with it, it is that of all numbers of the section that have no command. What a suite of tests holds names the suite. In
docs/validation.md a paragraph, item or row whose numbers have none of these is a failure. Numbers of figures, tables,
sections and cases, and in `code`, claim nothing; those of console blocks are compared by tools/check_examples.py.
"""
import argparse
import contextlib
import pathlib
import re
import sys
import tempfile
import time

from check_examples import DOCUMENTS as EXAMPLES, LONGEST, PROGRAM, ROOT, run, scratch

DOCUMENTS = ("README.md", "docs/user-guide.md", "docs/validation.md", "docs/comparison.md", "docs/test-day.md")
COMPLETE = "docs/validation.md"
CLAIM = re.compile(r"^<!-- \$ (.*?)\n(.*?)^-->$", re.MULTILINE | re.DOTALL)
LINE = re.compile(r'"([^"]+)" (?:~(\S+) % )?(?:([\d.e-]+) \* )?(.+)$')
NUMBER = re.compile(r"(?<![\w.^-])[-+]?(?:\d{1,3}(?: \d{3})+|\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?(?![\w^]|\.\d)")
CONSOLE = re.compile(r"^```console$.*?^```$", re.MULTILINE | re.DOTALL)
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
SOURCE = re.compile(r"\bSource: ")
SECTION_SOURCE = re.compile(r"^\*?Source: ", re.MULTILINE)
# Numbers that claim nothing: of code, figures, sections, cases, dates
NAMES = re.compile(r"`[^`]*`|https?:\S+|\(\d[ab]?(?:\.\d)*(?:, \d[ab]?(?:\.\d)*)*\)|\b(?:Figures?|Tables?|sections?|theory|"
                   r"cases?|[Ff]ront|[Bb]ack|rounds?|(?:Octo|Novem|Decem)ber|January) \d[\d.]*(?:(?:, | and |-)\d[\d.]*)*")
SUITE = re.compile(r"\bsuites? [a-z]|\| the same \|$")


def blank(match):
    """Nothing, in as many characters and lines."""
    return re.sub(r"[^\n]", " ", match.group())


def sections(text):
    """(offset, text) of what stands from a heading to the next."""
    starts = [0] + [match.start() for match in re.finditer(r"^#+ ", FENCED.sub(blank, text), re.MULTILINE)]
    return [(start, text[start:end]) for start, end in zip(starts, starts[1:] + [len(text)])]


def column(text, heading):
    """Numbers below a heading of a table, as matches in the text."""
    found, place = [], None
    for line in re.finditer(r"^.*$", text, re.MULTILINE):
        cells = list(re.finditer(r"[^|]+", line.group())) if line.group().startswith("|") else []
        words = [cell.group().strip() for cell in cells]
        if heading in words:
            place = words.index(heading)
        elif not cells:
            place = None
        elif place is not None and place < len(cells):
            found += NUMBER.finditer(text, line.start() + cells[place].start(), line.start() + cells[place].end())
    return found


def claimed(text, anchor):
    """The numbers of a claim, as matches in the text of its section; none where the anchor is not found once."""
    table = column(text, anchor)
    if table or text.count(anchor) != 1:
        return table
    return list(NUMBER.finditer(text, text.index(anchor) + len(anchor)))


def words_of(line):
    return [word for word in re.split(r"[\s,;:|()/]+", line) if word]


def written_out(form):
    """The words of a form, `#` for `#3` three times."""
    return [word[0] if word[0] in "*#" else word for word in words_of(form)
            for _ in range(int(word[1:] or 1) if word[0] in "*#" else 1)]


def printed(output, form):
    """The numbers in the lines of the output that have this form."""
    form, found = written_out(form), []
    anywhere = form[0] == "..."
    form = form[anywhere:]
    for line in output.splitlines():
        words = words_of(line)
        for first in range(len(words) - len(form) + 1) if anywhere else (0,):
            part = words[first:first + len(form)]
            if len(part) == len(form) and all(f in ("#", "*", w) for f, w in zip(form, part)):
                with contextlib.suppress(ValueError):
                    found += [float(w.rstrip("%")) for f, w in zip(form, part) if f == "#"]
    return found


def near(text, value, tolerance):
    """Whether a number of the text is this value, to its last digit or to so many per cent."""
    digits, _, exponent = text.replace(" ", "").lower().partition("e")
    number = float(text.replace(" ", ""))
    if tolerance:
        return abs(value - number) <= float(tolerance) / 100 * abs(number)
    return abs(value - number) <= 0.5000001 * 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))


class Check:
    """Counts and failures of all documents."""

    def __init__(self, program, long_ones):
        self.program, self.long_ones, self.outputs, self.failures = program, long_ones, {}, []
        self.counts = dict.fromkeys(("agree", "differ", "not run", "with a source", "held by tests", "in examples", "others"), 0)

    def output(self, command, folder):
        """What a command prints, once."""
        if command not in self.outputs:
            started = time.monotonic()
            status, output = run(command, folder, 36000 if self.long_ones else LONGEST)
            elapsed = time.monotonic() - started
            print(f"{elapsed:6.1f} s  {command[:130]}", flush=True)
            self.outputs[command] = (status, f"{output}\nelapsed {elapsed:.1f}")
        return self.outputs[command]

    def fail(self, text):
        self.failures.append(text if len(text) < 240 else text[:240] + " ...")
        print("DIFFERS", self.failures[-1])

    def document(self, name, text, folder):
        if name in EXAMPLES:
            self.counts["in examples"] += sum(len(NUMBER.findall(block)) for block in CONSOLE.findall(text))
        for start, section in sections(text):
            shown = CLAIM.sub(blank, FENCED.sub(blank, section))
            covered = set()
            for claim in CLAIM.finditer(section):
                covered |= self.claim(f"{name}:", text.count("\n", 0, start) + 1, shown, claim, folder)
            self.rest(name, text.count("\n", 0, start) + 1, shown, covered)

    def claim(self, name, first, shown, claim, folder):
        """Compares the lines of a claim; gives where its numbers stand."""
        command, _, duration = claim.group(1).partition("  # ")
        left_out = duration and not self.long_ones
        if left_out:
            print(f"not run, {duration}: {command[:130]}")
        status, output = (0, "") if left_out else self.output(command, folder)
        covered = set()
        for line in claim.group(2).splitlines():
            parts = LINE.match(line)
            numbers = claimed(shown, parts.group(1)) if parts else []
            place = name + str(first + shown[:numbers[0].start() if numbers else claim.start()].count("\n"))
            if not numbers:
                self.fail(f"{place}: no numbers, or not one place: {line}")
            elif left_out:
                table = column(shown, parts.group(1))
                count = len(table) or written_out(parts.group(4)).count("#")
                covered |= {number.start() for number in numbers[:count]}
                self.counts["not run"] += count
            elif status != 0 or not (values := printed(output, parts.group(4))):
                self.fail(f"{place}: status {status}, no such line: {parts.group(4)}: {command}")
            else:
                covered |= self.compare(place, parts, numbers, values, shown, command)
        return covered

    def compare(self, place, parts, numbers, values, shown, command):
        factor, used = float(parts.group(3) or 1), numbers[:len(values)]
        for number, value in zip(used, values):
            right = near(number.group(), factor * value, parts.group(2))
            self.counts["agree" if right else "differ"] += 1
            if not right:
                self.fail(f"{place}: {parts.group(1)}: claimed {number.group()}, printed {factor * value:.6g}: {command}")
        if len(used) < len(values) or column(shown, parts.group(1)) and len(values) < len(numbers):
            self.fail(f"{place}: {parts.group(1)}: {len(numbers)} numbers, {len(values)} printed: {command}")
        return {number.start() for number in used}

    def rest(self, name, first, shown, covered):
        """Numbers without a command: with a source, of a suite, or others."""
        body = shown.partition("\n")[2] if shown.startswith("#") else shown
        counted = NAMES.sub(blank, body)
        whole = SECTION_SOURCE.search(body)
        offset = len(shown) - len(body)
        for block in re.finditer(r"^(?!\s*$)(?:\|.*(?!\n\|-)$|(?!\|)(?:(?!\n(?:- |\||\s*$))[\s\S])+)", body, re.MULTILINE):
            starts = {offset + match.start() for match in NUMBER.finditer(counted, block.start(), block.end())}
            if SUITE.search(block.group()):
                kind = "held by tests"
            else:
                kind = "with a source" if whole or SOURCE.search(block.group()) else "others"
            self.counts[kind] += len(starts - covered)
            if name == COMPLETE and kind == "others" and starts and not starts & covered:
                self.fail(f"{name}:{first + shown[:offset + block.start()].count(chr(10))}: neither command nor source: "
                          f"{block.group()[:70].strip()}")


def check(program, root, names, long_ones=False):
    """All documents; gives the check with its counts and failures."""
    checked = Check(program, long_ones)
    with scratch(program) as folder:
        pathlib.Path(folder, "tools").symlink_to(ROOT / "tools")
        for name in names:
            print(f"== {name}")
            checked.document(name, (root / name).read_text(encoding="utf-8"), folder)
    print("numbers: " + ", ".join(f"{count} {what}" for what, count in checked.counts.items()))
    return checked


DOCUMENT = """# 1. One

Text 3 has {joint} um, front-2 1.
<!-- $ gracecg bound
"has" 1000 * joint # # #
"has" ~20 % 1000 * joint #
-->

- Item (suite b) 4.
- By hand 5, Source: a book.
{more}

# Two
| case | sigma | two |
|---|---|---|
| a | {sigma} | 8 |
| b | 4e-3, 12 000 | 9 |
<!-- $ gracecg bound
"sigma" * x # #
-->
<!-- $ gracecg long  # 7 min
"two" x #
-->
"""
STAND_IN = """#!/bin/sh
[ "$1" = bound ] && printf 'joint,0.00723,0.00094,0.0064\\na x 0.123 -4 y\\nb x: 0.0041 12000\\n' || echo 'x 8\nx 7'
"""


def self_test():
    """What the check overlooks or invents, tried with a program that plays gracecg."""
    good = {"joint": "7.23, 0.9, 6.4", "sigma": "0.12, -4", "more": ""}
    for change, long_ones, expected in (
            ({}, False, None), ({"joint": "7.23, 0.94, 6.3"}, False, "docs/validation.md:3: has: claimed 6.3, printed 6.4"),
            ({"sigma": "0.13, -4"}, False, "docs/validation.md:16: sigma: claimed 0.13"), ({"sigma": "0.12, 4"}, False, "printed -4"),
            ({"sigma": "0.12"}, False, "3 numbers, 4 printed"), ({"sigma": "0.12, -4, 9"}, False, "5 numbers, 4 printed"), ({}, True, "two: claimed 9, printed 7"),
            ({"more": "It has 6."}, False, "not one place"), ({"more": "\nNumber 7"}, False, "docs/validation.md:12: neither"),
            ({"more": "<!-- $ false\n\"By hand\" #\n-->"}, False, "status 1"),
            ({"more": "<!-- $ gracecg bound\n\"By hand\" no #\n-->"}, False, "no such line: no #")):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs").mkdir()
            (root / COMPLETE).write_text(DOCUMENT.format(**{**good, **change}), encoding="utf-8")
            (root / "gracecg").write_text(STAND_IN, encoding="utf-8")
            (root / "gracecg").chmod(0o755)
            checked = check(str(root / "gracecg"), root, [COMPLETE], long_ones)
        counts = list(checked.counts.values())
        if expected is None and (checked.failures or counts != [8, 0, 2, 1, 1, 0, 2]):
            yield f"false alarm: {checked.failures}, {checked.counts}"
        elif expected is not None and not any(expected in text for text in checked.failures):
            yield f"not found: {expected}; found: {checked.failures}"


def main():
    parser = argparse.ArgumentParser(description="Runs the commands that print the numbers of the documents.")
    parser.add_argument("documents", nargs="*", default=DOCUMENTS)
    parser.add_argument("--all", action="store_true", help="long studies, too")
    parser.add_argument("--program", default=str(ROOT / PROGRAM))
    parser.add_argument("--self-test", action="store_true")
    arguments = parser.parse_args()
    program = pathlib.Path(arguments.program).resolve()
    if arguments.self_test:
        found = list(self_test())
    elif not program.is_file():
        found = [f"{program}: no such program; make build"]
    else:
        found = check(str(program), ROOT, arguments.documents, arguments.all).failures
    for text in found:
        print(f"FAILED {text}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
