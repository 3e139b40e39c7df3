#!/usr/bin/env bash
# tools/docs.sh makes a site whose links all lead somewhere, takes measured pages along, and refuses what it cannot use.
set -uo pipefail
cd "$(dirname "$0")/../../.."
for command in git pandoc doxygen dpkg-query; do
  command -v "$command" >/dev/null || { echo "skipped: no $command"; exit 0; }
done
git rev-parse >/dev/null 2>&1 || { echo "skipped: no git checkout"; exit 0; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
  echo "FAILED: $*"
  exit 1
}

# refuses WHAT ARGUMENT...: status 2, and one line that holds WHAT.
refuses() {
  tools/docs.sh "${@:2}" >"$work/out" 2>"$work/err"
  [ $? -eq 2 ] || fail "${*:2}: not status 2"
  [ "$(wc -l <"$work/err")" -eq 1 ] && grep -q "$1" "$work/err" || fail "${*:2}: not one line with '$1': $(cat "$work/err")"
}

echo '<p>measured</p>' >"$work/chart.html"
refuses 'nothing.html: no such file' "$work/site" "$work/nothing.html"
refuses 'is there already' "$work"
[ ! -e "$work/site" ] || fail "a refusal wrote a site"

tools/docs.sh "$work/site" "$work/chart.html" >"$work/out" 2>"$work/err" || fail "$(tail -5 "$work/err")"
[ "$(tail -1 "$work/out")" = "$work/site/index.html" ] || fail "names another page: $(tail -1 "$work/out")"
for page in index.html docs/portrait.jpg docs/paper.html lens_models/index.html headers/files.html measured/chart.html; do
  [ -s "$work/site/$page" ] || fail "$page is missing"
done
grep -q 'href="[^"]*measured/chart.html"' "$work/site/docs/paper.html" || fail "pages do not list what was measured"
grep -rqs 'default_options' "$work/site/headers" || fail "the headers' manual does not know default_options()"
