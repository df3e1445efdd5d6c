#!/usr/bin/env bash
# Writes FOLDER/build_commit.inc, which takes the place of include/build_commit.inc: the commit of the sources, with a plus
# where files differ from it; blank where there is no git. What is up to date is not touched.
#
#   tools/commit.sh FOLDER
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
commit=''
if [ -e "$root/.git" ] && commit=$(git -C "$root" rev-parse --short=12 HEAD 2>/dev/null); then
    [ -z "$(git -C "$root" status --porcelain --untracked-files=no)" ] || commit+=+
fi
line="character(*), parameter :: COMMIT = '$commit'"
file=$1/build_commit.inc
[ -f "$file" ] && [ "$(cat "$file")" = "$line" ] && exit
mkdir -p "$1"
rm -f "$root"/build/gfortran_*/gracecg/app_main.f90.o.digest    # fpm does not see the change: it makes anew what has no digest
printf '%s\n' "$line" >"$file"
