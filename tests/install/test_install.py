"""Installs the program by `cmake --install`, moves the prefix, and tests it there."""
import json
import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PATIENCE_S = 30


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="rhoray-install-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        first = cls.folder / "first"
        subprocess.run(["cmake", "--install", ROOT / "build/release", "--prefix", first, "--strip"], check=True,
                       stdout=subprocess.DEVNULL)
        cls.prefix = cls.folder / "moved"
        shutil.move(first, cls.prefix)
        cls.rhoray = cls.prefix / "bin/rhoray"
        cls.environment = {**os.environ, "PATH": f"{cls.prefix / 'bin'}:{os.environ['PATH']}", "HOME": folder.name}
        cls.environment.pop("RHORAY_WORKER_DIR", None)

    def shell(self, line, program="sh"):
        done = subprocess.run([program, "-c", line], cwd=self.prefix, env=self.environment, capture_output=True,
                              text=True, check=False, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout


class Program(Installed):
    def test_passes_its_selftest_with_all_workers(self):
        result = json.loads(self.shell("rhoray selftest --json"))
        for check in result["checks"]:
            if not check["name"].startswith("kernels avx"):
                self.assertEqual(check["result"], "passed", check)

    def test_only_rhoray_is_a_command(self):
        self.assertEqual([path.name for path in (self.prefix / "bin").iterdir()], ["rhoray"])
        parts = sorted(path.name for path in next(self.prefix.glob("lib*/**/rhoray-pictures.so")).parent.iterdir())
        self.assertEqual(parts, ["rhoray-import-worker", "rhoray-pictures.so", "rhoray-repair-worker",
                                 "rhoray-slices-worker", "rhoray-tetgen-worker", "rhoray-validate-worker",
                                 "rhoray-vdb-worker"])

    def test_names_the_package_of_a_missing_worker(self):
        hidden = self.folder / "alone"
        shutil.copytree(self.prefix / "bin", hidden / "bin")
        (hidden / "triangle.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        done = subprocess.run([hidden / "bin/rhoray", "info", "triangle.off"], cwd=hidden, env=self.environment,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 7)
        self.assertIn("hint: the package rhoray-import contains it", done.stderr)

    def test_nothing_names_the_folders_of_the_build_or_the_first_prefix(self):
        for path in self.prefix.rglob("*"):
            if path.is_file():
                content = path.read_bytes()
                for folder in (ROOT / "build", self.folder / "first"):
                    self.assertNotIn(str(folder).encode(), content, path)


class Manuals(Installed):
    def test_are_clean(self):
        pages = sorted((self.prefix / "share/man/man1").iterdir())
        self.assertGreater(len(pages), 15)
        done = subprocess.run(["mandoc", "-T", "lint", *pages], capture_output=True, text=True, check=False)
        # mandoc looks for other pages where the system has its own. Ours are looked for here.
        self.assertEqual([line for line in done.stdout.splitlines() if "referenced manual not found" not in line], [])
        names = {page.stem for page in pages}
        for page in pages:
            self.assertLessEqual(set(re.findall(r"^\.Xr (\S+) 1", page.read_text(), re.M)), names, page)

    def test_there_is_one_of_every_subcommand(self):
        commands = self.shell("rhoray complete '' | grep -v ^-- | cut -f1").split()
        for command in commands:
            if command != "help":
                self.assertIn("EXIT STATUS", self.shell(f"mandoc -T ascii share/man/man1/rhoray-{command}.1 | col -b"))


class Completions(Installed):
    def test_bash(self):
        script = self.prefix / "share/bash-completion/completions/rhoray"
        self.converse(["bash", "--norc", "-i"], [f"source {script}", "bind 'set enable-bracketed-paste off'"])

    def test_zsh(self):
        folder = self.prefix / "share/zsh/vendor-completions"
        self.converse(["zsh", "-f", "-i"], [f"fpath=({folder} $fpath)", "autoload -Uz compinit", "compinit -u -D"])

    def test_fish(self):
        script = self.prefix / "share/fish/vendor_completions.d/rhoray.fish"
        (self.prefix / "a.rho").touch()

        def offered(line):
            return self.shell(f"source {script}; complete -C '{line}'", program="fish").split("\n")[:-1]
        self.assertIn("pack\tPack a volume, a mesh or a surface", offered("rhoray pa"))
        self.assertEqual(offered("rhoray render --colormap cu"), ["cubehelix", "cubehelix_r"])
        self.assertEqual(offered("rhoray render --colormap=cu"), ["--colormap=cubehelix", "--colormap=cubehelix_r"])
        self.assertIn("a.rho", offered("rhoray render a"))

    def converse(self, shell, preparation):
        """Types lines with tabs into a shell, and reads the completed lines."""
        (self.prefix / "some file.rho").touch()
        process, terminal = pty.fork()
        if process == 0:
            os.chdir(self.prefix)
            os.execvpe(shell[0], shell, {**self.environment, "PS1": "ready> ", "TERM": "dumb", "COLUMNS": "200"})
        self.addCleanup(lambda: (os.close(terminal), os.waitpid(process, 0)))

        def type_in(text, answer):
            os.write(terminal, text.encode())
            seen, end = "", time.time() + PATIENCE_S
            while not re.search(answer, seen):
                self.assertLess(time.time(), end, f"{text!r}: expected {answer!r}, found {seen!r}")
                if select.select([terminal], [], [], 0.1)[0]:
                    seen += os.read(terminal, 65536).decode(errors="replace")
        for number, line in enumerate(preparation):
            type_in(f"{line}; echo done{number}$((1))\n", f"done{number}1")
        for text, answer in (("rhoray pa\t", "rhoray pack "), ("rhoray render --colorm\t", "--colormap"),
                             ("rhoray render --colormap tur\t\t\t", "turbo_r"),
                             ("rhoray render --style=pre\t", "presentation"),
                             ("rhoray render some\t", r"some\\ file\.rho")):
            type_in(text, answer)
            type_in("\x15echo cleared$((1))\n", "cleared1")
        os.write(terminal, b"exit\n")


if __name__ == "__main__":
    unittest.main()
