"""Pictures of data and of scenes."""
import json
import os
import tempfile

import numpy

from rhoray import _core
from rhoray._contexts import Context
from rhoray._data import Data, open as open_data
from rhoray._errors import FileError, UsageError


class Picture:
    """A picture, with the scene that makes it again. Its arrays are views of its memory."""

    def __init__(self, core):
        self._core = core

    size = property(lambda self: self._core.size, doc="(width, height)")
    color = property(lambda self: self._core.color, doc="[height, width, 4]: linear RGB and alpha, float32")
    depth = property(lambda self: self._core.depth, doc="[height, width]: distance from the eye; None: not asked for")
    normal = property(lambda self: self._core.normal, doc="[height, width, 3]: towards the eye, world axes")
    cell = property(lambda self: self._core.cell, doc="[height, width]: id of the cell, 2**64 - 1: none")
    value = property(lambda self: self._core.value, doc="[height, width]: of the field; NaN: none")
    error = property(lambda self: self._core.error, doc="[height, width]: proven bound of depth, or of value")
    cost = property(lambda self: self._core.cost, doc="[height, width]: cells that were visited")
    stats = property(lambda self: self._core.statistics, doc="counts and times, by name")
    notes = property(lambda self: self._core.notes, doc="what was chosen otherwise than asked, one sentence each")

    @property
    def rgba(self):
        """[height, width, 3], or 4 without a background: 8-bit sRGB, as PNG files hold it."""
        return self._core.srgb8()

    @property
    def scene(self):
        """The scene document that says every choice, as a dict; `render` makes the same picture of it."""
        return json.loads(self._core.document)

    def verify(self, pixels=500, seed=1):
        """Compares random pixels, and pixels at edges, with exact arithmetic. Needs the channel depth, or value."""
        return self._core.verify(pixels, seed)

    def save(self, path, replace=False):
        """Writes a PNG file."""
        self._core.save_png(os.fspath(path), replace)

    def _repr_png_(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "picture.png")
            self.save(path)
            with open(path, "rb") as file:
                return file.read()

    def __repr__(self):
        return f"<rhoray.Picture: {self.size[0]} x {self.size[1]}, {self.stats['hits']} pixels show something>"


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


def _document(data, iso=None, mode=None, size=None, accuracy=None, view=None, azimuth=None, elevation=None, zoom=None,
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


def _by_file(scene, data):
    """The data that a scene names by files, each with the name of its file."""
    given = data or {}
    opened = {}
    for name, spec in scene.get("data", {}).items():
        file = spec.get("file", name)
        known = given.get(name, given.get(file))
        opened[file] = (known if known is not None else open_data(file))._core
    return opened


def _text_of(document):
    """JSON; numpy's numbers and arrays are taken as those of Python."""
    try:
        return json.dumps(document, allow_nan=False, default=lambda value: value.tolist())
    except ValueError:
        raise UsageError("render: a number of the scene is NaN or infinite; expected finite numbers") from None
    except AttributeError as error:
        raise UsageError(f"render: {error}; expected what JSON can say") from None


def render(what, *, data=None, channels=(), **options):
    """Renders data or a scene, and returns a Picture.

    what: Data with the options below, or a scene document: a dict, or the path of a .json file.
    data: of a scene: Data by the names in its "data"; others are opened by their files.
    channels: "depth", "normal", "cell", "value", "error" (certified or exact), "cost".

    Options are the keys of scene documents (data/scenes/README.md): iso (a number, "auto", "p95", or a
    list), mode ("iso", "mip", "boundary", "triangles"), size (width, height), accuracy, view, azimuth,
    elevation, zoom, camera (a dict), color, color_by, colormap, range, opacity, normals, style, lights,
    effects, clip, background, antialias. What is not given is chosen as `rhoray render` does.
    """
    if isinstance(what, Data):
        document, datasets = _document(what, **options), {"data": what._core}
    else:
        if options:
            raise UsageError(f"render: a scene has its own {', '.join(options)}; expected keys in its document")
        if not isinstance(what, dict):
            with open(what, encoding="utf-8") as file:
                document = json.load(file)
        else:
            document = what
        datasets = _by_file(document, data)
    text = _text_of(document)
    with Context() as context:
        try:
            return Picture(_core.render(context, text, datasets, list(channels)))
        except FileError as error:
            if not error.fact.startswith("scene:"):
                raise
            raise UsageError(error.fact, error.code, error.hint) from None
