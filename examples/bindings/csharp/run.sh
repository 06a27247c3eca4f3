#!/bin/sh
# Usage: sh examples/bindings/csharp/run.sh
# Builds the shared library, compiles Cageform.cs with mono's compiler, and runs its tests.
set -eu
cd "$(dirname "$0")/../../.."
sh cmake/install_packages.sh mono-mcs mono-runtime libmono-system-core4.0-cil python3 python3-numpy gcc
sh cmake/build_shared.sh
work=$PWD/build/csharp
rm -rf "$work"
mkdir -p "$work/figure"
sh examples/bindings/python/assemble.sh "$PWD/build/shared/libcageform.so" "$work/python"
cp "$work/python/layout.txt" "$work/figure"
cp "$work/python/cageform/libcageform.so" "$work"
PYTHONPATH="$work/python" /usr/bin/python3 examples/bindings/csharp/figure.py "$work/figure"
mcs -langversion:7 -warnaserror -target:library -out:"$work/Cageform.dll" examples/bindings/csharp/Cageform.cs
mcs -langversion:7 -warnaserror -out:"$work/Test.exe" examples/bindings/csharp/Cageform.cs examples/bindings/csharp/Test.cs
mono "$work/Test.exe" "$work/figure"
