#!/usr/bin/env bash
# Builds gracecg for another processor by Debian's cross compiler and runs tests of readers and numbers under qemu's user emulation.
#
#   tools/emulated.sh s390x DIR [SUITE ...]     big-endian; likewise arm64, ppc64el
#
# As root, in a Debian bookworm chroot, made below DIR if it is not there (needs debootstrap). Without SUITES those of READERS.
# Status 1 when a test fails. Half an hour: emulation is some 20 times slower.
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
readonly READERS='arithmetic quaternion lanes lapack runge-kutta time earth-orientation decimal text file table csv json settings
observation-files geopotential geomagnetic-field thermosphere wind sun earth-radiation fourier statistics spectrum random coloured-noise
accelerometer star-camera magnetometer torques level1-reader level1-writer level1-time level1-check level1-bundles level1-parts level1-results
level1-fuzz level1-simulated-files model-commands c-models library'

[ $# -ge 2 ] || { sed -n '4,7s/^# *//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
architecture=$1 root=$2
shift 2
case $architecture in       # Debian's names; those of its tools, of qemu
    s390x) triplet=s390x-linux-gnu emulator=s390x ;;
    arm64) triplet=aarch64-linux-gnu emulator=aarch64 ;;
    ppc64el) triplet=powerpc64le-linux-gnu emulator=ppc64le ;;
    *) echo "emulated: s390x, arm64 or ppc64el, not $architecture" >&2; exit 2 ;;
esac
if [ ! -e "$root/bin/sh" ]; then
    command -v debootstrap >/dev/null || { echo 'emulated: install debootstrap' >&2; exit 1; }
    debootstrap --variant=minbase bookworm "$root" "${MIRROR:-http://deb.debian.org/debian}"
fi
mount -t proc proc "$root/proc"       # a folder in which nobody may write
trap 'umount "$root/proc"' EXIT
cp /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir -p "$root/gracecg" "$root/build-$architecture"
# The files as they stand here
git ls-files -z --cached --others --exclude-standard | tar --null -cT - | tar -xC "$root/gracecg"
# shellcheck disable=SC2016 # the inner shell expands
chroot "$root" bash -euc '
    dpkg --add-architecture "$1"
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends cmake ninja-build qemu-user-static \
        "gfortran-$2" "libopenblas-dev:$1" "libgomp1:$1" "zlib1g:$1" >/dev/null
    cd /gracecg
    lapack=/usr/lib/$2/libopenblas.so tree=/build-$1 emulator=$3
    cmake -S . -B "$tree" -G Ninja -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR="$1" -DCMAKE_Fortran_COMPILER="$2-gfortran" \
        -DCMAKE_CROSSCOMPILING_EMULATOR="/usr/bin/qemu-$3-static" -DBLAS_LIBRARIES="$lapack" -DLAPACK_LIBRARIES="$lapack" \
        -DCMAKE_BUILD_TYPE=None -DCMAKE_Fortran_FLAGS=-O1 -DBUILD_SHARED_LIBS=OFF -DGRACECG_TESTS=ON >"$tree.log"
    ninja -C "$tree" ${JOBS:+-j"$JOBS"} >>"$tree.log"
    failed=0
    export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
    shift 3
    for suite in "$@"; do
        echo "== $suite"
        "qemu-$emulator-static" "$tree/tester" "$suite" >"$tree.txt" 2>&1 || failed=1
        grep -A2 -E "FAILED|^[0-9]+ passed" "$tree.txt" || failed=1
    done
    exit "$failed"' emulated "$architecture" "$triplet" "$emulator" ${@:-$READERS}
