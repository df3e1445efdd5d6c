#!/usr/bin/env bash
# Writes the manual page of the program on standard output, from what its --help texts say.
#
#   tools/man_page.sh PROGRAM > gracecg.1
#
# Status 1 when a command of the overview has no help.
set -euo pipefail
program=$1

# Text for roff: no escapes, no requests, and hyphens that can be copied.
roff() {
    sed -e 's/\\/\\e/g' -e 's/-/\\-/g' -e "s/^\\([.']\\)/\\\\\\&\\1/"
}

# A help text as roff: paragraphs are filled, options become tagged paragraphs, indented lines stay as
# they are.
help_page() {
    roff | awk '
        function leave() { if (verbatim) print ".fi\n.RE"; verbatim = 0 }
        /^$/ { leave(); option = 0; print ".PP"; next }
        /^ +\\-/ {    # an option and, behind two blanks, its text
            leave()
            option = 1
            line = substr($0, match($0, /[^ ]/))
            gap = match(line, /  +/)
            print ".TP\n.B " (gap ? substr(line, 1, gap - 1) : line)
            if (gap) print substr(line, gap + RLENGTH)
            next
        }
        /^ / && option {
            line = substr($0, match($0, /[^ ]/))
            if (line ~ /^\./) line = "\\&" line    # a word that begins with a dot is no request
            print line
            next
        }
        /^ / {
            if (!verbatim) print ".RS 2\n.nf"
            verbatim = 1
            print substr($0, 3)
            next
        }
        { leave(); print }
        /:$/ { print ".br" }
        END { leave() }'
}

overview=$("$program" --help)
version=$("$program" --version | sed 's/.* //')
# Lines of the overview between `commands:` and the next empty line, names alone.
commands=$(awk '/^commands:/ { on = 1; next } /^$/ { on = 0 } on' <<<"$overview" |
    sed -E 's/^  ([a-z-]+( [a-z-]+)?)  .*/\1/; s/ +$//')

cat <<EOF
.TH GRACECG 1 "" "gracecg $version" "User Commands"
.SH NAME
gracecg \\- centre\\-of\\-gravity calibration of GRACE\\-type satellites
.SH SYNOPSIS
.B gracecg
.I COMMAND
.RI [ ARGUMENTS ]
.RI [ OPTIONS ]
.br
.B gracecg
.I COMMAND
.B \\-\\-help
.br
.B gracecg \\-\\-version
.SH DESCRIPTION
Simulates the calibration in flight of the offset between a satellite's centre of mass and the proof
mass of its accelerometer, estimates the offset from observations, and plans such calibrations.
.PP
EOF
awk '/^commands:/ { on = 1 } on' <<<"$overview" | help_page
printf '.SH COMMANDS\n'
while IFS= read -r command; do
    printf '.SS %s\n' "$(roff <<<"$command")"
    # shellcheck disable=SC2086 # a command is one word or two
    "$program" $command --help </dev/null | help_page
done <<<"$commands"
cat <<'EOF'
.SH EXIT STATUS
0 done, 1 the work failed, 2 wrong usage.
.SH FILES
.nf
EOF
roff <<'EOF'
bin/gracecg                  the program
lib/libgracecg.a             the library, static
lib/libgracecg.so            the library, shared
lib/pkgconfig/gracecg.pc     options for compiler and linker
include/gracecg.h            its C interface
include/gracecg/gracecg.mod  its Fortran interface
libgracecg_level1, gracecg_level1.pc, .h, .mod
                             the same of the library for Level-1 data
EOF
cat <<'EOF'
.fi
.PP
below the prefix of the installation. Programs are compiled and linked with the output of
.B pkg\-config \-\-cflags \-\-libs gracecg
(with
.B \-\-static
for the static library).
EOF
