"""The examples in docstrings and in the README, as a user types them."""
import doctest
import importlib
import pathlib
import pkgutil
import re

import numpy
import pytest
import rhoray as rr
from conftest import CENTRE, distance_samples

MODULES = [module.name for module in pkgutil.iter_modules(rr.__path__)]
README = pathlib.Path(__file__).resolve().parents[2] / "tools/python/README.md"


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name):
    tests = doctest.DocTestFinder(exclude_empty=True).find(importlib.import_module(f"rhoray.{name}"))
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    said = []
    for test in tests:
        runner.run(test, out=said.append)
    assert not runner.failures, "".join(said)


def test_some_docstrings_have_examples():
    finder = doctest.DocTestFinder()
    examples = {name: sum(len(test.examples) for test in finder.find(importlib.import_module(f"rhoray.{name}")))
                for name in MODULES}
    assert examples["_rays"] > 5 and examples["_pictures"] > 3, examples


def test_the_first_lines_of_the_readme(tmp_path, monkeypatch):
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    code, _, others = code.partition("\nrr.info(")  # test_program.py calls the functions that start the program
    assert others
    monkeypatch.chdir(tmp_path)
    rr.pack({"u": distance_samples() / 20}, spacing=(0.5, 0.5, 0.5), path="torso.rho")
    origins, directions = numpy.tile(CENTRE, (3, 1)), numpy.eye(3)
    names = {"origins": origins, "directions": directions, "points": origins + directions}
    exec(code, names)
    assert (tmp_path / "torso.png").stat().st_size > 5_000
    assert numpy.allclose(names["h"].t, 5, atol=0.05)
    assert names["values"].shape == (3,)
