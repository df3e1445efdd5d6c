"""The entries of Fortran 77 that tools/interface.py writes, and their table."""
import math
import re

from interface_table import ROOT, Mistake
from interface_text import MADE, comment, folded, shape, uses, words

F77_TYPES = {"text": "character(*)", "settings": "character(*)", "integer": "integer", "count": "integer", "object": "integer",
             "handles": "integer"}


class Entry:
    """An entry of Fortran 77 and what its body is made of."""

    def __init__(self, line, function, objects):
        self.name, self.text, self.function, self.objects = line.name, line.text, function, objects
        self.arguments = []         # name, type, sizes, is a result, meaning
        self.call, self.before, self.after, self.local = [], [], [], []
        self.handle = self.made = None
        self.columns = ""
        self.translate(line.arguments)
        self.fetch(line.gets)

    def add(self, name, kind, sizes=(), result=False, meaning=""):
        if kind != "character(*)" and (kind == "integer") != (name[0] in "ijklmn"):
            raise Mistake(f"{self.name}: {name} has a name of another type")
        self.arguments.append((name, kind, list(sizes), result, meaning))

    def add_time(self, names, result):
        day, seconds = names.split()
        self.add(day, "integer", result=result, meaning="Modified Julian day number, UTC")
        self.add(seconds, "real(dp)", result=result, meaning="s of the day")
        return day, seconds

    def translate(self, given):
        """The arguments of the call. A count that is 1 takes its size away from the arrays."""
        function, one = self.function, set()
        if function.name in ("get", "get_text"):
            self.translate_get(given)
            return
        if len(given) != len(function.arguments):
            raise Mistake(f"{self.name} has {len(given)} arguments, gracecg_{function.name} {len(function.arguments)}")
        counts = {}
        for word, a in zip(given, function.arguments):
            if a.kind == "count":
                counts[a.name] = word
                if word == "1":
                    one.add(a.name)
        for word, a in zip(given, function.arguments):
            if word == "-":
                continue
            sizes = [counts.get(size, size) for size in a.sizes if size not in one]
            sizes = [f"0:{counts[size[2:]]}" if size.startswith("0:") else size for size in sizes]
            value = self.value(word, a, sizes, set(a.sizes) & one)
            self.call.append(f"{a.name}={value}")

    def value(self, word, a, sizes, single):
        """One argument of the call to C."""
        meaning = f"`{a.name}` of gracecg_{self.function.name}"
        if a.way == "make":
            self.made = (a, word)
            if word != "*":
                self.add(word, "integer", result=True, meaning="A handle, to be given back with GCFREE; 0 after a failure")
            return "handle"
        if a.kind == "time":
            day, seconds = self.add_time(word, a.way == "out")
            if a.way == "in":
                return f"c_utc_t({day}, {seconds})"
            self.local.append("type(c_utc_t) :: utc")
            self.before.append("utc = c_utc_t(0, 0.0_dp)")
            self.after += [f"{day} = utc%mjd", f"{seconds} = utc%seconds"]
            return "utc"
        if word.startswith("["):
            names = word.strip("[]").split(", ")
            for name in names:
                self.add(name, "real(dp)", result=a.way == "out", meaning=f"Of {meaning}")
            if a.way == "in":
                return word
            return self.values(names)
        if re.match(r"[\d']", word):
            text = a.kind in ("text", "settings")
            return f"c_text({word})" if text else f"{word}_c_size_t" if a.kind == "count" else \
                f"[{word}.0_dp]" if a.sizes else f"{word}.0_dp" if a.kind == "real" else f"{word}_c_int32_t"
        name = word.rstrip("'")
        kind = "integer" if a.is_handle else F77_TYPES.get(a.kind, "real(dp)")
        self.add(name, kind, sizes, a.way == "out", meaning)
        if a.is_handle:
            self.handle = name
            return f"c_handle({name})"
        if a.kind in ("text", "settings"):
            return f"c_text({name})"
        if a.kind == "count":
            return f"int({name}, c_size_t)"
        if a.kind == "handles":
            return f"c_handle({name}(:{sizes[0]}))"
        if word.endswith("'"):
            self.local.append(f"real(dp) :: rows({sizes[0]}, {sizes[1]})")
            self.before.append("rows = 0")
            self.after.append(f"{name} = transpose(rows)")
            return "rows"
        if single and not sizes:
            return f"[{name}]" if a.way == "in" else self.values([name])
        return name

    def values(self, names):
        """A local array whose numbers go to single arguments."""
        array = self.room(len(names))
        self.after += [f"{name} = {array}({i})" for i, name in enumerate(names, 1)]
        return array

    def room(self, size):
        """A local array for what comes out."""
        array = f"found_{sum(line.startswith('real(dp) :: found_') for line in self.local) + 1}"
        self.local.append(f"real(dp) :: {array}({size})")
        self.before.append(f"{array} = 0")
        return array

    def translate_get(self, given):
        self.add(given[0], "integer", meaning="A handle")
        self.handle = given[0]
        if given[1] == "-":
            return
        self.add(given[1], "character(*)", meaning="Name of the item")
        if self.function.name == "get_text":
            self.add(given[2], "character(*)", result=True, meaning="Its text; ISTAT is 3 when it is longer")
            self.after.append(f"call fetch_text(c_handle({given[0]}), {given[1]}, {given[2]}, status, error)")
            return
        limit, count, values = given[2:]
        self.add(limit, "integer", meaning="Room in the array")
        self.add(count, "integer", result=True, meaning="How many numbers there are")
        self.add(values, "real(dp)", [limit], True, "The numbers")
        self.after += [f"call fetch_count(c_handle({given[0]}), {given[1]}, 1, {count}, status, error)",
                       f"call fetch(c_handle({given[0]}), {given[1]}, {limit}, {values}, status, error)"]

    def fetch(self, gets):
        """What is fetched from the object that was made or, without one, given."""
        source = "handle" if self.made else f"c_handle({self.handle})"
        kind = self.made[0].kind if self.made else {"icas": "case", "iliv": "live"}.get(self.handle, "observations")
        items = self.objects[kind].all_items(self.objects) if gets else {}
        for get in gets:
            name, _, wanted = (part.strip() for part in get.partition("="))
            name, sizes = re.match(r"([\w ]+?)(?:\((.*)\))?$", name).groups()
            sizes = [size.strip() for size in sizes.split(",")] if sizes else []
            if not wanted:
                self.add(name, "integer", meaning="Columns that the arrays have room for")
                continue
            if name == "msg":
                self.after.append(f"call fetch_message({source}, '{wanted}', status, error)")
                continue
            own = wanted.lstrip("#").split()
            if unknown := [one for one in own if one not in items]:
                raise Mistake(f"no item {unknown[0]} of {kind}")
            if wanted.startswith("#"):
                row = math.prod(int(size) for size in items[own[0]].sizes if size.isdigit())
                self.add(name, "integer", result=True, meaning="How many columns there are")
                self.after.append(f"call fetch_count({source}, '{own[0]}', {row}, {name}, status, error)")
            elif " " in name:
                day, seconds = self.add_time(name, True)
                array = self.room("2")
                self.after += [f"call fetch({source}, '{wanted}', 2, {array}, status, error)", f"{day} = nint({array}(1))",
                               f"{seconds} = {array}(2)"]
            else:
                self.fetch_numbers(name, sizes, own, items, source)
        if self.made and self.made[1] == "*":
            self.after.append("call discard(handle)")

    def fetch_numbers(self, name, sizes, wanted, items, source):
        integer = name[0] in "ijklmn"
        meanings = [f"item {one}{': ' if items[one].meaning else ''}{items[one].meaning}" for one in wanted]
        self.add(name, "integer" if integer else "real(dp)", sizes, True, "I" + "; ".join(meanings)[1:])
        names, size = " ".join(wanted), "*".join(sizes) or "1"
        if not integer and sizes:
            self.after.append(f"call fetch({source}, '{names}', {size}, {name}, status, error)")
            return
        array = self.room(size)
        value = array if sizes else f"{array}(1)"
        value = f"nint({value})" if integer else value
        if sizes and not sizes[-1].isdigit():       # of assumed size
            columns = f"max({sizes[-1]}, 0)"
            name, value = f"{name}(:, :{columns})", f"reshape({value}, [{sizes[0]}, {columns}])"
        self.after += [f"call fetch({source}, '{names}', {size}, {array}, status, error)", f"{name} = {value}"]

    def declarations(self):
        for name, kind, sizes, result, meaning in self.arguments:
            yield f"{kind}, intent({'inout' if result else 'in'}) :: {name}{shape(sizes)}", meaning

    def lines(self, modules):
        body = list(self.before)
        if self.call:
            body.append(f"status = c_{self.function.name}({', '.join(self.call)}, error=error)")
        else:
            body.append("call start_call(status, error)")
        body += self.after
        new = self.made and self.made[1] != "*"
        if self.made:
            body.insert(0, "handle = 0")
            self.local.append("integer(c_intptr_t) :: handle")
        if new:
            body.append(f"{self.made[1]} = int(handle)")
        body.append("call finish(status, error, istat, msg)")
        names = [name for name, *_ in self.arguments] + ["istat", "msg"]
        text = [f"{line}    !! {meaning}" for line, meaning in self.declarations()]
        local = [*self.local, "type(c_error_t) :: error", "integer(c_int) :: status"]
        yield from comment(self.text[0].upper() + self.text[1:] + ".", "!> ")
        yield from folded(f"subroutine {self.name}({', '.join(names)})", "")
        for line in uses(words(text + local + body), modules, names):
            yield from folded(line, "    ")
        yield "    implicit none"
        for line, meaning in self.declarations():
            yield f"    {line}"
            yield from comment(meaning, "!! ", "    ")
        yield "    integer, intent(out) :: istat"
        yield "    character(*), intent(inout) :: msg"
        yield ""
        yield from (f"    {line}" for line in local)
        yield ""
        for line in body:
            yield from folded(line, "    ")
        yield f"end subroutine {self.name}"


BY_HAND = (ROOT / "src/interface/f77_by_hand.f90").read_text(encoding="utf-8")
ROWS_BY_HAND = ["| `GCVERS(`**'VERS'**`)` | version as text; no ISTAT, MSG |",
                "| `GCVINT(`**NVERS**`)` | version of the interface; no ISTAT, MSG |",
                "| `GCFREE(`**IH**`)` | gives any handle back and sets it to 0 |"]


def f77(entries, modules):
    yield f"! {MADE}"
    yield "!"
    yield "! The Fortran 77 entry points: external procedures that need no module where they are called. Their"
    yield "! arguments: docs/interface/fortran77.md. Each calls a function of the C interface, and ends with istat (0 or a status) and msg."
    for entry in entries:
        yield ""
        yield from entry.lines(modules)


def f77_interfaces(entries):
    yield f"! {MADE}"
    yield "!> The Fortran 77 entry points, for tests: checked by the compiler, called as from Fortran 77."
    yield "module f77_interfaces"
    yield "    implicit none"
    yield ""
    yield "    interface"
    for head, body, end in re.findall(r"^(subroutine .*?)$(.*?)^(end subroutine \w+)$", BY_HAND, flags=re.M | re.S):
        yield f"        {head}"
        for kind, names in re.findall(r"^    ([\w(*)]+), intent\(\w+\) :: ([\w, ]+)", body, flags=re.M):
            yield f"            {kind} :: {names.strip()}"
        yield f"        {end}"
        yield ""
    for entry in entries:
        names = [name for name, *_ in entry.arguments] + ["istat", "msg"]
        yield from folded(f"subroutine {entry.name}({', '.join(names)})", " " * 8)
        for kind, fortran in (("character(*)", "character(*)"), ("integer", "integer"), ("real(dp)", "double precision")):
            own = [f"{name}{shape(sizes)}" for name, of, sizes, *_ in entry.arguments if of == kind]
            own += ["istat"] * (kind == "integer") + ["msg"] * (kind == "character(*)")
            if own:
                yield from folded(f"{fortran} :: {', '.join(own)}", " " * 12)
        yield f"        end subroutine {entry.name}"
        yield ""
    yield "    end interface"
    yield "end module f77_interfaces"


def f77_table(entries):
    yield f"<!-- {MADE} -->"
    yield "# The routines of Fortran 77"
    yield ""
    yield "[api.md](../api.md#fortran-77) says how to read them."
    yield ""
    yield "| call; behind the arguments stand **ISTAT, MSG** | does |"
    yield "|---|---|"
    yield from ROWS_BY_HAND
    for entry in entries:
        arguments = []
        for name, kind, sizes, result, _ in entry.arguments:
            text = f"{name}{f'({chr(44).join(sizes)})' if sizes else ''}".upper()
            text = f"'{text}'" if kind == "character(*)" else text
            arguments.append(f"**{text}**" if result else text)
        yield f"| `{entry.name.upper()}(`{', '.join(arguments)}`)` | {entry.text} |"
