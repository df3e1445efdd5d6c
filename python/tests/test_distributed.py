"""Campaigns and days over executors: the bytes of one process, workers that are lost, bad input."""
import os
import pathlib
import subprocess
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from gracecg import distributed
from gracecg.distributed import Task, TaskError

PROGRAM = os.environ.get("GRACECG_PROGRAM")
CAMPAIGN = ["front-3,back-2", "--algorithms", "assest-fde,optimal", "--runs", "5", "--seed", "5"]

pytestmark = pytest.mark.skipif(PROGRAM is None, reason="GRACECG_PROGRAM names no program")


@pytest.fixture(name="whole", scope="module")
def fixture_whole(tmp_path_factory):
    """The campaign in one process."""
    place = tmp_path_factory.mktemp("whole")
    words = ["montecarlo", "--cases", *CAMPAIGN, "--out", place / "table.csv", "--runs-out", place / "runs.csv"]
    printed = subprocess.run([PROGRAM, *map(str, words)], check=True, text=True, stdout=subprocess.PIPE).stdout
    return (place / "table.csv").read_bytes(), (place / "runs.csv").read_bytes(), printed


def check_campaign(executor, place, whole, **how):
    """The campaign in shards has the bytes of the whole one."""
    merged = distributed.montecarlo(["--cases", *CAMPAIGN], executor, shards=4, out=place / "table.csv",
                                    runs_out=place / "runs.csv", **{"program": PROGRAM, "progress": None, **how})
    assert ((place / "table.csv").read_bytes(), (place / "runs.csv").read_bytes()) == whole[:2]
    assert [line for line in merged.text.splitlines() if "RMS" in line] == [
        line for line in whole[2].splitlines() if "RMS" in line]


def two():
    return ProcessPoolExecutor(2)


def program_that(place, first):
    """The program, whose first run does something else."""
    script = pathlib.Path(place, "program")
    script.write_text(f"#!/bin/sh\nif mkdir '{place}/begun' 2>/dev/null; then {first}; fi\nexec '{PROGRAM}' \"$@\"\n",
                      encoding="utf-8")
    script.chmod(0o755)
    return str(script)


def test_processes(tmp_path, whole):
    told = []
    with two() as pool:
        check_campaign(pool, tmp_path, whole, progress=lambda *numbers: told.append(numbers))
    assert told == [(k, 4) for k in range(1, 5)]


def test_killed_program(tmp_path, whole):
    """A program that is killed is begun again by the same executor."""
    check_campaign(ThreadPoolExecutor(2), tmp_path, whole, program=program_that(tmp_path, "kill -9 $$"))


def test_killed_worker(tmp_path, whole):
    """A process that dies breaks its pool; a new one takes over where there is a way to make it."""
    check_campaign(two, tmp_path, whole, program=program_that(tmp_path, "kill -9 $PPID; sleep 1"))
    os.rmdir(tmp_path / "begun")
    with pytest.raises(TaskError, match="makes the executor"), two() as pool:
        check_campaign(pool, tmp_path, whole, program=str(tmp_path / "program"))


def test_class_as_executor():
    """What makes an executor may be its class."""
    (outcome,) = distributed.run([Task(["cases"])], ThreadPoolExecutor, program=PROGRAM, progress=None)
    assert outcome.status == 0


def test_lost_always(tmp_path):
    """What is lost again and again ends the work."""
    script = pathlib.Path(tmp_path, "program")
    script.write_text(f"#!/bin/sh\necho >>'{tmp_path}/begun'\nkill -9 $$\n", encoding="utf-8")
    script.chmod(0o755)
    with pytest.raises(TaskError, match="1 of 1 tasks were lost"):
        distributed.run([Task(["cases"])], ThreadPoolExecutor(1), program=str(script), tries=2)
    assert (tmp_path / "begun").read_text() == "\n\n"


def test_bad_input(tmp_path):
    """What the program refuses is not tried again; its words are shown."""
    program = program_that(tmp_path, f"echo >>'{tmp_path}/count'")
    with pytest.raises(TaskError, match="no_such_case"):
        distributed.montecarlo(["no_such_case"], ThreadPoolExecutor(1), shards=3, program=program)
    with pytest.raises(ValueError, match="--shard"):
        distributed.montecarlo(["front-3", "--shard", "1/2"], ThreadPoolExecutor(1), shards=3)


def test_order():
    """Results stand in the order of the tasks."""
    outcomes = distributed.run([Task(["bound", case, "--format", "csv"]) for case in ("front-1", "back-1", "front-2")],
                               ThreadPoolExecutor(2), program=PROGRAM, progress=None)
    assert [outcome.text.splitlines()[-1].split(",")[0] for outcome in outcomes] == ["front-1", "back-1", "front-2"]


def test_days(tmp_path):
    """Days of an archive: the JSON of each."""
    places = [tmp_path / f"day{k}" for k in (1, 2)]
    for k, place in enumerate(places):
        subprocess.run([PROGRAM, "level1", "simulate", "front-1", "--seed", str(k + 1), "--out", place], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    found = distributed.days(places, places[0] / "setup.nml", ThreadPoolExecutor(2), program=PROGRAM, progress=None)
    assert [len(day["spans"]) for day in found] == [4, 4]
    assert found[0]["offset_mm"] != found[1]["offset_mm"]


def test_dask(tmp_path, whole):
    """Dask's client, as it is handed in."""
    dask = pytest.importorskip("distributed")
    with dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, dask.Client(cluster) as client:
        check_campaign(client, tmp_path, whole)
