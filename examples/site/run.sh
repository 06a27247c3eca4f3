#!/bin/sh
# Usage: sh examples/site/run.sh [--with-page] [--test]
# Installs Debian packages and builds the reference site in out/site. Open out/site/index.html; no
# server and no network is needed. Warnings of Doxygen about public headers, and broken links, are errors.
#   --with-page  builds the interactive page if it is missing (examples/page/run.sh, some minutes)
#   --test       opens pages in a headless Chromium, which is installed; saves pictures to out/site_*.png
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh doxygen python3 g++ libeigen3-dev
site=examples/site
work=build/site
out=out/site
mkdir -p $work out

test=
for option in "$@"; do
  case $option in
    --with-page) [ -f out/cageform.html ] || sh examples/page/run.sh ;;
    --test) test=yes ;;
    *) echo "unknown option $option" >&2; exit 2 ;;
  esac
done
export PYTHONDONTWRITEBYTECODE=1
if [ ! -x $work/draw ] || [ -n "$(find include $site/pictures.cpp -name '*.[ch]pp' -newer $work/draw)" ]; then
  echo "the pictures of coordinate types (half a minute)"
  g++ -std=c++20 -O1 -Iinclude -isystem /usr/include/eigen3 $site/pictures.cpp -o $work/draw
fi
mkdir -p $work/pictures
$work/draw $work/pictures
python3 $site/pages.py $work/input

# Replaces the site only when the new one is complete.
rm -rf $work/html
mkdir -p $work/html
version=$(sed -n 's/.*VERSION_STRING "\(.*\)"/\1/p' include/cageform/version.hpp)
{
  cat $site/Doxyfile
  echo "PROJECT_NUMBER = $version"
  echo "INPUT = $work/input"
  echo "OUTPUT_DIRECTORY = $work/html"
  echo "LAYOUT_FILE = $work/input/layout.xml"
  echo "IMAGE_PATH = examples/pictures $work/pictures"
  echo "HTML_EXTRA_STYLESHEET = $site/style.css"
  echo "STRIP_FROM_PATH = $work/input/include"
  echo "STRIP_FROM_INC_PATH = $work/input/include"
  echo "WARN_LOGFILE = $work/warnings.txt"
} >$work/Doxyfile
doxygen $work/Doxyfile || { sed "s|$PWD/||" $work/warnings.txt >&2; exit 1; }
python3 $site/pages.py --finish $work/html
cp -n examples/pictures/* $work/html/ # pictures that pages link to without showing them
if [ -f out/cageform.html ]; then cp out/cageform.html $work/html/; fi
python3 $site/check_links.py $work/html
rm -rf $out
mv $work/html $out
echo "$out/index.html: open it in a browser"
if [ -n "$test" ]; then
  sh cmake/install_packages.sh chromium
  python3 $site/test.py $out out
fi
