"""Campaigns, maps and archives of days over any executor of ``concurrent.futures``.

A task is one run of the program, on any machine that has it and sees the same folders; what it prints and writes comes back.
The executor is the user's: ``ProcessPoolExecutor``, joblib's ``get_reusable_executor``, ``MPIPoolExecutor`` of mpi4py, a
``dask.distributed.Client``. A task whose worker was lost is done again; one that the program refuses ends the work with the
program's words.

>>> from concurrent.futures import ProcessPoolExecutor
>>> from gracecg import distributed
>>> distributed.montecarlo(["front-3", "--runs", "1000"], ProcessPoolExecutor, shards=20, out="table.csv")
"""
from __future__ import annotations

import json
import os
import pathlib
import subprocess
import sys
import tempfile
from concurrent.futures import BrokenExecutor, CancelledError, as_completed
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Sequence

__all__ = ["Outcome", "Task", "TaskError", "days", "montecarlo", "run"]

DONE = (0, 3)                   # exit statuses: done; done, but not to be used
STOPPED = (130, 143)            # by Ctrl-C, by kill: other than by a signal itself, which is a negative status
OWN_OPTIONS = ("--shard", "--out", "--runs-out", "--resume", "--threads", "--format")


class TaskError(Exception):
    """The program refused a task, or a task was lost as often as it was tried."""


@dataclass(frozen=True)
class Task:
    """A run of the program.

    Attributes
    ----------
    arguments : sequence of str
        What stands behind ``gracecg`` on a command line.
    outputs : sequence of str
        Options that name a file to write, as ``--out``: each is given one; what is written comes back.
    """

    arguments: Sequence[str]
    outputs: Sequence[str] = ()


@dataclass(frozen=True)
class Outcome:
    """What came of a task.

    Attributes
    ----------
    status : int
        Exit status: 0 done, 3 done, but not to be used.
    text, messages : str
        What the program printed: results, and what it said beside.
    files : dict of bytes
        What was written, by the option's name: ``out``, and beside it ``out.meta.json``.
    """

    status: int
    text: str
    messages: str
    files: dict[str, bytes]


def _work(program: str, folder: str, task: Task) -> Outcome:
    """A task, done where this is called."""
    with tempfile.TemporaryDirectory() as place:
        options = [word for option in task.outputs for word in (option, os.path.join(place, option.lstrip("-")))]
        ended = subprocess.run([program, *map(str, task.arguments), *options], cwd=folder, stdin=subprocess.DEVNULL, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", check=False)
        files = {path.name: path.read_bytes() for path in pathlib.Path(place).iterdir()} if ended.returncode in DONE else {}
    return Outcome(ended.returncode, ended.stdout, ended.stderr, files)


def say(done: int, of_all: int) -> None:
    """A line of progress on standard error, twenty at most."""
    if done == of_all or done * 20 // of_all > (done - 1) * 20 // of_all:
        print(f"gracecg: {done} of {of_all} tasks done", file=sys.stderr, flush=True)


def run(tasks: Iterable[Task], executor: Any, *, program: str = "gracecg", folder: str | os.PathLike[str] | None = None,
        tries: int = 3, progress: Callable[[int, int], object] | None = say) -> list[Outcome]:
    """Does tasks and gives what came of them, in their order.

    Parameters
    ----------
    executor
        With ``submit``; or what makes one, as a class or function without arguments: a new one is made when one breaks.
    program, folder
        The program and the folder to work in (default: the present one), as the workers see them.
    tries : int
        How often a task is begun whose worker is lost.
    progress
        Called with the numbers of tasks that are done, and of all.

    Raises
    ------
    TaskError
        The program refuses a task (the others are cancelled), or a task is lost `tries` times.
    """
    todo = list(tasks)
    folder = os.path.abspath(folder or ".")
    make = None if hasattr(executor, "submit") and not isinstance(executor, type) else executor
    pool = _with_futures(make() if make else executor)
    found: dict[int, Outcome] = {}
    lost: BaseException | None = None
    try:
        for _ in range(tries):
            broken = False
            futures: dict[Any, int] = {}
            try:
                for i in range(len(todo)):
                    if i not in found:
                        futures[pool.submit(_work, program, folder, todo[i])] = i
            except (BrokenExecutor, RuntimeError) as failure:   # RuntimeError: it has been shut down
                broken, lost = True, failure
            try:
                for future in as_completed(futures):
                    try:
                        outcome = future.result()
                    except (Exception, CancelledError) as failure:
                        broken, lost = broken or isinstance(failure, BrokenExecutor), failure
                        continue
                    if outcome.status < 0 or outcome.status in STOPPED:
                        lost = TaskError(f"stopped from outside, exit status {outcome.status}")
                        continue
                    if outcome.status not in DONE:
                        raise TaskError(f"gracecg {' '.join(map(str, todo[futures[future]].arguments))}: "
                                        f"{outcome.messages.strip()}")
                    found[futures[future]] = outcome
                    if progress:
                        progress(len(found), len(todo))
            finally:
                for future in futures:
                    future.cancel()
            if len(found) == len(todo):
                return [found[i] for i in range(len(todo))]
            if broken:
                if not make:
                    break
                pool.shutdown(wait=False)
                pool = _with_futures(make())
    finally:
        if make:
            pool.shutdown(wait=True)
    raise TaskError(f"{len(todo) - len(found)} of {len(todo)} tasks were lost with their workers: {lost!r}"
                    + ("" if make or not broken else "; give a function that makes the executor, and a new one takes over"))


def _with_futures(executor: Any) -> Any:
    """The executor of a Dask client; any other as it is."""
    return executor.get_executor() if hasattr(executor, "get_executor") else executor


def montecarlo(arguments: Sequence[str], executor: Any, *, shards: int, out: str | None = None, runs_out: str | None = None,
               **how: Any) -> Outcome:
    """A campaign in shards: what ``gracecg montecarlo ARGUMENTS`` prints and writes, to the byte.

    Parameters
    ----------
    arguments : sequence of str
        Of ``gracecg montecarlo``: cases, ``--algorithms``, ``--runs``, ``--seed``, ...; not files, shards or threads.
    shards : int
        Tasks to divide it into, some times as many as there are workers.
    out, runs_out : path
        Files to write, as ``--out`` and ``--runs-out`` do.
    how
        As of `run`.
    """
    if taken := [word for word in arguments if str(word).split("=")[0] in OWN_OPTIONS]:
        raise ValueError(f"{', '.join(taken)}: said by the arguments of montecarlo, or not at all")
    parts = run([Task(["montecarlo", *arguments, "--threads", "1", "--shard", f"{k}/{shards}", "--format", "csv"], ["--runs-out"])
                 for k in range(1, shards + 1)], executor, **how)
    files = {"--out": out, "--runs-out": runs_out}
    program, folder = how.get("program", "gracecg"), os.path.abspath(how.get("folder") or ".")
    with tempfile.TemporaryDirectory() as place:
        names = [pathlib.Path(place, f"shard_{k}.csv") for k in range(1, shards + 1)]
        for name, part in zip(names, parts):
            for written, content in part.files.items():
                pathlib.Path(f"{name}{written.removeprefix('runs-out')}").write_bytes(content)
        merged = _work(program, folder, Task(["merge", *map(str, names), *(
            str(word) for option, path in files.items() if path for word in (option, path))]))
    if merged.status != 0:
        raise TaskError(f"gracecg merge: {merged.messages.strip()}")
    return merged


def days(places: Iterable[str | os.PathLike[str] | Sequence[str]], setup: str | os.PathLike[str], executor: Any,
         options: Sequence[str] = (), **how: Any) -> list[dict[str, Any]]:
    """The offset of every manoeuvre of an archive: the JSON of ``gracecg level1 estimate`` of each, as objects.

    Parameters
    ----------
    places
        A folder or bundle for each manoeuvre, or several of them.
    setup : path
        Of ``--setup``.
    options : sequence of str
        More of ``gracecg level1 estimate``, for all.
    how
        As of `run`.
    """
    alone = [[place] if isinstance(place, (str, os.PathLike)) else list(place) for place in places]
    outcomes = run([Task(["level1", "estimate", *map(str, place), "--setup", str(setup), *options, "--format", "json"])
                    for place in alone], executor, **how)
    return [json.loads(outcome.text) for outcome in outcomes]
