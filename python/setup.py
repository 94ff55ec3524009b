"""What pyproject.toml cannot say: the version, which the project's CMakeLists.txt has, and the two shared libraries, which
are taken from the folder of a build (TOUCHABLE_LIBRARIES) into the wheel."""

import os
import pathlib
import re
import shutil

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from wheel.bdist_wheel import bdist_wheel

top = pathlib.Path(__file__).resolve().parent.parent
libraries = ("libtouchable.so.0", "libtouchable-media.so.0")


def version():
    try:
        text = (top / "CMakeLists.txt").read_text()
    except OSError as problem:
        raise SystemExit(f"the version is in the repository's CMakeLists.txt: {problem}; build the wheel in the repository, "
                         "with --wheel") from None
    return re.search(r"project\(touchable VERSION ([0-9.]+)", text)[1]


def folder_of_libraries():
    """TOUCHABLE_LIBRARIES, from the top of the repository where it is no absolute path."""
    folder = top / os.environ.get("TOUCHABLE_LIBRARIES", "build/release/capi")
    missing = [name for name in libraries if not (folder / name).exists()]
    if missing:
        raise SystemExit(f"{folder} has no {' and no '.join(missing)}; build them (cmake --build --preset release --target "
                         "touchable_shared touchable_media_shared), or name their folder in TOUCHABLE_LIBRARIES")
    return folder


class BuildWithLibraries(build_py):
    def run(self):
        super().run()
        into = pathlib.Path(self.build_lib) / "touchable" / "lib"
        into.mkdir(parents=True, exist_ok=True)
        folder = folder_of_libraries()
        for name in libraries:
            shutil.copyfile(folder / name, into / name)


class WheelOfThisPlatform(bdist_wheel):
    """For every Python 3, on the platform that the libraries were built for."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


class WithLibraries(Distribution):
    def has_ext_modules(self):
        return True


setup(version=version(), distclass=WithLibraries,
      cmdclass={"build_py": BuildWithLibraries, "bdist_wheel": WheelOfThisPlatform})
