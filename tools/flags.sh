#!/usr/bin/env bash
# Prints the compiler flags that `make` and tools/install.sh add to fpm's release profile, by the environment variable
# FPM_FFLAGS: the user's own of that name, and those for the processor of this machine, as far as the compiler knows them.
#
#   PORTABLE=1    none for the processor: what is built runs on every machine of its kind
set -euo pipefail

flags=${FPM_FFLAGS:-}
if [ -z "${PORTABLE:-}" ]; then
    case $(uname -m) in
        x86_64 | amd64 | i?86) native=-march=native ;;
        *) native=-mcpu=native ;;
    esac
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    printf 'end\n' >"$folder/try.f90"
    # Known is what it compiles with without a word: some compilers only warn of a flag that they do not know.
    if said=$("${FPM_FC:-gfortran}" "$native" -c "$folder/try.f90" -o "$folder/try.o" 2>&1) && [ -z "$said" ]; then
        flags="$native $flags"
    fi
fi
printf '%s\n' "${flags% }"
