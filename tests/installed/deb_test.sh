#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The Debian package: the same bytes twice, and nothing that Debian's checker complains of.
#   deb_test.sh CPACK BUILD_DIR
set -euo pipefail
cpack=$1 build=$2
for tool in dpkg-shlibdeps dpkg-parsechangelog file; do
    command -v "$tool" >/dev/null || { echo "needs $tool (Debian: dpkg-dev, file)"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fault() { echo "$*" >&2; exit 1; }

export SOURCE_DATE_EPOCH=1795737600
for folder in once again; do
    (cd "$build" && "$cpack" -G DEB -B "$work/$folder" >"$work/said" 2>&1) || { cat "$work/said"; exit 1; }
    rm -r "$work/$folder/_CPack_Packages"
done
package=$(echo "$work"/once/*.deb)
cmp "$package" "$work"/again/*.deb

# What lintian complained of.
mkdir "$work/root" "$work/control"
dpkg-deb -x "$package" "$work/root"
dpkg-deb -e "$package" "$work/control"
[[ $(<"$work/control/triggers") == 'activate-noawait ldconfig' ]] || fault "ldconfig is not triggered"
for script in "$work"/control/{preinst,postinst,prerm,postrm}; do [[ ! -e $script ]] || fault "has the script $script"; done
for library in "$work"/root/usr/lib/libtouchable*.so.?; do
    library=${library##*/}
    grep -q "^${library%.so.*} ${library##*.} touchable (= " "$work/control/shlibs" || fault "shlibs has no $library"
done
[[ $(dpkg-deb -f "$package" Maintainer) != *localhost* ]] || fault "the maintainer's host is localhost"
doc=$work/root/usr/share/doc/touchable
zcat "$doc/changelog.gz" >"$work/changelog"
dpkg-parsechangelog -l "$work/changelog" >"$work/parsed" 2>&1
grep -q "^Version: $(dpkg-deb -f "$package" Version)\$" "$work/parsed" || { cat "$work/parsed"; fault "no changelog of this version"; }
[[ -s $doc/copyright && -s $doc/CHANGELOG.md && -s $work/root/usr/share/man/man1/touchable.1.gz ]] ||
    fault "no copyright, CHANGELOG.md or manual page"

command -v lintian >/dev/null || { echo "lintian is not installed: its checks are left out"; exit 0; }
lintian --allow-root --fail-on error,warning "$package"
