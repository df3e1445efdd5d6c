#!/usr/bin/env bash
# Prints the compiler flags that `make` and tools/install.sh add to fpm's release profile, by the environment variable
# FPM_FFLAGS: the user's own of that name, behind those for a processor.
#
#   tools/flags.sh                for that of this machine, as far as the compiler knows such flags
#   PORTABLE=1 tools/flags.sh     for none: what is built runs on every machine of its kind
#   tools/flags.sh x86-64-v3      for a level of processors
#
# With -ffp-contract=off products are rounded before they are added, whether the processor could do both at once or not, so
# that builds for different processors give the same numbers.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Known is what the compiler takes without a word: some only warn of a flag that they do not know.
known() {
    local said
    printf 'end\n' >"$folder/try.f90"
    said=$("${FPM_FC:-gfortran}" "$1" -c "$folder/try.f90" -o "$folder/try.o" 2>&1) && [ -z "$said" ]
}

flags=''
if [ $# -gt 0 ]; then
    flags="-march=$1"
elif [ -z "${PORTABLE:-}" ]; then
    case $(uname -m) in
        x86_64 | amd64 | i?86) native=-march=native ;;
        *) native=-mcpu=native ;;
    esac
    if known "$native"; then
        flags=$native
    fi
fi
if [ -n "$flags" ] && known -ffp-contract=off; then
    flags+=' -ffp-contract=off'
fi
if [ $# -eq 0 ] && [ -z "${PORTABLE:-}" ]; then
    flags+=' -Ibuild/commit'    # the commit that tools/commit.sh writes; packages are of a version
fi
flags+=" ${FPM_FFLAGS:-}"
read -r flags <<<"$flags" || true
printf '%s\n' "$flags"
