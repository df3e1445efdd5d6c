"""The Python package: identities, the command line's digits, and what is refused.

GRACECG_PROGRAM names the program whose numbers are compared; without it those tests are skipped.
"""
import csv
import datetime
import json
import os
import pathlib
import pickle
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import gracecg
from gracecg import _library

PROGRAM = os.environ.get("GRACECG_PROGRAM")
POSITION = [[4.0e6, -3.0e6, 4.6e6], [6.8e6, 1e5, -2e5]]      # m
SAME = {"rtol": float(os.environ.get("GRACECG_DIGITS", "1e-9")), "atol": 0.0}


def program(*words, folder=None):
    """The first row of CSV that the program prints, as numbers by column."""
    output = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=True, cwd=folder).stdout
    lines = [line for line in output.splitlines() if line and not line.startswith("#")]
    return {name: float(value) for name, value in next(csv.DictReader(lines)).items()
            if value.replace(".", "").replace("-", "").replace("e", "").isdigit()}


needs_program = pytest.mark.skipif(PROGRAM is None, reason="GRACECG_PROGRAM is not set")


@pytest.fixture(scope="module")
def case():
    return gracecg.Case("front-3")


@pytest.fixture(scope="module")
def observations(case):
    return case.simulator().observe(seed=1, run=1)


def test_every_function_of_the_header_is_there():
    names = [name for name in dir(_library.lib) if name.startswith("gracecg_")]
    assert len(names) > 40 and all(getattr(_library.lib, name) for name in names)


def test_time():
    assert gracecg.Utc.of("2016-12-31T23:59:60").seconds == 86400.0        # a leap second
    assert gracecg.Utc.of("1989-01-02").mjd == 47528
    late = gracecg.Utc.of("2016-12-31T23:59:59.5").plus(1.0)
    assert str(late) == "2016-12-31T23:59:60.5" and late.since("2016-12-31") == 86400.5
    assert str(gracecg.Utc.of("1980-01-06").plus(1e9)) == "2011-09-14T01:46:25"      # GPS week 1653, 265600 s


def test_live_estimate(case, observations):
    """Fed as the samples come, with the wave's frequency: that of "sequential", which has them all at once."""
    truth = case.simulator().truth()
    (times, accelerations), (star_times, heads, quaternions) = observations.accelerometer, observations.star_camera
    field_times, fields = observations.magnetometer
    orbit_times, positions = observations.orbit
    live = gracecg.LiveEstimate(observations.setup, truth["state"][0, 9:], truth["state"][0, 6:9], 1 / 19.9)
    step = times[1] - times[0]
    assert live.now().sigma.max() > 0.1
    for k in range(len(times) + 1):
        at = k * step
        moment = np.zeros((3, 3))
        for rod in case.rods:
            angle = 2 * np.pi * rod.frequency * (at - step * np.array([1, 0.5, 0])) + rod.phase
            moment[:, rod.axis - 1] += rod.amplitude * np.sin(angle)
        live.add(at, moment, accelerations[k - 1] if k else None,
                 next(iter(fields[np.abs(field_times - at) < step / 2]), fields[0] if k == 0 else None),
                 [np.interp(at, orbit_times, row) for row in positions.T],
                 [(star_times[i], heads[i], quaternions[i]) for i in np.flatnonzero(np.abs(star_times - at) < step / 2)])
    found, whole = live.now(), observations.estimate("sequential")
    assert np.all(np.abs(found.offset - whole.offset) < whole.sigma) and np.allclose(found.sigma, whole.sigma, rtol=0.1)
    assert found.counts[0] == len(times) + 1 and abs(1 / found.wave[0] - 19.9) < 0.5
    with pytest.raises(gracecg.GracecgError, match="the next sample is that at"):
        live.add(0.0, moment)
    with pytest.raises(TypeError, match="cannot be pickled"):
        pickle.dumps(live)
    assert "after 60 s" in repr(live) and "600 samples of the accelerometer" in repr(observations)


def test_laplace_and_symmetry():
    acceleration, potential, gradient = gracecg.Gravity("egm96", 20).evaluate(POSITION)
    assert np.array_equal(gracecg.Gravity("egm96", 20).acceleration(POSITION), acceleration)
    assert acceleration.shape == (2, 3) and potential.shape == (2,)
    assert np.allclose(np.trace(gradient, axis1=1, axis2=2), 0, atol=1e-20)
    assert np.array_equal(gradient, gradient.transpose(0, 2, 1))
    step = 1.0
    moved = gracecg.Gravity("egm96", 20).evaluate(np.array(POSITION) + [step, 0, 0])[0]
    assert np.allclose((moved - acceleration) / step, gradient[:, :, 0], rtol=1e-3, atol=1e-12)


def test_models():
    point = gracecg.Gravity("point-mass", 0).evaluate(POSITION[0])
    assert point[0].shape == (3,) and point[2].shape == (3, 3)     # of one position
    assert np.isclose(point[1], 3.986004415e14 / np.linalg.norm(POSITION[0]), rtol=1e-9)
    field = gracecg.Field("igrf95", "1989-01-02").evaluate(POSITION)
    assert np.all((np.linalg.norm(field, axis=1) > 1e-5) & (np.linalg.norm(field, axis=1) < 7e-5))
    air = gracecg.Density("dtm77", "1989-01-02").evaluate("1989-01-02", POSITION)
    assert np.all(air.density > 0) and air.number_density.shape == (2, 3)
    assert gracecg.Wind().evaluate("1989-01-02", POSITION).shape == (2, 2)
    sun = gracecg.sun_position(np.datetime64("1989-01-02T00:00"), [0.0, 86400.0])
    assert sun.shape == (2, 3) and gracecg.sun_position("1989-01-02").shape == (3,)
    assert gracecg.Utc.of(np.datetime64("2050-01", "M")).mjd == 69807
    assert gracecg.Utc.of(np.datetime64("1989-01-02T00:00:00.5")).seconds == 0.5
    assert np.allclose(np.linalg.norm(sun, axis=1), 1.471e11, rtol=2e-3)     # perihelion
    assert np.array_equal(gracecg.sun_illumination(sun[:1] / 1e4, sun[:1]), [1.0])
    flux = gracecg.EarthRadiation().flux("1989-01-02", POSITION)
    assert np.all(np.einsum("ij,ij->i", flux, POSITION) > 0)                 # away from the Earth


def test_truth_and_propagation(case):
    truth = case.simulator().truth()
    assert np.array_equal(truth["state"][0], case.state) and truth["time"][-1] == case.duration
    states = case.force_model().propagate(case.state, 0.1, 10)
    assert np.allclose(states[-1], truth["state"][10], rtol=1e-9, atol=1e-9)
    parts = case.force_model().accelerations(0.0, case.state[:3], case.state[3:6], case.state[9:])
    assert np.allclose(sum(parts[name] for name in parts if name != "total"), parts["total"])


def test_arrays_there_and_back(observations):
    again = gracecg.Observations.from_arrays(observations.setup, observations.accelerometer,
                                             observations.star_camera, observations.magnetometer,
                                             observations.orbit)
    for algorithm in gracecg.algorithms():
        one, other = observations.estimate(algorithm), again.estimate(algorithm)
        assert np.array_equal(one.offset, other.offset), algorithm
    assert one == one != other and len({one, other}) == 2 and not one.covariance.flags.writeable


def test_every_item_of_the_table_is_there(case, observations):
    sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "tools"))
    from interface_table import read_table

    settings = case.design_settings()
    settings.rod_used, settings.waveform_used = [0, 1, 1], [1, 0, 0, 0]
    simulator = case.simulator()
    joint = _library.Handle("estimate_joint", 1, _library.ffi.new("gracecg_object *[]", [observations._handle]))
    samples = {"case": case, "force_model": case.force_model(), "simulator": simulator, "setup": observations.setup,
               "observations": observations, "fit": observations.fit("sequential"), "joint": joint,
               "chain": _library.Handle("estimate_chain", observations._handle, 20.0, 1),
               "bound": _library.Handle("case_bound", case._handle), "design": case.design(settings).case,
               "map": _library.Handle("map", case._handle, 1, _library.pointer(np.zeros(1)), 1),
               "live": gracecg.LiveEstimate(observations.setup, [0, 0, 0, 1], [0, 0, 0])}
    seen = 0
    objects = {item.name: item for item in read_table()["gracecg"] if item.kind == "object"}
    for thing in (item for item in objects.values() if item.items):
        there = samples[thing.name]._items()
        for item in thing.all_items(objects).values():
            count = there.pop(item.name)
            assert (count is None) == item.is_text, (thing.name, item.name)
            if count is not None and all(size.isdigit() for size in item.sizes):
                assert count == np.prod([int(size) for size in item.sizes], dtype=int), (thing.name, item.name)
            seen += 1
        assert not there, (thing.name, list(there))
    assert seen > 120


def test_folder(observations, tmp_path):
    observations.write(tmp_path / "set")
    again = gracecg.Observations(tmp_path / "set")
    assert np.array_equal(again.accelerometer[1], observations.accelerometer[1])
    assert again.setup.text == observations.setup.text


def test_pickle_and_repr(case, observations, tmp_path):
    assert repr(gracecg.Gravity("egm96", degree=10)) == "Gravity('egm96', degree=10)"
    assert repr(case) == "Case('front-3')" and "Observations" in repr(observations)
    gravity = pickle.loads(pickle.dumps(gracecg.Gravity("egm96", degree=10)))
    assert np.array_equal(gravity.acceleration(POSITION), gracecg.Gravity("egm96", 10).acceleration(POSITION))
    options = "&sequential edit_sigma = 6 /"
    again = pickle.loads(pickle.dumps(case.with_options(options)))
    assert again.text == case.with_options(options).text and again.options == case.with_options(options).options
    again = pickle.loads(pickle.dumps(observations))
    assert all(map(np.array_equal, again.star_camera, observations.star_camera)) and "/tmp" not in repr(again)
    assert np.array_equal(again.estimate("assest-fde").offset, observations.estimate("assest-fde").offset)
    setup = pickle.loads(pickle.dumps(observations.setup))
    assert setup.text == observations.setup.text
    with pytest.raises(TypeError, match="measured moments"):
        pickle.dumps(setup.measured(np.linspace(-1.0, 61.0, 63), np.zeros((63, 3))))
    with pytest.raises(TypeError, match="pickle what it was made of"):
        pickle.dumps(gracecg.Simulator._made("simulator_open", case._handle))


def test_failures_travel():
    """A failure in a worker process reaches the caller with its status."""
    failure = pickle.loads(pickle.dumps(gracecg.GracecgError(4, "too near")))
    assert (failure.status, str(failure)) == (4, "too near")


def test_misuse(tmp_path, case):
    with pytest.raises(ValueError, match="not both"):
        gracecg.Density("dtm77", "1989-01-02", f107=400)
    with pytest.raises(gracecg.GracecgError, match="no gravity model"):
        gracecg.Gravity(tmp_path / "none.gfc")
    with pytest.raises(ValueError, match="steps = -1"):
        case.force_model().propagate(np.zeros(13), 1.0, -1)
    for call, match in ((lambda: gracecg.ForceModel("front-3"), "class Case is expected, not 'front-3'"),
                        (lambda: case.simulator().observe().estimate(None), "algorithm: a text is expected"),
                        (lambda: gracecg.estimate_joint([case]), "class Observations")):
        with pytest.raises(TypeError, match=match):
            call()
    setup = case.simulator().observe().setup
    with pytest.raises(ValueError, match="accelerometer: expected times, accelerations"):
        gracecg.Observations.from_arrays(setup, ([0.1],))
    assert len(set(dir(gracecg))) == len(dir(gracecg)) and "Any" not in dir(gracecg) and "plot" in dir(gracecg)
    day = gracecg.Utc.of("2020-01-01")
    assert gracecg.Utc.of(datetime.date(2020, 1, 1)) == day
    space = {}
    exec("from gracecg import *", space)
    assert "Gravity" in space


def test_action(observations):
    fit = observations.fit("optimal")
    action = fit.action()
    assert repr(fit).startswith("<Fit: " + action.text)
    assert gracecg.Action is type(action) and action.kind in (1, 2, 3) and action.text == fit._text("action")
    assert np.all(action.sigma >= fit.solution.sigma)
    assert np.all((action.trim == 1) <= (action.kind == 1)) and np.all((action.again == 1) | (action.again == 0))


def test_what_is_not_to_be_used_says_so(observations):
    times, field = observations.magnetometer
    halved = gracecg.Observations.from_arrays(observations.setup, observations.accelerometer, observations.star_camera,
                                              (times, field / 2), observations.orbit)
    with pytest.warns(UserWarning, match="do not use: the data contradict"):
        assert halved.estimate("assest-fde").action.kind == 4


def test_options_of_a_call(case, observations):
    untested = {"estimation": {"test_beliefs": False}}
    assert observations.estimate("assest-fde", untested).action.kind == observations.fit("assest-fde", untested).action().kind == 5
    with pytest.raises(gracecg.GracecgError, match="the options leave out the tests"):
        observations.beliefs("assest-fde", untested)
    assert gracecg.monte_carlo(case, "assest-fde", runs=1, options=untested).converged.all()
    fixed = {"optimal": {"estimate_within_limits": False}}
    assert np.all(gracecg.estimate_joint([observations], fixed).covariance.diagonal() < observations.estimate().sigma**2)
    assert observations.estimate_chain(20.0, options=fixed).arcs == 3


def test_earth_orientation_goes_half_a_day():
    with pytest.raises(gracecg.GracecgError, match="43200"):
        gracecg.Utc.of("2026-01-01").earth_orientation(seconds=86400.0)


def test_kilometres(case):
    with pytest.raises(gracecg.GracecgError, match="in metres"):
        gracecg.Gravity().acceleration(np.array(POSITION)/1000)
    state = case.state.copy()
    state[3:6] *= 1000
    with pytest.raises(gracecg.GracecgError, match="20000 m/s"):
        case.force_model().rate(0.0, state)
    with pytest.raises(gracecg.GracecgError, match="86400 s"):
        case.force_model().propagate_nadir(case.state[:3], case.state[3:6], 2.0**31, 1)


@pytest.mark.parametrize("algorithm", gracecg.algorithms())
def test_fit(observations, algorithm):
    fit = observations.fit(algorithm)
    series, solution = fit.series(), fit.solution
    n = len(series["time"])
    assert series["residual"].shape == (n, 3) and series["partials"].shape == (n, 3, 3)
    assert np.array_equal(solution.offset, observations.estimate(algorithm).offset) and solution.converged
    assert fit.parameters[:3] == ["d_x", "d_y", "d_z"]
    covariance = fit.covariance()
    assert covariance.shape == (len(fit.parameters),) * 2
    assert np.allclose(covariance[:3, :3], solution.covariance, rtol=1e-6)
    assert np.allclose(fit.covariance_by_source().sum(axis=0), solution.covariance, rtol=1e-6, atol=1e-18)
    # a_x by the offset: -(omega_y^2 + omega_z^2); its trace with the others is -2 omega^2 and never positive
    assert np.all(np.trace(series["partials"], axis1=1, axis2=2) < 1e-5)
    # d x alpha has no component along d: antisymmetric part of the partials is the angular acceleration
    antisymmetric = (series["partials"] - series["partials"].transpose(0, 2, 1)) / 2
    alpha = np.stack([antisymmetric[:, 2, 1], antisymmetric[:, 0, 2], antisymmetric[:, 1, 0]], axis=1)
    assert np.allclose(alpha, series["angular_acceleration"], atol=1e-9) or \
        np.allclose(alpha, -series["angular_acceleration"], atol=1e-9)
    tests = fit.tests()
    assert np.allclose(tests.source_share.sum(axis=0), 1, rtol=1e-6)
    assert np.all((tests.probability >= 0) & (tests.probability <= 1))
    assert (len(fit.running()["time"]) > 0) == (algorithm == "sequential")


def test_tests_of_a_fit_are_made_once(observations, monkeypatch):
    fit, called = observations.fit("optimal"), []
    call = _library.call
    monkeypatch.setattr(_library, "call", lambda name, *arguments, **more: called.append(name) or call(name, *arguments, **more))
    tests = fit.tests()
    assert called == ["get"]
    assert np.array_equal(tests.direction, fit._numbers("test_direction", 3, 3))
    assert tests.torque_factor == fit._number("test_torque_factor")


def test_options(observations):
    tight = observations.estimate("optimal", {"optimal": {"density_wave": "none", "estimate_rod_gain": True}})
    assert "rod" in " ".join(tight.parameters) and not np.array_equal(tight.offset, observations.estimate().offset)
    with pytest.raises(gracecg.GracecgError, match="density_wav"):
        observations.with_options({"optimal": {"density_wav": "none"}})
    assert gracecg.Case.parse(gracecg.Case("back-1").text).bound().sigma[0] == gracecg.Case("back-1").bound().sigma[0]


def test_joint(case):
    simulator = case.simulator()
    joint = gracecg.estimate_joint([simulator.observe(1, 1), simulator.observe(1, 2)])
    assert joint.consistent and joint.difference.shape == (2, 3)
    assert np.allclose(joint.offset, case.offset, atol=1e-4) and joint.action.kind in (1, 2, 3)
    with pytest.warns(UserWarning, match="the runs do not agree on one offset"):
        apart = gracecg.estimate_joint([simulator.observe(1, 1), gracecg.Case("back-3").simulator().observe(1, 2)])
    assert apart.action.text.startswith("do not use") and not apart.consistent


def test_chain(case):
    chain = case.simulator().observe(1, 1).estimate_chain(arc=20.0, threads=2)
    assert (chain.arcs, chain.joined, chain.degrees) == (3, 3, 6) and isinstance(chain.warnings, list)
    assert chain.action.text.startswith("not tested: in arcs")
    assert isinstance(chain.consistent, bool) and 0 <= chain.probability <= 1
    assert np.allclose(chain.offset, case.offset, atol=5e-4)
    with pytest.raises(gracecg.GracecgError, match="arcs of 1 s"):
        case.simulator().observe(1, 1).estimate_chain(arc=1.0)


def test_bound_and_plan(case):
    bound = case.bound()
    assert np.allclose(np.sqrt(np.diag(bound.covariance)), bound.sigma)
    assert np.allclose(bound.direction @ bound.direction.T, np.eye(3), atol=1e-12)
    assert len(case.rods) == 2 and case.rods[0].axis in (1, 2, 3)
    places = case.map([0.0, 600.0])
    assert places.sigma.shape == (2, 3) and np.all(np.abs(places.latitude) < np.pi / 2)
    assert case.design_settings().amplitude == 30


def test_monte_carlo(case):
    seen = []
    result = gracecg.monte_carlo(case, "assest-fde", runs=4, threads=2, progress=lambda done, of: seen.append((done, of)))
    assert seen == [(k, 4) for k in range(1, 5)]
    assert np.array_equal(result.offset, gracecg.monte_carlo(case, "assest-fde", runs=4, threads=1).offset)
    with pytest.raises(KeyboardInterrupt):
        gracecg.monte_carlo(case, "assest-fde", runs=4, threads=1, progress=lambda done, of: False)


def test_other_threads_run(observations):
    counts = []
    stop = threading.Event()

    def count():
        while not stop.is_set():
            counts.append(time.perf_counter())
            time.sleep(1e-3)

    counter = threading.Thread(target=count)
    counter.start()
    start = time.perf_counter()
    for _ in range(5):
        observations.estimate("optimal")
    spent = time.perf_counter() - start
    stop.set()
    counter.join()
    inside = [t for t in counts if start < t < start + spent]
    assert len(inside) > 5 and max(np.diff(inside)) < spent


@pytest.mark.parametrize("call, message", [
    (lambda: gracecg.Gravity("egm96", 99), "99"),
    (lambda: gracecg.Case("front-9"), "front-9"),
    (lambda: gracecg.Field("igrf14", "3000-01-01"), "3000"),
    (lambda: gracecg.Gravity().evaluate([[float("nan"), 0, 7e6]]), "finite"),
    (lambda: gracecg.Level1("/no/such/file"), "no/such"),
    (lambda: gracecg.Setup.parse("&a"), "&a"),
])
def test_refusals(call, message):
    with pytest.raises(gracecg.GracecgError, match=message):
        call()


def test_arguments(case, observations):
    with pytest.raises(gracecg.GracecgError, match="NUL"):
        gracecg.Case("front-1\0x")
    with pytest.raises(ValueError, match="1 or more"):
        gracecg.monte_carlo(case, runs=-2)
    assert observations.with_options({}).estimate().converged


def test_shapes():
    with pytest.raises(ValueError, match="shape"):
        gracecg.Gravity().evaluate([1.0, 2.0])
    with pytest.raises(ValueError, match="masked"):
        gracecg.Gravity().evaluate(np.ma.masked_less([[7e6, 0, 0], [-1, 0, 0]], 0))


@needs_program
def test_digits_of_the_command_line(observations, case, tmp_path):
    subprocess.run([PROGRAM, "simulate", "front-3", "--out", str(tmp_path / "set"), "--seed", "1"], check=True,
                   capture_output=True)
    for algorithm in ("assest-fde", "ascrest", "optimal", "sequential"):
        row = program("estimate", str(tmp_path / "set"), "--algorithm", algorithm, "--format", "csv")
        ours = gracecg.Observations(tmp_path / "set").estimate(algorithm)
        assert np.allclose([row[f"d{axis}_mm"] for axis in "xyz"], 1e3 * ours.offset, **SAME), algorithm
    row = program("bound", "front-3", "--format", "csv")
    bound = [row[name] for name in row if name.startswith("sigma_")][:3]
    assert np.allclose(bound, 1e3 * case.bound().sigma, **SAME)
    gravity = program("model", "gravity", "--degree", "20", "--position", *map(str, POSITION[0]))
    assert np.allclose([gravity[f"a{axis}_m_s2"] for axis in "xyz"], gracecg.Gravity("egm96", 20, 20).evaluate(POSITION[0])[0],
                       rtol=1e-12)
    runs = tmp_path / "runs.csv"
    subprocess.run([PROGRAM, "montecarlo", "--cases", "front-3", "--algorithms", "assest-fde", "--runs", "3",
                    "--runs-out", str(runs)], check=True, capture_output=True)
    table = np.array([[float(value) for value in line.split(",")[3:6]] for line in runs.read_text().splitlines()
                      if line.startswith("front-3,")])
    assert np.allclose(table, 1e3 * gracecg.monte_carlo(case, "assest-fde", runs=3).offset, **SAME)


def test_beliefs(observations):
    beliefs = observations.beliefs()
    assert beliefs.tested > 0 and np.all(beliefs.undetected > 0)
    assert (beliefs.contradicted > 0) == (beliefs.contradictions != "")


def test_earth_orientation():
    epoch = gracecg.Utc.of("2026-03-01T00:00:00")
    rotation = epoch.earth_orientation(ut1_minus_utc=0.0672)
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    # the angle alone leaves 26 years of precession, 20 arcsec a year of the pole
    assert np.linalg.norm(rotation[2] - [0, 0, 1]) == pytest.approx(26.16*20.04*np.pi/648000, rel=0.03)
    with pytest.raises(gracecg.GracecgError, match="no such file"):
        epoch.earth_orientation("missing.txt")


def test_design_along_the_orbit():
    case = gracecg.Case("front-3")
    settings = case.design_settings()
    settings.rod_used, settings.waveform_used = [0, 1, 1], [1, 0, 0, 0]
    at, anywhere = case.design(settings), case.design_anywhere(settings)
    assert at.start == settings.start and anywhere.start > 0 and anywhere.worst <= at.worst
    assert (anywhere.case.epoch.mjd - case.epoch.mjd) * 86400.0 + anywhere.case.epoch.seconds - case.epoch.seconds \
        == pytest.approx(anywhere.start)


def test_level1_estimate_fails_in_words(tmp_path):
    (tmp_path / "setup.nml").write_text("&mass_properties mass = 600 /")
    with pytest.raises(gracecg.GracecgError):
        gracecg.estimate_level1(tmp_path, tmp_path / "setup.nml")
    (tmp_path / "setup.nml").write_text("&mass_properties mass = 600, moments_of_inertia = 70, 345, 388 /\n&level1 /\n")
    with pytest.raises(gracecg.GracecgError, match="2020-02-30.*no date"):
        gracecg.estimate_level1(tmp_path, tmp_path / "setup.nml", day="2020-02-30")


@pytest.mark.parametrize("name", ["calibration", "manoeuvre"])
def test_notebook(name):
    notebook = json.loads((pathlib.Path(__file__).parents[1] / "notebooks" / f"{name}.ipynb").read_text(encoding="utf-8"))
    space: dict = {}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert cells
    for cell in cells:
        exec("".join(cell["source"]), space)    # noqa: S102
