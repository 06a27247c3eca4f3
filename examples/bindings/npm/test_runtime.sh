#!/bin/sh
# Usage: sh examples/bindings/npm/test_runtime.sh FOLDER
# Compiles the package's run time into FOLDER and tests it in node: a quarter of a minute, installs nothing.
set -eu
made=$1
cd "$(dirname "$0")/../../.."
mkdir -p "$made"
python3 examples/bindings/npm/write_module.py include/cageform/c/cageform.h include/cageform/version.hpp "$made"
sh examples/bindings/npm/compile.sh examples/bindings/npm/cageform.cpp "$made/runtime.wasm" "-I$made" \
  "@$made/exports_runtime.txt" -Os -DCAGEFORM_C_RUNTIME_ONLY
cp examples/bindings/npm/package/*.js examples/bindings/npm/test/small.js examples/bindings/npm/test/support.js examples/bindings/npm/test/small.json "$made"
echo '{ "type": "module" }' >"$made/package.json"
cd "$made" && exec node --test small.js
