"""The examples, as a user runs them."""
import pathlib
import runpy
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).parent / "examples"


@pytest.mark.parametrize("example, pictures, words", [
    ("ct", ["head.png", "head_mip.png"], "same picture: True"),
    ("fem", ["beam.png", "beam_stress.png"], "0 pixels missed, 0 false"),
    ("certified_rays", [], "1000000 of 1000000 rays"),
])
def test_examples_run(tmp_path, monkeypatch, capsys, example, pictures, words):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [example])
    runpy.run_path(str(EXAMPLES / f"{example}.py"), run_name="__main__")
    assert words in capsys.readouterr().out
    for picture in pictures:
        assert (tmp_path / picture).stat().st_size > 5_000
