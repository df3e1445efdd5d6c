#!/usr/bin/env python3
"""Kills a campaign at random moments and goes on with it, again and again.

    tools/check_resume.py PROGRAM [TIMES] [SEED]

A small campaign is done once without interruption. Then the same campaign is killed TIMES times (20) by SIGINT, SIGTERM
or SIGKILL at a random moment and gone on with by --resume, until it is complete; now and then the last line of its
journal is torn, as a crash of the machine would. The runs file and the table must be those of the first campaign, to the
byte, with any number of threads; the exit status of a stopped campaign 130 or 143; a campaign of other settings must
be refused. Last, the same for shards, put together by `merge`.
"""
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

CASES = ["front-3", "back-1"]
ALGORITHMS = "assest-fde,ascfest"
KINDS = (".csv", ".csv.meta.json", "_table.csv", "_table.csv.meta.json")
STATUS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGKILL: -9}


def defaults():
    """A shell in the background sets SIGINT aside; the program would inherit that."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def words(program, runs, files, *more):
    return [program, "montecarlo", *CASES, "--algorithms", ALGORITHMS, "--runs", str(runs), *files, *more]


def start(command, folder):
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                            preexec_fn=defaults)


def expect(truth, text):
    if not truth:
        sys.exit(f"check_resume: {text}")


def complete(command, folder):
    process = start(command, folder)
    message = process.communicate()[1]
    expect(process.returncode == 0, f"{' '.join(command)}: status {process.returncode}: {message}")


def tear(journal, chance):
    """Cuts the last line of a journal somewhere within."""
    text = journal.read_bytes()
    body = text.rstrip(b"\n")
    last = body.rfind(b"\n") + 1
    if body[last:last + 1] in (b"#", b"") or body[last:].startswith(b"case,"):
        return
    journal.write_bytes(text[:chance.randint(last + 1, len(text) - 1)])


def interrupted(program, runs, folder, name, kills, duration, chance, *more):
    """A campaign that is killed so often, and gone on with until it is complete. Says how often each signal hit."""
    hit = {number: 0 for number in STATUS}
    runs_file, journal = folder / f"{name}.csv", folder / f"{name}.csv.part"
    while True:
        resume = ["--resume", runs_file.name] if journal.exists() else []
        threads = ["--threads", str(chance.randint(1, 3))]
        process = start(words(program, runs, ["--runs-out", runs_file.name, "--out", f"{name}_table.csv"], *more,
                              *threads, *resume), folder)
        if sum(hit.values()) < kills:
            # between the begin of the first runs and the end of all
            moment = chance.uniform(0, max(duration, 0.05))
            time.sleep(moment)
            number = chance.choice(list(STATUS))
            process.send_signal(number)
            message = process.communicate()[1]
            if process.returncode == 0:
                # it was quicker: all is done. From the beginning again
                for kind in KINDS:
                    (folder / (name + kind)).unlink()
                continue
            # before the program has come so far as to catch a signal, the system kills it
            expect(process.returncode in (STATUS[number], -number), f"{number.name}: status {process.returncode}: {message}")
            if runs_file.exists():      # all runs were done, if not their table
                expect(content(folder, name, KINDS[0]) == content(folder, "whole", KINDS[0]),
                       "an incomplete campaign has a runs file under its final name")
                for kind in (*KINDS, ".csv.part"):
                    (folder / (name + kind)).unlink(missing_ok=True)
                continue
            hit[number] += 1
            if journal.exists() and chance.random() < 0.3:
                tear(journal, chance)
        else:
            message = process.communicate()[1]
            expect(process.returncode == 0, f"status {process.returncode}: {message}")
            expect(not journal.exists(), f"{journal.name} is still there")
            return hit


def main():
    program = os.path.abspath(sys.argv[1])
    kills = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else random.randrange(2**32)
    chance = random.Random(seed)
    print(f"random moments of seed {seed}")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        runs = 40
        began = time.monotonic()
        complete(words(program, runs, ["--runs-out", "whole.csv", "--out", "whole_table.csv"]), folder)
        duration = time.monotonic() - began
        whole = {kind: content(folder, "whole", kind) for kind in KINDS}

        hit = interrupted(program, runs, folder, "killed", kills, duration, chance)
        for kind, text in whole.items():
            expect(content(folder, "killed", kind) == text, f"killed{kind} differs from whole{kind}")
        print(f"{sum(hit.values())} interruptions ({', '.join(f'{n.name} {k}' for n, k in hit.items())}): "
              f"runs file and table as of a campaign never stopped, {len(whole['.csv'])} bytes")

        # what belongs to another campaign is not gone on with
        for other in (["--seed", "2"], ["--shard", "1/2"], ["--without", "systematic"]):
            process = start(words(program, runs, [], "--resume", "killed.csv", *other), folder)
            message = process.communicate()[1]
            expect(process.returncode == 1 and "different" in message, f"{other} is taken: {message}")
        expect(content(folder, "killed", ".csv") == whole[".csv"], "a refused campaign changed the runs file")

        for shard in (1, 2):
            interrupted(program, runs, folder, f"shard{shard}", 2, duration/2, chance, "--shard", f"{shard}/2")
        subprocess.run([program, "merge", "shard2.csv", "shard1.csv", "--runs-out", "merged.csv"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        expect(content(folder, "merged", ".csv") == whole[".csv"], "merged shards differ from the whole")
        print("interrupted shards, merged, are the whole campaign; other seeds, shards and switches are refused")


def content(folder, name, kind):
    """A file of a campaign; of what stands beside it all but its own name, the command line and what it went on with."""
    text = (folder / (name + kind)).read_text().replace(f'"{name}', '"')
    if kind.endswith(".json"):
        about = json.loads(text)
        del about["command_line"], about["input_hashes"]
        text = json.dumps(about)
    return text


if __name__ == "__main__":
    main()
