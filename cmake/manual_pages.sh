#!/usr/bin/env bash
# Writes the manual pages of PROGRAM and of its commands, from their --help, into FOLDER: manual_pages.sh PROGRAM FOLDER
set -euo pipefail
program=$1 folder=$2
version=$("$program" --version)

# The names below "Subcommands:" of a command's help.
commands() { "$program" "$@" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p'; }

write_page() {
  local name summary
  name=$(IFS=-; echo "dualpixel${*:+-$*}")
  summary=$("$program" "$@" --help | sed -n 1p)
  help2man --no-info --no-discard-stderr --version-string="$version" --name="${summary%.}" "$program${*:+ $*}" |
    sed -e "s/^\.TH DUALPIXEL /.TH ${name^^} /" -e "s/^dualpixel \\\\- /$name \\\\- /" \
        -e '/^\.SS "Example:"/,$s/^\.IP$/.IP\n.nf/' >"$folder/$name.1"  # an example's lines stay lines
  for command in $(commands "$@"); do write_page "$@" "$command"; done
}

mkdir -p "$folder"
write_page
