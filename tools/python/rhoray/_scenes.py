"""Scene documents, as `render`, `view` and `accuracy` take them."""
import collections.abc
import json
import os
import pathlib

from rhoray._data import Data, open  # noqa: A004  (the command's name)
from rhoray._errors import FileError, UsageError


def _without_none(**keys):
    return {key: value for key, value in keys.items() if value is not None}


def _layer(data, iso, mode, **keys):
    kinds = {"iso": "isosurface", "mip": "mip", "triangles": "triangles", "boundary": "boundary"}
    if mode is None:
        by_kind = {"grid": "iso", "tetrahedra": "boundary", "triangles": "triangles"}
        mode = "iso" if iso is not None else by_kind[data.kind]
    if not isinstance(mode, str) or mode not in kinds:
        raise UsageError(f"mode: {mode!r}; expected 'iso', 'mip', 'boundary' or 'triangles'")
    layer = {"data": "data", "type": kinds[mode]}
    layer.update(_without_none(**keys))
    if iso is not None:
        layer["isovalue"] = iso
    return layer


def document_of(data, iso=None, mode=None, size=None, accuracy=None, view=None, azimuth=None, elevation=None, zoom=None,
              camera=None, color=None, color_by=None, colormap=None, range=None, opacity=None, normals=None,  # noqa: A002
              style=None, lights=None, effects=None, clip=None, background=None, antialias=None):
    """The scene document that the options of `render` say, for one dataset named "data".

    Values of a wrong type stay in it: who reads the document refuses them.
    """
    placed = _without_none(view=view, azimuth=azimuth, elevation=elevation, zoom=zoom)
    camera = {} if camera is None else camera
    document = {"data": {"data": _without_none(file="data", field=data._name or None)},
                "layers": [_layer(data, iso, mode, color=color, color_by=color_by, colormap=colormap,
                                  range=range, opacity=opacity, normals=normals)],
                "camera": {**placed, **camera} if isinstance(camera, dict) else camera,
                "image": _without_none(size=size, background=background, antialias=antialias)}
    document.update(_without_none(accuracy=accuracy, style=style, lights=lights, effects=effects, clip=clip))
    return document


def _document_in(path):
    """The scene document in a file."""
    try:
        document = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}", 3) from None
    except UnicodeDecodeError:
        raise FileError(f"{path}: is not text; expected a scene document", 4,
                        "rhoray.open makes Data of other files") from None
    except json.JSONDecodeError as error:
        raise FileError(f"{path}: line {error.lineno}, column {error.colno}: {error.msg}; expected JSON", 4) from None
    except RecursionError:
        raise FileError(f"{path}: lists in lists beyond every limit; expected a scene document", 4) from None
    if not isinstance(document, dict):
        raise FileError(f"{path}: found {type(document).__name__}; expected a scene document, which is a dict", 4)
    return document


_reading_keys = ("raw", "spacing", "origin", "time")


def read(what, data, options, where):
    """(document, known) of what `render`, `view` and `accuracy` take. known: Data, or paths of files, by name.

    Data of a wrong shape are not among the known: who reads the document refuses them.
    where: the function's name, for messages.
    """
    if isinstance(what, Data):
        return document_of(what, **options), {"data": what}
    if options:
        raise UsageError(f"{where}: a scene has its own {', '.join(options)}; expected keys in its document")
    if not isinstance(what, (dict, str, os.PathLike)):
        raise UsageError(f"{where}: found {type(what).__name__}; expected Data, a scene document, or the path of one")
    is_path = not isinstance(what, dict)
    folder, document = (pathlib.Path(what).parent, _document_in(what)) if is_path else (pathlib.Path(), what)
    given = {} if data is None else data
    if not isinstance(given, collections.abc.Mapping):
        raise UsageError(f"data: found {type(given).__name__}; expected a dict of Data by name")
    for name, one in given.items():
        if not isinstance(one, Data):
            raise UsageError(f"data: {name!r}: found {type(one).__name__}; expected Data")
    specs = document.get("data", {})
    if not isinstance(specs, dict):
        return document, {}
    known, specs, names = {}, dict(specs), set(specs)
    for name, spec in specs.items():
        file = spec.get("file", name) if isinstance(spec, dict) else None
        if not isinstance(file, str):
            continue
        names.add(file)
        known[name] = given.get(name, given.get(file, folder / file))
        field = known[name]._name if isinstance(known[name], Data) else ""
        specs[name] = {**({"field": field} if field else {}), **spec, "file": file}
    for name in given:
        if name not in names:
            expected = " or ".join(sorted(map(repr, names))) or "none"
            raise UsageError(f"data: {name!r}: is not in the scene; expected {expected}")
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
    if not files:
        return document
    return {**document, "data": {name: {**spec, "file": files[name]} if name in files else spec
                                 for name, spec in document["data"].items()}}


def with_paths(document, known):
    """The document with files that the program can open. Those of Data are packed: they are not read again."""
    if not known:
        return document
    paths = {name: data.path if isinstance(data, Data) else os.path.abspath(data) for name, data in known.items()}
    specs = {name: {key: value for key, value in spec.items() if key not in _reading_keys}
             if isinstance(known.get(name), Data) else spec for name, spec in document["data"].items()}
    return with_files({**document, "data": specs}, paths)


def text_of(document, where):
    """JSON; numpy's numbers and arrays are taken as those of Python. where: for messages."""
    try:
        text = json.dumps(document, allow_nan=False, ensure_ascii=False, default=lambda value: value.tolist())
        text.encode()
        return text
    except UnicodeEncodeError as error:
        found = error.object[error.start:error.end]
        raise UsageError(f"{where}: a name has {found!r}, which is not UTF-8; expected what JSON can say") from None
    except ValueError:
        raise UsageError(f"{where}: a number of the scene is NaN or infinite; expected finite numbers") from None
    except (AttributeError, TypeError) as error:
        raise UsageError(f"{where}: {error}; expected what JSON can say") from None
