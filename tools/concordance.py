#!/usr/bin/env python3
"""Writes docs/concordance.md: where the project has each piece of the report CSR-TM-00-01.

    tools/concordance.py              writes the file where it is out of date
    tools/concordance.py --check      writes nothing; status 1 when it is out of date
    tools/concordance.py --self-test  plants mistakes and checks that they are found

The places of an equation are where its number stands, in the form (4-17), a range as (4-27)-(4-32) or
(4-27) to (4-32): in docs/theory.md, in the comments of src/ before or inside a procedure (or before a module
or type that says it in place of its procedures), in the comments of test/. Titles, states, remarks and what
is no equation stand in tools/concordance.txt, which says itself how it is written.

A mistake, which ends in status 1: an equation that is missing from the table, from the theory or from src/;
one called corrected that the theory's list of slips lacks; a number that the report does not have; a place
that does not exist.
"""
import collections
import itertools
import pathlib
import re
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE, TARGET, THEORY = "tools/concordance.txt", "docs/concordance.md", "docs/theory.md"
EQUATIONS = [f"{chapter}-{i}" for chapter, last in ((2, 35), (3, 23), (4, 103))
             for i in range(1, last + 1)] + ["6.1"]
STATES = ("printed", "corrected", "equivalent", "replaced", "definition", "absent")
SLIPS = "The report's slips"                # the section of the theory that repeats what others say
NOT_PLACES = ("app/cli",)                   # what prints a number does not implement it

CITATION = r"\(([2-9])-(\d{1,3})\)"
RANGE = re.compile(CITATION + r"(?:\s*(?:-|to|\.\.\.)\s*" + CITATION + r")?|\((6\.1)\)")
PROCEDURE = re.compile(r"\s*(?:(?:pure|elemental|impure|recursive|module)\s+)*"
                       r"(?:(?:real|integer|logical|complex|character|type)\s*(?:\([^)]*\)+)?\s+)?"
                       r"(?:subroutine|function)\s+(\w+)", re.I)
TYPE = re.compile(r"\s*type\s*(?:,[^:]*)?::\s*(\w+)|\s*type\s+(?!is\b)(\w+)\s*$", re.I)
MODULE = re.compile(r"\s*(?:module\s+(?!procedure\b|subroutine\b|function\b)|program\s+)(\w+)\s*$", re.I)
END = re.compile(r"\s*end\s+(subroutine|function|type|module|program)\b", re.I)

Equation = collections.namedtuple("Equation", "number state title remark section")
Section = collections.namedtuple("Section", "number title theory modules suites remark")
Item = collections.namedtuple("Item", "kind name title places remark line")


def cited(text):
    """The numbers of the equations that a text cites."""
    for match in RANGE.finditer(text):
        chapter, first, last_chapter, last, other = match.groups()
        if other:
            yield other
        elif last and last_chapter == chapter and int(first) <= int(last):
            yield from (f"{chapter}-{i}" for i in range(int(first), int(last) + 1))
        else:
            yield f"{chapter}-{first}"
            if last:
                yield f"{last_chapter}-{last}"


# --- Fortran sources ---

def comment_of(line):
    """(code, comment) of a line."""
    code = re.sub(r"'[^']*'|\"[^\"]*\"", lambda m: "'" * len(m.group()), line)
    place = code.find("!")
    return (code, "") if place < 0 else (code[:place], line[place:])


class Source:
    """The comments and the code of one Fortran file by module, type and outermost procedure."""

    def __init__(self, path, text):
        self.path, self.module = path, ""
        self.comments = collections.defaultdict(list)      # (kind, name) -> texts
        self.code = collections.defaultdict(list)          # procedure -> lines
        self.names = {"procedure": set(), "type": set()}
        stack, block = [], []
        for line in text.splitlines():
            code, comment = comment_of(line)
            if not code.strip():
                if comment.startswith("!>"):
                    block.append(comment.lstrip("!> "))
                elif comment:
                    self.keep(stack, comment.lstrip("!< "))
                continue
            if END.match(code):
                stack = stack[:-1]
            elif opened := self.opened(code):
                stack.append(opened)
            if block:
                self.keep(stack, " ".join(block), MODULE.match(code))
                block = []
            if comment and not (stack and stack[-1][0] == "type"):
                self.keep(stack, comment.lstrip("!< "))
            if place := self.place(stack):
                self.code[place[1]].append(code)

    def opened(self, code):
        """(kind, name) of what a line begins."""
        for kind, pattern in (("module", MODULE), ("procedure", PROCEDURE), ("type", TYPE)):
            if match := pattern.match(code):
                name = next(g for g in match.groups() if g)
                if kind == "module":
                    self.module = name
                else:
                    self.names[kind].add(name)
                return kind, name
        return None

    @staticmethod
    def place(stack):
        """The outermost procedure, or else the type or module, that a line stands in."""
        return next((s for s in stack if s[0] == "procedure"), stack[-1] if stack else None)

    def keep(self, stack, comment, of_module=False):
        """Puts a comment where it belongs; in a module, but not before it, it is one of a constant."""
        if place := self.place(stack):
            kind, name = place
            self.comments["constant" if kind == "module" and not of_module else kind, name].append(comment)

    def citations(self):
        """(number, kind, name); comments of several lines may break a range."""
        for (kind, name), texts in self.comments.items():
            for number in cited(" ".join(texts)):
                yield number, kind, name


def sources(root, *tops):
    return [Source(path.relative_to(root).as_posix(), path.read_text(encoding="utf-8"))
            for top in tops for path in sorted((root / top).rglob("*.f90"))]


def places_in_source(found):
    """Of each equation: {source: names of its procedures or type; none for the module as a whole}."""
    places = collections.defaultdict(dict)
    for source in found:
        if source.path.startswith(NOT_PLACES):
            continue
        kinds = collections.defaultdict(lambda: collections.defaultdict(list))
        for number, kind, name in source.citations():
            if name not in kinds[number][kind]:
                kinds[number][kind].append(name)
        for number, by_kind in kinds.items():
            names = by_kind["procedure"] or ([] if by_kind["module"] else by_kind["type"])
            places[number][source] = names
    return places


# --- tests ---

def suites(root):
    text = (root / "test/main.f90").read_text(encoding="utf-8")
    return {collector: suite for suite, collector in re.findall(r"new_testsuite\('([^']+)',\s*(\w+)\)", text)}


def registered(root, source, collectors):
    """{procedure: (suite, test)} of the tests of a source."""
    text = (root / source.path).read_text(encoding="utf-8")
    tests = {}
    for name, body in re.findall(r"subroutine (\w+)\(testsuite\)(.*?)end subroutine", text, re.S):
        for test, procedure in re.findall(r"new_unittest\('([^']+)',\s*(?:&\s*)?(\w+)\)", body):
            tests[procedure] = (collectors.get(name, name), test)
    return tests


def places_in_tests(root, found):
    """Of each equation: its tests, as `suite: test`. What a helper cites counts for the tests that call it."""
    places, names = collections.defaultdict(list), set()
    collectors = suites(root) if (root / "test/main.f90").exists() else {}
    names.update(collectors.values())
    for source in found:
        tests = registered(root, source, collectors)
        names.update(f"{suite}: {test}" for suite, test in tests.values())
        for number, kind, name in source.citations():
            if kind != "procedure":
                continue
            for procedure in callers(source, name, tests):
                text = ": ".join(tests[procedure])
                if text not in places[number]:
                    places[number].append(text)
    return places, names


def callers(source, name, tests):
    """The tests among a procedure and those that reach it."""
    reached, new = set(), {name}
    while new:
        reached |= new
        new = {p for p, lines in source.code.items() if p not in reached
               and any(re.search(rf"\b{re.escape(r)}\b", line) for r in reached for line in lines)}
    return sorted(reached & set(tests), key=list(tests).index)


# --- documents ---

def slug(heading):
    """The anchor that a heading has on the pages of GitHub."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def theory_sections(root):
    """[(number or title, heading, text)] of docs/theory.md."""
    parts = re.split(r"^##+ (.+)$", (root / THEORY).read_text(encoding="utf-8"), flags=re.M)
    for heading, text in zip(parts[1::2], parts[2::2]):
        text = re.sub(r"\\text\{-\}", "-", text)
        text = re.sub(r"\\(?:ldots|dots|cdots)", "...", text)
        number = re.match(r"\d+(?:\.\d+)*", heading)
        yield number.group() if number else heading, heading, text.replace("$", "")


def places_in_theory(root):
    """Of each equation: its sections; the headings; (number, place) of what the report has not; the slips."""
    places, headings, unknown, slips = collections.defaultdict(list), {}, set(), set()
    for name, heading, text in theory_sections(root):
        headings[name] = heading
        for number in cited(text):
            if number not in EQUATIONS:
                unknown.add((number, f"{THEORY}, {heading}"))
            elif name.startswith(SLIPS):
                slips.add(number)
            elif name not in places[number]:
                places[number].append(name)
    return places, headings, unknown, slips


# --- the table ---

def read_table(root, mistakes):
    """What tools/concordance.txt says."""
    equations, sections, items = {}, [], []
    order = []
    for line_number, line in enumerate((root / TABLE).read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        where = f"{TABLE}:{line_number}"
        fields = [f.strip() for f in line.split("|")]
        kind, _, name = fields[0].partition(" ")
        if kind == "section" and len(fields) == 6:
            sections.append(Section(name, fields[1], *(f.split() for f in fields[2:5]), fields[5]))
        elif kind in ("figure", "table", "card", "name") and len(fields) in (3, 4):
            if len(fields) == 3:
                fields.append("")
            items.append(Item(kind, name, fields[1], fields[2], fields[3], where))
        elif kind == "value" and len(fields) == 3:
            items.append(Item(kind, name, "", fields[1], fields[2], where))
        elif re.fullmatch(r"\d-\d+|6\.1", fields[0]) and len(fields) == 4:
            number = fields[0]
            order.append(number)
            if fields[1] not in STATES:
                mistakes.append(f"{where}: the state {fields[1]!r} is none of {', '.join(STATES)}")
            if not sections:
                mistakes.append(f"{where}: ({number}) stands above the first section")
                continue
            before = equations.get(order[-2]) if len(order) > 1 else None
            title, remark = fields[2:] if fields[2] or not before else (before.title, before.remark)
            equations[number] = Equation(number, fields[1], title, remark, sections[-1].number)
        else:
            mistakes.append(f"{where}: cannot be read: {line}")
    if order != EQUATIONS:
        missing = [n for n in EQUATIONS if n not in order]
        mistakes.append(f"{TABLE}: the equations are not those of the report in their order; missing: "
                        f"{', '.join(missing) or 'none'}; not of the report: "
                        f"{', '.join(n for n in order if n not in EQUATIONS) or 'none'}")
    return equations, sections, items


def case_keys(root):
    """`group/key` of the case files, from what src/ reads. A key read outside of a group may be of any."""
    keys, groups, loose = set(), set(), set()
    for path in sorted(p for top in ("src", "level1/src") for p in (root / top).rglob("*.f90")):
        group = None
        for match in re.finditer(r"settings%group\('(\w+)'|settings%end_group|settings%\w+_values?\('(\w+)'",
                                 path.read_text(encoding="utf-8")):
            begun, key = match.groups()
            if begun:
                group = begun
                groups.add(group)
            elif key and group:
                keys.add(f"{group}/{key}")
            elif key:
                loose.add(key)
            else:
                group = None
    return keys | {f"{group}/{key}" for group in groups for key in loose}


def known_names(root, found, tests):
    """Everything that may stand in backticks, but for files."""
    names = set(tests) | case_keys(root)
    for source in found:
        names |= {source.module} | source.names["procedure"] | source.names["type"]
        for match in re.finditer(r"parameter[^!]*::\s*(\w+)", (root / source.path).read_text(encoding="utf-8")):
            names.add(match.group(1))
    commands = root / "app/cli/command_line.f90"
    if commands.exists():
        names |= {f"gracecg {c}" for c in re.findall(r"command_t\('([^']+)'", commands.read_text(encoding="utf-8"))}
    statements = root / "src/studies/statements/statements.f90"
    if statements.exists():
        names |= {f"gracecg statements {s}" for s in re.findall(r"claim_t\('([^']+)'", statements.read_text(encoding="utf-8"))}
    return names


def check_names(root, names, equations, sections, items, headings, mistakes):
    texts = [(f"({e.number})", e.remark) for e in equations.values()]
    texts += [(f"section {s.number}", s.remark) for s in sections]
    texts += [(i.line, f"{i.title} {i.places} {i.remark}") for i in items]
    for where, text in texts:
        for name in re.findall(r"`([^`]+)`", text):
            if name not in names and not (root / name).is_file():
                mistakes.append(f"{TABLE}, {where}: `{name}` does not exist")
    for section in sections:
        for number in section.theory:
            if number not in headings:
                mistakes.append(f"{TABLE}, section {section.number}: {THEORY} has no section {number}")
        for module in section.modules:
            if module not in names:
                mistakes.append(f"{TABLE}, section {section.number}: the module {module} does not exist")
        for suite in section.suites:
            if suite not in names:
                mistakes.append(f"{TABLE}, section {section.number}: the suite {suite} does not exist")


# --- the document ---

def theory_link(name, headings):
    return f"[{name}](theory.md#{slug(headings[name])})"


def source_text(by_source):
    """The procedures, or the module where none is meant, each a link to its file."""
    return ", ".join(f"[{name}](../{source.path})" for source, names in by_source.items()
                     for name in names or [source.module.removeprefix("gracecg_")])


def row(*cells):
    return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"


HEAD = """\
# Concordance with the report

Where each piece of the report CSR-TM-00-01 stands here; made by `tools/concordance.py`.

An equation is computed as printed unless called *corrected*, a [slip](theory.md#{slips}) mended;
*equivalent*, the same in another form; *replaced*, by something else; *definition*, nothing to compute; *absent*. Of the {total}:
{states}. Named by a test: {tested}.

## Sections and equations

Behind a title stand sections of the theory. Procedures or a module link to their files; behind them stand suites of tests, which
`fpm test -- SUITE` runs ("none": no test names it).
"""


def table_head(*head):
    yield row(*head)
    yield row(*["---"] * len(head))


def span(numbers):
    """(2-1), or (2-1)-(2-5) of what follows one another."""
    return f"({numbers[0]})" + (f"-({numbers[-1]})" if len(numbers) > 1 else "")


def merged(rows):
    """[(names, first cells, cells that are equal)]: what follows one another with equal cells becomes one."""
    for same, group in itertools.groupby(rows, lambda r: r[2]):
        group = list(group)
        yield [name for name, _, _ in group], list(dict.fromkeys(cell for _, cell, _ in group if cell)), same


def section_cells(section, own, places, by_module):
    """A section, with the theory of its equations, and the modules and suites that none of these names."""
    in_source, in_theory, in_tests, headings = places
    named = {source.module for e in own for source in in_source[e.number]}
    tested = {test.split(": ")[0] for e in own for test in in_tests[e.number]}
    theory = dict.fromkeys(section.theory + [n for e in own for n in in_theory[e.number]])
    modules = {by_module[m]: () for m in section.modules if m in by_module and m not in named}
    suites = ", ".join(s for s in section.suites if s not in tested)
    return (", ".join(theory_link(n, headings) for n in sorted(theory, key=list(headings).index)),
            "; ".join(part for part in (source_text(modules), suites) if part))


def together(own, places):
    """Equations that follow one another, in at most eight procedures of four modules."""
    in_source, _, in_tests, _ = places
    groups, procedures = [], set()
    for e in own:
        here = {(source, name) for source, names in in_source[e.number].items() for name in names or [""]}
        joint = here | procedures
        if groups and bool(in_tests[e.number]) == bool(in_tests[groups[-1][0].number]) and \
                len(joint) <= 8 and len({source for source, _ in joint}) <= 4:
            groups[-1].append(e)
            procedures = joint
        else:
            groups.append([e])
            procedures = here
    return groups


def equation_rows(own, places):
    """The cells of the equations of a section by rows; a state that all of a row have stands once."""
    in_source, _, in_tests, _ = places
    for members in together(own, places):
        texts, states = [], {e.state for e in members}
        for e in members:
            said = [e.title, "" if e.state == "printed" or len(states) == 1 else f"*{e.state}*", e.remark]
            text = ", ".join(part for part in said if part)
            if text and text not in texts:
                texts.append(text)
        of_all = states - {"printed"} if len(states) == 1 else ()
        found, suites = collections.defaultdict(list), {}
        for e in members:
            for source, names in in_source[e.number].items():
                found[source] += [n for n in names if n not in found[source]]
            suites.update(dict.fromkeys(t.split(": ")[0] for t in in_tests[e.number]))
        tests = ", ".join(suites) or ("" if states == {"absent"} else "none")
        what = "; ".join(texts + [f"*{s}*" for s in of_all])
        yield (f"{span([e.number for e in members])} {what}", "; ".join(part for part in (source_text(found), tests) if part))


def section_row(members, cells, equations=("", "")):
    """Sections with equal cells, and the cells of equations in the same row."""
    titles = "; ".join(f"{s.number} {s.title}" for s in members)
    what = [f"**{titles}** {cells[0]}", *(s.remark for s in members if s.remark), equations[0]]
    return row("; ".join(part for part in what if part), cells[1] or equations[1])


def section_rows(sections, equations, places, by_module):
    """Sections that follow one another with equal cells and without equations share a row; so do a section and its
    equations where these have one row and it names nothing besides."""
    waiting, of_waiting = [], None
    for section in sections:
        own = [e for e in equations.values() if e.section == section.number]
        cells = section_cells(section, own, places, by_module)
        rows = list(equation_rows(own, places))
        if waiting and (own or cells != of_waiting or section.number[0] != waiting[0].number[0]):
            yield section_row(waiting, of_waiting)
            waiting = []
        if len(rows) == 1 and not cells[1]:
            yield section_row([section], cells, rows[0])
        elif own:
            yield section_row([section], cells)
            yield from (row(*r) for r in rows)
        else:
            waiting, of_waiting = [*waiting, section], cells
    if waiting:
        yield section_row(waiting, of_waiting)


TABLES = (("figure", "Figures", ("figure", "where; remark")),
          ("table", "Tables", ("table", "where; remark")),
          ("card", "Cards of MSODP (section 5.2)", ("card", "meaning", "key of the case file; remark")),
          ("value", "Numbers of sections 3.4.1, 5.2, 6.1 and 6.2", ("what", "key of the case file; remark")),
          ("name", "Programs, models and data that the report names", ("name", "what", "here; remark")))


def item_rows(items, kind):
    """The items of a kind; "the same" stands for the places, "likewise" for the remark of the item above."""
    rows, places, remark = [], "", ""
    for i in (i for i in items if i.kind == kind):
        places = places if i.places == "the same" else i.places
        remark = remark if i.remark == "likewise" else i.remark
        name = f"`{i.name}`" if kind == "card" else i.name
        rows.append((name, i.title, "; ".join(part for part in (places, remark) if part)))
    for names, titles, where in merged(rows):
        name, title = "; ".join(names), "; ".join(titles)
        if kind in ("figure", "table"):
            yield row(f"{names[0]}-{names[-1]} {title}" if len(names) > 1 else f"{name} {title}", where)
        else:
            yield row(name, *([] if kind == "value" else [title]), where)


def document(equations, sections, items, places, by_module):
    headings = places[3]
    counts = collections.Counter(e.state for e in equations.values())
    states = ", ".join(f"{s} {counts[s]}" for s in STATES if counts[s])
    slips = next((slug(h) for n, h in headings.items() if n.startswith(SLIPS)), "")
    tested = sum(bool(places[2][n]) for n in EQUATIONS)
    yield HEAD.format(slips=slips, total=len(equations), states=states, tested=tested)
    yield from table_head("section, equation", "source; tests")
    yield from section_rows(sections, equations, places, by_module)
    yield ""
    for kind, title, head in TABLES:
        yield f"## {title}\n"
        if kind in ("figure", "table"):
            yield "`gracecg report` makes them all; besides:\n"
        yield from table_head(*head)
        yield from item_rows(items, kind)
        yield ""


def build(root):
    """(text of the document, mistakes)."""
    mistakes = []
    equations, sections, items = read_table(root, mistakes)
    in_src = sources(root, "src", "app", "level1/src")
    in_test = sources(root, "test")
    by_source = places_in_source(in_src)
    by_test, tests = places_in_tests(root, in_test)
    by_theory, headings, unknown, slips = places_in_theory(root)
    for source in in_src + in_test:
        unknown |= {(n, f"{source.path}, {name}") for n, _, name in source.citations() if n not in EQUATIONS}
    mistakes += [f"{where}: the report has no equation ({number})" for number, where in sorted(unknown)]
    for e in equations.values():
        lacking = [what for what, has in (("docs/theory.md", by_theory[e.number]), ("src/", by_source[e.number]))
                   if not has]
        if e.state == "absent" and len(lacking) < 2:
            mistakes.append(f"({e.number}) is called absent, but {THEORY} or src/ names it")
        elif e.state != "absent" and lacking:
            mistakes.append(f"({e.number}) {e.title}: not named in {' nor '.join(lacking)}")
        if e.state == "corrected" and e.number not in slips:
            mistakes.append(f"({e.number}) is called corrected, but the slips of {THEORY} lack it")
    names = known_names(root, in_src, tests)
    check_names(root, names, equations, sections, items, headings, mistakes)
    if mistakes:
        return "", mistakes
    by_module = {s.module: s for s in in_src}
    text = "\n".join(document(equations, sections, items, (by_source, by_theory, by_test, headings), by_module))
    return text.rstrip() + "\n", mistakes


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if sys.argv[1:] not in ([], ["--check"]):
        print(__doc__)
        return 2
    text, mistakes = build(ROOT)
    for mistake in mistakes:
        print(mistake)
    if mistakes:
        return 1
    target = ROOT / TARGET
    if target.exists() and target.read_text(encoding="utf-8") == text:
        return 0
    if sys.argv[1:] == ["--check"]:
        print(f"{TARGET} is out of date: run tools/concordance.py")
        return 1
    target.write_text(text, encoding="utf-8")
    print(f"{TARGET} written")
    return 0


# --- the test of this tool ---

HOUSE = {
    "tools/concordance.txt": """\
# a comment
section 2.1 | All | 1 | gracecg_base_all | all | `whole`
EQUATIONS
figure 2.1 | Axes | `docs/theory.md`, `all: test` |
figure 2.2 | More axes | the same |
card AL 0 0 .34 | albedo | `earth/rings` |
""",
    "docs/theory.md": """\
# Theory

## 1 All of it

$$(2\\text{-}1) \\ldots (2\\text{-}35)$$ and (3-1) to (3-23), (4-1)-(4-103), (6.1)

## The report's slips

(2-7)
""",
    "src/base/all.f90": """\
!> All.
module gracecg_base_all
    private
    integer, parameter :: ONE = 1  !! Of (2-2)
contains

    !> (2-1) to
    !> (2-35), (3-1)-(3-23), (4-1)-(4-103)
    subroutine whole(error)
        print *, '! (2-99)'   ! (6.1)
        call settings%group('earth', '')
        call settings%integer_value('rings', n)
    end subroutine whole
end module gracecg_base_all
""",
    "test/test_all.f90": """\
module test_all
contains
    subroutine collect_all(testsuite)
        testsuite = [new_unittest('test', test_it)]
    end subroutine
    subroutine test_it(error)
        call helper()
    end subroutine test_it

    !> (4-17)
    subroutine helper()
    end subroutine helper
end module test_all
""",
    "test/main.f90": """\
program tester
    suites = [new_testsuite('all', collect_all)]
end program tester
""",
}


def plant_house(root):
    """A small project in which every equation has its places; (4-19) takes the title of (4-18)."""
    equations = "\n".join(f"{n} | {'corrected' if n == '2-7' else 'printed'} | {'' if n == '4-19' else f'what {n} is'} |" for n in EQUATIONS)
    for path, text in HOUSE.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text.replace("EQUATIONS", equations), encoding="utf-8")


FAULTS = (  # file, what is replaced, by what, what is found
    ("tools/concordance.txt", "4-17 | printed | what 4-17 is |\n", "", "missing: 4-17"),
    ("tools/concordance.txt", "4-17 | printed |", "4-17 | guessed |", "the state 'guessed'"),
    ("tools/concordance.txt", "4-17 | printed |", "4-17 | absent |", "(4-17) is called absent"),
    ("tools/concordance.txt", "4-17 | printed |", "4-17 printed |", "cannot be read"),
    ("tools/concordance.txt", "`whole`", "`half`", "`half` does not exist"),
    ("tools/concordance.txt", "| gracecg_base_all |", "| gracecg_base_none |", "gracecg_base_none does not exist"),
    ("tools/concordance.txt", "| all | `whole`", "| al | `whole`", "the suite al does not exist"),
    ("tools/concordance.txt", "| All | 1 |", "| All | 7 |", "has no section 7"),
    ("tools/concordance.txt", "`all: test`", "`all: toast`", "`all: toast` does not exist"),
    ("tools/concordance.txt", "`earth/rings`", "`earth/ring`", "`earth/ring` does not exist"),
    ("docs/theory.md", "(6.1)", "", "(6.1) what 6.1 is: not named in docs/theory.md"),
    ("docs/theory.md", "(2-7)", "", "the slips of docs/theory.md lack it"),
    ("docs/theory.md", "(2-7)", "(2-77)", "the report has no equation (2-77)"),
    ("src/base/all.f90", "! (6.1)", "! 6.1", "(6.1) what 6.1 is: not named in src/"),
    ("src/base/all.f90", "! (6.1)", "! (6.1), (3-24)", "the report has no equation (3-24)"),
    ("test/test_all.f90", "(4-17)", "(4-170)", "the report has no equation (4-170)"))


def self_test():
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder, "clean")
        plant_house(root)
        text, mistakes = build(root)
        failures += [f"the clean house: {m}" for m in mistakes]
        for part in ("Of the 162:\nprinted 161, corrected 1. Named by a test: 1.",
                     "| **2.1 All** [1](theory.md#1-all-of-it); `whole` |  |",
                     "| (4-17) what 4-17 is | [whole](../src/base/all.f90); all |",
                     "| (4-18)-(6.1) what 4-18 is; what 4-20 is; ",
                     "; what 2-6 is; what 2-7 is, *corrected*; ",
                     "; what 6.1 is | [whole](../src/base/all.f90); none |",
                     "| 2.1-2.2 Axes; More axes | `docs/theory.md`, `all: test` |"):
            if part not in text:
                failures.append(f"the clean house lacks: {part}")
        for number, (path, old, new, found) in enumerate(FAULTS):
            root = pathlib.Path(folder, str(number))
            plant_house(root)
            before = (root / path).read_text(encoding="utf-8")
            (root / path).write_text(before.replace(old, new), encoding="utf-8")
            if before.count(old) == 0 or not any(found in m for m in build(root)[1]):
                failures.append(f"not found: {found}")
    for failure in failures:
        print(failure)
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
