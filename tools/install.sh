#!/usr/bin/env bash
# Builds gracecg with fpm's release profile and installs it; `make install` calls it.
#
#   tools/install.sh              installs
#   tools/install.sh --library    installs nothing: leaves the libraries in build/library
#   tools/install.sh --remove     removes what it installs
#
# By environment: PREFIX (/usr/local), BINDIR, LIBDIR, INCLUDEDIR, MANDIR (below PREFIX), DESTDIR (put
# before all of them, for packages); PORTABLE=1: not for this machine's processor (tools/flags.sh), for packages that
# leave the machine. On x86-64 with the C library of GNU the shared library is then built for newer processors, too;
# HWCAPS says for which (x86-64-v3 x86-64-v4; empty: none). The loader takes the best that the processor runs (ld.so(8)).
#
#   BINDIR/gracecg                    the program
#   LIBDIR/libNAME.a                  the static libraries, NAME gracecg and gracecg_level1
#   LIBDIR/libNAME.so.VERSION         the shared libraries, with links .so.MAJOR and .so
#   LIBDIR/glibc-hwcaps/LEVEL         the same for newer processors
#   LIBDIR/pkgconfig/NAME.pc          compiler and linker options
#   LIBDIR/cmake/gracecg              the package for CMake, find_package(gracecg): the shared libraries
#   INCLUDEDIR/NAME.h                 the C interfaces
#   INCLUDEDIR/gracecg/NAME.mod       the Fortran interfaces: the umbrella modules alone
#   MANDIR/man1/gracecg.1             the manual page
#   PREFIX/share/bash-completion/completions/gracecg
#   PREFIX/share/doc/gracecg          the licence; the sources and rights of the data
#
# fpm puts the objects of all packages into one archive, each named after its source. The library gracecg is those of
# src/, gracecg_level1 those of level1/src without its commands. A shared library is made of the objects of the static
# one: fpm's release profile compiles them position-independent. It shows the symbols of the interfaces only: C, F77 and
# module procedures.
set -euo pipefail
CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."

prefix=${PREFIX:-/usr/local}
bindir=${BINDIR:-$prefix/bin}
libdir=${LIBDIR:-$prefix/lib}
includedir=${INCLUDEDIR:-$prefix/include}
mandir=${MANDIR:-$prefix/share/man}
destdir=${DESTDIR:-}
version=$(sed -n 's/^version *= *"\(.*\)"/\1/p' fpm.toml)
major=${version%%.*}
readonly prefix bindir libdir includedir mandir destdir version major
readonly names='gracecg gracecg_level1'
readonly stage=build/stage library=build/library docdir=$prefix/share/doc/gracecg
hwcaps=${HWCAPS-}
if [ -n "${PORTABLE:-}" ] && [ -z "${HWCAPS+set}" ] && [ "$(uname -sm)" = 'Linux x86_64' ] &&
    getconf GNU_LIBC_VERSION >/dev/null 2>&1; then
    hwcaps='x86-64-v3 x86-64-v4'
fi
readonly hwcaps
readonly bash_completion=$prefix/share/bash-completion/completions/gracecg

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
    local name licence level
    printf '%s\n' "$bindir/gracecg" "$mandir/man1/gracecg.1" "$bash_completion" \
        "$docdir/LICENSE" "$docdir/DATA.md"
    for name in $names; do
        printf '%s\n' "$libdir/lib$name.a" "$libdir/lib$name.so" "$libdir/lib$name.so.$major" "$libdir/lib$name.so.$version" \
            "$libdir/pkgconfig/$name.pc" "$includedir/$name.h" "$includedir/gracecg/$name.mod"
        for level in "$@"; do
            printf '%s\n' "$libdir/glibc-hwcaps/$level/lib$name.so.$major" "$libdir/glibc-hwcaps/$level/lib$name.so.$version"
        done
    done
    printf '%s\n' "$libdir/cmake/gracecg/gracecgConfig.cmake" "$libdir/cmake/gracecg/gracecgConfigVersion.cmake"
    for licence in LICENSES/*; do
        printf '%s\n' "$docdir/$licence"
    done
}

# The library's dependencies, as the linker wants them.
dependencies() {
    printf '%s -lgfortran -lgomp -lm -ldl' "$(pkg-config --libs openblas | sed 's/ *$//')"
}

# The way from one folder to another, so that the installed tree can be moved.
way() {
    realpath --canonicalize-missing --relative-to="$1" "$2"
}

# The pkg-config file of a library: NAME DESCRIPTION LINE...
write_pkg_config() {
    cat <<EOF
prefix=\${pcfiledir}/$(way "$libdir/pkgconfig" "$prefix")
libdir=\${pcfiledir}/$(way "$libdir/pkgconfig" "$libdir")
includedir=\${pcfiledir}/$(way "$libdir/pkgconfig" "$includedir")
moddir=\${includedir}/gracecg

Name: $1
Description: $2
Version: $version
Cflags: -I\${includedir} -I\${moddir}
Libs: -L\${libdir} -l$1
$3
EOF
}

# The package for CMake, of the shared libraries; by find_package a version suits as one that CMakeLists.txt installs.
write_cmake_config() {
    cat <<EOF
# find_package(gracecg): the targets gracecg::gracecg and gracecg::level1.
get_filename_component(gracecg_libdir "\${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
get_filename_component(gracecg_includedir "\${gracecg_libdir}/$(way "$libdir" "$includedir")" ABSOLUTE)
if(NOT TARGET gracecg::gracecg)
    foreach(gracecg_target gracecg level1)
        string(REGEX REPLACE "^level1" "gracecg_level1" gracecg_name \${gracecg_target})
        add_library(gracecg::\${gracecg_target} SHARED IMPORTED)
        set_target_properties(gracecg::\${gracecg_target} PROPERTIES
            IMPORTED_LOCATION "\${gracecg_libdir}/lib\${gracecg_name}.so.$version" IMPORTED_SONAME lib\${gracecg_name}.so.$major
            INTERFACE_INCLUDE_DIRECTORIES "\${gracecg_includedir};\${gracecg_includedir}/gracecg")
    endforeach()
    set_target_properties(gracecg::level1 PROPERTIES INTERFACE_LINK_LIBRARIES gracecg::gracecg)
endif()
EOF
}

write_cmake_version() {
    cat <<EOF
set(PACKAGE_VERSION $version)
if(NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION AND NOT PACKAGE_FIND_VERSION VERSION_LESS ${version%.*})
    set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
if(PACKAGE_FIND_VERSION VERSION_EQUAL PACKAGE_VERSION)
    set(PACKAGE_VERSION_EXACT TRUE)
endif()
EOF
}

# Both libraries as archive and shared, in a folder: STAGE LIBRARY FLAGS.
build_libraries() {
    local archive objects
    tools/commit.sh build/commit
    FPM_FFLAGS=$3 FPM_FC=${FPM_FC:-$PWD/tools/compiler/gfortran} "$fpm" install --profile release --prefix "$1" \
        >build/install.log 2>&1 || {
        cat build/install.log >&2
        return 1
    }
    objects=$(mktemp -d)
    archive=$PWD/$1/lib/libgracecg.a
    (cd "$objects" && ar x "$archive")
    rm -rf "$objects"/level1_src_commands_*
    mkdir -p "$2"
    make_library "$2" gracecg "$objects"/src_*.o
    # A program finds the library that this one needs beside it
    # shellcheck disable=SC2016 # the loader expands
    make_library "$2" gracecg_level1 "$objects"/level1_src_*.o -- "$2/libgracecg.so.$version" -Wl,-rpath,'$ORIGIN'
    rm -rf "$objects"
}

# Makes FOLDER/libNAME.a and libNAME.so.VERSION: FOLDER NAME OBJECT... [-- LIBRARY...], with the libraries that it needs.
make_library() {
    local archive=$1/lib$2.a shared=$1/lib$2.so soname=lib$2.so.$major objects=()
    shift 2
    while [ "$#" -gt 0 ] && [ "$1" != -- ]; do
        objects+=("$1")
        shift
    done
    [ "$#" -eq 0 ] || shift
    rm -f "$archive"
    ar rcs "$archive" "${objects[@]}"
    # shellcheck disable=SC2046 # several words are meant
    "${FPM_FC:-gfortran}" -shared -fopenmp -Wl,-soname,"$soname" -Wl,-z,defs -Wl,--version-script=tools/cmake/exports.map \
        -o "$shared.$version" -Wl,--whole-archive "$archive" -Wl,--no-whole-archive "$@" $(dependencies)
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
    write_pkg_config gracecg 'Centre-of-gravity calibration of GRACE-type satellites: models, simulation, estimation' \
        "Libs.private: $(dependencies)" >"$stage/gracecg.pc"
    write_pkg_config gracecg_level1 'Level-1 data of GRACE and GRACE-FO for gracecg: files, time, frames, estimates' \
        'Requires: gracecg' >"$stage/gracecg_level1.pc"
    write_cmake_config >"$stage/gracecgConfig.cmake"
    write_cmake_version >"$stage/gracecgConfigVersion.cmake"
    tools/man_page.sh "$stage/bin/gracecg" >"$stage/gracecg.1"
}

copy() {
    local name shared level licence
    install -D -m 755 "$stage/bin/gracecg" "$destdir$bindir/gracecg"
    for name in $names; do
        shared=lib$name.so
        install -D -m 644 "$library/lib$name.a" "$destdir$libdir/lib$name.a"
        install -D -m 644 "$library/$shared.$version" "$destdir$libdir/$shared.$version"
        ln -sfn "$shared.$version" "$destdir$libdir/$shared.$major"
        ln -sfn "$shared.$major" "$destdir$libdir/$shared"
        for level in $hwcaps; do
            install -D -m 644 "$library/$level/$shared.$version" "$destdir$libdir/glibc-hwcaps/$level/$shared.$version"
            ln -sfn "$shared.$version" "$destdir$libdir/glibc-hwcaps/$level/$shared.$major"
        done
        install -D -m 644 "$stage/$name.pc" "$destdir$libdir/pkgconfig/$name.pc"
        install -D -m 644 "include/$name.h" "$destdir$includedir/$name.h"
        install -D -m 644 "$stage/include/$name.mod" "$destdir$includedir/gracecg/$name.mod"
    done
    install -D -m 644 "$stage/gracecg.1" "$destdir$mandir/man1/gracecg.1"
    install -D -m 644 packaging/completion.bash "$destdir$bash_completion"
    for name in gracecgConfig gracecgConfigVersion; do
        install -D -m 644 "$stage/$name.cmake" "$destdir$libdir/cmake/gracecg/$name.cmake"
    done
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
    rmdir -- "$destdir$libdir/cmake/gracecg" "$destdir$libdir/cmake" 2>/dev/null || true
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
