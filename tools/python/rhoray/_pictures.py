"""Pictures of data and of scenes."""
import json
import os
import shlex
import tempfile

from rhoray import _core, _program, _scenes
from rhoray._contexts import Context
from rhoray._errors import FileError, UsageError


class Picture:
    """A picture, with the scene that makes it again. Its arrays are views of its memory."""

    def __init__(self, core, data, files):
        self._core = core
        self._data = data  # by name, as the files of the scene
        self._files = files

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
        return _scenes.with_files(json.loads(self._core.document), self._files)

    @property
    def command(self):
        """The shell command that draws the same picture. Data in memory must exist when it runs."""
        document = _scenes.text_of(_scenes.with_paths(self.scene, self._data), "command")
        return f"rhoray render {shlex.quote(document)} -o picture.png"

    def compare(self, other):
        """How far the 8-bit colours of another Picture, or of a picture file, differ.

        A dict as `rhoray compare --json` prints it: the number of pixels, how many differ, the largest
        difference (colours from 0 to 1) with its pixel, root mean square and mean.
        """
        with tempfile.TemporaryDirectory(prefix="rhoray-") as folder:
            own, theirs = os.path.join(folder, "own.png"), os.path.join(folder, "other.png")
            self.save(own)
            if isinstance(other, Picture):
                other.save(theirs)
            else:
                theirs = os.fspath(other)
            found = _program.run("compare", [own, theirs], [])
        return {key: value for key, value in found.items() if key not in ("a", "b")}

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


def render(what, *, data=None, channels=(), **options):
    """Renders data or a scene, and returns a Picture.

    what: Data with the options below, or a scene document: a dict, or the path of a .json file.
    data: of a scene: Data by the names in its "data"; others are opened by their files.
    channels: "depth", "normal", "cell", "value", "error" (certified or exact), "cost".

    Options are the keys of scene documents (data/scenes/README.md): iso (a number, "auto", "p95", or a
    list), mode ("iso", "mip", "boundary", "triangles"), size (width, height), accuracy, view, azimuth,
    elevation, zoom, camera (a dict), color, color_by, colormap, range, opacity, normals, style, lights,
    effects, clip, background, antialias. What is not given is chosen as `rhoray render` does.

    >>> import numpy, rhoray as rr
    >>> data = rr.volume(numpy.hypot(*numpy.mgrid[-9:10, -9:10]) + numpy.zeros((19, 1, 1)))  # a cylinder
    >>> picture = rr.render(data, iso=5, size=(80, 60), channels=["depth"])
    >>> picture.rgba.shape, picture.depth.dtype
    ((60, 80, 3), dtype('float32'))
    >>> again = rr.render(picture.scene, data={"data": data})
    >>> numpy.array_equal(again.rgba, picture.rgba)
    True
    """
    document, known = _scenes.read(what, data, options, "render")
    known = _scenes.opened(document, known)
    files = {name: document["data"][name]["file"] for name in known}
    # Several names may have one file, but data of their own.
    text = _scenes.text_of(_scenes.with_files(document, {name: name for name in known}), "render")
    with Context() as context:
        try:
            core = _core.render(context, text, {name: data._core for name, data in known.items()}, list(channels))
            return Picture(core, known, files)
        except FileError as error:
            if not error.fact.startswith("scene:"):
                raise
            raise UsageError(error.fact, error.code, error.hint) from None
