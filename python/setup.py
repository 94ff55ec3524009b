# SPDX-License-Identifier: Apache-2.0
"""What pyproject.toml cannot say: the version, which the project's CMakeLists.txt has; the shared libraries, which go into the
wheel; and their C++ sources, which go into an sdist. The libraries are taken from the folder that TOUCHABLE_LIBRARIES names,
where libtouchable-media may be absent, and built where it names none."""

import functools
import os
import pathlib
import re
import shutil
import subprocess

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist
from wheel.bdist_wheel import bdist_wheel

here = pathlib.Path(__file__).resolve().parent
top = here / "source" if (here / "source").is_dir() else here.parent  # in an sdist; in the repository
sources = ("CMakeLists.txt", "LICENSE", "capi", "cmake", "device", "engine", "haptics_cpu", "shaders")
libraries = ("libtouchable.so.0", "libtouchable-media.so.0")
everywhere = {"libc.so.6", "libm.so.6", "libgcc_s.so.1", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}  # of any Linux
programs = {"c++": "g++", "cmake": "cmake", "ninja": "ninja-build", "pkg-config": "pkg-config"}  # and Debian's packages of them
packages = ("libglm-dev nlohmann-json3-dev libxxhash-dev libavformat-dev libavcodec-dev libavutil-dev libswresample-dev "
            "libswscale-dev libsrt-gnutls-dev libzstd-dev libzip-dev libtiff-dev libopenexr-dev liblz4-dev libbz2-dev libsqlite3-dev "
            "libheif-dev libpugixml-dev zlib1g-dev")


def version():
    try:
        text = (top / "CMakeLists.txt").read_text()
    except OSError as problem:
        raise SystemExit(f"the version is in the repository's CMakeLists.txt: {problem}; build the wheel in the repository, "
                         "with --wheel, or of an sdist") from None
    return re.search(r"project\(touchable VERSION ([0-9.]+)", text)[1]


@functools.lru_cache(maxsize=None)
def folder_of_libraries():
    """TOUCHABLE_LIBRARIES, from the top of the repository where it is no absolute path; else where they are built."""
    if "TOUCHABLE_LIBRARIES" not in os.environ:
        return built()
    folder = top / os.environ["TOUCHABLE_LIBRARIES"]
    if not (folder / libraries[0]).exists():
        raise SystemExit(f"{folder} has no {libraries[0]}; build it (cmake --build --preset release --target touchable_shared "
                         "touchable_media_shared), name its folder in TOUCHABLE_LIBRARIES, or name none: then it is built")
    return folder


def built():
    """The folder of the libraries, built now: in the release build where there is one, else in one of their own."""
    install = f"on Debian: sudo apt install {' '.join(programs.values())} {packages}"
    missing = [program for program in programs if not shutil.which(program)]
    if missing:
        raise SystemExit(f"the C++ libraries of touchable cannot be built: there is no {' and no '.join(missing)}; {install}")
    release, own = top / "build/release", top / "build/libraries"
    folder = release if (release / "CMakeCache.txt").exists() else own
    if folder == own:
        configured = subprocess.run(
            ["cmake", "-S", top, "-B", own, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON",
             "-DCMAKE_UNITY_BUILD_BATCH_SIZE=0", "-DTOUCHABLE_PARTS=libraries"], stderr=subprocess.PIPE, text=True)
        if configured.returncode:
            raise SystemExit(f"the C++ libraries of touchable cannot be built; CMake says:\n{configured.stderr}\n{install}")
    if subprocess.run(["cmake", "--build", folder, "--target", "touchable_shared", "touchable_media_shared"]).returncode:
        raise SystemExit("the C++ libraries of touchable cannot be built; the compiler's errors are above")
    return folder / "capi"


def taken():
    return [folder_of_libraries() / name for name in libraries if (folder_of_libraries() / name).exists()]


class BuildWithLibraries(build_py):
    def run(self):
        super().run()
        into = pathlib.Path(self.build_lib) / "touchable" / "lib"
        into.mkdir(parents=True, exist_ok=True)
        for library in taken():
            shutil.copyfile(library, into / library.name)


class SdistWithSources(sdist):
    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        for name in sources:
            into = pathlib.Path(base_dir) / "source" / name
            if (top / name).is_dir():
                shutil.copytree(top / name, into, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                into.parent.mkdir(exist_ok=True)
                shutil.copyfile(top / name, into)
        licence = pathlib.Path(base_dir) / "LICENSE"  # in the repository a link
        licence.unlink()
        shutil.copyfile(top / "LICENSE", licence)


class WheelOfLibraries(bdist_wheel):
    """For every Python 3. Libraries that need nothing but a C library of 2.N or newer are for any such Linux (PEP 600); others
    are for the machine that builds them."""

    def get_tag(self):
        said = subprocess.run(["readelf", "-hdVW", *taken()], check=True, stdout=subprocess.PIPE, text=True,
                              env={**os.environ, "LC_ALL": "C"}).stdout if shutil.which("readelf") else "(NEEDED) [?]"
        if set(re.findall(r"\(NEEDED\).*\[(.+)\]", said)) <= everywhere:
            newest = max(map(int, re.findall(r"\bGLIBC_2\.(\d+)", said)))
            return "py3", "none", f"manylinux_2_{newest}_{'aarch64' if 'AArch64' in said else 'x86_64'}"
        return "py3", "none", super().get_tag()[2]


class WithLibraries(Distribution):
    def has_ext_modules(self):
        return True


setup(version=version(), distclass=WithLibraries,
      cmdclass={"build_py": BuildWithLibraries, "sdist": SdistWithSources, "bdist_wheel": WheelOfLibraries})
