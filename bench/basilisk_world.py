#!/usr/bin/env python3
"""Calibrations that another program flies: truth by Basilisk (PyPI: bsk), estimate by gracecg.

    bench/basilisk_world.py GRACECG [--seeds 5] [--cases front-3,designed]

Basilisk integrates orbit and attitude with its own gravity (spherical harmonics), magnetic field (its code of the World
Magnetic Model), magnetic torque bars, drag, and gravity-gradient torque. It shares no code with gracecg; only the
coefficients of EGM96 and IGRF, the initial state and what an operator knows (setup.nml) come from here. Its
accelerometer lacks the gravity gradient, which this script adds (central term; the rest is below 1e-12 m/s^2), and
the noise of the setup. For every seed new noise, bias, scale factors, gain of the rods and bias of the magnetometer
are drawn from what the setup states. Prints a table; status 1 where an error is beyond 3 sigma.

Needs numpy and bsk. `designed` is what `gracecg design front-3 --waveforms sine` finds.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
from Basilisk.architecture import messaging, sysModel
from Basilisk.simulation import (GravityGradientEffector, MtbEffector, dragDynamicEffector, exponentialAtmosphere, extForceTorque,
                                 gravityEffector, magneticFieldWMM, spacecraft)
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"
STEP = 0.01                 # s: of Basilisk's integration (RK4); moments and field are held for so long
GRAVITY_DEGREE = 20
EARTH_RATE = 7.2921158553e-5            # rad/s
OFFSET = np.array([0.3e-3, 0.4e-3, -0.5e-3])    # m, centre of mass to proof mass: of all cases of the report
UNMODELLED = [1e-6, -2e-6, 1.5e-6]      # N m: a torque that the estimators take for an unknown constant
AREA, DRAG_COEFFICIENT, ARM = 1.0, 2.2, [0.0, 0.005, -0.005]    # m^2, 1, m: of the drag, and where it acts
DENSITY, HEIGHT, SCALE_HEIGHT = 4e-12, 466e3, 65e3      # kg/m^3, m, m


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def numbers(text, key, group=""):
    """The numbers of a key of a namelist, of the first such group."""
    at = text.index(f"&{group}") if group else 0
    line = re.compile(rf"^ *{key} = ([^!\n]*)", re.M).search(text, at).group(1)
    return np.array([float(word) for word in line.split(",")])


def rods_of(setup):
    """Axis, amplitude, frequency, phase, start and stop of each rod; sines."""
    rods = []
    for group in re.findall(r"^&rod\n(.*?)^/", setup, re.M | re.S):
        if "waveform = 'sine'" not in group:
            raise SystemExit("the manoeuvre has other waveforms than sines")
        rods.append([numbers(group, key)[0] for key in ("axis", "amplitude", "frequency", "phase_deg", "start", "stop")])
    return rods


def moments(rods, t):
    """Magnetic moments, A m^2, body axes."""
    m = np.zeros(3)
    for axis, amplitude, frequency, phase, start, stop in rods:
        if start <= t <= stop:
            m[int(axis) - 1] += amplitude*np.sin(2*np.pi*frequency*(t - start) + np.radians(phase))
    return m


def write_gravity(path):
    """EGM96 as Basilisk reads coefficients."""
    lines = (DATA / "egm96_deg70.gfc").read_text().splitlines()
    rows = [line.split() for line in lines if line.startswith("gfc")]
    mu, radius = (float(next(line for line in lines if line.startswith(key)).split()[1])
                  for key in ("earth_gravity_constant", "radius"))
    with open(path, "w", encoding="ascii") as file:
        file.write(f"{radius},{mu},0,{GRAVITY_DEGREE},{GRAVITY_DEGREE},1,0,0\n")
        for row in rows:
            if int(row[1]) <= GRAVITY_DEGREE:
                file.write(",".join([row[1], row[2], row[3], row[4], "0", "0"]) + "\n")
    return mu, radius


def write_field(path, year):
    """The IGRF of a year in the form of the World Magnetic Model, degree 12: beyond 10 it was 0 then."""
    lines = [line.split() for line in (DATA / "igrf_1900_2030.txt").read_text().splitlines()]
    epochs = next([float(word) for word in line[2:] if word[0].isdigit()] for line in lines if line[:2] == ["#", "epochs"])
    value = {(line[0], int(line[1]), int(line[2])): np.interp(year, epochs, [float(x) for x in line[3:3 + len(epochs)]])
             for line in lines if line and line[0] in "gh"}
    with open(path, "w", encoding="ascii") as file:
        file.write(f"    {year:.1f}            IGRF                 01/01/{int(year)}\n")
        for n in range(1, 13):
            for m in range(n + 1):
                file.write(f"{n:3d}{m:3d}{value.get(('g', n, m), 0.0):10.2f}{value.get(('h', n, m), 0.0):10.2f}"
                           f"{0.0:11.1f}{0.0:11.1f}\n")
        file.write("9"*48 + "\n")


class Earth(sysModel.SysModel):
    """The Earth's rotation: Earth-fixed axes turn about z."""

    def __init__(self, angle):
        super().__init__()
        self.angle = angle
        self.message = messaging.SpicePlanetStateMsg()

    def Reset(self, now):
        self.UpdateState(now)

    def UpdateState(self, now):
        angle = self.angle + EARTH_RATE*now*macros.NANO2SEC
        c, s = np.cos(angle), np.sin(angle)
        payload = messaging.SpicePlanetStateMsgPayload()
        payload.PlanetName = "earth"
        payload.J20002Pfix = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        payload.J20002Pfix_dot = (EARTH_RATE*np.array([[-s, c, 0], [-c, -s, 0], [0, 0, 0]])).tolist()
        payload.computeOrient = 1
        self.message.write(payload, now, self.moduleID)


class Rods(sysModel.SysModel):
    """Commands of the torque rods, of the middle of each step: Basilisk's spacecraft then goes from the step before to `now`."""

    def __init__(self, rods):
        super().__init__()
        self.rods = rods
        self.message = messaging.MTBCmdMsg()

    def Reset(self, now):
        self.UpdateState(now)

    def UpdateState(self, now):
        payload = messaging.MTBCmdMsgPayload()
        payload.mtbDipoleCmds = moments(self.rods, now*macros.NANO2SEC - STEP/2).tolist() + [0.0]*33
        self.message.write(payload, now, self.moduleID)


def fly(setup, start, gain, folder):
    """The arc: times, positions, DCMs to body axes, rates, fields and non-gravitational accelerations, body axes."""
    year = int(re.search(r"epoch = '(\d+)-", setup).group(1))
    mu, radius = write_gravity(folder / "egm96.txt")
    write_field(folder / "WMM.COF", float(year))
    duration = numbers(setup, "duration")[0]
    mass = numbers(setup, "mass", "mass_properties")[0]
    ixx, iyy, izz = numbers(setup, "moments_of_inertia")
    ixy, iyz, izx = numbers(setup, "products_of_inertia")
    inertia = np.array([[ixx, ixy, izx], [ixy, iyy, iyz], [izx, iyz, izz]])
    inertia -= mass*(OFFSET @ OFFSET*np.eye(3) - np.outer(OFFSET, OFFSET))      # about the centre of mass

    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("world").addTask(simulation.CreateNewTask("task", macros.sec2nano(STEP)))
    earth = Earth(np.radians(numbers(setup, "sidereal_angle_deg")[0]))
    craft = spacecraft.Spacecraft()
    craft.ModelTag = "craft"
    craft.hub.mHub = mass
    craft.hub.r_BcB_B = [[0.0], [0.0], [0.0]]
    craft.hub.IHubPntBc_B = inertia.tolist()
    q = start["q"]
    craft.hub.r_CN_NInit = start["r"].tolist()
    craft.hub.v_CN_NInit = start["v"].tolist()
    craft.hub.sigma_BNInit = RigidBodyKinematics.EP2MRP(np.array([q[3], q[0], q[1], q[2]])).tolist()
    craft.hub.omega_BN_BInit = start["w"].tolist()

    body = gravityEffector.GravBodyData()
    body.planetName = "earth"
    body.mu = mu
    body.radEquator = radius
    body.isCentralBody = True
    body.useSphericalHarmonicsGravityModel(str(folder / "egm96.txt"), GRAVITY_DEGREE)
    body.planetBodyInMsg.subscribeTo(earth.message)
    craft.gravField.gravBodies = gravityEffector.GravBodyVector([body])
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName("earth")

    field = magneticFieldWMM.MagneticFieldWMM()
    field.configureWMMFile(str(folder / "WMM.COF"))
    field.epochDateFractionalYear = float(year)
    field.planetPosInMsg.subscribeTo(earth.message)
    field.addSpacecraftToModel(craft.scStateOutMsg)
    rods = Rods(rods_of(setup))
    bars = MtbEffector.MtbEffector()
    about = messaging.MTBArrayConfigMsgPayload()
    about.numMTB = 3
    about.GtMatrix_B = (gain*np.eye(3)).flatten().tolist()
    about.maxMtbDipoles = [1e3]*3
    about_message = messaging.MTBArrayConfigMsg().write(about)
    bars.mtbParamsInMsg.subscribeTo(about_message)
    bars.mtbCmdInMsg.subscribeTo(rods.message)
    bars.magInMsg.subscribeTo(field.envOutMsgs[0])

    air = exponentialAtmosphere.ExponentialAtmosphere()
    air.planetRadius = radius
    air.scaleHeight = SCALE_HEIGHT
    air.baseDensity = DENSITY*np.exp(HEIGHT/SCALE_HEIGHT)
    air.planetPosInMsg.subscribeTo(earth.message)
    air.addSpacecraftToModel(craft.scStateOutMsg)
    drag = dragDynamicEffector.DragDynamicEffector()
    drag.coreParams.projectedArea = AREA
    drag.coreParams.dragCoeff = DRAG_COEFFICIENT
    drag.coreParams.comOffset = ARM
    drag.atmoDensInMsg.subscribeTo(air.envOutMsgs[0])
    rest = extForceTorque.ExtForceTorque()
    rest.extTorquePntB_B = [[x] for x in UNMODELLED]

    for effector in (gradient, bars, drag, rest):
        craft.addDynamicEffector(effector)
    states, fields = craft.scStateOutMsg.recorder(), field.envOutMsgs[0].recorder()
    for priority, model in enumerate([states, fields, craft, bars, drag, rest, gradient, rods, air, field, earth]):
        simulation.AddModelToTask("task", model, priority)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(duration + 5*STEP))
    simulation.ExecuteSimulation()
    to_body = np.array([RigidBodyKinematics.MRP2C(sigma) for sigma in states.sigma_BN])
    return {"t": states.times()*macros.NANO2SEC, "r": np.array(states.r_CN_N), "c": to_body, "w": np.array(states.omega_BN_B),
            "b": np.einsum("kij,kj->ki", to_body, np.array(fields.magField_N)),
            "a": np.array(states.nonConservativeAccelpntB_B), "mu": mu, "duration": duration}


def at(arc, key, times):
    """What an arc has at some times, which are steps of it."""
    return arc[key][np.rint(np.asarray(times)/STEP).astype(int)]


def coloured(random, level, corner, n, interval):
    """Noise of the two-sided spectrum level (1 + corner/f)."""
    f = np.fft.rfftfreq(n, interval)
    spectrum = level*(1 + corner/np.where(f > 0, f, f[1]))
    draws = (random.normal(size=f.size) + 1j*random.normal(size=f.size))*np.sqrt(spectrum*n/(2*interval))
    return np.fft.irfft(draws, n)


def write_observations(folder, arc, setup, seed):
    """What the instruments of the arc say, with errors of a seed."""
    random = np.random.default_rng(seed)
    folder.mkdir()
    (folder / "setup.nml").write_text(setup)
    interval = numbers(setup, "interval", "accelerometer")[0]
    times = np.arange(1, round(arc["duration"]/interval) + 1)*interval
    w = at(arc, "w", times)
    turning = (at(arc, "w", times + STEP) - at(arc, "w", times - STEP))/(2*STEP)
    r, c = at(arc, "r", times), at(arc, "c", times)
    up = np.einsum("kij,kj->ki", c, r)
    distance = np.linalg.norm(up, axis=1)[:, None]
    pull = arc["mu"]/distance**3*(3*up*(up @ OFFSET)[:, None]/distance**2 - OFFSET)     # of the gradient on d
    acceleration = at(arc, "a", times) - pull + np.array(
        [(cross_matrix(wd) + cross_matrix(rate) @ cross_matrix(rate)) @ OFFSET for wd, rate in zip(turning, w)])
    level, corner = numbers(setup, "noise_level"), numbers(setup, "noise_corner")
    longer = 8*len(times)       # so that the slowest part is not left out
    for axis in range(3):
        acceleration[:, axis] *= 1 + numbers(setup, "sigma_scale_factors")[axis]*random.normal()
        acceleration[:, axis] += 1e-6*random.normal() + coloured(random, level[axis], corner[axis], longer, interval)[:len(times)]
    save(folder / "accelerometer.csv", "time_s,ax_m_s2,ay_m_s2,az_m_s2", times, acceleration)

    times = np.arange(1, round(arc["duration"]/0.5) + 1)*0.5
    mounting = numbers(setup, "mounting_1")
    mounting = RigidBodyKinematics.EP2C(np.array([mounting[3], *mounting[:3]]))
    rows = []
    for c in at(arc, "c", times):
        error = cross_matrix(numbers(setup, "noise_about_axes")*random.normal(size=3))
        q = RigidBodyKinematics.C2EP((np.eye(3) - error) @ mounting @ c)
        rows.append([1, *(q[1:]/np.linalg.norm(q)), q[0]/np.linalg.norm(q)])
    save(folder / "star_camera.csv", "time_s,camera,q1,q2,q3,q4", times, np.array(rows))

    times = np.arange(1, round(arc["duration"]) + 1)*1.0
    bias = numbers(setup, "sigma_magnetometer_bias")*random.normal(size=3)
    save(folder / "magnetometer.csv", "time_s,bx_tesla,by_tesla,bz_tesla", times,
         at(arc, "b", times) + bias + 3e-9*random.normal(size=(len(times), 3)))
    times = np.arange(0, round(arc["duration"]) + 1)*1.0
    save(folder / "orbit.csv", "time_s,rx_m,ry_m,rz_m", times, at(arc, "r", times))


def save(path, header, times, values):
    with open(path, "w", encoding="ascii") as file:
        file.write(header + "\n")
        for t, row in zip(times, values):
            file.write(",".join([f"{t:.1f}", *(f"{x:.17g}" for x in row)]) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("gracecg")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--cases", default="front-3,designed")
    given = parser.parse_args()
    program = str(pathlib.Path(given.gracecg).resolve())

    def gracecg(*words):
        return subprocess.run([program, *words], cwd=folder, check=True, capture_output=True, text=True).stdout

    beyond = 0
    print("case      seed   error x, y, z, um           sigma x, y, z, um         action; contradicted")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for case in given.cases.split(","):
            if case == "designed":
                gracecg("design", "front-3", "--waveforms", "sine", "--out", "designed.nml")
            gracecg("simulate", "designed.nml" if case == "designed" else case, "--out", f"ref-{case}")
            setup = (folder / f"ref-{case}" / "setup.nml").read_text()
            first = next(line for line in (folder / f"ref-{case}" / "truth.csv").read_text().splitlines()
                         if line.startswith("0,")).split(",")
            first = np.array([float(word) for word in first])
            start = {"r": first[1:4], "v": first[4:7], "q": first[7:11], "w": first[11:14]}
            for seed in range(1, given.seeds + 1):
                gain = 1 + numbers(setup, "sigma_rod_gain")[0]*np.random.default_rng(1000 + seed).normal()
                arc = fly(setup, start, gain, folder)
                run = folder / f"{case}-{seed}"
                write_observations(run, arc, setup, seed)
                result = json.loads(gracecg("estimate", run.name, "--algorithm", "optimal", "--format", "json"))
                row = result["results"][0]
                error = np.array([row[f"d{a}_mm"] for a in "xyz"])*1e3 - OFFSET*1e6
                sigma = np.array([row[f"sigma_{a}_mm"] for a in "xyz"])*1e3
                beyond += int(np.any(abs(error) > 3*sigma))
                told = result["beliefs"]["contradiction"] or "nothing"
                print(f"{case:9s} {seed:4d}  " + "".join(f"{x:8.2f}" for x in error) + "   " +
                      "".join(f"{x:8.2f}" for x in sigma) + f"   {result['action']['kind']}; {told}", flush=True)
    print(f"{beyond} runs have an error beyond 3 sigma")
    return int(beyond > 0)


if __name__ == "__main__":
    sys.exit(main())
