"""Scene documents, as `render`, `view` and `accuracy` take them."""
import json
import os
import pathlib

import numpy

from rhoray._data import Data, open  # noqa: A004  (the command's name)
from rhoray._errors import UsageError


def _without_none(**keys):
    return {key: value for key, value in keys.items() if value is not None}


def _layer(data, iso, mode, **keys):
    kinds = {"iso": "isosurface", "mip": "mip", "triangles": "triangles", "boundary": "boundary"}
    if mode is None:
        by_kind = {"grid": "iso", "tetrahedra": "boundary", "triangles": "triangles"}
        mode = "iso" if iso is not None else by_kind[data.kind]
    if mode not in kinds:
        raise UsageError(f"mode: {mode!r}; expected 'iso', 'mip', 'boundary' or 'triangles'")
    layer = {"data": "data", "type": kinds[mode]}
    layer.update(_without_none(**keys))
    if iso is not None:
        layer["isovalue"] = list(iso) if isinstance(iso, (list, tuple, numpy.ndarray)) else iso
    return layer


def document_of(data, iso=None, mode=None, size=None, accuracy=None, view=None, azimuth=None, elevation=None, zoom=None,
              camera=None, color=None, color_by=None, colormap=None, range=None, opacity=None, normals=None,  # noqa: A002
              style=None, lights=None, effects=None, clip=None, background=None, antialias=None):
    """The scene document that the options of `render` say, for one dataset named "data"."""
    document = {"data": {"data": _without_none(file="data", field=data._name or None)},
                "layers": [_layer(data, iso, mode, color=color, color_by=color_by, colormap=colormap,
                                  range=list(range) if range is not None else None, opacity=opacity,
                                  normals=normals)],
                "camera": {**_without_none(view=view, azimuth=azimuth, elevation=elevation, zoom=zoom),
                           **(camera or {})},
                "image": _without_none(size=list(size) if size is not None else None, background=background,
                                       antialias=antialias)}
    document.update(_without_none(accuracy=accuracy, style=style, lights=lights, effects=effects, clip=clip))
    return document


_reading_keys = ("raw", "spacing", "origin", "time")


def read(what, data, options, where):
    """(document, known) of what `render`, `view` and `accuracy` take. known: Data, or paths of files, by name.

    where: the function's name, for messages.
    """
    if isinstance(what, Data):
        return document_of(what, **options), {"data": what}
    if options:
        raise UsageError(f"{where}: a scene has its own {', '.join(options)}; expected keys in its document")
    folder, document = pathlib.Path(), what
    if not isinstance(what, dict):
        folder, document = pathlib.Path(what).parent, json.loads(pathlib.Path(what).read_text(encoding="utf-8"))
    given, known, specs = data or {}, {}, {}
    for name, spec in document.get("data", {}).items():
        file = spec.get("file", name)
        known[name] = given.get(name, given.get(file, folder / file))
        field = known[name]._name if isinstance(known[name], Data) else ""
        specs[name] = {**({"field": field} if field else {}), **spec, "file": file}
    return {**document, "data": specs}, known


def opened(document, known):
    """Data by name, where `known` may have paths. What several names read in the same way is opened once."""
    result, by_reading = {}, {}
    for name, data in known.items():
        if not isinstance(data, Data):
            spec = document["data"][name]
            reading = {key: spec[key] for key in _reading_keys if key in spec}
            same = os.path.abspath(data), repr(reading)
            data = by_reading[same] = by_reading.get(same) or open(data, **reading)
        result[name] = data
    return result


def with_files(document, files):
    """The document with other files, by the names of the data."""
    return {**document, "data": {name: {**spec, "file": files[name]} for name, spec in document["data"].items()}}


def with_paths(document, known):
    """The document with files that the program can open. Those of Data are packed: they are not read again."""
    packed = {name: {key: value for key, value in spec.items()
                     if key not in _reading_keys or not isinstance(known[name], Data)}
              for name, spec in document["data"].items()}
    return with_files({**document, "data": packed},
                      {name: data.path if isinstance(data, Data) else os.path.abspath(data)
                       for name, data in known.items()})


def text_of(document, where):
    """JSON; numpy's numbers and arrays are taken as those of Python. where: for messages."""
    try:
        return json.dumps(document, allow_nan=False, default=lambda value: value.tolist())
    except ValueError:
        raise UsageError(f"{where}: a number of the scene is NaN or infinite; expected finite numbers") from None
    except AttributeError as error:
        raise UsageError(f"{where}: {error}; expected what JSON can say") from None
