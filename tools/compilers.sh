#!/usr/bin/env bash
# Builds gracecg with several compilers, runs the tests with each, and compares results with the first one's.
#
#   tools/compilers.sh [--quick] COMPILER...          with compilers that are installed, as gfortran-15 flang-22
#   tools/compilers.sh --chroot DIR COMPILER...       in a Debian sid chroot, made below DIR if it is not there (as
#                                                     root; needs debootstrap), with the packages of the compilers and
#                                                     the genuine test-drive of Debian in place of tools/testdrive
#
# The last lines are a table in Markdown: tests passed and failed, warnings, and the greatest relative difference of
# verify's curves, of the six cases' estimates by all algorithms, and of the bound, from the first compiler's.
# Results stay in build/compilers. Status 1 when a test fails or a difference is above its limit (that of
# tools/compare_numbers.py). --quick leaves out the tests that take long. JOBS: of the build (1).
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
readonly OUT=build/compilers

usage() {
    sed -n '4,7s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
}

# A chroot with the compilers, and this tool in it.
in_chroot() {
    local root=$1 packages='cmake ninja-build libopenblas-dev pkgconf python3 libfortran-testdrive-dev' compiler
    shift
    [ $# -gt 0 ] || usage
    if [ ! -e "$root/bin/sh" ]; then
        command -v debootstrap >/dev/null || { echo 'compilers: install debootstrap' >&2; exit 1; }
        debootstrap --variant=minbase sid "$root" "${MIRROR:-http://deb.debian.org/debian}"
    fi
    for compiler in "$@"; do
        case $compiler in
            flang-*) packages+=" $compiler clang-${compiler#flang-} libomp-${compiler#flang-}-dev" ;;
            -*) ;;
            *) packages+=" $compiler" ;;
        esac
    done
    # A snapshot of sid may be older than its signature lasts.
    # shellcheck disable=SC2086 # several words are meant
    chroot "$root" sh -c 'apt-get -o Acquire::Check-Valid-Until=false update -qq && exec env \
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@"' sh $packages >/dev/null
    mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"    # a test needs a folder that nobody can write
    mkdir -p "$root/gracecg"
    find "$root/gracecg" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
    git ls-files -co --exclude-standard | tar cf - -T - | tar xmf - -C "$root/gracecg"
    exec chroot "$root" env JOBS="${JOBS:-1}" /gracecg/tools/compilers.sh "$@"
}

# The flags for the genuine test-drive, where Debian's has a module for the compiler.
genuine_testdrive() {
    local family=gnu modules library
    case $1 in flang*) family=flang ;; esac
    modules=$(compgen -G "/usr/lib/*/fortran/${family/gnu/gfortran}-mod-*/testdrive" | head -1) || return 0
    library=$(compgen -G "/usr/lib/*/fortran/$family/libtest-drive.a" | head -1) || return 0
    # A module file of another version of the compiler may not be read: try.
    printf 'program t\nuse testdrive\nend program t\n' >"$OUT/try.f90"
    "$1" -I"$modules" -c "$OUT/try.f90" -o "$OUT/try.o" 2>/dev/null || return 0
    printf '%s\n%s\n' "-DTESTDRIVE_LIBRARY=$library" "-DTESTDRIVE_MODULES=$modules"
}

build() {
    local compiler=$1 folder=$OUT/$1 flags=()
    case $compiler in gfortran*) flags=('-DCMAKE_Fortran_FLAGS=-Wall -Wextra -std=f2018 -pedantic') ;; esac
    mapfile -t testdrive <<<"$(genuine_testdrive "$compiler")"
    [ -n "${testdrive[0]}" ] || testdrive=()
    cmake -S . -B "$folder" -G Ninja -DCMAKE_Fortran_COMPILER="$compiler" \
        -DBUILD_SHARED_LIBS=OFF -DGRACECG_TESTS=ON "${flags[@]}" "${testdrive[@]}" >"$folder.log" 2>&1
    cmake --build "$folder" -j"${JOBS:-1}" >>"$folder.log" 2>&1
}

case ${1:-} in
    --chroot) [ $# -gt 1 ] || usage; in_chroot "${@:2}" ;;
    -h | --help) usage ;;
esac
quick=()
[ "${1:-}" != --quick ] || { quick=(--fast); shift; }
[ $# -gt 0 ] || usage
mkdir -p "$OUT"
status=0
table='| compiler | tests | warnings | verify | estimates | bound |'$'\n''|---|---|---|---|---|---|'$'\n'
for compiler in "$@"; do
    echo "== $compiler"
    if ! build "$compiler"; then
        grep -n -m 20 -i 'error' "$OUT/$compiler.log" || true
        table+="| $compiler | does not compile ($OUT/$compiler.log) | | | | |"$'\n'
        status=1
        continue
    fi
    (
        # flang has parts of texts on the stack, and two tests read lines of 10 MB.
        case $compiler in flang*) ulimit -s unlimited ;; esac
        "$OUT/$compiler/tester" "${quick[@]}" >"$OUT/$compiler.tests" 2>&1
    ) || status=1
    tests=$(grep -E '^[0-9]+ passed, [0-9]+ failed$' "$OUT/$compiler.tests" | tail -1 || true)
    grep FAILED "$OUT/$compiler.tests" || true
    warnings=$(grep -c -i 'warning: ' "$OUT/$compiler.log" || true)
    rm -rf "$OUT/$compiler/results"
    python3 tools/check_builds.py --compute "$OUT/$compiler/gracecg" "$OUT/$compiler/results" || status=1
    differences=$(python3 tools/compare_numbers.py --parts 'verify*/verify_*.csv' 'estimate_*.csv' 'bound_*.csv' \
        "$OUT/$1/results" "$OUT/$compiler/results") || status=1
    table+="| $("$compiler" --version | head -1) | ${tests:-broke off} | $warnings | $differences |"$'\n'
done
printf '\n%s' "$table"
exit "$status"
