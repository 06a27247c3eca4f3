#!/bin/sh
# Usage: sh examples/npm/test_runtime.sh FOLDER
# Compiles the package's run time into FOLDER and tests it in node: a quarter of a minute, installs nothing.
set -eu
made=$1
cd "$(dirname "$0")/../.."
mkdir -p "$made"
python3 examples/npm/write_module.py include/cageform/c/cageform.h include/cageform/version.hpp "$made"
sh examples/support/wasm/compile.sh examples/npm/cageform.cpp "$made/runtime.wasm" "-I$made" \
  "@$made/exports_runtime.txt" -Os -DCAGEFORM_C_RUNTIME_ONLY
cp examples/npm/package/*.js examples/npm/test/small.js examples/npm/test/support.js examples/npm/test/small.json "$made"
sh examples/npm/write_host.sh "$made/host.js"
echo '{ "type": "module" }' >"$made/package.json"
cd "$made" && exec node --test small.js
