#!/bin/sh
# Usage: sh examples/bindings/npm/write_host.sh FILE
# Writes what a module of the library needs around it, shared with the page, as a module of JavaScript.
set -eu
cd "$(dirname "$0")/../../.."
{
  cat examples/bindings/wasm/host.js
  printf '\nexport { importsOf, wasiHost };\n'
} >"$1"
