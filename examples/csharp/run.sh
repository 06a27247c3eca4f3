#!/bin/sh
# Usage: sh examples/csharp/run.sh
# Builds the shared library, compiles Cageform.cs by mono's compiler, and runs its tests.
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh mono-mcs mono-runtime libmono-system-core4.0-cil python3 python3-numpy gcc
sh cmake/build_shared.sh
python=/usr/bin/python3
header=include/cageform/c/cageform.h
work=build/csharp
rm -rf $work
mkdir -p $work/site $work/figure
cp -r examples/python/package/cageform $work/site
cp -L build/shared/libcageform.so $work/site/cageform
ln -s site/cageform/libcageform.so $work
$python examples/python/read_header.py ctypes $header >$work/site/cageform/_c.py
$python examples/python/read_header.py layout $header >$work/layout.c
cc -std=c99 -Iinclude $work/layout.c -o $work/layout
$work/layout >$work/figure/layout.txt
PYTHONPATH=$work/site $python examples/csharp/figure.py $work/figure
mcs -langversion:7 -warnaserror -target:library -out:$work/Cageform.dll examples/csharp/Cageform.cs
mcs -langversion:7 -warnaserror -out:$work/Test.exe examples/csharp/Cageform.cs examples/csharp/Test.cs
mono $work/Test.exe $work/figure
