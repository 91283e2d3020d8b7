"""The report on the accuracy and speed of every method."""
import dataclasses
import os
import pathlib
import tempfile

import numpy

from rhoray import _program, _scenes
from rhoray._commands import file_of
from rhoray._data import Data


@dataclasses.dataclass(frozen=True, eq=False)
class Accuracy:
    """Errors and times of every method, and what follows from them.

    columns: arrays of one length by name, a row for each layer and variant; NaN: not measured.
        pandas.DataFrame(a.columns) is the table.
    units, meanings: of the columns, by name.
    conclusions, notes: sentences. facts: about the run, by name.
    report: the page report.html in the folder; None: no folder was given.
    """
    columns: dict
    units: dict
    meanings: dict
    conclusions: list
    notes: list
    facts: dict
    report: str | None

    def __repr__(self):
        return "\n".join([f"<rhoray.Accuracy: {len(self.columns['variant'])} variants>", *self.conclusions])


def accuracy(what, folder="", *, data=None, replace=False, progress=None, **options):
    """Measures error and time of every method, as `rhoray accuracy` does. Returns Accuracy.

    what: Data, the path of any file that is read, or a scene document: a dict, or a .json file.
    folder: for the report, its pictures and the tables; created if missing. replace: overwrite one.
    data: of a scene: Data by the names in its "data"; others are opened by their files.
    Options are those of `rhoray accuracy`, such as iso, mode, field, size=(width, height), time_limit (s;
    default 600), repeat (times that each variant is timed), seed, max_error (cells), budget_ms, memory.

    Ctrl+C ends it. With a folder, the report of what was measured is written first.
    """
    with tempfile.TemporaryDirectory(prefix="rhoray-") as temporary:
        file, options = _input(what, data, options, temporary)
        output = os.fspath(folder) if folder else f"{temporary}/results"
        words = [f"--output={output}", *(["--force"] if replace else []), *_program.option_words(options)]
        results = _program.run("accuracy", [file], words, progress, keeps_results=bool(folder))
    return Accuracy(columns={column["name"]: _column([row[column["name"]] for row in results["rows"]])
                             for column in results["columns"]},
                    units={column["name"]: column["unit"] for column in results["columns"]},
                    meanings={column["name"]: column["meaning"] for column in results["columns"]},
                    conclusions=results["conclusions"], notes=results["notes"], facts=results["context"],
                    report=os.path.join(output, "report.html") if folder else None)


def _input(what, data, options, folder):
    """The program's input, and the options with the field that Data show."""
    if isinstance(what, Data):
        return file_of(what), {"field": what._name or None, **options}
    if not isinstance(what, dict) and not data:
        return file_of(what), options
    path = os.path.join(folder, "scene.json")
    document = _scenes.with_paths(*_scenes.read(what, data, {}, "accuracy"))
    pathlib.Path(path).write_text(_scenes.text_of(document, "accuracy"), encoding="utf-8")
    return path, options


def _column(values):
    """An array: of texts, booleans, integers, or floats with NaN for None."""
    if any(value is None for value in values):
        return numpy.array([numpy.nan if value is None else value for value in values], dtype=float)
    return numpy.array(values)
