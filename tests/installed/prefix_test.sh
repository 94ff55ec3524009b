#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Installs a build into a folder, moves that, and builds other projects with it: in C by CMake and by pkg-config, in C++ by
# the solver's rooms.
#   prefix_test.sh BUILD_DIR SOURCE_DIR LIBRARY_FOLDER
set -euo pipefail
build=$1 sources=$2 libraries=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"
prefix=$work/moved

for page in "$prefix"/share/doc/touchable/{,docs/}*.md; do
    for link in $(grep -oE '\]\([^):# ]+[)#]' "$page"); do
        link=${link:2:-1}
        [[ -e ${page%/*}/$link ]] || { echo "$page leads to $link, which is not there" >&2; exit 1; }
    done
done

cmake -S "$sources/tests/package/c" -B "$work/c" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$work/c"
"$work/c/shared_hill" >"$work/shared"
"$work/c/static_hill" >"$work/static"
grep -q touching "$work/shared"
cmp "$work/shared" "$work/static"

export PKG_CONFIG_PATH=$prefix/$libraries/pkgconfig
# Where it looks for others: beside itself, never in the folder that a program happens to be in.
path=$(readelf -d "$prefix/$libraries/libtouchable-media.so.0" | sed -n 's/.*runpath: \[\(.*\)\]/\1/p')
[[ $path == '$ORIGIN' ]] || { echo "libtouchable-media looks for libraries in '$path'" >&2; exit 1; }
cc "$sources/examples/c/touch_clip.c" $(pkg-config --cflags --libs touchable-media) -o "$work/clip"
touchable=$prefix/bin/touchable
"$touchable" make globe "$work/globe.mkv" --size 144x96 --frames 12 >/dev/null
"$touchable" touch "$work/globe.mkv" --seconds 1 --forces "$work/forces.csv" --json "$work/report.json" >/dev/null
hash=$(sed -n 's/.*"force_hash": "\([0-9a-f]*\)".*/\1/p' "$work/report.json")
c_hash=$(LD_LIBRARY_PATH=$prefix/$libraries "$work/clip" "$work/globe.mkv" "$work/forces.csv")
if [[ -z $hash || $c_hash != "$hash" ]]; then
    echo "the program's force hash is '$hash', touch_clip.c has '$c_hash'" >&2
    exit 1
fi

cmake -S "$sources/tests/package" -B "$work/solver" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$work/solver"
"$work/solver/touch_a_hill" >/dev/null

# A checkout and a build folder are no installed package.
mkdir "$work/none"
cat >"$work/none/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(none NONE)
find_package(touchable QUIET PATHS "${CHECKOUT}" "${BUILD}" NO_DEFAULT_PATH)
if(touchable_CONSIDERED_CONFIGS)
  message(FATAL_ERROR "find_package(touchable) takes ${touchable_CONSIDERED_CONFIGS}, which is not installed")
endif()
END
cmake -S "$work/none" -B "$work/none/build" -G Ninja -DCHECKOUT="$sources" -DBUILD="$build" >/dev/null
