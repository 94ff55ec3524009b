#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# FFmpeg, libheif and libtiff from Debian's source packages, without their parts under the GPL, for the portable archive:
#   cmake/ffmpeg.sh FOLDER    FOLDER/lib gets them, under Debian's names; FOLDER/sources says what they were made of
# A second run with the same sources and settings does nothing. Root is not needed, and the system's lists of packages stay.
set -euo pipefail
folder=$(realpath -m "$1")
ffmpeg_options=(--disable-static --enable-shared --disable-programs --disable-doc --disable-debug --disable-autodetect
    --disable-avdevice --disable-avfilter --disable-postproc --enable-zlib --enable-gnutls --enable-libdav1d --enable-libopenh264
    --extra-cflags='-include ../hypot.h')  # that of glibc 2.35 is all that would keep it from older ones
heif_options=(-DCMAKE_BUILD_TYPE=Release -DWITH_EXAMPLES=OFF -DWITH_X265=OFF -DWITH_LIBDE265=ON -DWITH_AOM=OFF -DWITH_AOM_DECODER=OFF
    -DWITH_AOM_ENCODER=OFF -DWITH_DAV1D=ON -DWITH_RAV1E=OFF -DWITH_SvtEnc=OFF -DENABLE_PLUGIN_LOADING=OFF)
tiff_options=(-DCMAKE_BUILD_TYPE=Release -Djbig=OFF -Dtiff-tools=OFF -Dtiff-tests=OFF -Dtiff-docs=OFF
    -Dtiff-contrib=OFF -Dtiff-opengl=OFF -Dcxx=OFF)

version_of() { dpkg-query -W -f '${source:Version}' "$1"; }

# What is built has the names and interfaces of the libraries that the program was linked with.
made_of="ffmpeg $(version_of libavcodec-dev) ${ffmpeg_options[*]}
libheif $(version_of libheif-dev) ${heif_options[*]}
tiff $(version_of libtiff-dev) ${tiff_options[*]}"
if [[ -e $folder/sources && $(<"$folder/sources") == "$made_of" ]]; then exit 0; fi

# The system's sources with deb-src; apt keeps the rest of its state below the folder.
mkdir -p "$folder"/apt/{lists/partial,archives/partial,sources}
for list in /etc/apt/sources.list.d/*.sources; do
    [[ ! -e $list ]] || sed 's/^Types:.*/Types: deb-src/' "$list" >"$folder/apt/sources/$(basename "$list")"
done
for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [[ ! -e $list ]] || sed -n 's/^deb /deb-src /p' "$list" >"$folder/apt/sources/$(basename "$list" .list).list"
done
apt_options=(-o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$folder/apt/sources" -o Dir::State="$folder/apt"
    -o Dir::State::status=/var/lib/dpkg/status -o Dir::Cache="$folder/apt" -o APT::Sandbox::User="$(id -un)")
apt-get "${apt_options[@]}" -q update
rm -rf "$folder"/{lib,source,sources}
mkdir -p "$folder/source" "$folder/lib"
cd "$folder/source"
for package in "ffmpeg=$(version_of libavcodec-dev)" "libheif=$(version_of libheif-dev)" "tiff=$(version_of libtiff-dev)"; do
    apt-get "${apt_options[@]}" -q source "$package"
done
echo '__asm__(".symver hypot,hypot@GLIBC_2.2.5");' >hypot.h
(
    cd ffmpeg-*/
    ./configure --prefix="$folder/installed" "${ffmpeg_options[@]}"
    make -j"$(nproc)"
    make install
)
build() {  # source folder, option...
    cmake -S "$1" -B "$1/build" -DCMAKE_INSTALL_PREFIX="$folder/installed" -DCMAKE_INSTALL_LIBDIR=lib "${@:2}"
    cmake --build "$1/build" -j"$(nproc)"
    cmake --install "$1/build"
}
build libheif-*/ "${heif_options[@]}"
build tiff-*/ "${tiff_options[@]}"
for library in "$folder"/installed/lib/lib{av,sw,heif,tiff}*.so.*; do
    name=$(objdump -p "$library" | awk '$1 == "SONAME" { print $2 }')
    cp -L "$library" "$folder/lib/$name"
done
rm -rf "$folder/source" "$folder/installed"
echo "$made_of" >"$folder/sources"
