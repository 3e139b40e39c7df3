#!/usr/bin/env bash
# Writes the manual pages of PROGRAM and of its commands, from their --help, into FOLDER, unless it holds those of this
# very program: manual_pages.sh PROGRAM FOLDER
# They have no date, so that a package is the same bytes whenever it is made.
set -euo pipefail
program=$1 folder=$2
exec 9>"$folder.lock" && flock 9  # two installs at once take turns
if [ "$folder/complete" -nt "$program" ]; then exit; fi
version=$("$program" --version)

mkdir -p "$folder"
rm -f "$folder"/dualpixel*.1

# Of one command, given by its words, and of the commands below it.
write_page() {
  local help name
  help=$("$program" "$@" --help)
  name=$(IFS=-; echo "dualpixel${*:+-$*}")
  local summary=${help%%$'\n'*}
  # help2man runs its argument by a shell
  help2man --no-info --no-discard-stderr --version-string="$version" --name="${summary%.}" \
    "$(printf %q "$program")${*:+ $*}" |
    sed -e "s/^\.TH DUALPIXEL \([^ ]*\) \"[^\"]*\"/.TH ${name^^} \1 \"\"/" -e "s/^dualpixel \\\\- /$name \\\\- /" \
        -e '/^\.SS "Example:"/,$s/^\.IP$/.IP\n.nf/' >"$folder/$name.1"  # an example's lines stay lines
  for command in $(sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p' <<<"$help"); do
    write_page "$@" "$command"
  done
}

write_page
touch "$folder/complete"
