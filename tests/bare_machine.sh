#!/usr/bin/env bash
# The first run anywhere: a Debian 12 with nothing on it, and what README.md tells a newcomer to type there.
set -euo pipefail

if [ "${1:-}" = "--help" ] || [ "${1:-}" = "-h" ]; then
  cat <<'HELP'
usage: tests/bare_machine.sh [--keep] [--ccache DIR] [--root DIR] [--no-sanitizers]

Makes two bare Debian 12 machines (debootstrap) in DIR: on the first a clean copy of what is committed runs README.md's
quickstart as it is printed there (./demo --quick and what follows), ./demo --quick again without a network, and
./package; on the second, without a compiler, the package is installed and every command and the quickstart run again;
then, on the first, ./test.
Ends with 0 if all of them did, and writes the minutes of each to DIR/minutes.tsv and its words to DIR/*.log.
Needs root, debootstrap, 16 GB and, besides Debian's mirror (the one that apt uses here), no network.

  --root DIR       the folder for the machines (default: a new one under TMPDIR)
  --keep           leaves the machines there; a next run with this DIR makes new ones but for the bare system itself
  --ccache DIR     a compiler cache for the first machine, to save time (the minutes are then not a newcomer's)
  --no-sanitizers  passed on to ./test
HELP
  exit 0
fi

fail() { echo "bare_machine.sh: $*" >&2; exit 2; }
keep="" cache="" root="" test_options=""
while [ $# -gt 0 ]; do
  case $1 in
    --keep) keep=yes ;;
    --no-sanitizers) test_options=$1 ;;
    --ccache | --root)
      [ $# -ge 2 ] || fail "$1 needs a folder"
      if [ "$1" = --root ]; then root=$2; else cache=$2; fi
      shift
      ;;
    *) fail "$1: no such option; see --help" ;;
  esac
  shift
done
[ "$(id -u)" -eq 0 ] || fail "debootstrap and chroot need root: run it with sudo"
command -v debootstrap >/dev/null || fail "debootstrap is missing: apt-get install debootstrap"
[ -z "$cache" ] || cache=$(realpath -e "$cache") || fail "no such folder: $cache"
source=$(cd "$(dirname "$0")/.." && pwd)
git -C "$source" rev-parse HEAD >/dev/null || fail "$source is no checkout: what is committed is tried"
if [ -z "$root" ]; then root=$(mktemp -d -t ohb-bare-XXXXXX); else mkdir -p "$root"; root=$(realpath "$root"); fi

# Everything is mounted in a namespace of the commands' own, which dies with them, and they die with this: nothing stays
# mounted, and nothing here can delete a folder of this machine through a mount.
running=""
clean() {
  if [ -n "$running" ]; then kill -KILL "$running" 2>/dev/null || true; fi
  [ -n "$keep" ] || rm -rf --one-file-system "$root/base" "$root/first" "$root/second"
}
trap clean EXIT
trap 'exit 143' TERM INT HUP

# on MACHINE NETWORK(yes or no) COMMANDS: in bash on that machine, with the environment of a first login.
on() {
  local spaces=(--mount --pid --fork --kill-child=KILL --propagation private)
  [ "$2" = yes ] || spaces+=(--net)
  setpriv --pdeathsig KILL unshare "${spaces[@]}" bash -euc '
    mount --bind "$0" "$0"
    mount -t proc proc "$0/proc"
    mount --rbind /sys "$0/sys"
    mount --rbind /dev "$0/dev"
    mount -t tmpfs -o mode=1777 tmpfs "$0/dev/shm"
    settings=(PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb)
    if [ -n "$2" ]; then
      mkdir -p "$0/ccache"
      mount --bind "$2" "$0/ccache"
      settings+=(CCACHE_DIR=/ccache ${LANG:+LANG=$LANG})  # entries are of a language
    fi
    code=0
    chroot "$0" /usr/bin/env -i "${settings[@]}" bash -c "$1" || code=$?
    times >"$3"
    exit "$code"
  ' "$root/$1" "$3" "$cache" "$root/times.txt" &
  running=$!
  wait "$running"
}

# timed NAME MACHINE NETWORK COMMANDS: its words go to NAME.log.
timed() {
  local begin=$SECONDS code=0
  echo "== $1 on the $2 machine"
  on "$2" "$3" "$4" >"$root/$1.log" 2>&1 || code=$?
  # The second line of times: user and system time of what ran, as 1m2.3s.
  awk -v name="$1" -v machine="$2" -v code="$code" -v wall_s=$((SECONDS - begin)) 'NR == 2 {
    split($1 "m" $2, t, /[ms]+/)
    printf "%s\t%s machine\texit code %s\t%.1f min\t%.1f min of processor time\n", name, machine, code, wall_s / 60,
           t[1] + t[3] + (t[2] + t[4]) / 60
  }' "$root/times.txt" | tee -a "$root/minutes.tsv"
  [ "$code" -eq 0 ] || { tail -n 25 "$root/$1.log"; failed="$failed $1"; }
}

# machine NAME: a bare system that gets Debian's packages from where this one does.
machine() {
  rm -rf --one-file-system "${root:?}/$1"
  cp -a "$root/base" "$root/$1"
  apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 'Origin: Debian' |
    sort -u >"$root/$1/etc/apt/sources.list"
  apt-config dump | grep -E '^Acquire::(https?::|Check-)' >"$root/$1/etc/apt/apt.conf.d/90host" || true
  cp -L /etc/resolv.conf /etc/hosts "$root/$1/etc/"
}

# The commands of README.md under this heading, as they are printed there.
printed() { awk -v heading="## $1" '/^## /{here = ($0 == heading)} /^```/{if (here && inside) exit; inside = here; next} here && inside' \
  "$root/first/checkout/README.md"; }

failed=""
: >"$root/minutes.tsv"
if [ ! -e "$root/base/etc/debian_version" ]; then
  echo "== a bare Debian 12"
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' 'Created-By: Packages' | head -n 1)
  rm -rf --one-file-system "$root/base"
  debootstrap --variant=minbase bookworm "$root/making" "$mirror" >"$root/debootstrap.log" 2>&1 ||
    { tail "$root/debootstrap.log"; fail "debootstrap failed"; }
  mv "$root/making" "$root/base"
fi
machine first
mkdir "$root/first/checkout"
git -C "$source" archive HEAD | tar -x -C "$root/first/checkout"
quickstart=$(printed Quickstart)
[ -n "$quickstart" ] || fail "README.md has no commands under Quickstart"

timed quickstart first yes "set -e; cd /checkout; $quickstart"
timed demo_again first no "cd /tmp && /checkout/demo --quick"
timed package first yes "cd /checkout && ./package"

machine second
mkdir "$root/second/here"
cp "$root"/first/checkout/build/package/*.deb "$source/tests/install/every_command.sh" "$root/second/here/" || failed="$failed copy"
timed install second yes "set -e; cd /here; apt-get update -q; $(printed "Installing a package")
  if command -v g++ cmake; then exit 1; fi"
timed every_command second no "bash /here/every_command.sh /usr /here/commands"
timed installed_quickstart second no "set -e; cd /here; cp -r /usr/share/openhumanbrdf/assets .
  $(printf '%s\n' "$quickstart" | sed '/^\.\/demo/d; /^export PATH/d')"
timed remove second no "apt-get purge -y -q openhumanbrdf && test ! -e /usr/share/openhumanbrdf"
timed test first yes "cd /checkout && ./test $test_options"

column -t "$root/minutes.tsv" 2>/dev/null || cat "$root/minutes.tsv"
[ -z "$failed" ] || { echo "failed:$failed; logs in $root"; exit 1; }
