# Shared by ./demo and ./test: says what it does, installs packages, builds a preset.
# shellcheck shell=bash

# humanmaterial's precompiled headers would otherwise never hit the compiler cache.
export CCACHE_SLOPPINESS=pch_defines,time_macros
# A second checkout, as of continuous integration, finds what the first compiled.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1

say() { printf '\n== %s\n' "$*"; }

# install_packages [TAG...]: the lines of packages.txt without a tag, and those with one of these.
install_packages() {
  local wanted missing=() package
  wanted=$(sed 's/^#.*//' packages.txt | awk -v tags="$*" \
    'NF == 1 || index(" " tags " ", " " substr($2, 2, length($2) - 2) " ") { print $1 }')
  for package in $wanted; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  if ! command -v apt-get >/dev/null; then
    echo "This is no Debian: install what packages.txt lists in your own way, then build by hand (README.md)." >&2
    exit 2
  fi
  say "installing ${#missing[@]} Debian packages: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      echo "These packages are missing and this is not root: run 'apt-get install ${missing[*]}' as root first." >&2
      exit 2
    fi
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -q >/dev/null
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" >/dev/null
}

# build_preset NAME [--target T...]; configure=(-D...) is passed on to CMake
configure=()
build_preset() {
  local preset=$1
  shift
  cmake --preset "$preset" "${configure[@]}" >/dev/null
  cmake --build --preset "$preset" -j "$(nproc)" "$@" -- --quiet
}
