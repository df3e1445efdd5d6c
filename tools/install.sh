#!/usr/bin/env bash
# Builds gracecg with fpm's release profile and installs it; `make install` calls it.
#
#   tools/install.sh              installs
#   tools/install.sh --library    installs nothing: leaves the two libraries in build/library
#   tools/install.sh --remove     removes what it installs
#
# By environment: PREFIX (/usr/local), BINDIR, LIBDIR, INCLUDEDIR, MANDIR (below PREFIX), DESTDIR (put
# before all of them, for packages); PORTABLE=1: not for this machine's processor (tools/flags.sh), for packages that
# leave the machine. On x86-64 with the C library of GNU the shared library is then built for newer processors, too;
# HWCAPS says for which (x86-64-v3 x86-64-v4; empty: none). The loader takes the best that the processor runs (ld.so(8)).
#
#   BINDIR/gracecg                    the program
#   LIBDIR/libgracecg.a               the static library
#   LIBDIR/libgracecg.so.VERSION      the shared library, with its links .so.MAJOR and .so
#   LIBDIR/glibc-hwcaps/LEVEL         the same for newer processors
#   LIBDIR/pkgconfig/gracecg.pc       compiler and linker options
#   INCLUDEDIR/gracecg.h              the C interface
#   INCLUDEDIR/gracecg/gracecg.mod    the Fortran interface: the module gracecg alone
#   MANDIR/man1/gracecg.1             the manual page
#   PREFIX/share/bash-completion/completions/gracecg, PREFIX/share/zsh/site-functions/_gracecg
#   PREFIX/share/doc/gracecg          the licence; the sources and rights of the data
#
# fpm puts all modules of src/ into one archive, those of the program (src/cli) too. The library is what the
# umbrella src/gracecg.f90 and the interfaces to C and F77 use, directly or not: the other objects are left
# out. The shared library is made of the objects of the static one: fpm's release profile compiles them
# position-independent. It shows the symbols of the interfaces only: C, F77 and module procedures.
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."

prefix=${PREFIX:-/usr/local}
bindir=${BINDIR:-$prefix/bin}
libdir=${LIBDIR:-$prefix/lib}
includedir=${INCLUDEDIR:-$prefix/include}
mandir=${MANDIR:-$prefix/share/man}
destdir=${DESTDIR:-}
version=$(sed -n 's/^version *= *"\(.*\)"/\1/p' fpm.toml)
soname=libgracecg.so.${version%%.*}
readonly prefix bindir libdir includedir mandir destdir version soname
readonly stage=build/stage library=build/library docdir=$prefix/share/doc/gracecg
hwcaps=${HWCAPS-}
if [ -n "${PORTABLE:-}" ] && [ -z "${HWCAPS+set}" ] && [ "$(uname -sm)" = 'Linux x86_64' ] &&
    getconf GNU_LIBC_VERSION >/dev/null 2>&1; then
    hwcaps='x86-64-v3 x86-64-v4'
fi
readonly hwcaps
readonly bash_completion=$prefix/share/bash-completion/completions/gracecg
readonly zsh_completion=$prefix/share/zsh/site-functions/_gracecg

for folder in "$prefix" "$bindir" "$libdir" "$includedir" "$mandir"; do
    case $folder in
        /*) ;;
        *)
            printf 'install: "%s" is not an absolute path; write for example PREFIX="$PWD/%s"\n' "$folder" "$folder" >&2
            exit 1
            ;;
    esac
done

# The installed files, without DESTDIR; arguments: the levels of processors.
installed_files() {
    local licence level
    printf '%s\n' "$bindir/gracecg" "$libdir/libgracecg.a" "$libdir/libgracecg.so" "$libdir/$soname" \
        "$libdir/libgracecg.so.$version" "$libdir/pkgconfig/gracecg.pc" "$includedir/gracecg.h" \
        "$includedir/gracecg/gracecg.mod" "$mandir/man1/gracecg.1" "$bash_completion" "$zsh_completion" \
        "$docdir/LICENSE" "$docdir/DATA.md"
    for level in "$@"; do
        printf '%s\n' "$libdir/glibc-hwcaps/$level/$soname" "$libdir/glibc-hwcaps/$level/libgracecg.so.$version"
    done
    for licence in LICENSES/*; do
        printf '%s\n' "$docdir/$licence"
    done
}

# The library's dependencies, as the linker wants them.
dependencies() {
    printf '%s -lgfortran -lgomp -lm' "$(pkg-config --libs openblas | sed 's/ *$//')"
}

# The way from one folder to another, so that the installed tree can be moved.
way() {
    realpath --canonicalize-missing --relative-to="$1" "$2"
}

write_pkg_config() {
    cat <<EOF
prefix=\${pcfiledir}/$(way "$libdir/pkgconfig" "$prefix")
libdir=\${pcfiledir}/$(way "$libdir/pkgconfig" "$libdir")
includedir=\${pcfiledir}/$(way "$libdir/pkgconfig" "$includedir")
moddir=\${includedir}/gracecg

Name: gracecg
Description: Centre-of-gravity calibration of GRACE-type satellites: models, simulation, estimation
Version: $version
Cflags: -I\${includedir} -I\${moddir}
Libs: -L\${libdir} -lgracecg
Libs.private: $(dependencies)
EOF
}

# The sources of the library: what its doors use, directly or not, with the submodules of these modules. A module
# gracecg_FLOOR_ROOM stands in src/FLOOR, in ROOM.f90.
library_sources() {
    local waiting=(src/gracecg.f90 src/interface/*.f90) seen=' ' source floor room submodule
    while [ "${#waiting[@]}" -gt 0 ]; do
        source=${waiting[0]}
        waiting=("${waiting[@]:1}")
        case $seen in *" $source "*) continue ;; esac
        seen+="$source "
        printf '%s\n' "$source"
        while read -r floor room; do
            waiting+=("$(find "src/$floor" -name "$room.f90")")
            while IFS= read -r submodule; do
                waiting+=("$submodule")
            done < <(grep -lr --include='*.f90' "^submodule *(gracecg_${floor}_$room)" src)
        done < <(sed -n 's/^ *use gracecg_\([a-z0-9]*\)_\([a-z0-9_]*\).*/\1 \2/p' "$source" | sort -u)
    done
}

# Takes out of an archive of fpm's what does not belong to the library: fpm names an object after its source.
leave_library() {
    local others
    others=$(ar t "$1" | grep -vxFf <(library_sources | sed 's|/|_|g; s|$|.o|'))
    # shellcheck disable=SC2086 # several words are meant
    ar d "$1" $others
}

# Both libraries, in a folder: STAGE LIBRARY FLAGS.
build_libraries() {
    FPM_FFLAGS=$3 "$fpm" install --profile release --prefix "$1" >build/install.log 2>&1 || {
        cat build/install.log >&2
        return 1
    }
    mkdir -p "$2"
    cp "$1/lib/libgracecg.a" "$2/"
    leave_library "$2/libgracecg.a"
    # shellcheck disable=SC2046 # several words are meant
    "${FPM_FC:-gfortran}" -shared -fopenmp -Wl,-soname,"$soname" -Wl,-z,defs -Wl,--version-script=tools/cmake/exports.map \
        -o "$2/libgracecg.so.$version" -Wl,--whole-archive "$2/libgracecg.a" \
        -Wl,--no-whole-archive $(dependencies)
}

build() {
    local fpm level
    fpm=$(tools/setup.sh)
    # fpm does not link a program anew when another of its commands has rebuilt the library since.
    rm -rf build/gfortran_*/app/gracecg "$stage" "$library"
    for level in $hwcaps; do
        build_libraries "$stage/$level" "$library/$level" "$(tools/flags.sh "$level")"
    done
    build_libraries "$stage" "$library" "$(tools/flags.sh)"
    write_pkg_config >"$stage/gracecg.pc"
    tools/man_page.sh "$stage/bin/gracecg" >"$stage/gracecg.1"
    "$stage/bin/gracecg" completion bash >"$stage/completion.bash"
    "$stage/bin/gracecg" completion zsh >"$stage/completion.zsh"
}

copy() {
    local level licence
    install -D -m 755 "$stage/bin/gracecg" "$destdir$bindir/gracecg"
    install -D -m 644 "$library/libgracecg.a" "$destdir$libdir/libgracecg.a"
    install -D -m 644 "$library/libgracecg.so.$version" "$destdir$libdir/libgracecg.so.$version"
    ln -sfn "libgracecg.so.$version" "$destdir$libdir/$soname"
    ln -sfn "$soname" "$destdir$libdir/libgracecg.so"
    for level in $hwcaps; do
        install -D -m 644 "$library/$level/libgracecg.so.$version" "$destdir$libdir/glibc-hwcaps/$level/libgracecg.so.$version"
        ln -sfn "libgracecg.so.$version" "$destdir$libdir/glibc-hwcaps/$level/$soname"
    done
    install -D -m 644 "$stage/gracecg.pc" "$destdir$libdir/pkgconfig/gracecg.pc"
    install -D -m 644 include/gracecg.h "$destdir$includedir/gracecg.h"
    install -D -m 644 "$stage/include/gracecg.mod" "$destdir$includedir/gracecg/gracecg.mod"
    install -D -m 644 "$stage/gracecg.1" "$destdir$mandir/man1/gracecg.1"
    install -D -m 644 "$stage/completion.bash" "$destdir$bash_completion"
    install -D -m 644 "$stage/completion.zsh" "$destdir$zsh_completion"
    install -D -m 644 LICENSE "$destdir$docdir/LICENSE"
    install -D -m 644 data/README.md "$destdir$docdir/DATA.md"
    for licence in LICENSES/*; do
        install -D -m 644 "$licence" "$destdir$docdir/$licence"
    done
}

remove() {
    local file
    installed_files x86-64-v2 x86-64-v3 x86-64-v4 | while IFS= read -r file; do
        rm -f -- "$destdir$file"
    done
    rmdir -- "$destdir$libdir"/glibc-hwcaps/* "$destdir$libdir/glibc-hwcaps" 2>/dev/null || true
    rmdir -- "$destdir$includedir/gracecg" "$destdir$docdir/LICENSES" "$destdir$docdir" 2>/dev/null || true
}

# The loader's cache, when the library went into a folder of the system.
refresh_loader() {
    if [ -z "$destdir" ] && [ "$(id -u)" -eq 0 ] && command -v ldconfig >/dev/null; then
        ldconfig
    fi
}

case ${1:-} in
    '')
        build
        copy
        refresh_loader
        # shellcheck disable=SC2086 # several words are meant
        installed_files $hwcaps | sed "s|^|installed: $destdir|"
        ;;
    --library)
        build
        ;;
    --remove)
        remove
        refresh_loader
        ;;
    *)
        echo 'usage: tools/install.sh [--library | --remove]' >&2
        exit 2
        ;;
esac
