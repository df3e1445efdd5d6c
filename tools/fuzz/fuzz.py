#!/usr/bin/env python3
"""Mutated files for every reader, and calls of every C entry with NULL, negative, huge and NaN arguments.

    tools/fuzz/fuzz.py [--executions N] [--seed S] [--program PROGRAM] [--keep FOLDER]

Run it with a Python that has the package `gracecg` (tools/check_python.py makes build/python-venv). The work is done in a
process of its own, which says what it is about to do; when that process ends, or is silent for LIMIT seconds, the input
is kept and another process goes on behind it. What counts as a finding:

- a crash, or more than LIMIT seconds;
- through C, a status that is none of 0 to 7, a failure without a message, NaN or infinity in a result;
- of the program, an exit status other than 0, 1 and 2, a result that is not finite, a failure without a message;
- a file that is accepted with a field that is no number where one is expected.

2,000 executions (the default) take about 20 s. Every execution is named by seed and number: --only NUMBER repeats one.
"""
import argparse
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIMIT = 10.0
SENTINEL = 12345.0
ROOM = 16384                        # numbers in every array that is handed over
NO_NUMBERS = ["inf", "nan", "--1", "12abc", "1.2.3", "1e", "-1e999", "T", "+", "0x10", "1,5"]
NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+\.?\d*(?:[eEdD][-+]?\d+)?(?![\w.])")
# Functions that work for seconds with sound arguments, or that write files: sound calls are left out
SLOW = {"gracecg_design", "gracecg_observations_write", "gracecg_map", "gracecg_force_model_propagate"}


# ---------------------------------------------------------------- mutated files


def mutate(data, rng):
    """Some bytes after a few random changes, as faults and typing make them."""
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 4, 16])):
        kind = rng.randrange(12)
        at = rng.randrange(len(data) + 1)
        lines = data.split(b"\n")
        line = rng.randrange(len(lines))
        if kind == 0 and data:
            data[at % len(data)] = rng.randrange(256)
        elif kind == 1:
            data[at:at] = bytes(rng.randrange(256) for _ in range(rng.choice([1, 3, 40])))
        elif kind == 2:
            del data[at:at + rng.choice([1, 3, 40, 1000])]
        elif kind == 3:
            data = data[:at]
        elif kind == 4:
            lines.insert(line, lines[rng.randrange(len(lines))])
            data = bytearray(b"\n".join(lines))
        elif kind == 5:
            del lines[line]
            data = bytearray(b"\n".join(lines))
        elif kind == 6:
            lines[line] = lines[line] * rng.choice([2, 100])
            data = bytearray(b"\n".join(lines))
        elif kind == 7:
            lines[line] = rng.choice([b"1,", b"'", b"'' ", b"&a ", b"x", b"9" * 40 + b" "]) * rng.choice([10, 32000])
            data = bytearray(b"\n".join(lines))
        else:
            numbers = list(NUMBER.finditer(data))
            if numbers:
                place = rng.choice(numbers)
                value = rng.choice([*NO_NUMBERS, "-1", "0", "1e30", "1e308", "-1e308", "1e-320", "99999999999",
                                    "2147483648", "", "*", "1*1", "''"])
                data[place.start():place.end()] = value.encode()
    return bytes(data)


class Files:
    """The readers: how each is reached, and the sound file that its inputs are made of."""

    def __init__(self, gracecg, work, program):
        self.gracecg = gracecg
        self.work = work
        self.program = program
        case = gracecg.Case("front-3")
        text = case.text
        observations = case.simulator().observe(1, 1)
        observations.write(work / "set")
        # Files that are short enough to be read many times a second
        gfc = [line for line in (ROOT / "data/egm96_deg70.gfc").read_bytes().splitlines()
               if not line.startswith(b"gfc") or int(line.split()[1]) <= 6]
        stars = (ROOT / "data/bright_stars.txt").read_bytes().splitlines()[:120]
        self.sound = {
            "case": text.encode(), "setup": (work / "set/setup.nml").read_bytes(),
            "options": (work / "set/options.nml").read_bytes(), "gfc": b"\n".join(gfc) + b"\n",
            "stars": b"\n".join(stars) + b"\n",
            "wind": (ROOT / "data/wind_hwm93_1989-01-02.txt").read_bytes()}
        days = [line.split() for line in (ROOT / "data/space_weather_1989.txt").read_text().splitlines()
                if line and not line.startswith("#")]
        self.sound["weather"] = ("DATE,KP1,KP2,KP3,KP4,KP5,KP6,KP7,KP8,F10.7_OBS,F10.7_OBS_CENTER81\n" + "".join(
            ",".join([day[0], *day[6:14], day[1], day[3]]) + "\n" for day in days)).encode()
        rows = [(n, m) for n in range(1, 4) for m in range(-n, n + 1)]
        self.sound["shc"] = ("# a field of degree 3\n1 3 2 2 1\n1990.0 2000.0\n" + "".join(
            f"{n} {m} {-30000.5 / (7*n + m):.2f} {-29000.5 / (7*n + m):.2f}\n" for n, m in rows)).encode()
        for name in ("accelerometer.csv", "star_camera.csv", "magnetometer.csv"):
            self.sound[name] = (work / "set" / name).read_bytes()
        if program:
            subprocess.run([program, "montecarlo", "--cases", "front-3", "--algorithms", "assest-fde", "--runs", "2",
                            "--runs-out", "runs.csv"], cwd=work, check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
            self.sound["runs"] = (work / "runs.csv").read_bytes()
        self.text = text
        self.names = [name for name in self.sound if name != "runs"]

    def _case_with(self, group, key, value):
        """The case with one key replaced."""
        return re.sub(rf"(&{group}\b.*?\n\s*{key}\s*=\s*)[^\n!]*", lambda found: f"{found.group(1)}{value}  ", self.text,
                      count=1, flags=re.S)

    def try_one(self, name, data):
        """Gives a reader an input. None, or what is wrong with what became of it."""
        g = self.gracecg
        file = self.work / f"input.{name.split('.')[0]}"
        if name.endswith(".csv"):
            file = self.work / "set" / name
        file.write_bytes(data)
        try:
            if name == "case":
                numbers = g.Case.parse(data.decode("latin-1")).state
            elif name == "setup":
                numbers = [len(g.Setup.parse(data.decode("latin-1")).text)]
            elif name == "options":
                numbers = [len(g.Case("front-3").with_options(data.decode("latin-1")).options)]
            elif name == "gfc":
                numbers = g.Gravity(str(file), 4).evaluate([7e6, 1e5, 2e5])[0]
            elif name == "shc":
                numbers = g.Field(str(file), "1995-01-01").evaluate([7e6, 1e5, 2e5])
            elif name == "wind":
                numbers = g.Wind(str(file)).evaluate("1989-01-02", [7e6, 1e5, 2e5])
            elif name == "stars":
                numbers = [len(g.Case.parse(self._case_with("star_camera", "catalogue_file", f"'{file}'")).text)]
                text = self._case_with("star_camera", "catalogue_file", f"'{file}'")
                if text == self.text:
                    raise RuntimeError("the case has no key for a star catalogue")
                g.Case.parse(text).simulator()
            elif name == "weather":
                text = self._case_with("atmosphere", "space_weather_file", f"'{file}'")
                text = re.sub(r"(\n\s*space_weather\s*=\s*)'[^']*'", r"\1'file'", text, count=1)
                numbers = g.Case.parse(text).force_model().accelerations(
                    0.0, [6.8e6, 0, 0], [0, 7.5e3, 0], [0, 0, 0, 1])["total"]
            elif name == "runs":
                return self._merge(file)
            else:
                try:
                    numbers = g.Observations(self.work / "set").accelerometer[1]
                finally:
                    file.write_bytes(self.sound[name])
        except g.GracecgError as error:
            return None if str(error).strip() else "failed without a message"
        except UnicodeEncodeError:
            return None
        if not all(abs(float(x)) < 1e300 for x in _flat(numbers)):
            return f"accepted, and a result is not finite: {numbers}"
        if name in ("gfc", "shc", "stars", "wind"):
            word = _no_number(data, name)
            if word:
                return f"accepted with {word!r} in place of a number"
        return None

    def _merge(self, file):
        path = self.work / "input_runs.csv"
        path.write_bytes(file.read_bytes())
        (self.work / "input_runs.csv.meta.json").write_bytes((self.work / "runs.csv.meta.json").read_bytes())
        ended = subprocess.run([self.program, "merge", path.name, "--out", "merged.csv"], cwd=self.work, timeout=LIMIT,
                               capture_output=True, check=False)
        if ended.returncode not in (0, 1, 2):
            return f"merge ended with {ended.returncode}"
        if ended.returncode == 0 and re.search(rb"nan|inf", (self.work / "merged.csv").read_bytes(), re.I):
            return "merge wrote what is not finite"
        return "merge failed without a message" if ended.returncode and not ended.stderr.strip() else None


def _flat(numbers):
    for item in numbers:
        if hasattr(item, "__iter__"):
            yield from _flat(item)
        else:
            yield item


def _no_number(data, name):
    """A word of NO_NUMBERS where a row of numbers is: it must have been refused."""
    for line in data.decode("latin-1").splitlines():
        words = line.split("#")[0].split()
        if name == "gfc" and (not words or words[0] != "gfc"):
            continue
        if name == "stars" and len(words) > 8:
            words = words[:7] + words[8:]       # the eighth column is a text
        for word in words[1:]:
            if word in NO_NUMBERS:
                return word
    return None


# ---------------------------------------------------------------- C entries


class Entries:
    """The functions of the header, called with what a confused caller may hand over."""

    def __init__(self, gracecg, work):
        from gracecg import _library

        self.ffi, self.lib = _library.ffi, _library.lib
        self.g = gracecg
        self.work = work
        self.names = sorted(name for name in dir(self.lib) if name.startswith("gracecg_"))
        self.buffers = {}
        self.made = {}
        self.texts = [self.ffi.new("char[]", text) for text in
                      (b"", b"egm96", b"front-3", b"optimal", b"assest-fde", b"igrf14", b"1989-01-02", b"knocke", b"\xff\xfe",
                       b"x" * 5000, b"&a /", os.fsencode(work / "set"), os.fsencode(work / "set/setup.nml"),
                       b"/no/such/file", b"dtm77", b"hwm93", b"offset", b"items", b"state", b"text", b"options", b"test_rms")]
        self.texts.append(self.ffi.new("char[]", gracecg.Case("front-3").text.encode()))
        make = gracecg
        case = make.Case("front-3")
        simulator = case.simulator()
        observations = simulator.observe(1, 1)
        self.keep = {"object": observations, "case": case, "simulator": simulator, "observations": observations, "setup": observations.setup,
                     "fit": observations.fit("sequential"), "gravity": make.Gravity("egm96", 4),
                     "field": make.Field("igrf14", "1989-01-02"), "density": make.Density("dtm77", "1989-01-02"), "wind": make.Wind(),
                     "earth_radiation": make.EarthRadiation(), "force_model": case.force_model(),
                     "live": make.LiveEstimate(observations.setup, [0, 0, 0, 1], [0, 0, 0])}
        gone = make.Case("front-1")
        self.freed = int(self.ffi.cast("intptr_t", gone._handle))
        del gone

    def _handle(self, kind, rng):
        choice = rng.randrange(8)
        if choice == 0:
            number = 0
        elif choice == 1:
            number = rng.choice([self.freed, 1, -1, 2**62, 12345678])
        elif choice == 2 or kind not in self.keep:
            number = int(self.ffi.cast("intptr_t", rng.choice(list(self.keep.values()))._handle))
        else:
            number = int(self.ffi.cast("intptr_t", self.keep[kind]._handle))
        return number

    def _doubles(self, place, rng):
        buffer = self.buffers.setdefault(("double", place), self.ffi.new("double[]", ROOM))
        kind = rng.randrange(6)
        pool = [float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 0.0, 1e-320, -1.0]
        for i in range(64):
            if kind < 2:
                buffer[i] = rng.choice([7e6, 1e5, -6.9e6, 7.5e3, 1.0, 0.5])
            elif kind == 2:
                buffer[i] = float(i)
            elif kind == 3:
                buffer[i] = 0.0
            else:
                buffer[i] = rng.choice(pool) if rng.randrange(3) == 0 else 7e6
        return buffer

    def call(self, name, rng, null=None):
        """Calls a function with random arguments; null: the pointers with these places are NULL and the rest is sound."""
        function = getattr(self.lib, name)
        kind = self.ffi.typeof(function)
        arguments, outputs, keep = [], [], []
        error = None
        for place, argument in enumerate(kind.args):
            sound = null is not None
            cname = argument.cname
            if argument.kind == "pointer":
                if (place in null) if sound else rng.randrange(5) == 0:
                    arguments.append(self.ffi.NULL)
                    continue
                target = argument.item
                if target.kind == "pointer" and target.item.kind == "struct":       # a new or a freed handle
                    address = self.ffi.new("intptr_t[4]", [0, 0, 0, 0])
                    if name == "gracecg_free":
                        address[0] = rng.choice([0, self.freed, 99, -5])
                    elif name == "gracecg_estimate_joint" and place == 1:
                        for i in range(4):
                            address[i] = self._handle("observations", rng)
                    keep.append(address)
                    arguments.append(self.ffi.cast(cname, address))
                    outputs.append(("handle", place, address))
                elif target.kind == "struct" and not _fields(target):
                    which = self._kind_of(name)
                    number = int(self.ffi.cast("intptr_t", self.keep[which]._handle)) if sound else self._handle(which, rng)
                    arguments.append(self.ffi.cast(cname, self.ffi.cast("intptr_t", number)))
                elif target.cname == "double":
                    buffer = self._doubles(place, rng)
                    arguments.append(buffer)
                    outputs.append(("double", "", buffer))
                elif target.cname == "char":
                    if cname.startswith("char const") or "const" in cname or self._is_input(name, place):
                        arguments.append(rng.choice(self.texts))
                    else:
                        arguments.append(self.buffers.setdefault("text", self.ffi.new("char[]", 1 << 17)))
                elif target.cname == "gracecg_error":
                    error = self.ffi.new("gracecg_error *")
                    arguments.append(error)
                elif target.kind == "struct":
                    structure = self.ffi.new(f"{target.cname}[64]")
                    self._fill(structure[0], rng, sound)
                    keep.append(structure)
                    arguments.append(structure)
                else:
                    buffer = self.ffi.new(f"{target.cname}[]", ROOM)
                    buffer[0] = rng.choice([0, 1, 2, 3])
                    keep.append(buffer)
                    arguments.append(buffer)
            elif argument.kind == "enum":
                arguments.append(rng.choice([0, 3, 7, 99]))
            elif cname == "double":
                arguments.append(rng.choice([0.0, 1.0, 0.1, 60.0, -1.0, 1e308, float("nan"), float("inf"), 1e-300]))
            elif cname in ("unsigned long", "size_t", "unsigned long long"):
                arguments.append(rng.choice([0, 1, 2, 3, 2**40, 2**63, 2**64 - 1]))
            else:
                arguments.append(rng.choice([0, 1, 2, 3, -1, -2**31, 2**31 - 1, 20]))
        if name in SLOW and null is None and rng.randrange(10):
            return None
        if name == "gracecg_design" and null is None:
            arguments[0] = self.ffi.NULL
        if name == "gracecg_observations_write":
            for place, argument in enumerate(kind.args):
                if argument.item.cname == "char" and arguments[place] != self.ffi.NULL:
                    arguments[place] = self.ffi.new("char[]", os.fsencode(self.work / "written"))
        before = {id(buffer): list(buffer[0:64]) for what, _, buffer in outputs if what == "double"}
        result = function(*arguments)
        if kind.result.kind != "enum":
            return None
        status = int(result)
        if not 0 <= status <= 7:
            return f"status {status}"
        if error is not None:
            message = self.ffi.string(error.message)
            if (status != 0) != bool(message.strip()) or error.status != status:
                return f"status {status}, in the structure {error.status}, message {message!r}"
        if status == 0:
            for what, _, buffer in outputs:
                if what == "double" and any(x != old and not abs(x) < float("inf") for x, old in
                                            zip(buffer[0:64], before[id(buffer)]) if old == old):
                    return "a result is NaN or infinite"
        for what, place, address in outputs:
            if what == "handle" and name != "gracecg_free" and (name, place) != ("gracecg_estimate_joint", 1) and address[0]:
                if status not in (0, 6):
                    return f"status {status}, and a handle all the same"
                self.lib.gracecg_free(self.ffi.cast("gracecg_object **", address), self.ffi.NULL)
        return None

    def _kind_of(self, name):
        """What kind of object a function works on."""
        makers = {"force_model_open": "case", "simulator_open": "case", "case_bound": "case", "design": "case", "map": "case",
                  "simulate": "simulator", "observations_create": "setup", "live_begin": "setup", "estimate": "observations",
                  "estimate_chain": "observations"}
        word = name.replace("gracecg_", "")
        return makers.get(word) or next((kind for kind in self.keep if word.startswith(kind)), "object")

    @staticmethod
    def _is_input(name, place):
        return not (name == "gracecg_get_text" and place == 2)

    def _fill(self, structure, rng, sound):
        for name, item in _fields(self.ffi.typeof(structure)):
            value = rng.choice([0, 1, 2, 3])
            if item.type.kind == "primitive" and item.type.cname == "double":
                value = rng.choice([0.0, 1.0, 60.0, 43200.0] if sound else
                                   [0.0, 1.0, 60.0, -1.0, float("nan"), float("inf"), 1e308, 86400.5])
            elif item.type.kind == "primitive" and item.type.cname in ("int", "int32_t"):
                value = rng.choice([47528, 50000] if name == "mjd" else [0, 1, 2, 3, -1, 2**31 - 1])
            elif item.type.kind != "primitive":
                continue
            setattr(structure, name, value)


def _fields(kind):
    try:
        return kind.fields or []
    except AttributeError:
        return []


# ---------------------------------------------------------------- the process that works


def plan(entries, files):
    """The systematic part: every entry with every pointer NULL, one by one and together."""
    steps = []
    for name in entries.names:
        arguments = entries.ffi.typeof(getattr(entries.lib, name)).args
        pointers = [place for place, argument in enumerate(arguments) if argument.kind == "pointer"]
        if name in ("gracecg_design", "gracecg_map"):               # one NULL leaves seconds of work
            pointers = [place for place in pointers if place < 3]
        steps += [(name, {place}) for place in pointers]
        if pointers:
            steps.append((name, {place for place, argument in enumerate(arguments) if argument.kind == "pointer"}))
    return steps


def work(options):
    import gracecg

    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder)
        files = Files(gracecg, path, options.program)
        entries = Entries(gracecg, path)
        steps = plan(entries, files)
        for number in range(options.start, options.executions):
            if options.only is not None and number != options.only:
                continue
            rng = random.Random(f"{options.seed} {number}")
            if number < len(steps):
                name, null = steps[number]
                what = f"{name} NULL {sorted(null)}"
                print(f"> {number} {what}", flush=True)
                problem = entries.call(name, rng, null)
            elif number % 2 == 0:
                name = rng.choice(entries.names)
                print(f"> {number} {name}", flush=True)
                problem = entries.call(name, rng)
            else:
                name = rng.choice(files.names)
                if options.program and number % 100 == 1:
                    name = "runs"
                data = mutate(files.sound[name], rng)
                if options.keep:
                    (options.keep / "current").write_bytes(data)
                print(f"> {number} {name}", flush=True)
                problem = files.try_one(name, data)
                if problem and options.keep:
                    (options.keep / f"{number}.{name}").write_bytes(data)
            if problem:
                print(f"! {problem}", flush=True)
    print("= done", flush=True)


def watch(options):
    """Starts processes that work until all is done; counts what they did and found."""
    options.keep.mkdir(parents=True, exist_ok=True)
    start, findings, done, begin = 0, [], 0, time.time()
    while True:
        command = [sys.executable, __file__, "--worker", "--start", str(start), "--executions", str(options.executions),
                   "--seed", str(options.seed), "--keep", str(options.keep)]
        command += ["--program", options.program] if options.program else []
        command += ["--only", str(options.only)] if options.only is not None else []
        child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
        state = {"last": time.time() + 60, "what": "", "number": start, "ended": False, "killed": False}

        def guard():
            while not state["ended"]:
                time.sleep(0.5)
                if time.time() - state["last"] > LIMIT:
                    state["killed"] = True
                    child.kill()
                    return

        guardian = threading.Thread(target=guard, daemon=True)
        guardian.start()
        complete = False
        for line in child.stdout:
            state["last"] = time.time()
            if line.startswith("> "):
                _, number, what = line.split(" ", 2)
                state["number"], state["what"] = int(number), what.strip()
                done += 1
            elif line.startswith("! "):
                findings.append(f"{state['number']} {state['what']}: {line[2:].strip()}")
            elif line.startswith("= done"):
                complete = True
        child.wait()
        state["ended"] = True
        if complete:
            break
        reason = f"more than {LIMIT:g} s" if state["killed"] else f"ended with {child.returncode}"
        findings.append(f"{state['number']} {state['what']}: {reason}")
        if not state["what"] or len(findings) > 200:
            break
        current = options.keep / "current"
        if current.exists() and not state["what"].startswith("gracecg_"):
            current.rename(options.keep / f"{state['number']}.{state['what']}")
        start = state["number"] + 1
    for finding in findings:
        print(finding)
    print(f"{done} executions of seed {options.seed}, {len(findings)} findings, {time.time() - begin:.0f} s")
    return 1 if findings else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--executions", type=int, default=2000)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--program", help="of gracecg, for the readers that only it has")
    parser.add_argument("--keep", type=pathlib.Path, default=ROOT / "build/fuzz", help="folder of inputs with findings")
    parser.add_argument("--only", type=int)
    parser.add_argument("--start", type=int, default=0, help=argparse.SUPPRESS)
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    options.keep = options.keep.resolve()
    if options.program:
        options.program = str(pathlib.Path(options.program).resolve())
    if options.worker:
        return work(options)
    return watch(options)


if __name__ == "__main__":
    sys.exit(main())
