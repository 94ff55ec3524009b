#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What a release carries, made of what is committed: ./run release (CONTRIBUTING.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

version=$(sed -n 's/^project(touchable VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
[[ -z $(git status --porcelain) ]] || { echo "release: some files are not committed; git status names them" >&2; exit 2; }
grep -q "^## $version (" CHANGELOG.md || { echo "release: CHANGELOG.md has no version $version with its date" >&2; exit 2; }
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
into=out/release
rm -rf "$into"
mkdir -p "$into"
./run deb
./run portable
./run wheel
./run wheel aarch64
./run web --build
cp build/release/touchable_"$version"_*.deb out/touchable-"$version"-linux-x86_64.tar.xz out/touchable-"$version"-*.whl "$into/"
cp out/web/touch.html "$into/touchable-$version-page.html"
tar -C out --exclude=touch.html --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" -cJf "$into/touchable-$version-page.tar.xz" web
git archive --prefix="touchable-$version/" HEAD | xz -9e >"$into/touchable-$version-source.tar.xz"
cp "build/portable/touchable-$version-linux-x86_64/LICENCES" "$into/"
sed -n "/^## $version /,/^## /{/^## /!p}" CHANGELOG.md >"$into/NOTES.md"
(cd "$into" && sha256sum -- * >SHA256SUMS)
ls -la "$into"
