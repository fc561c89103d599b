#!/usr/bin/env bash
# usage: install_test.sh BUILD SOURCE
# Installs BUILD into a folder of its own and runs every command there, with SOURCE hidden under an empty folder (in a
# mount namespace, which ends with this). Where a container forbids that, the programs' bytes alone show that they name
# nothing in SOURCE.
set -euo pipefail
build=$1 source=$2
here=$(cd "$(dirname "$0")" && pwd)
there=$(mktemp -d -t ohb-install-XXXXXX)
trap 'rm -rf "$there"' EXIT
cmake --install "$build" --prefix "$there/prefix" >/dev/null
cp "$here/every_command.sh" "$there/"
if [ -n "$(find "$there/prefix" -name __pycache__ -o -type l)" ]; then
  echo "links or caches were installed" >&2
  exit 1
fi
for program in "$there"/prefix/bin/*; do
  if grep -qF "$source/" "$program"; then
    echo "$program names files of $source" >&2
    exit 1
  fi
done

hide=(unshare --mount)
[ "$(id -u)" -eq 0 ] || hide+=(--map-root-user)
hide+=(sh -c 'mount -t tmpfs none "$0" && cd / && exec "$@"' "$source")
if ! "${hide[@]}" true 2>/dev/null; then
  echo "no mount namespace here: $source stays visible"
  hide=(env)
fi
"${hide[@]}" bash "$there/every_command.sh" "$there/prefix" "$there/out"
