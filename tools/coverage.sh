#!/usr/bin/env bash
# The share of lines of src/, app/ and level1/ that `tester --fast` runs, by gcov; the files and procedures with most lines left out.
#
#   tools/coverage.sh DIR [SUITE ...]       builds below DIR; SUITES in place of all fast tests
#
# A quarter of an hour on two cores. A line that gcov counts but no program runs, as the END of a procedure, counts as gcov has it.
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
[ $# -ge 1 ] || { sed -n '4s/^# *//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
mkdir -p "$1"
folder=$(realpath "$1")
shift
cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_Fortran_FLAGS='-O0 --coverage' -DBUILD_SHARED_LIBS=OFF \
    -DGRACECG_PROGRAM=OFF -DGRACECG_TESTS=ON >"$folder/build.log"
ninja -C "$folder" ${JOBS:+-j"$JOBS"} tester >>"$folder/build.log"
find "$folder" -name '*.gcda' -delete
for suite in "${@:---fast}"; do
    "$folder/tester" "$suite" >>"$folder/tests.log" 2>&1 || { tail -n 3 "$folder/tests.log"; exit 1; }
done
cd "$folder"
find . -name '*.gcno' ! -path '*/tester.dir/*' -print0 | xargs -0 gcov --json-format --stdout 2>/dev/null |
    python3 -c '
import collections, json, sys
root = sys.argv[1] + "/"
lines, procedures = collections.defaultdict(dict), {}
for record in sys.stdin:
    for file in json.loads(record)["files"]:
        name = file["file"].removeprefix(root)
        if name.split("/")[0] not in ("src", "app", "level1"):
            continue
        for line in file["lines"]:
            number = line["line_number"]
            lines[name][number] = lines[name].get(number, 0) + line["count"]
        for f in file["functions"]:
            procedures[name, f["start_line"], f["end_line"]] = f["demangled_name"].split("_MOD_")[-1]

def show(rows):
    for missed, of, name in sorted(rows, reverse=True)[:25]:
        print(f"{missed:5d} of {of:5d}  {name}")

def missed(counts):
    counts = list(counts)
    return sum(count == 0 for count in counts), len(counts)

for top in ("src", "app", "level1", ""):
    left, of = missed(c for name in lines if name.startswith(top) for c in lines[name].values())
    label = top or "all"
    print(f"{label:8s} {100*(1 - left/of):5.1f} % of {of} lines")
print("Lines left out, by file")
show((*missed(found.values()), name) for name, found in lines.items())
print("by procedure")
show((*missed(c for n, c in lines[name].items() if first <= n <= last), f"{name}:{first} {title}")
     for (name, first, last), title in procedures.items())
' "$OLDPWD"
