#!/usr/bin/env python3
"""The same work by gracecg and by other programs, in turn, in one run: seconds and ratios.

    bench/peers.py [--rounds N] [--markdown]

Needs fpm, and for each peer what it needs: pip and a network (brahe, Basilisk, Orekit, ppigrf, pymsis go into a virtual
environment below build/peers), java and javac (Orekit), g++, apt-get and dpkg (GeographicLib's Debian packages are
unpacked below build/peers, not installed). A peer that cannot be had is named with the reason, and the rest is run.

All have the coefficients of data/egm96_deg70.gfc and the same places. Before a time counts, the answers are compared
with gracecg's. A round runs every program once (each gives the best of its own repeats); the ratio is the median of
the rounds' ratios, so that a machine that others use hardly enters it. What is not alike stands in the last column.

brahe and Basilisk are called from Python a place at a time: of their times that of degree 2, which is all but the call,
is taken off. With 13 equations Basilisk steps by itself, and its time of a stage is what its step of four stages takes
longer than its step of one. Of all forces only gravity is the same in both programs and is compared; of the others the
mean sizes along an orbit are printed, relative to gracecg's.
"""
import argparse
import datetime
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
HERE = ROOT / "bench" / "peers"
WORK = ROOT / "build" / "peers"
GFC = ROOT / "data" / "egm96_deg70.gfc"
PACKAGES = {"brahe": "brahe", "Basilisk": "bsk", "Orekit": "orekit-jpype", "ppigrf": "ppigrf", "pymsis": "pymsis"}
DEBIAN = ("libgeographiclib-dev", "libgeographiclib23")
ORBIT_ACCURACY = 2e-4       # m after a day
SHOWN = 5                   # places whose values are compared


class Missing(Exception):
    """A peer that cannot be had, and why."""


def run(command, **options):
    """Standard output of a command; Missing with the end of its messages when it fails."""
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    except OSError as failure:
        raise Missing(f"{command[0]}: {failure.strerror}") from failure
    if done.returncode != 0:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise Missing(f"{pathlib.Path(str(command[0])).name}: {said[-1] if said else done.returncode}")
    return done.stdout


def python_of_peers():
    """The interpreter of the virtual environment."""
    python = WORK / "venv" / "bin" / "python"
    if not python.exists():
        run([sys.executable, "-m", "venv", WORK / "venv"])
    return python


def install(package):
    """A package of PyPI, into the virtual environment; its version."""
    python = python_of_peers()
    query = [python, "-c", f"import importlib.metadata as m; print(m.version({package!r}))"]
    try:
        return run(query).strip()
    except Missing:
        run([python, "-m", "pip", "install", "--quiet", package])
        return run(query).strip()


def parsed(text):
    """What a program printed: seconds, values at the first places, sizes of forces, runs of the orbit."""
    found = {"values": [], "sizes": {}, "runs": []}
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["seconds"]:
            found["seconds"] = float(words[1])
        elif words[:1] == ["value"]:
            found["values"].append([float(word) for word in words[1:]])
        elif words[:1] == ["size"]:
            found["sizes"][words[1]] = float(words[2])
        elif words[:1] == ["run"]:
            found["runs"].append([float(word) for word in words[1:]])
    return found


class Gracecg:
    """bench/peers/gracecg_peer.f90, linked to the library of the release build as its users link it."""

    name = "gracecg"

    def __init__(self):
        fpm = shutil.which(os.environ.get("FPM", "fpm"))
        if fpm is None:
            raise Missing("fpm is not on the PATH; set FPM")
        folder = WORK / "gracecg"
        folder.mkdir(parents=True, exist_ok=True)
        run([fpm, "install", "--profile", "release", "--prefix", folder], cwd=ROOT)
        blas = run(["pkg-config", "--libs", "openblas"]).split()
        self.program = folder / "peer"
        run(["gfortran", "-O3", "-funroll-loops", "-fopenmp", "-I", folder / "include", HERE / "gracecg_peer.f90", "-J", folder,
             "-o", self.program, folder / "lib" / "libgracecg.a", *blas])
        self.version = next(line.split('"')[1] for line in (ROOT / "fpm.toml").read_text().splitlines()
                            if line.startswith("version"))

    def __call__(self, *task):
        return parsed(run([self.program, *task]))


# The peers. Each has `name`, `version` and `unlike`: what it does, and what is not alike there.

class GeographicLib:
    """SphericalHarmonic of GeographicLib, from Debian's packages."""

    name = "GeographicLib"
    unlike = {"gravity": "C++ with -O2"}

    def __init__(self):
        folder = WORK / "debian"
        folder.mkdir(exist_ok=True)
        if not list(folder.glob("*.deb")):
            run(["apt-get", "download", *DEBIAN], cwd=folder)
            for package in folder.glob("*.deb"):
                run(["dpkg", "-x", package, folder])
        self.version = next(folder.glob("libgeographiclib-dev*.deb")).name.split("_")[1]
        library = next(folder.glob("usr/lib/*/libGeographicLib.so"))
        self.program = WORK / "geographiclib_peer"
        run(["g++", "-O2", "-I", folder / "usr/include", "-o", self.program, HERE / "geographiclib_peer.cpp", library,
             f"-Wl,-rpath,{library.parent}"])

    def __call__(self, task, degree):
        return parsed(run([self.program, GFC, degree]))


class Orekit:
    """Orekit's classes, from the jars of orekit-jpype."""

    name = "Orekit"
    unlike = {"gravity": "Java, warmed up",
              "forces": "Java, warmed up; DTM-2000 against DTM-77, a sphere against plates; Knocke's model by 205 elements, 35 of "
                        "them in view, 1.6 % off its integral, against 19 segments, 0.5 % off; answers: gravity",
              "forces-dark": "Java, warmed up; DTM-2000 against DTM-77, a sphere against plates; answers: gravity",
              "orbit": "Java, warmed up; DOP853 against RKF7(8)"}

    def __init__(self):
        self.version = install(PACKAGES["Orekit"])
        jars = list((WORK / "venv").glob("lib/python*/site-packages/orekit_jpype/jars/*.jar"))
        data = WORK / "orekit-data"
        data.mkdir(exist_ok=True)
        shutil.copy(GFC, data / "peer.gfc")
        classes = ":".join(str(path) for path in [*jars, WORK])
        run(["javac", "-cp", classes, "-d", WORK, HERE / "OrekitPeer.java"])
        self.command = ["java", "-cp", classes, "OrekitPeer", data]

    def __call__(self, *task):
        return parsed(run([*self.command, *task]))


class FromPython:
    """A package called from Python: `code` has the arguments TASK, GFC, DEGREE and prints as the programs do."""

    def __init__(self):
        self.version = install(PACKAGES[self.name])

    def __call__(self, *task):
        return parsed(run([python_of_peers(), "-c", PLACES + self.code, GFC, *task]))


PLACES = """
import sys, timeit
import numpy as np
def place(i):
    a = 2*np.pi*((i*0.618034) % 1.0)
    b = 2*np.pi*((i*0.381966*0.5) % 0.5 - 0.25)*0.98
    return 6.838e6*np.array([np.cos(b)*np.cos(a), np.cos(b)*np.sin(a), np.sin(b)])
P = [place(i) for i in range(1, 1001)]
def timed(work, number=1):
    return min(timeit.repeat(work, number=number, repeat=5))/number/1000
def show(seconds, values):
    print('seconds', seconds)
    for v in values: print('value', *(f'{x:.16e}' for x in v))
"""


class Brahe(FromPython):
    """Its acceleration of harmonics by Clenshaw's sums."""

    name = "brahe"
    unlike = {"gravity": "called from Python, less the call of degree 2"}
    code = """
import brahe
model, eye, n = brahe.GravityModel.from_file(sys.argv[1]), np.eye(3), int(sys.argv[3])
f = brahe.accel_gravity_spherical_harmonics
t = [timed(lambda: [f(p, eye, model, k, k) for p in P]) for k in (2, n)]
show(t[1] - t[0], [f(p, eye, model, n, n) for p in P[:5]])
"""


class Basilisk(FromPython):
    """Its SphericalHarmonicsGravityModel, alone and in a Spacecraft."""

    name = "Basilisk"
    unlike = {"gravity": "called from Python, less the call of degree 2",
              "equations": "modified Rodrigues parameters against a quaternion, 18 equations; less the time between steps, which "
                           "gracecg's has"}
    code = """
from Basilisk.architecture import messaging
from Basilisk.simulation import gravityEffector, spacecraft, svIntegrators, sphericalHarmonicsGravityModel
from Basilisk.utilities import SimulationBaseClass, macros
n = int(sys.argv[3]) if sys.argv[3:] else 20
C, S = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
for line in open(sys.argv[1]):
    w = line.split()
    if w[:1] == ['earth_gravity_constant']: gm = float(w[1])
    if w[:1] == ['radius']: radius = float(w[1])
    if w[:1] == ['gfc'] and int(w[1]) <= n: C[int(w[1]), int(w[2])], S[int(w[1]), int(w[2])] = float(w[3]), float(w[4])
def model(k):
    g = sphericalHarmonicsGravityModel.SphericalHarmonicsGravityModel()
    g.maxDeg, g.muBody, g.radEquator = k, gm, radius
    g.cBar = [[float(C[i, j]) for j in range(i + 1)] for i in range(k + 1)]
    g.sBar = [[float(S[i, j]) for j in range(i + 1)] for i in range(k + 1)]
    return g
def gravity():
    Q = [[[float(x)] for x in p] for p in P]
    two, full = model(2), model(n)
    assert not two.initializeParameters() and not full.initializeParameters()
    t = [timed(lambda: [g.computeField(q) for q in Q]) for g in (two, full)]
    show(t[1] - t[0], [[row[0] for row in full.computeField(q)] for q in Q[:5]])
def flight(integrator):
    sim = SimulationBaseClass.SimBaseClass()
    sim.CreateNewProcess('process').addTask(sim.CreateNewTask('task', macros.sec2nano(1)))
    craft = spacecraft.Spacecraft()
    sim.AddModelToTask('task', craft)
    earth = gravityEffector.GravBodyData()
    earth.planetName, earth.isCentralBody, earth.mu, earth.radEquator, earth.gravityModel = 'earth', True, gm, radius, model(n)
    a = np.radians(101.60748558)
    at_rest = messaging.SpicePlanetStateMsgPayload(PlanetName='earth', computeOrient=1, J20002Pfix=[
        [np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])
    message = messaging.SpicePlanetStateMsg().write(at_rest)
    earth.planetBodyInMsg.subscribeTo(message)
    craft.gravField.gravBodies = spacecraft.GravBodyVector([earth])
    stepper = integrator(craft)
    craft.setIntegrator(stepper)
    craft.hub.mHub, craft.hub.IHubPntBc_B = 420.0, [[70., 3., 3.], [3., 345., 0.3], [3., 0.3, 389.]]
    craft.hub.r_CN_NInit, craft.hub.v_CN_NInit = [[6.838e6], [0.], [0.]], [[0.], [120.], [7634.]]
    craft.hub.sigma_BNInit, craft.hub.omega_BN_BInit = [[0.1], [0.2], [-0.3]], [[0.001], [0.0011], [-0.002]]
    sim.InitializeSimulation()
    def to(second):
        sim.ConfigureStopTime(macros.sec2nano(second))
        sim.ExecuteSimulation()
    to(1000)
    state = craft.scStateOutMsg.read()
    s = np.array(state.sigma_BN)
    tilde = np.array([[0, -s[2], s[1]], [s[2], 0, -s[0]], [-s[1], s[0], 0]])
    axes = np.eye(3) + (8*tilde@tilde - 4*(1 - s@s)*tilde)/(1 + s@s)**2
    values = [np.array(v) for v in (state.r_BN_N, state.v_BN_N, state.omega_BN_B, axes[0], axes[1])]
    ends = iter(range(6000, 31000, 5000))
    return timed(lambda: to(next(ends)))/5, values      # a step: 5000 of them stand for 1000 places
def equations():
    four, values = flight(svIntegrators.svIntegratorRK4)
    one, _ = flight(svIntegrators.svIntegratorEuler)
    show((four - one)/3, values)
{'gravity': gravity, 'equations': equations}[sys.argv[2]]()
"""


class Ppigrf(FromPython):
    """IGRF-14 in numpy, all places in one call."""

    name = "ppigrf"
    unlike = {"field": "numpy, 1000 places a call"}
    code = """
import datetime, ppigrf
p = np.array(P); r = np.linalg.norm(p, axis=1)
theta, phi = np.arccos(p[:, 2]/r), np.arctan2(p[:, 1], p[:, 0])
f = lambda: ppigrf.igrf_gc(r/1e3, np.degrees(theta), np.degrees(phi), datetime.datetime(2020, 1, 1))
br, bt, bp = [np.ravel(b)*1e-9 for b in f()]
x = np.sin(theta)*br + np.cos(theta)*bt
show(timed(f), np.array([x*np.cos(phi) - bp*np.sin(phi), x*np.sin(phi) + bp*np.cos(phi),
                         np.cos(theta)*br - np.sin(theta)*bt]).T[:5])
"""


class Pymsis(FromPython):
    """NRLMSIS in Fortran behind Python, all places in one call."""

    name = "pymsis"
    unlike = {"density": "another model (NRLMSIS 2.1 against DTM-77, both at 450 km): answers cannot be compared"}
    code = """
import pymsis
lon = np.degrees(np.arctan2([p[1] for p in P], [p[0] for p in P]))
lat = np.degrees(np.arcsin([p[2]/6.838e6 for p in P]))
when = np.array(['2003-03-21T12:00']*1000, dtype='datetime64[m]')
f = lambda: pymsis.calculate(when, lon, lat, np.full(1000, 450.0), np.full(1000, 150.0), np.full(1000, 150.0),
                             np.full((1000, 7), 7.0))
show(timed(f), np.repeat(np.array(f())[:5, :1], 3, 1))
"""


PEERS = (GeographicLib, Orekit, Brahe, Basilisk, Ppigrf, Pymsis)

#: task, what it is, unit of a time and seconds in it, largest relative difference of answers; None: not compared
WORK_ITEMS = (
    (("gravity", "20"), "gravity 20x20, acceleration", "us", 1e-6, 1e-12),
    (("gravity", "70"), "gravity 70x70, acceleration", "us", 1e-6, 1e-12),
    (("orbit",), "a day of orbit, gravity 20x20, to 0.2 mm", "ms", 1e-3, 1e-9),
    (("field",), "IGRF-14", "us", 1e-6, 1e-6),
    (("density",), "density of the air", "us", 1e-6, None),
    (("equations",), "13 equations, gravity 20x20 alone, a stage", "us", 1e-6, 1e-11),
    (("forces",), "all forces, acceleration", "us", 1e-6, 1e-12),
    (("forces-dark",), "all forces without the Earth's light", "us", 1e-6, 1e-12),
    (("derivative",), "all forces and torques, 13 equations", "us", 1e-6, None),
)


def cheapest(found):
    """Of the runs of an orbit the cheapest that ends within ORBIT_ACCURACY of the reference, the first one."""
    reference = found["runs"][0][2:]
    met = [(line[1], math.dist(line[2:], reference)) for line in found["runs"][1:]
           if math.dist(line[2:], reference) <= ORBIT_ACCURACY]
    if not met:
        raise Missing(f"no tolerance reached {ORBIT_ACCURACY} m")
    found["seconds"], found["accuracy"] = min(met)
    found["values"] = [reference]
    return found


def measured(program, task):
    """A run of a program, with the seconds that count."""
    found = program(*task)
    return cheapest(found) if found["runs"] else found


def difference(ours, theirs):
    """The largest difference of answers, relative to their size."""
    return max(math.dist(a, b) / math.hypot(*a) for a, b in zip(ours["values"][:SHOWN], theirs["values"][:SHOWN]))


def compare(gracecg, peers, item, rounds):
    """Rows of the table for one piece of work."""
    task, title, unit, seconds_in, tolerance = item
    takers = [peer for peer in peers if task[0] in peer.unlike]
    times, agreed, accuracy, sizes = {peer.name: [] for peer in [gracecg, *takers]}, {}, {}, {}
    for _ in range(rounds):
        ours = measured(gracecg, task)
        times[gracecg.name].append(ours["seconds"])
        for peer in takers:
            theirs = measured(peer, task)
            if tolerance is not None:
                agreed[peer.name] = difference(ours, theirs)
                if not agreed[peer.name] <= tolerance:
                    raise SystemExit(f"{title}: {peer.name} differs by {agreed[peer.name]:.1e} from gracecg, more than "
                                     f"{tolerance:.0e}: this is not the same work")
            times[peer.name].append(theirs["seconds"])
            sizes[peer.name] = ", ".join(f"{force} {theirs['sizes'][force] / size:.2f}" for force, size in ours["sizes"].items())
            if "accuracy" in theirs:
                accuracy[peer.name], accuracy[gracecg.name] = theirs["accuracy"], ours["accuracy"]
    rows = []
    for peer in [gracecg, *takers]:
        ratio = statistics.median(b / a for a, b in zip(times[gracecg.name], times[peer.name]))
        note = "" if peer is gracecg else peer.unlike[task[0]]
        if peer.name in accuracy:
            note = "; ".join(filter(None, [note, f"{accuracy[peer.name] * 1e3:.2f} mm from its tightest run"]))
        if sizes.get(peer.name):
            note += f"; mean sizes relative to gracecg's: {sizes[peer.name]}"
        rows.append({"work": title, "program": f"{peer.name} {peer.version}", "time": min(times[peer.name]) / seconds_in,
                     "unit": unit, "ratio": ratio, "difference": agreed.get(peer.name), "note": note})
    return rows


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3, help="of every program in turn (default 3)")
    parser.add_argument("--markdown", action="store_true", help="the table as for docs/validation.md")
    parser.add_argument("--json", action="store_true", help="the table as JSON")
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    try:
        gracecg = Gracecg()
    except Missing as reason:
        raise SystemExit(f"gracecg: {reason}") from None
    peers, absent = [], []
    for kind in PEERS:
        try:
            peer = kind()
            for task in peer.unlike:             # whether it runs at all
                measured(peer, next(item[0] for item in WORK_ITEMS if item[0][0] == task))
            peers.append(peer)
        except Missing as reason:
            absent.append(f"{kind.name}: {reason}")
    rows = [row for item in WORK_ITEMS for row in compare(gracecg, peers, item, arguments.rounds)]
    if arguments.json:
        print(json.dumps({"date": str(datetime.date.today()), "rows": rows, "absent": absent}, indent=2))
        return
    if arguments.markdown:
        print("| work | program | time | ratio | answers differ by | not alike |\n|---|---|---|---|---|---|")
    for row in rows:
        agreed = "" if row["difference"] is None else f"{row['difference']:.0e}"
        fields = [row["work"], row["program"], f"{row['time']:.3g} {row['unit']}", f"{row['ratio']:.2f}", agreed, row["note"]]
        print("| " + " | ".join(fields) + " |" if arguments.markdown else
              f"{fields[0]:44}{fields[1]:24}{fields[2]:>12}{fields[3]:>8}  {fields[4]:7}{fields[5]}")
    print(f"\n{datetime.date.today()}, {arguments.rounds} rounds, {run(['gfortran', '--version']).splitlines()[0]}")
    for line in absent:
        print(f"could not be had: {line}")


if __name__ == "__main__":
    main()
