#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The program with all the libraries it needs, for any Linux on x86-64: ./run portable (docs/install.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CMakeLists.txt)}
export SOURCE_DATE_EPOCH
./run install portable
./run build program installed_files touchable_wheel touchable_media_portable
cmake/ffmpeg.sh build/media

version=$(sed -n 's/^project(touchable VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
name=touchable-$version-linux-x86_64
top=$PWD/build/portable/$name
rm -rf build/portable
cmake --install build/release --prefix "$top" >/dev/null
cp build/release/capi/{wheel/libtouchable,portable/libtouchable-media}.so.0 "$top/lib/"  # a Python's libstdc++ may be older
mkdir -p "$top"/{libexec,python/touchable,share/vulkan/icd.d,share/fonts}
mv "$top/bin/touchable" "$top/libexec/"
cc -static -D_GNU_SOURCE -O2 -Wall -Wextra -s cmake/launcher.c -o "$top/bin/touchable"
rm -rf "$top"/{include,lib/*.a,lib/cmake,lib/pkgconfig}
cp python/touchable/*.py python/touchable/py.typed "$top/python/touchable/"
ln -s ../../lib "$top/python/touchable/lib"

# Which group of libraries the machine's are preferred to, if it has them (cmake/launcher.c); nothing: all others.
group_of() {
    case $1 in
        ld-linux-x86-64.so* | libc.so* | libm.so* | libpthread.so* | libdl.so* | librt.so* | libresolv.so* | libutil.so* | libanl.so* | libmvec.so*) echo libc ;;
        libstdc++.so* | libgcc_s.so*) echo libstdc++ ;;
        libasound.so*) echo alsa ;;
        libdrm.so*) echo drm ;;
        libvulkan.so*) echo vulkan ;;
        libwayland-client.so*) echo wayland ;;
        libX11.so* | libxcb.so* | libXau.so* | libXdmcp.so*) echo x11 ;;  # which never come alone
    esac
}
declare -A sources=() where=()
while read -r soname path; do where[$soname]=${where[$soname]:-$path}; done < <(ldconfig -p | awk '/libc6,x86-64/ { print $1, $NF }')
for library in /usr/lib/x86_64-linux-gnu/pulseaudio/*.so; do where[$(basename "$library")]=$library; done
for library in build/media/lib/*; do where[$(basename "$library")]=$PWD/$library; done

# What a binary needs, and what that needs.
take() {  # soname
    local from=${where[$1]:-} into
    [[ -z ${sources[$1]:-} ]] || return 0
    [[ -n $from ]] || { echo "portable: no library $1" >&2; exit 1; }
    into=$top/lib
    if [[ -n $(group_of "$1") ]]; then into=$top/lib/fallback/$(group_of "$1"); fi
    mkdir -p "$into"
    cp -L "$from" "$into/$1"
    chmod u+w "$into/$1"
    sources[$1]=$(realpath "$from")
    needs "$into/$1"
}
needs() {  # binary
    local soname
    while read -r soname; do [[ -e $top/lib/$soname ]] || take "$soname"; done < <(objdump -p "$1" | awk '$1 == "NEEDED" { print $2 }')
}
for binary in "$top/libexec/touchable" "$top"/lib/libtouchable*.so.0; do needs "$binary"; done
# GLFW and SDL load some by name; the C library loads libgcc_s.
for soname in libvulkan_lvp.so libvulkan.so.1 libX11-xcb.so.1 libXcursor.so.1 libXi.so.6 libXinerama.so.1 libXrandr.so.2 libXrender.so.1 \
    libXxf86vm.so.1 libgcc_s.so.1; do
    where[libvulkan_lvp.so]=/usr/lib/x86_64-linux-gnu/libvulkan_lvp.so
    take "$soname"
done
sed 's#"library_path":.*#"library_path": "../../../lib/libvulkan_lvp.so"#' /usr/share/vulkan/icd.d/lvp_icd.x86_64.json >"$top/share/vulkan/icd.d/lvp_icd.json"
cp /usr/share/fonts/truetype/dejavu/DejaVuSans{,-Bold}.ttf /usr/share/fonts/truetype/dejavu/DejaVuSansMono.ttf "$top/share/fonts/"
cat >"$top/share/fonts/fonts.conf" <<'XML'
<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig><dir prefix="relative">.</dir><cachedir prefix="xdg">fontconfig</cachedir></fontconfig>
XML
find "$top/lib" "$top/libexec" -type f \( -name '*.so*' -o -name touchable \) -exec strip --strip-unneeded {} +
patchelf --set-rpath "\$ORIGIN/../lib" "$top/libexec/touchable"
find "$top/lib" -maxdepth 1 -type f -name '*.so*' -exec patchelf --set-rpath "\$ORIGIN" {} \;
find "$top/lib/fallback" -type f ! -path '*/libc/*' -exec patchelf --set-rpath "\$ORIGIN:\$ORIGIN/../.." {} \;

# Libraries under the GPL alone, which Debian's FFmpeg, libheif and libtiff bring.
if find "$top/lib" | grep -E 'lib(x264|x265|xvidcore|postproc|rubberband|vidstab|cdio|readline|jbig)\b'; then
    echo "portable: the libraries above are under the GPL; the archive must not have them" >&2
    exit 1
fi
licence_of() {  # file of a package's copyright: the names of all licences in it
    local names
    names=$(sed -n 's/^License: *//p' "$1" | sort -u | paste -sd ';' | sed 's/;/; /g')
    echo "${names:-see its file}"
}
mkdir -p "$top/share/doc/touchable/licences"
{
    cat <<TEXT
touchable $version is under the Apache License 2.0 (share/doc/touchable). This archive also has the libraries below, each under its own
licence. None is under the GPL alone, so that the whole may be passed on as it is, with this file. FFmpeg, libheif and others are
under the LGPL: each is a file of its own in lib/, which you may replace by your own build.

Their sources are Debian's source packages of the names and versions below (its snapshot archive keeps all). FFmpeg, libheif and libtiff were
built from these by cmake/ffmpeg.sh of touchable's source, with these settings:

$(<build/media/sources)

package, version, source package: files: licences of the package's parts (texts in share/doc/touchable/licences)
TEXT
    for soname in "${!sources[@]}"; do
        path=${sources[$soname]}
        if [[ $path == "$PWD"/build/media/* ]]; then
            case $soname in libheif*) package=libheif-dev ;; libtiff*) package=libtiff-dev ;; *) package=libavcodec-dev ;; esac
        else
            package=$({ dpkg -S "$path" 2>/dev/null || dpkg -S "${path#/usr}"; } | sed -n '1s/:.*//p')
        fi
        echo "$package $soname"
    done | sort | awk '{ if ($1 == last) printf " %s", $2; else printf "%s%s %s", (NR > 1 ? "\n" : ""), $1, $2; last = $1 } END { print "" }' |
        while read -r package files; do
            cp -L "/usr/share/doc/$package/copyright" "$top/share/doc/touchable/licences/$package"
            echo "$(dpkg-query -W -f '${Package}, ${Version}, ${source:Package}' "$package"): $files: $(licence_of "/usr/share/doc/$package/copyright")"
        done
    cp -L /usr/share/doc/fonts-dejavu-core/copyright "$top/share/doc/touchable/licences/fonts-dejavu-core"
    dpkg-query -W -f 'fonts-dejavu-core, ${Version}: share/fonts: Bitstream Vera and public domain\n' fonts-dejavu-core
} >"$top/LICENCES"

mkdir -p out
rm -f out/touchable-*-linux-x86_64.tar.xz
tar -C build/portable --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" -cf - "$name" | xz --x86 --lzma2=preset=9e >"out/$name.tar.xz"
echo "out/$name.tar.xz ($(($(stat -c %s "out/$name.tar.xz") / 1000000)) MB): unpack it anywhere, and run $name/bin/touchable"
