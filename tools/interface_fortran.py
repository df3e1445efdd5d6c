"""The public Fortran interface as one text, made of the sources: every name of a module, and how it is declared there."""
import re

from interface_table import ROOT, Mistake

SOURCES = {"gracecg": ROOT / "src", "gracecg_level1": ROOT / "level1/src"}
KINDS = r"(?:(?:pure|elemental|recursive|impure|module|real\(dp\)|integer|logical|type\(\w+\))\s+)*"


def code_of(line):
    """A line without its comment."""
    return re.sub(r"""((?:'[^']*'|"[^"]*"|[^'"!])*)!.*""", r"\1", line).rstrip()


def statements(text):
    """The statements of a source, each as its lines with the comments that stand at it or below it."""
    found, open_one = [], False
    for line in text.splitlines():
        code = code_of(line)
        if not code.strip():
            if line.strip().startswith("!!") and found:
                found[-1].append(line)
        elif open_one:
            found[-1].append(line)
        else:
            found.append([line])
        if code.strip():
            open_one = code.endswith("&")
    return found


def said(statement):
    """What a statement says, in one line."""
    return re.sub(r"\s+", " ", " ".join(code_of(line).strip(" &") for line in statement)).strip()


class Module:
    """The declarations of one module, by name."""

    def __init__(self, path):
        self.all = statements(path.read_text(encoding="utf-8"))
        self.texts = [said(statement) for statement in self.all]

    def origin(self, name):
        """The module from which it has a name."""
        return next((text.split(",")[0][4:] for text in self.texts
                     if text.startswith("use ") and name in re.findall(r"\w+", text.split("only:")[-1])), None)

    def block(self, start):
        """The numbers of the statements of a procedure, type or interface that begins there."""
        kind = re.search(r"\b(subroutine|function)\b|^(?:abstract )?(type|interface)\b", self.texts[start])
        kind = kind.group(1) or kind.group(2)
        end = next(i for i in range(start, len(self.texts)) if re.match(rf"end {kind}\b", self.texts[i]))
        return range(start, end + 1)

    def procedure(self, name):
        """The statements that declare its arguments and its result."""
        start = next((i for i, text in enumerate(self.texts)
                      if re.match(rf"{KINDS}(?:subroutine|function) {name}\b", text, flags=re.I)), None)
        if start is None:
            return []
        head = self.texts[start]
        wanted = re.findall(r"\w+", head.split("(", 1)[1] if "(" in head else "") + [name]
        body = [i for i in self.block(start)[1:-1] if "::" in self.texts[i] or self.texts[i].startswith("procedure(")]
        kept = [i for i in body if set(re.findall(r"\w+", self.texts[i].split("::")[-1].split("=")[0])) & set(wanted)
                and ("intent(" in self.texts[i] or "procedure(" in self.texts[i] or "result" in head or "function" in head)]
        return [self.all[start], *(self.all[i] for i in kept)]

    def declared(self, name):
        """The statements of a name."""
        for i, text in enumerate(self.texts):
            if re.match(rf"type\b.*:: {name}$", text, flags=re.I):
                return self.of_type([self.all[k] for k in self.block(i)])
            if re.match(rf"interface {name}$", text, flags=re.I):
                names = re.findall(r"\w+", " ".join(self.texts[k].replace("module procedure", "") for k in self.block(i)[1:-1]))
                return [statement for one in names for statement in self.procedure(one)]
            if "parameter" in text and re.search(rf":: .*\b{name}\b *[(=]", text, flags=re.I):
                kind, value = text.split("::", 1)
                shape = re.search(rf"\b{name}\b *(\([^=]*?\))? *=", value, flags=re.I).group(1) or ""
                return [[f"    {kind.strip()} :: {name}{shape}"]]
        return self.procedure(name)

    def of_type(self, lines):
        """A type without what is private, each procedure followed by its arguments."""
        kept = []
        for statement in lines:
            text = said(statement)
            if re.search(r"\bprivate\b|^final ", text):
                continue
            kept.append(statement)
            if bound := re.match(r"procedure(?:\((\w+)\))?[^:]*:: (\w+)(?: => (\w+))?$", text):
                kept += [["    " + line for line in one]
                         for one in self.procedure(bound.group(1) or bound.group(3) or bound.group(2))]
        return kept


def names_of(package):
    """Of the module that a program uses: each name, that in its own module, and that module."""
    for statement in statements((SOURCES[package] / f"{package}.f90").read_text(encoding="utf-8")):
        if match := re.match(r"use (\w+), only: (.*)", said(statement)):
            for name in match.group(2).split(","):
                own, _, other = (piece.strip() for piece in name.partition("=>"))
                yield own, other or own, match.group(1)


def fortran_interface(package):
    """The lines of the text."""
    yield "! Made by tools/interface.py from the sources."
    yield f"! What `use {package}` gives, as they declare it: types with components and procedures, arguments in their order."
    yield "! docs/api.md says what of it stays."
    files = {match.group(1): path for path in sorted(SOURCES[package].rglob("*.f90"))
             if (match := re.search(r"^module (\w+)", path.read_text(encoding="utf-8"), flags=re.M))}
    modules, before = {}, ""
    for name, own, module in names_of(package):
        if module not in files:
            continue
        if module != before:
            yield from ("", f"! ---- {module}")
        before = module
        found = []
        while not found and module in files:        # a module may pass on what another declares
            source = modules.setdefault(module, Module(files[module]))
            found = source.declared(own)
            module = source.origin(own)
        if own != name:
            yield f"! {name} is"
        if not found:
            raise Mistake(f"{before} does not declare {own}")
        for statement in found:
            yield from (line.rstrip() for line in statement)
