#!/bin/sh
# Usage: sh cmake/install_packages.sh PACKAGE…
# Installs missing Debian packages. Without root or sudo, prints the command to run and fails.
set -eu

missing=
if command -v dpkg-query >/dev/null 2>&1; then
  for package in "$@"; do
    status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
    [ "$status" = 'install ok installed' ] || missing="$missing $package"
  done
else
  # Not Debian: only check for the compiler and cmake; cmake reports missing libraries.
  for tool in c++ cmake; do
    command -v "$tool" >/dev/null 2>&1 || missing="$*"
  done
fi
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    as_root='sudo -n'
  else
    as_root=no
  fi
fi
if ! command -v apt-get >/dev/null 2>&1; then
  echo "Please install the equivalents of these Debian packages:$missing" >&2
  exit 1
fi
if [ "$as_root" = no ]; then
  echo "Packages are missing. Please run:" >&2
  echo "  sudo apt-get install --no-install-recommends$missing" >&2
  exit 1
fi

echo "Installing:$missing"
export DEBIAN_FRONTEND=noninteractive
# Another apt may hold a lock (unattended upgrades): wait for it. Only dpkg's lock has an option for this.
# Prints the output only on failure.
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt_get() {
  $as_root apt-get -qq -o DPkg::Lock::Timeout=600 "$@" >"$log" 2>&1 || { cat "$log" >&2; return 1; }
}
tries=1
until apt_get update; do
  [ $tries -lt 6 ] || exit 1
  tries=$((tries + 1))
  sleep 10
done
# shellcheck disable=SC2086  # the list is split into words
apt_get install -y --no-install-recommends $missing
