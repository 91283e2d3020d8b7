"""Builds the module for pip: CMake compiles it over an installed library.

    python3 -m venv --system-site-packages environment
    environment/bin/pip install --no-build-isolation ./tools/python

CMAKE_PREFIX_PATH names the prefix of the library, if it is not a system folder. The module looks for the library there.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import setuptools
from setuptools.command.build_ext import build_ext

FOLDER = pathlib.Path(__file__).resolve().parent
PACKAGES = "cmake, g++, librhoray-dev, make, pybind11-dev and python3-dev"


class BuildByCMake(build_ext):
    """Lets CMake build the only extension."""

    def build_extension(self, ext):
        if shutil.which("cmake") is None:
            sys.exit(f"rhoray: cmake was not found. Building the module needs the Debian packages {PACKAGES}.")
        build = pathlib.Path(self.build_temp, "cmake").resolve()
        configure = ["cmake", "-S", FOLDER, "-B", build, "-DCMAKE_BUILD_TYPE=Release",
                     f"-DPython_EXECUTABLE={sys.executable}"]
        for command in (configure, ["cmake", "--build", build, "--parallel", str(os.cpu_count())]):
            if subprocess.run(command, check=False).returncode != 0:
                sys.exit("rhoray: CMake failed; the lines above say why. Building the module needs the Debian packages "
                         f"{PACKAGES}.")
        target = pathlib.Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / "python/rhoray" / target.name, target)


version = re.search(r"^project\(rhoray VERSION ([\d.]+)", (FOLDER / "../../CMakeLists.txt").read_text(), re.M)[1]
with tempfile.TemporaryDirectory(prefix="rhoray-pip-") as scratch:  # the tree of the sources stays as it is
    setuptools.setup(version=version, packages=["rhoray"], package_data={"rhoray": ["*.pyi", "py.typed"]},
                     cmdclass={"build_ext": BuildByCMake}, ext_modules=[setuptools.Extension("rhoray._core", [])],
                     options={"build": {"build_base": scratch}, "egg_info": {"egg_base": scratch}})
