"""Installs the library by `cmake --install`, and builds its examples as other projects would."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"
EXAMPLES = ("picture", "array", "rays", "progressive")
PNG_BEGIN = b"\x89PNG\r\n\x1a\n"


def run(*words, **options):
    options = {"capture_output": True, "text": True, "check": False, "timeout": 5400, **options}
    return subprocess.run([str(word) for word in words], **options)


class WithFolder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="rhoray-library-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        # Distances from the middle of 24^3 samples.
        middle = numpy.mgrid[:24, :24, :24] - 11.5
        numpy.save(cls.folder / "ball.npy", numpy.sqrt((middle ** 2).sum(axis=0)).astype(numpy.float32))
        cls.succeed(BUILD / "bin/rhoray", "pack", cls.folder / "ball.npy", "-o", cls.folder / "ball.rho")

    @staticmethod
    def succeed(*words, **options):
        done = run(*words, **options)
        if done.returncode != 0:
            command = " ".join(map(str, words))
            raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return done

    def build(self, name, source, *options):
        """Configures and builds a project, and returns its build folder."""
        build = self.folder / name
        self.succeed("cmake", "-S", source, "-B", build, "-G", "Ninja", *options)
        self.succeed("cmake", "--build", build)
        return build

    def check_examples(self, programs, library=None):
        """Runs all examples. @param library  the folder to load the library from; None: where it was linked"""
        environment = {**os.environ, **({"LD_LIBRARY_PATH": str(library)} if library else {})}

        def example(name, *words):
            return run(programs / name, *words, cwd=self.folder, env=environment)
        for name, words, says in (("picture", ["ball.rho", "8", "picture.png"], ""),
                                  ("array", ["array.png"], "exact arithmetic: 0 missed, 0 false"),
                                  ("rays", ["ball.rho", "8"], "hits; every t is proven"),
                                  ("progressive", ["ball.rho", "4", "9", "progressive.png"], "complete")):
            picture = self.folder / f"{name}.png"
            picture.unlink(missing_ok=True)
            done = example(name, *words)
            self.assertEqual((done.returncode, done.stderr), (0, ""), name)
            self.assertIn(says, done.stdout)
            if name != "rays":
                self.assertEqual(picture.read_bytes()[:8], PNG_BEGIN)
        for name, words, code, says in (
                ("picture", ["missing.rho", "8", "no.png"], 3, "picture: missing.rho: No such file or directory"),
                ("picture", ["ball.npy", "8", "no.png"], 7, "picture: ball.npy: is not a packed file"),
                ("picture", ["ball.rho", "nan", "no.png"], 2, "nan; expected a finite number"),
                ("picture", ["ball.rho", "8", "no/no.png"], 2, "no/no.png: cannot write into the folder no"),
                ("array", ["no/no.png"], 2, "no/no.png: cannot write into the folder no"),
                ("rays", ["ball.rho", "nan"], 2, "nan; expected a finite number"),
                ("progressive", ["ball.rho", "nan", "9", "no.png"], 2, "nan; expected a finite number")):
            done = example(name, *words)
            self.assertEqual(done.returncode, code, (name, words, done.stderr))
            self.assertIn(says, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        for name in EXAMPLES:
            done = example(name)
            self.assertEqual((done.returncode, done.stdout.startswith(f"usage: {name} ")), (2, True), name)


class Installed(WithFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.prefix = cls.folder / "first"
        for component in ("librhoray", "librhoray-dev"):
            cls.succeed("cmake", "--install", BUILD, "--component", component, "--prefix", cls.prefix, "--strip")
        cls.examples = cls.folder / "examples"
        shutil.copytree(cls.prefix / "share/doc/rhoray/examples", cls.examples)
        cls.programs = cls.folder / "programs"
        cls.build(cls, cls.programs, cls.examples, f"-DCMAKE_PREFIX_PATH={cls.prefix}")
        cls.check_first = cls.folder / "ball.png"
        done = cls.succeed(cls.programs / "picture", "ball.rho", "8", cls.check_first, cwd=cls.folder)
        assert done.stdout == "", done.stdout
        # From here on there is no first prefix any more.
        moved = cls.folder / "moved"
        shutil.move(cls.prefix, moved)
        cls.prefix = moved
        cls.libraries = next(moved.rglob("librhoray.so")).parent
        cls.headers = sorted((moved / "include/rhoray").iterdir())

    def configure(self, text, *options):
        """Configures a project with these lines."""
        source = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        (source / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.25)\nproject(other LANGUAGES CXX)\n{text}\n")
        return run("cmake", "-S", source, "-B", source / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.prefix}",
                   *options)

    def test_holds_the_files_of_a_library_and_no_program(self):
        libraries = str(self.libraries.relative_to(self.prefix))
        files = sorted(str(path.relative_to(self.prefix)) for path in self.prefix.rglob("*") if not path.is_dir())
        expected = [f"{libraries}/librhoray.so{version}" for version in ("", ".0.1", ".0.1.0")]
        expected += [f"{libraries}/cmake/Rhoray/Rhoray{name}.cmake"
                     for name in ("Config", "ConfigVersion", "Targets", "Targets-release")]
        expected += [f"{libraries}/pkgconfig/rhoray.pc", "include/rhoray/version.h"]
        expected += [f"include/rhoray/{path.name}" for path in (ROOT / "tools/library/rhoray").glob("*.h")]
        expected += [f"share/doc/rhoray/examples/{path.name}"
                     for path in (ROOT / "tools/library/examples").iterdir()]
        self.assertEqual(files, sorted(expected))

    def test_nothing_names_the_folder_of_the_build_or_the_first_prefix(self):
        for path in self.prefix.rglob("*"):
            if path.is_file():
                for folder in (ROOT / "build", self.folder / "first"):
                    self.assertNotIn(str(folder).encode(), path.read_bytes(), path)

    def test_programs_run_with_the_moved_library(self):
        self.check_examples(self.programs, self.libraries)

    def test_examples_are_built_against_the_moved_prefix(self):
        build = self.build("moved-build", self.examples, f"-DCMAKE_PREFIX_PATH={self.prefix}")
        self.check_examples(build)

    def test_examples_are_built_by_clang(self):
        build = self.build("clang-build", self.examples, f"-DCMAKE_PREFIX_PATH={self.prefix}",
                           "-DCMAKE_CXX_COMPILER=clang++")
        self.check_examples(build)

    def test_an_example_is_built_by_pkg_config(self):
        environment = {**os.environ, "PKG_CONFIG_PATH": str(self.libraries / "pkgconfig")}
        self.succeed("sh", "-c", "g++ -std=c++20 examples/picture.cpp $(pkg-config --cflags --libs rhoray) -o by_hand",
                     cwd=self.folder, env=environment)
        self.succeed(self.folder / "by_hand", "ball.rho", "8", "by_hand.png", cwd=self.folder,
                     env={**os.environ, "LD_LIBRARY_PATH": str(self.libraries)})
        # Another compiler line, the same picture.
        self.assertEqual((self.folder / "by_hand.png").read_bytes(), self.check_first.read_bytes())
        version = self.succeed("pkg-config", "--modversion", "rhoray", env=environment).stdout.strip()
        self.assertIn(f'"{version}"', (self.prefix / "include/rhoray/version.h").read_text())

    def test_find_package_gives_every_component(self):
        done = self.configure("find_package(Rhoray 0.1 REQUIRED COMPONENTS formats render preprocess)\n"
                              "find_package(Rhoray 0.1 REQUIRED)  # again, as in another folder of a project\n"
                              "foreach(name rhoray formats render preprocess)\n"
                              "  if(NOT TARGET Rhoray::${name})\n"
                              "    message(FATAL_ERROR ${name})\n"
                              "  endif()\n"
                              "endforeach()")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_find_package_refuses_an_unknown_component(self):
        done = self.configure("find_package(Rhoray 0.1 REQUIRED COMPONENTS render viewer)")
        self.assertEqual(done.returncode, 1)
        self.assertIn("Unknown component 'viewer'; expected formats, render or preprocess", done.stderr)

    def test_find_package_refuses_other_versions(self):
        for version in ("0.0", "0.1.1", "0.2", "1.0"):
            done = self.configure(f"find_package(Rhoray {version} REQUIRED)")
            self.assertEqual(done.returncode, 1, version)
            self.assertIn(f'compatible with requested version "{version}"', " ".join(done.stderr.split()))

    def test_each_header_needs_the_standard_library_alone(self):
        flags = ["-std=c++20", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Werror",
                 f"-I{self.prefix / 'include'}"]
        (self.folder / "all.txt").write_text("".join(f"-include\nrhoray/{path.name}\n" for path in self.headers))
        used = self.succeed("g++", *flags, "-M", f"@{self.folder / 'all.txt'}", "-x", "c++", "/dev/null").stdout
        others = [path for path in used.replace("\\\n", " ").split()[1:]
                  if not path.startswith((f"{self.prefix}/include/rhoray/", "/usr/lib/gcc/", "/dev/null"))]
        self.assertGreater(len(others), 100)
        packages = {re.sub(r"[-\d]*-dev$", "", line.split(":")[0])
                    for line in self.succeed("dpkg", "-S", *others).stdout.splitlines()}
        self.assertEqual(packages, {"libc", "libstdc++", "linux-libc"})
        for compiler in ("g++", "clang++"):
            for header in self.headers:
                self.succeed(compiler, *flags, "-fsyntax-only", "-include", f"rhoray/{header.name}",
                             "-x", "c++", "/dev/null")


class Subproject(WithFolder):
    """A project with settings of its own that adds the sources of the library."""
    PARENT = """cmake_minimum_required(VERSION 3.25)
project(parent LANGUAGES CXX)
set(CMAKE_CXX_STANDARD 23)
add_compile_definitions(OF_PARENT)
enable_testing()
set(settings CMAKE_CXX_STANDARD CMAKE_CXX_STANDARD_REQUIRED CMAKE_CXX_EXTENSIONS CMAKE_CXX_FLAGS CMAKE_BUILD_TYPE
             CMAKE_POSITION_INDEPENDENT_CODE CMAKE_CXX_VISIBILITY_PRESET CMAKE_VISIBILITY_INLINES_HIDDEN
             CMAKE_EXPORT_COMPILE_COMMANDS CMAKE_RUNTIME_OUTPUT_DIRECTORY CMAKE_CXX_COMPILER_LAUNCHER BUILD_TESTING
             BUILD_SHARED_LIBS CMAKE_UNITY_BUILD CMAKE_FIND_PACKAGE_TARGETS_GLOBAL)
foreach(setting IN LISTS settings)
  set(before_${setting} "${${setting}}")
endforeach()
add_subdirectory(%s rhoray)
foreach(setting IN LISTS settings)
  if(NOT "${${setting}}" STREQUAL "${before_${setting}}")
    message(FATAL_ERROR "${setting} was '${before_${setting}}' and is '${${setting}}'")
  endif()
endforeach()
foreach(property COMPILE_OPTIONS LINK_OPTIONS INCLUDE_DIRECTORIES)
  get_property(value DIRECTORY PROPERTY ${property})
  if(value)
    message(FATAL_ERROR "${property}: ${value}")
  endif()
endforeach()
add_executable(picture %s/picture.cpp)
target_link_libraries(picture PRIVATE Rhoray::render)
install(TARGETS picture)
"""

    def test_keeps_the_settings_of_its_parent(self):
        source, build = self.folder / "parent", self.folder / "parent-build"
        source.mkdir()
        (source / "CMakeLists.txt").write_text(self.PARENT % (ROOT, ROOT / "tools/library/examples"))
        self.succeed("cmake", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_CXX_FLAGS=-DFLAG_OF_PARENT",
                     "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")
        self.assertIn("CMAKE_BUILD_TYPE:STRING=\n", (build / "CMakeCache.txt").read_text())
        commands = json.loads((build / "compile_commands.json").read_text())
        own = [entry["command"] for entry in commands if entry["file"].endswith("picture.cpp")
               and "/examples/" in entry["file"]]
        self.assertEqual(len(own), 1)
        for word in ("-DFLAG_OF_PARENT", "-DOF_PARENT", "-std=gnu++23"):
            self.assertIn(f" {word} ", own[0])
        for word in ("-Werror", "-ffp-contract", "-fvisibility", "ccache"):
            self.assertNotIn(word, own[0])
        # Only the library: no program, test, worker or recipe of ours.
        folders = {pathlib.Path(entry["file"]).resolve().relative_to(ROOT).parts[:2] for entry in commands
                   if pathlib.Path(entry["file"]).resolve().is_relative_to(ROOT)}
        self.assertLessEqual({parts for parts in folders if parts[0] in ("tools", "tests", "data")},
                             {("tools", "library")})
        self.assertIn("Total Tests: 0", self.succeed("ctest", "-N", "--test-dir", build).stdout)
        self.succeed("cmake", "--build", build, "--target", "CMakeFiles/picture.dir" + own[0].split(
            "CMakeFiles/picture.dir")[1].split()[0])
        # Its rules of installation, and none of ours.
        for script in (build / "rhoray").rglob("cmake_install.cmake"):
            self.assertFalse("file(INSTALL" in script.read_text(), script)

    def test_the_library_alone_needs_no_library_that_reads_foreign_files(self):
        build = self.folder / "alone-build"
        missing = ("VTK", "OpenVDB", "CGAL", "Eigen3", "CLI11")
        self.succeed("cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DRHORAY_PROGRAMS=OFF", "-DRHORAY_TESTS=OFF",
                     *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in missing))
        rules = "".join(path.read_text() for path in build.rglob("cmake_install.cmake"))
        self.assertEqual(set(re.findall(r'COMPONENT}? STREQUAL "([^"]*)"', rules)),
                         {"librhoray", "librhoray-dev", "rhoray-doc"})

    def test_examples_are_built_with_the_sources(self):
        """Compiles the library without optimisation: three minutes on two cores."""
        build = self.build("subproject", ROOT / "tools/library/examples", f"-DRHORAY_SOURCE_DIR={ROOT}",
                           "-DRHORAY_BASELINE_KERNELS=ON")
        self.check_examples(build)


if __name__ == "__main__":
    unittest.main()
