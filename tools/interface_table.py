"""Reads tools/interface.txt, the table of the interfaces, which says how it is written."""
import pathlib
import re
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE = ROOT / "tools/interface.txt"
PLAIN = ("text", "settings", "integer", "count", "real", "position", "attitude", "state", "time", "handles", "numbers")


class Mistake(Exception):
    """A line of the table that cannot be read."""


@dataclass
class Text:
    """A chapter's title, or lines of the header as they stand."""

    kind: str
    text: str


@dataclass
class Item:
    """Numbers or a text of an object; the sizes are those of C."""

    name: str
    sizes: list
    meaning: str
    is_text: bool = False

    @property
    def shown(self):
        """As a document shows it."""
        sizes = "".join(f"[{size}]" for size in self.sizes).replace("[*]", "[]")
        return f'"{self.name}"' if self.is_text else self.name + sizes


@dataclass
class Object:
    """A kind of object."""

    name: str
    parent: str             # its items are items of this one, too
    type: str
    title: str
    items: list = field(default_factory=list)
    kind: str = "object"

    def all_items(self, objects):
        """By name, those of the parent among them."""
        inherited = objects[self.parent].all_items(objects) if self.parent else {}
        return inherited | {item.name: item for item in self.items}


@dataclass
class Argument:
    """An argument of a function."""

    way: str
    kind: str
    name: str
    sizes: list
    range: tuple
    optional: bool

    @property
    def is_handle(self):
        """Whether it is an object that the function uses."""
        return self.way == "in" and self.kind not in PLAIN


@dataclass
class Line:
    """An entry of Fortran 77 as the table has it."""

    name: str
    arguments: list
    gets: list
    text: str


@dataclass
class Function:
    """A function of C."""

    name: str
    text: str
    arguments: list = field(default_factory=list)
    work: str = ""          # a statement or, with a status, a call
    status: str = ""
    f77: list = field(default_factory=list)
    kind: str = "function"


def split(text):
    """The pieces between commas that stand in no bracket."""
    pieces, depth = [""], 0
    for letter in text:
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            pieces.append("")
        else:
            pieces[-1] += letter
    return [piece.strip() for piece in pieces if piece.strip()]


def read_argument(line):
    match = re.fullmatch(r"    (in|out|make) (\w+) (\w+)(?:\(([^)]*)\))?(?: \[([^\]]*)\])?( \?)?", line)
    if not match:
        raise Mistake("not an argument")
    way, kind, name, sizes, allowed, optional = match.groups()
    limits = None
    if allowed:
        limits = re.fullmatch(r"(>=?)(\d+)|(-?\d+)\.\.(-?\d+)", allowed)
        if not limits:
            raise Mistake("not a range")
        limits = (limits[1], limits[2]) if limits[1] else (limits[3], limits[4])
    return Argument(way, kind, name, split(sizes or ""), limits, bool(optional))


def read_f77(line):
    match = re.fullmatch(r"    f77 (gc\w+)\(([^;]*?)(?:; (.*))?\)  (\S.*)", line)
    if not match:
        raise Mistake("not an entry")
    return Line(match[1], split(match[2]), split(match[3] or ""), match[4])


def read_line(line, packages, items):
    """One line; `items` are those of the package that is being read."""
    if match := re.fullmatch(r"package (\w+)", line):
        items = packages.setdefault(match[1], [])
    elif match := re.fullmatch(r"chapter (.+)", line):
        items.append(Text("chapter", match[1]))
    elif line == "|" or line.startswith("| "):
        items.append(Text("verbatim", line[2:]))
    elif match := re.fullmatch(r"object (\w+)(?:\((\w+)\))? (\w+) (.+)", line):
        items.append(Object(*match.groups()))
    elif match := re.fullmatch(r"    (\w+|\"\w+\")(?:\(([^)]*)\))?(?:  +(\S.*))?", line):
        items[-1].items.append(Item(match[1].strip('"'), split(match[2] or ""), match[3] or "", '"' in match[1]))
    elif line.startswith("    f77 "):
        items[-1].f77.append(read_f77(line))
    elif match := re.fullmatch(r"    (?:does (.*)|tries (.*) \[(\w+)\])", line):
        items[-1].work, items[-1].status = match[1] or match[2], match[3] or ""
    elif line.startswith("    "):
        items[-1].arguments.append(read_argument(line))
    elif match := re.fullmatch(r"([a-z]\w*)  (\S.*)", line):
        items.append(Function(*match.groups()))
    else:
        raise Mistake("neither a function, an argument, an object nor an item")
    return items


def read_table():
    """Of each package what its header has, in order."""
    packages, items = {}, None
    for number, line in enumerate(TABLE.read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            items = read_line(line, packages, items)
        except (Mistake, AttributeError, TypeError, IndexError) as mistake:
            raise Mistake(f"{number}: {mistake}: {line}") from mistake
    return packages
