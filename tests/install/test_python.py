"""Installs the Python module by `cmake --install` and by pip, and uses it."""
import os
import pathlib
import re
import shutil
import subprocess
import sysconfig
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCE = ROOT / "tools/python"
USE = ROOT / "tools/setup/debian/tests/python"  # draws and traces, and prints where module and program are
SYSTEM_PYTHON = "/usr/bin/python3"  # it also runs this test
CORE = "_core" + sysconfig.get_config_var("EXT_SUFFIX")


def run(*words, **variables):
    """Runs a command without the variables that name a module or a library elsewhere."""
    environment = {name: value for name, value in os.environ.items()
                   if name not in ("PYTHONPATH", "LD_LIBRARY_PATH", "RHORAY_PROGRAM", "CMAKE_PREFIX_PATH")}
    environment.update(PYTHONDONTWRITEBYTECODE="1", PIP_NO_INDEX="1",
                       **{name: str(value) for name, value in variables.items()})
    return subprocess.run([str(word) for word in words], env=environment, capture_output=True, text=True, check=False,
                          timeout=600)


def succeed(*words, **variables):
    done = run(*words, **variables)
    if done.returncode != 0:
        command = " ".join(map(str, words))
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def module_in(prefix):
    """The folder of the installed module."""
    return next(prefix.glob("lib/python3*/dist-packages/rhoray"))


def names_in(folder):
    """The names of the files in a folder."""
    return {path.name for path in folder.iterdir() if path.is_file()}


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="rhoray-python-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name).resolve()
        first, cls.prefix = cls.folder / "first", cls.folder / "moved"
        for component in ("librhoray", "librhoray-dev", "python3-rhoray", "rhoray"):
            succeed("cmake", "--install", ROOT / "build/release", "--component", component, "--prefix", first,
                    "--strip")
        cls.used_first = (cls.used_in(first), [module_in(first), first / "bin/rhoray"])
        shutil.move(first, cls.prefix)

    @staticmethod
    def used_in(prefix):
        """The folder of the module that was used, and the program that it found."""
        printed = succeed(SYSTEM_PYTHON, USE, PYTHONPATH=module_in(prefix).parent)
        return [pathlib.Path(line) for line in printed.splitlines()]

    def copy_of_sources(self, name):
        source = self.folder / name
        shutil.copytree(SOURCE, source / "tools/python")
        shutil.copy(ROOT / "CMakeLists.txt", source)
        return source

    def test_works_in_a_prefix_and_after_the_prefix_moved(self):
        self.assertEqual(*self.used_first)
        self.assertEqual(self.used_in(self.prefix), [module_in(self.prefix), self.prefix / "bin/rhoray"])

    def test_holds_every_file_and_the_compiled_part_for_this_python(self):
        expected = names_in(SOURCE / "rhoray")
        self.assertLessEqual({"__init__.py", "__init__.pyi", "py.typed"}, expected)
        self.assertEqual(names_in(module_in(self.prefix)), expected | {CORE})

    def test_is_built_to_find_the_library_relative_to_itself(self):
        dynamic = succeed("readelf", "-d", ROOT / "build/release/python/rhoray" / CORE)
        self.assertRegex(dynamic, r"Library runpath: \[\$ORIGIN/[^/]")

    def test_pip_installs_it_over_the_library_and_removes_it(self):
        """Compiles the module: 20 s of processor time. It needs no sources but those that are copied."""
        source = self.copy_of_sources("source")
        before = sorted(source.rglob("*"))
        environment = self.folder / "environment"
        succeed(SYSTEM_PYTHON, "-m", "venv", "--system-site-packages", environment)
        pip, python = environment / "bin/pip", environment / "bin/python3"
        succeed(pip, "install", "--no-build-isolation", source / "tools/python", CMAKE_PREFIX_PATH=self.prefix)
        self.assertEqual(sorted(source.rglob("*")), before)

        installed = next(environment.glob("lib/python3*/site-packages/rhoray"))
        program = self.prefix / "bin/rhoray"
        printed = succeed(python, USE, PATH=f"{program.parent}:{os.environ['PATH']}")
        self.assertEqual(printed, f"{installed}\n{program}\n")
        self.assertEqual(names_in(installed), names_in(source / "tools/python/rhoray") | {CORE})
        version = succeed(python, "-c", "import importlib.metadata; print(importlib.metadata.version('rhoray'))")
        expected = re.search(r"^project\(rhoray VERSION (\S+)", (source / "CMakeLists.txt").read_text(), re.M)
        self.assertEqual(version.strip(), expected[1])

        succeed(pip, "uninstall", "--yes", "rhoray")
        self.assertEqual(list(environment.glob("lib/python3*/site-packages/rhoray*")), [])

    def test_a_build_without_the_library_says_how_to_get_it(self):
        hint = "Install it (Debian: librhoray-dev), or set CMAKE_PREFIX_PATH to the prefix where it is installed."
        done = run("cmake", "-S", SOURCE, "-B", self.folder / "without", "-DCMAKE_DISABLE_FIND_PACKAGE_Rhoray=ON")
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"was not found. {hint}", " ".join(done.stderr.split()))

        later = self.copy_of_sources("later")
        project = later / "CMakeLists.txt"
        text, count = re.subn(r"^(project\(rhoray VERSION )\S+", r"\g<1>98.7.6", project.read_text(), flags=re.M)
        self.assertEqual(count, 1)
        project.write_text(text)
        done = run("cmake", "-S", later / "tools/python", "-B", later / "build", CMAKE_PREFIX_PATH=self.prefix)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(" ".join(done.stderr.split()),
                         rf"Rhoray 98\.7\.6 was not found \(found: [0-9.]+\)\. {re.escape(hint)}")


if __name__ == "__main__":
    unittest.main()
