#!/bin/sh
# Usage: sh examples/bindings/npm/compile.sh SOURCE OUT [OPTION…]
# Compiles a C++ file and the library to a WebAssembly module without threads, exceptions and a file system, for the npm
# package and the page. Callers install the required Debian packages:
#   clang-19 lld-19 wasi-libc libc++-19-dev-wasm32 libc++abi-19-dev-wasm32 libclang-rt-19-dev-wasm32 libeigen3-dev
set -eu
source=$1
out=$2
shift 2
# Matrix products need more stack than the default of 64 kB. The stack comes first in memory, so that an overflow traps.
exec clang++-19 --target=wasm32-wasi -mexec-model=reactor -std=c++20 -O2 -fno-unroll-loops -flto -msimd128 -DNDEBUG -fno-exceptions \
  -fno-rtti -Wall -Wextra -Iinclude -isystem /usr/include/eigen3 "$source" -Wl,-z,stack-size=1048576 -Wl,--stack-first \
  -Wl,--strip-all "$@" -o "$out"
