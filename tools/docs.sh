#!/usr/bin/env bash
# Builds the documentation as a site of plain files: README, docs/, the headers' manual, and pages that were measured.
#   tools/docs.sh SITE [PAGE.html...]
#     SITE  a new folder; open SITE/index.html
#     PAGE  what `dualpixel chart`, `experiment`, `report` or `dataset merge` wrote, to be on the site
# Example: dualpixel chart --quick -o chart.html && tools/docs.sh site chart.html
if [ $# -lt 1 ] || [[ $1 == -* ]]; then
  sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
site=$(realpath -m "$1")
measured=()
for page in "${@:2}"; do
  [ -f "$page" ] || { echo "tools/docs.sh: $page: no such file" >&2; exit 2; }
  measured+=("$(realpath "$page")")
done
if [ -e "$site" ]; then
  echo "tools/docs.sh: $1: is there already; remove it, or name another folder" >&2
  exit 2
fi
set --
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" pandoc doxygen

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mapfile -t sources < <(for pattern in README.md 'docs/*.md' '*/README.md' '*.md'; do git ls-files "$pattern"; done | awk '!seen[$0]++')
page_of() { sed 's/README\.md$/index.html/; s/\.md$/.html/' <<<"$1"; }
title_of() { sed -n 's/^# //p' "$1" | head -1; }
root_of() { tr -cd / <<<"$1" | sed 's|/|../|g'; }

# What every page lists at its side.
{
  echo 'page:'
  for source in "${sources[@]}"; do echo "- {file: '$(page_of "$source")', title: '$(title_of "$source")'}"; done
  for page in "${measured[@]}"; do echo "- {file: 'measured/$(basename "$page")', title: 'Measured: $(basename "$page" .html)'}"; done
  echo "- {file: 'headers/files.html', title: 'Headers'}"
} >"$work/pages.yaml"

for source in "${sources[@]}"; do
  page=$work/site/$(page_of "$source")
  mkdir -p "$(dirname "$page")"
  pandoc --from gfm --to html5 --template tools/docs/page.html --lua-filter tools/docs/links.lua \
    --metadata-file "$work/pages.yaml" --variable "root=$(root_of "$source")" --metadata pagetitle="$(title_of "$source")" \
    --no-highlight -o "$page" "$source"
  # Pictures and files of the repository that the page leads to come along.
  grep -oP '(?:href|src)="\K[^"#:]+(?=["#])' "$page" | sort -u | while read -r target; do
    file=$(realpath -m --relative-to=. "$(dirname "$source")/$target")
    if [ -f "$file" ]; then cp --parents "$file" "$work/site"; fi
    if [ -d "$file" ]; then cp -r --parents "$file" "$work/site"; fi
  done
done
cp tools/docs/site.css "$work/site"
if [ ${#measured[@]} -gt 0 ]; then
  mkdir "$work/site/measured"
  cp "${measured[@]}" "$work/site/measured"
fi
{ cat tools/docs/Doxyfile; echo "OUTPUT_DIRECTORY = $work/site"; } | doxygen -

broken=$(cd "$work/site" && find . -name '*.html' -not -path './headers/*' -not -path './measured/*' | while read -r page; do
  grep -oP '(?:href|src)="\K[^":]+(?=")' "$page" | sort -u | while read -r target; do
    file=$page
    if [ -n "${target%%#*}" ]; then file=$(dirname "$page")/${target%%#*}; fi
    [ -e "$file" ] || echo "$page leads to $target, which is not there"
    if [[ $target == *'#'* && -f $file ]] && ! grep -q "id=\"${target#*#}\"" "$file"; then
      echo "$page leads to $target, and there is no such heading"
    fi
  done
done)
if [ -n "$broken" ]; then
  echo "$broken" >&2
  exit 1
fi
mv "$work/site" "$site"
echo "$site/index.html"
