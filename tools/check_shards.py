#!/usr/bin/env python3
"""A campaign in four shards under mpirun, and one shard that is lost.

    tools/check_shards.py PROGRAM

`mpirun -n 4` of a shell line that takes the shard's number from Open MPI; the merged files equal those of the whole campaign to the byte. A shard
whose file is missing is named by `merge`, and run again by itself. Needs what `tools/setup.sh checks` installs.
"""
import pathlib
import subprocess
import sys
import tempfile

CAMPAIGN = ["montecarlo", "--cases", "front-1,back-2", "--algorithms", "assest-fde,optimal", "--runs", "6", "--threads", "1"]
LAUNCH = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "4", "sh", "-c",
          'K=$((OMPI_COMM_WORLD_RANK + 1)); exec "$0" "$@" --shard $K/4 --runs-out part_$K.csv']


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)

        def run(*words, launch=()):
            ended = subprocess.run([*launch, program, *words], cwd=work, stdin=subprocess.DEVNULL, text=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
            if ended.returncode != 0:
                sys.exit(f"check_shards: {' '.join(words)} ended with {ended.returncode}: {ended.stderr}")
            return ended.stderr

        def merge(names):
            messages = run("merge", *names, "--out", "merged.csv", "--runs-out", "merged_runs.csv")
            return messages, [(work / name).read_bytes() for name in ("merged.csv", "merged_runs.csv")]

        run(*CAMPAIGN, "--out", "whole.csv", "--runs-out", "whole_runs.csv")
        whole = [(work / name).read_bytes() for name in ("whole.csv", "whole_runs.csv")]
        run(*CAMPAIGN, launch=LAUNCH)
        parts = [f"part_{k}.csv" for k in range(1, 5)]
        missing = [name for name in parts if not (work / name).exists()]
        if missing:
            sys.exit(f"check_shards: mpirun did not leave {missing}")
        if merge(parts)[1] != whole:
            sys.exit("check_shards: the merged shards are not the whole campaign")
        (work / "part_3.csv").unlink()
        messages, _ = merge([name for name in parts if name != "part_3.csv"])
        if "run again shard 3/4" not in " ".join(messages.split()):
            sys.exit(f"check_shards: the missing shard is not named: {messages}")
        run(*CAMPAIGN, "--shard", "3/4", "--runs-out", "part_3.csv")
        if merge(parts)[1] != whole:
            sys.exit("check_shards: with the shard run again the merged shards are not the whole campaign")
    print("four shards under mpirun, and one of them lost and run again: the whole campaign, to the byte")


if __name__ == "__main__":
    main()
