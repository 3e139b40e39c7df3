#!/usr/bin/env bash
# Tries the README's two commands on a bare system: makes one with debootstrap, clones this commit into it, runs both there.
#   sudo tools/fresh.sh SUITE [FOLDER] [MIRROR]
#     SUITE   Debian's name of a release: bookworm or trixie
#     FOLDER  where the system goes (default: /var/tmp/dualpixel-SUITE); one that is there is used again
#     MIRROR  where its packages come from (default: debootstrap's own)
# Takes some 5 GB and, on two cores, about an hour. Example: sudo tools/fresh.sh trixie
set -euo pipefail
if [ $# -lt 1 ] || [ "$(id -u)" -ne 0 ]; then
  sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
suite=$1 root=${2:-/var/tmp/dualpixel-$1} mirror=${3:-}
source_folder=$(realpath "$(dirname "${BASH_SOURCE[0]}")/..")
command -v debootstrap >/dev/null || { echo "fresh.sh: needs debootstrap: apt-get install debootstrap" >&2; exit 2; }
# mounts of the new system are this process's own: they go with it
[ "${FRESH_NAMESPACE:-}" = 1 ] || FRESH_NAMESPACE=1 exec unshare --mount --pid --fork "${BASH_SOURCE[0]}" "$@"

if [ ! -e "$root/debootstrapped" ]; then
  if [ -e "$root" ] && [ -n "$(ls -A "$root")" ] && [ ! -e "$root/debootstrapping" ]; then
    echo "fresh.sh: $root: is not empty, and not a system that this script made" >&2
    exit 2
  fi
  rm -rf --one-file-system "$root"  # a run that broke off begins anew
  mkdir -p "$root"
  touch "$root/debootstrapping"
  debootstrap --variant=minbase --include=git,ca-certificates "$suite" "$root" ${mirror:+"$mirror"}
  mv "$root/debootstrapping" "$root/debootstrapped"
fi
cp -L /etc/resolv.conf "$root/etc/resolv.conf"
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
rm -rf "$root/root/dualpixel"
git clone --quiet "$source_folder" "$root/root/dualpixel"
for step in tools/demo.sh tools/test.sh; do
  echo "== $suite: $step" >&2
  start=$SECONDS
  chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 bash -c "cd /root/dualpixel && $step"
  echo "== $suite: $step passed in $((SECONDS - start)) s" >&2
done
