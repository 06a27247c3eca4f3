#!/bin/sh
# Usage: sh examples/bindings/npm/run.sh [--build-only]
# Installs Debian packages, compiles the C interface to WebAssembly and writes out/cageform-VERSION.tgz. Then installs the
# package into an empty folder without a network and tests it: in node, with TypeScript's compiler, in a headless Chromium,
# and against the native library. The script takes some minutes.
set -eu
cd "$(dirname "$0")/../../.."
packages='clang-19 lld-19 wasi-libc libc++-19-dev-wasm32 libc++abi-19-dev-wasm32 libclang-rt-19-dev-wasm32 libeigen3-dev python3'
command -v node >/dev/null && command -v npm >/dev/null || packages="$packages nodejs npm" # other installations are accepted
# shellcheck disable=SC2086  # the list is meant to be split
sh cmake/install_packages.sh $packages
npm=examples/bindings/npm
work=build/npm
made=$work/made       # compiled and generated files
package=$work/package # the contents of the package
mkdir -p $made out

/usr/bin/python3 $npm/write_module.py include/cageform/c/cageform.h include/cageform/version.hpp $made
# compiled NAME EXPORTS [OPTION…]: makes NAME.wasm if it is older than its sources. -Os saves a seventh of the bytes and
# does not slow down clones.
compiled() {
  name=$1
  exports=$2
  shift 2
  sources="include $npm/cageform.cpp $npm/compile.sh $made/layout_check.hpp $made/$exports.txt"
  # shellcheck disable=SC2086  # the list is meant to be split
  [ ! -f "$made/$name.wasm" ] || [ -n "$(find $sources -newer "$made/$name.wasm" -type f)" ] || return 0
  echo "$name.wasm"
  sh $npm/compile.sh $npm/cageform.cpp $made/"$name".wasm -I$made "@$made/$exports.txt" -Os "$@"
}
compiled runtime exports_runtime -DCAGEFORM_C_RUNTIME_ONLY
compiled cageform exports # two minutes

rm -rf $package
mkdir -p $package
cp $npm/package/*.js $npm/package/*.d.ts $npm/package/README.md LICENSE $made/layout.js $made/layout.d.ts $made/*.wasm $package
version=$(sed -n 's/.*VERSION_STRING "\(.*\)".*/\1/p' include/cageform/version.hpp)
chmod 644 $package/*
license=$(sed -n '1s/ License$//p' LICENSE)
sed -e "s/@VERSION@/$version/" -e "s/@LICENSE@/$license/" $npm/package/package.json.in >$package/package.json
tarball=out/cageform-$version.tgz
npm pack --silent --pack-destination out ./$package >/dev/null
node $npm/sizes.js $package "$tarball"
[ "${1:-}" != --build-only ] || exit 0

sh cmake/install_packages.sh node-typescript chromium python3-numpy
sh cmake/build_shared.sh
test=$work/test # the empty folder
rm -rf $test
mkdir -p $test/data
echo '{ "private": true, "type": "module" }' >$test/package.json
(cd $test && npm install --offline --no-audit --no-fund --silent "../../../$tarball")
cp $npm/test/*.js $npm/test/*.ts $npm/test/*.html $test
cp -r tests/data/oracle $test/data
sh examples/bindings/python/assemble.sh build/shared/libcageform.so $work/python
export PYTHONDONTWRITEBYTECODE=1
PYTHONPATH=$work/python /usr/bin/python3 $npm/test/native.py $test/data

(cd $test && DATA=data node --test node.js && node --test full.js)
(cd $test && tsc --strict --target es2022 --module node16 --moduleResolution node16 --lib es2022,dom --outDir compiled consumer.ts)
(cd $test && node compiled/consumer.js)
/usr/bin/python3 $npm/test/chromium.py $test
