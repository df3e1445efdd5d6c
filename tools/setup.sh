#!/usr/bin/env bash
# Installs what gracecg is built with, where it is missing, and prints the path of the fpm to use.
#
#   tools/setup.sh           what builds: gfortran, OpenBLAS (found through pkg-config, as fpm does), and
#                            fpm 0.12 or later; prints the path of fpm
#   tools/setup.sh ford      what makes the documentation: FORD; prints the path of a Python that has it
#   tools/setup.sh checks    what .ci/run checks the installed library with: valgrind, g++, groff, patch,
#                            mpirun (Open MPI)
#   tools/setup.sh pages     what makes the pages of --report: Jinja2 and matplotlib; prints the path of a Python that
#                            has them and finds python/gracecg. build/bin/gracecg takes this one by itself
#   tools/setup.sh browser   what tools/check_pages.py looks at the pages with: Chromium, and axe-core
#
# On Debian the packages come from apt-get, as root or through a sudo that asks no password; fpm,
# FORD, the pages' packages and axe-core come from PyPI into .venv. Whatever it does it says on standard error; with everything in place
# it says nothing. Status 1, with what to do, when it cannot help.
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."

readonly FPM_OLDEST=0.12.0
readonly FPM_INSTALLED=0.12.0
readonly FORD=7.0.13    # exactly this one: tools/api_docs.py looks into it
readonly AXE=0.1.8      # of the package axe-playwright-python, which carries axe-core 4.12.1

say() {
    printf 'setup: %s\n' "$@" >&2
}

# The first fpm that is recent enough: that of .venv, else that of PATH.
find_fpm() {
    local candidate version
    for candidate in "$PWD/.venv/bin/fpm" "$(command -v fpm)"; do
        [ -x "$candidate" ] || continue
        version=$("$candidate" --version 2>/dev/null | sed -n 's/^Version: *\([0-9.]*\).*/\1/p') || continue
        [ -n "$version" ] || continue
        if printf '%s\n%s\n' "$FPM_OLDEST" "$version" | sort -V -C; then
            printf '%s\n' "$candidate"
            return 0
        fi
    done
    return 1
}

# The first Python that has the FORD wanted.
find_ford() {
    local candidate version
    for candidate in "$PWD/.venv/bin/python" "$(command -v python3)"; do
        [ -x "$candidate" ] || continue
        version=$("$candidate" -c 'import ford; print(ford.__version__)' 2>/dev/null) || continue
        if [ "$version" = "$FORD" ]; then
            printf '%s\n' "$candidate"
            return 0
        fi
    done
    return 1
}

# Whether .venv has the axe-core wanted.
find_axe() {
    compgen -G ".venv/lib/python*/site-packages/axe_playwright_python-$AXE.dist-info" >/dev/null
}

# Whether .venv makes pages.
find_pages() {
    [ -x .venv/bin/python ] && .venv/bin/python -c 'import gracecg.pages' 2>/dev/null
}

can_make_venv() {
    python3 -c 'import ensurepip, venv' 2>/dev/null
}

# The Debian packages of what is missing for a purpose, on one line; python3-venv is needed to install
# from PyPI.
missing_packages() {
    local packages=''
    case $1 in
        build)
            command -v "${FPM_FC:-gfortran}" >/dev/null || packages+=' gfortran'
            command -v pkg-config >/dev/null || packages+=' pkg-config'
            pkg-config --exists openblas 2>/dev/null || packages+=' libopenblas-dev'
            find_fpm >/dev/null || can_make_venv || packages+=' python3-venv'
            ;;
        ford)
            find_ford >/dev/null || can_make_venv || packages+=' python3-venv'
            ;;
        pages)
            find_pages || can_make_venv || packages+=' python3-venv'
            ;;
        browser)
            command -v chromium >/dev/null || packages+=' chromium'
            find_axe || can_make_venv || packages+=' python3-venv'
            ;;
        checks)
            command -v valgrind >/dev/null || packages+=' valgrind'
            command -v c++ >/dev/null || packages+=' g++'
            command -v groff >/dev/null || packages+=' groff-base'
            command -v patch >/dev/null || packages+=' patch'
            command -v mpirun >/dev/null || packages+=' openmpi-bin'
            can_make_venv || packages+=' python3-venv'
            ;;
    esac
    printf '%s\n' "${packages# }"
}

# What to install by hand, after the reason why this script does not.
explain_packages() {
    say "missing here: $1" "$2"
    if command -v apt-get >/dev/null; then
        say "  apt-get install $1   (as root)"
    else
        say '  Fedora: dnf install gcc-gfortran openblas-devel pkgconf-pkg-config python3' \
            '  Arch: pacman -S gcc-fortran openblas pkgconf python' \
            '  elsewhere: gfortran, python3 with venv, and OpenBLAS so that "pkg-config --exists openblas" holds'
    fi
}

install_packages() {
    local packages=$1 as_root=''
    if ! command -v apt-get >/dev/null; then
        explain_packages "$packages" '(names of Debian packages). This machine has no apt-get; please install them, then try again:'
        return 1
    fi
    if [ "$(id -u)" -ne 0 ]; then
        if ! sudo -n true 2>/dev/null; then
            explain_packages "$packages" 'Installing takes root. Please have this done, then try again:'
            return 1
        fi
        as_root='sudo -n'
    fi
    say "installing $packages with apt-get (a few minutes at most)"
    local log
    log=$(mktemp)
    # Word splitting of $as_root and $packages is meant. A failed update matters only if the
    # installation fails too.
    # shellcheck disable=SC2086
    if ! {
        $as_root apt-get -o DPkg::Lock::Timeout=120 update || true
        $as_root env DEBIAN_FRONTEND=noninteractive \
            apt-get -o DPkg::Lock::Timeout=120 install -y $packages
    } >"$log" 2>&1 </dev/null; then
        tail -n 15 "$log" >&2
        rm -f "$log"
        explain_packages "$packages" 'apt-get could not install it (its last lines stand above). Is there a network? By hand:'
        return 1
    fi
    rm -f "$log"
}

install_fpm() {
    say "no fpm $FPM_OLDEST or later here: installing fpm $FPM_INSTALLED from PyPI into .venv"
    if { [ -x .venv/bin/python ] || python3 -m venv --clear .venv >&2; } &&
        .venv/bin/python -m pip install -qq --disable-pip-version-check "fpm==$FPM_INSTALLED" >&2 &&
        find_fpm >/dev/null; then
        return 0
    fi
    say "fpm $FPM_INSTALLED could not be installed from PyPI (the reason stands above). Is there a network?" \
        "Otherwise put an fpm of version $FPM_OLDEST or later on PATH (https://fpm.fortran-lang.org), then try again."
    return 1
}

install_ford() {
    say "no FORD $FORD here: installing it from PyPI into .venv"
    if { [ -x .venv/bin/python ] || python3 -m venv .venv >&2; } &&
        .venv/bin/python -m pip install -qq --disable-pip-version-check "ford==$FORD" >&2 &&
        find_ford >/dev/null; then
        return 0
    fi
    say "FORD $FORD could not be installed from PyPI (the reason stands above). Is there a network?"
    return 1
}

# python/gracecg is used where it stands.
install_pages() {
    say "installing Jinja2 and matplotlib from PyPI into .venv"
    if { [ -x .venv/bin/python ] || python3 -m venv .venv >&2; } &&
        .venv/bin/python -m pip install -qq --disable-pip-version-check jinja2 matplotlib >&2 &&
        .venv/bin/python -c 'import pathlib, sysconfig
pathlib.Path(sysconfig.get_path("purelib"), "gracecg.pth").write_text(str(pathlib.Path("python").resolve()) + "\n")' &&
        find_pages; then
        return 0
    fi
    say "Jinja2 and matplotlib could not be installed from PyPI (the reason stands above). Is there a network?"
    return 1
}

# Without what the package needs itself: only the file axe.min.js is used.
install_axe() {
    say "no axe-core here: installing it from PyPI into .venv"
    if { [ -x .venv/bin/python ] || python3 -m venv .venv >&2; } &&
        .venv/bin/python -m pip install -qq --disable-pip-version-check --no-deps "axe-playwright-python==$AXE" >&2 &&
        find_axe; then
        return 0
    fi
    say "axe-core could not be installed from PyPI (the reason stands above). Is there a network?"
    return 1
}

# Installs the missing Debian packages for a purpose, if there are any.
need_packages() {
    local packages
    packages=$(missing_packages "$1")
    [ -n "$packages" ] || return 0
    install_packages "$packages"
    packages=$(missing_packages "$1")
    if [ -n "$packages" ]; then
        explain_packages "$packages" 'Not found although apt-get installed it: see PATH and PKG_CONFIG_PATH. By hand:'
        exit 1
    fi
}

case ${1:-} in
    '')
        if [ -n "${FPM_FC:-}" ] && ! command -v "$FPM_FC" >/dev/null; then
            say "the compiler $FPM_FC, named by the environment variable FPM_FC, is not found; unset FPM_FC to use gfortran"
            exit 1
        fi
        need_packages build
        find_fpm >/dev/null || install_fpm
        find_fpm
        ;;
    ford)
        need_packages ford
        find_ford >/dev/null || install_ford
        find_ford
        ;;
    checks)
        need_packages checks
        ;;
    pages)
        need_packages pages
        find_pages || install_pages
        printf '%s\n' "$PWD/.venv/bin/python"
        ;;
    browser)
        need_packages browser
        find_axe || install_axe
        ;;
    *)
        say "usage: tools/setup.sh [ford|checks|pages|browser]"
        exit 2
        ;;
esac
