"""Packed files (.rho), version 1 of formats/SPEC.md, as arrays of numpy.

The file is mapped. Every part is checked before it is used. A RhoError names file, place, the value that was found and
the expected one. Checksums are not checked: `rhoray verify` does that.
"""
import json
import math
import os
import re
import stat
from collections import namedtuple

import numpy as np

START = b'{"__metadata__":{"format":"rhoray"'
SEAL_START = b"\x89RHO\r\n\x1a\n"
FEATURES = {"axis-tables", "cell-clusters", "sparse-bricks"}
FLOATS = {"F32": "<f4", "F64": "<f8"}
DTYPES = {"U8": "u1", "I8": "i1", "U16": "<u2", "I16": "<i2", "U32": "<u4", "I32": "<i4", "U64": "<u8", "I64": "<i8",
          **FLOATS}
NO_BRICK = 2**32 - 1
LARGEST = 1e300  # of coordinates; differences stay finite
CELLS_AT_ONCE = 1 << 20  # limits the memory of intermediate arrays

Field = namedtuple("Field", "name unit type array")


class RhoError(Exception):
    pass


def shown(value):
    return ascii(value)[:80]


def printable(text):
    return "".join(letter if letter.isprintable() else "?" for letter in text)


def is_count(value, low=0, high=2**63 - 1):
    return type(value) is int and low <= value <= high


def is_list(value, fits, size):
    return isinstance(value, list) and len(value) == size and all(map(fits, value))


def object_of(pairs):
    if len(dict(pairs)) < len(pairs):
        raise ValueError("a key twice")
    return dict(pairs)


class RhoFile:
    """A mapped packed file whose arrays lie inside it."""

    def __init__(self, path):
        self.path = path
        self.require(stat.S_ISREG(os.stat(path).st_mode), "path", "a folder or a special file", "a file")
        size = os.stat(path).st_size
        self.require(size >= 4160, f"byte {size}", "the end of the file", "at least 4160 bytes")
        self.bytes = np.memmap(path, np.uint8, "r", shape=(size,))
        start, seal = self.bytes[8:8 + len(START)].tobytes(), self.bytes[-64:-56].tobytes()
        self.require(start == START, "byte 8", shown(start), "the start of a .rho file")
        self.require(seal == SEAL_START, f"byte {size - 64}", shown(seal), "the seal of a complete file")
        sealed_size, text_bytes = int(self.bytes[-56:-48].view("<u8")[0]), int(self.bytes[:8].view("<u8")[0])
        self.require(sealed_size == size, f"byte {size - 56}", sealed_size, f"{size}, the size of the file")
        self.data_start = 8 + text_bytes
        self.require(self.data_start % 4096 == 0 and 4096 <= self.data_start <= min(2**20, size - 64), "byte 0",
                     text_bytes, "the length of the header, 8 less than a multiple of 4096")
        self.arrays = self.parse(self.bytes[8:self.data_start].tobytes(), "header")
        self.check_metadata(self.arrays.pop("__metadata__"))
        self.check_arrays(size - self.data_start)

    def require(self, holds, place, found, expected):
        if not holds:
            raise RhoError(f"{self.path}, {place}: found {found}; expected {expected}")

    def parse(self, text, place):
        try:
            value = json.loads(text, object_pairs_hook=object_of)
        except (ValueError, RecursionError) as error:
            value = error
        self.require(isinstance(value, dict), place, shown(value), "a JSON object, no key twice")
        return value

    def check_metadata(self, metadata):
        for key in ("version", "requires", "kind", "details"):
            self.require(isinstance(metadata.get(key), str), f"header, {key}", shown(metadata.get(key)), "a text")
        version, features, self.kind = metadata["version"], metadata["requires"], metadata["kind"]
        self.require(re.fullmatch(r"1\.[0-9]{1,4}", version), "header, version", shown(version),
                     "1.x; a newer reader may read it")
        self.features = set(filter(None, features.split(",")))
        self.require(self.features <= FEATURES, "header, requires", shown(features),
                     f"some of {', '.join(sorted(FEATURES))}; a newer reader may read it")
        self.details = self.parse(metadata["details"], "details")

    def check_arrays(self, data_bytes):
        """Checks that the arrays follow one another to the end of the file."""
        self.begin, end = {}, 0
        for name, array in self.arrays.items():
            place = f"header, array {shown(name)}"
            self.require(isinstance(array, dict) and set(array) == {"dtype", "shape", "data_offsets"} and
                         isinstance(array["dtype"], str) and array["dtype"] in DTYPES and
                         any(is_list(array["shape"], is_count, rank) for rank in range(9)), place, shown(array),
                         "dtype, shape and data_offsets of an array")
            begin, end = end, end + math.prod(array["shape"]) * np.dtype(DTYPES[array["dtype"]]).itemsize
            self.require(array["data_offsets"] == [begin, end], place, f"data_offsets {shown(array['data_offsets'])}",
                         f"{[begin, end]} by its shape and the array before")
            self.require(end <= data_bytes, place, f"its end at {end}", f"at most {data_bytes}, the end of the file")
            self.require(begin % 64 == 0 or name.startswith("_pad.") or name == "_seal", place, f"its start at {begin}",
                         "a multiple of 64")
            self.begin[name] = self.data_start + begin
        self.require(end == data_bytes and list(self.arrays)[-2:] == ["_sum", "_seal"], "header",
                     f"arrays of {end} bytes", f"{data_bytes} bytes with _sum and _seal at the end")

    def array(self, name, dtype, *shape):
        """A view of an array, which must have this type, such as F32, and shape."""
        found = self.arrays.get(name)
        self.require(found, "header", f"no array '{name}'", "it")
        self.require(found["dtype"] == dtype and found["shape"] == list(shape), f"header, array '{name}'",
                     f"{found['dtype']} {found['shape']}", f"{dtype} {list(shape)}")
        size = math.prod(shape) * np.dtype(DTYPES[dtype]).itemsize
        return np.asarray(self.bytes)[self.begin[name]:self.begin[name] + size].view(DTYPES[dtype]).reshape(shape)

    def check(self, name, values, good, expected, first=0):
        """Refuses the first element of an array that is not good. `first` is the number of the first element here."""
        place = good.argmin()
        self.require(good.all(), f"array '{name}', element {first + place}", values.flat[place], expected)

    def get(self, key, fits, expected):
        """A value of the details. A key such as "clusters/size" leads into an object."""
        value = self.details
        for step in key.split("/"):
            value = value.get(step) if isinstance(value, dict) else None
        self.require(fits(value), f"details/{key}", shown(value), expected)
        return value

    def text(self, key):
        return printable(self.get(key, lambda value: isinstance(value, str), "a text"))

    def count(self, key, low=0, high=2**32 - 1):
        return self.get(key, lambda value: is_count(value, low, high), f"an integer from {low} to {high}")

    def index(self, key, low, high):
        """In the order z, y, x, as the shapes of arrays."""
        return self.get(key, lambda value: is_list(value, lambda item: is_count(item, low, high), 3),
                        f"three integers from {low} to {high}")[::-1]

    def vector(self, key):
        def is_finite(item):
            return type(item) in (int, float) and abs(item) < LARGEST
        return np.array(self.get(key, lambda value: is_list(value, is_finite, 3), "three finite numbers"), float)

    def fields(self, key, array_name, types=FLOATS, first=()):
        """The fields of a list, which may be missing, behind those in `first`."""
        items = self.get(key, lambda value: value is None or isinstance(value, list), "a list") or []
        fields = {}
        for number, item in enumerate([*first, *items]):
            item = item if isinstance(item, dict) else {}
            texts = [item.get(member) for member in ("name", "unit", "type")]
            self.require(all(isinstance(text, str) for text in texts) and texts[0] and texts[2] in types,
                         f"details/{key}", shown(texts), f"name, unit and type of a field: {' or '.join(types)}")
            name, unit = map(printable, texts[:2])
            self.require(name not in fields, f"details/{key}", shown(name), "a name that no other field has")
            fields[name] = Field(name, unit, texts[2], array_name(number))
        return list(fields.values())


class Grid:
    """A grid of fields or colours. Counts of samples and bricks are in the order z, y, x.

    Where the grid is axis-aligned, permuted and flipped axes are undone: samples come in the order of rising x, y and
    z of the world, which `coordinates` has. Otherwise `coordinates` is None, and samples come in the grid's order.
    """

    def __init__(self, file):
        self.file, self.cell_fields, is_colors = file, [], file.kind == "colors"
        self.count = file.index("sample_count", 1 if is_colors else 2, 2**20)
        self.components = file.count("component_count", 3, 4) if is_colors else 1
        self.is_sparse = "sparse-bricks" in file.features and not is_colors
        self.point_fields = [Field("color", "", "U8", "texels")] if is_colors else file.fields(
            "more_fields", lambda number: f"field.{number}.samples" if number else "samples",
            FLOATS if self.is_sparse else DTYPES, [file.details.get("field")])
        self.has_tables = "axis-tables" in file.features
        self.read_layout()
        self.read_geometry()
        for field in self.point_fields:
            self.stored(field)

    def read_layout(self):
        """Finds the shape of the stored samples, and the slots of bricks."""
        self.component_shape = [self.components] if self.components > 1 else []
        self.edge, self.superbrick = self.file.count("brick_edge", 1, 64), self.file.index("superbrick_edge", 1, 64)
        bricks = [-(-count // self.edge) for count in self.count]
        self.superbricks, self.slots = [-(-count // m) for count, m in zip(bricks, self.superbrick)], None
        self.stored_shape = [math.prod(self.superbricks), *self.superbrick, *[self.edge] * 3]
        if self.is_sparse:
            self.stored_shape = [self.file.count("stored_brick_count"), *[self.edge] * 3]
            self.slots = self.file.array("bricks", "U32", *bricks)
            is_slot = (self.slots < self.stored_shape[0]) | (self.slots == NO_BRICK)
            self.file.check("bricks", self.slots, is_slot, f"a slot below {self.stored_shape[0]}")
        elif self.stored_shape[1:] == [1] * 6:
            self.stored_shape = self.count

    def read_geometry(self):
        """For each axis of the output: which axis of the grid has its direction, and whether it is flipped."""
        axes = self.axes = np.array([self.file.vector(f"world_from_grid/{axis}_axis") for axis in "xyz"])
        self.origin, largest = self.file.vector("world_from_grid/origin"), np.abs(axes).max(1)
        with np.errstate(all="ignore"):
            volume = abs(np.linalg.det(axes / largest[:, None]))
        self.file.require(volume > 0, "details/world_from_grid", axes.tolist(), "axes that span a volume")
        self.positions = [self.read_positions(axis) for axis in range(3)]  # x, y, z
        # Axis-aligned: sideways, no sample is off by more than a millionth of a step.
        along = np.abs(axes).argmax(1)
        sideways = np.abs(axes * (along[:, None] != range(3))).max(1) * [p[-1] - p[0] for p in self.positions]
        steps = largest * [np.diff(p).min(initial=np.inf) for p in self.positions]
        self.order, self.flipped, self.coordinates = [0, 1, 2], [False] * 3, None
        if len(set(along)) == 3 and (sideways <= 1e-6 * steps).all():
            self.order = np.argsort(along).tolist()
            spacing = [axes[axis, world] for world, axis in enumerate(self.order)]
            self.spacing, self.flipped = np.abs(spacing).tolist(), [step < 0 for step in spacing]
            self.coordinates = [np.sort(self.origin[world] + spacing[world] * self.positions[axis])
                                for world, axis in enumerate(self.order)]
        self.output_count = [self.count[2 - axis] for axis in self.order]  # x, y, z
        self.point_shape = self.output_count[::-1] + self.component_shape

    def read_positions(self, axis):
        count, name = self.count[2 - axis], f"axis.{axis}"
        if not self.has_tables or name not in self.file.arrays:
            return np.arange(count, dtype=float)
        positions = self.file.array(name, "F64", count)
        rises = np.append(True, positions[1:] > positions[:-1])
        self.file.check(name, positions, (np.abs(positions) < LARGEST) & rises, "finite numbers that rise")
        return positions

    def read_points(self, points):
        """The points [z, y, x, 3] of a grid that is not axis-aligned."""
        x, y, z = (np.multiply.outer(positions, axis) for positions, axis in zip(self.positions, self.axes))
        points[:] = self.origin + x
        points += y[:, None]
        points += z[:, None, None]

    def stored(self, field):
        return self.file.array(field.array, field.type, *self.stored_shape, *self.component_shape)

    def read_point_values(self, field, values):
        """The samples [z, y, x] in the order of the output."""
        # The same samples in the order of the grid.
        view = values[tuple(slice(None, None, -1 if flipped else 1) for flipped in self.flipped[::-1])]
        view = view.transpose(*(2 - self.order.index(2 - axis) for axis in range(3)), *range(3, values.ndim))
        for layer, begin in enumerate(range(0, self.count[0], self.edge)):
            rows = self.read_layer(self.stored(field), layer)
            view[begin:begin + self.edge] = rows[:self.count[0] - begin, :self.count[1], :self.count[2]]

    def read_layer(self, stored, layer):
        """The samples [z, y, x] of a layer of bricks."""
        n, m = self.edge, self.superbrick
        if self.slots is None:
            bricks = stored.reshape(*self.superbricks, *m, n, n, n, *self.component_shape)
            bricks = bricks[layer // m[0], :, :, layer % m[0]]
        else:
            slots = self.slots[layer]
            bricks = np.full((*slots.shape, 1, 1, n, n, n), np.nan, stored.dtype)
            bricks[slots != NO_BRICK, 0, 0] = stored[slots[slots != NO_BRICK]]
        rows = bricks.transpose(4, 0, 2, 5, 1, 3, 6, *range(7, bricks.ndim))
        return rows.reshape(n, math.prod(rows.shape[1:4]), math.prod(rows.shape[4:7]), *self.component_shape)

    def cells_with(self, flags):
        """Flags of the cells with a flagged corner."""
        for axis in range(3):
            slices = flags.swapaxes(0, axis)
            flags = (slices[:-1] | slices[1:]).swapaxes(0, axis)
        return flags


class Mesh:
    """Tetrahedra, or the triangles of a surface."""

    def __init__(self, file):
        self.file, self.components, self.is_surface = file, 1, file.kind == "surface"
        self.point_type = file.text("point_type") if self.is_surface else "F64"
        file.require(self.point_type in FLOATS, "details/point_type", shown(self.point_type), "F32 or F64")
        self.origin = 0 if self.is_surface else file.vector("origin")
        self.point_count = file.count("point_count", 1)
        self.point_shape, self.corner_count = [self.point_count], 3 if self.is_surface else 4
        self.cell_count = file.count("triangle_count" if self.is_surface else "cell_count", 1)
        self.point_fields = file.fields("fields", "field.{}".format)
        self.cell_fields = file.fields("cell_fields", "cell_field.{}".format)
        ids = "triangle_id" if self.is_surface else "cell_id"
        if ids + "s" in file.arrays:
            self.cell_fields.append(Field(ids, "", "U32", ids + "s"))
        # All arrays have their shapes before memory is allocated.
        self.is_clustered = "cell-clusters" in file.features
        self.cell_array = "triangles" if self.is_surface else "cluster.corners" if self.is_clustered else "cells"
        cell_type = "U8" if self.is_clustered else "U32"
        self.cells = file.array(self.cell_array, cell_type, self.cell_count, self.corner_count)
        self.points = file.array("points", self.point_type, self.point_count, 3)
        for field in self.point_fields:
            file.array(field.array, field.type, self.point_count)
        for field in self.cell_fields:
            file.array(field.array, field.type, self.cell_count)

    def read_points(self, points):
        self.file.check("points", self.points, np.isfinite(self.points), "finite numbers")
        np.add(self.points, self.origin, out=points)

    def read_corners(self, corners):
        """The point numbers of the cells: [cells, corner_count]."""
        if self.is_clustered:
            self.read_clustered_corners(corners)
        else:
            self.check_point_numbers(self.cell_array, self.cells)
            corners[:] = self.cells

    def check_point_numbers(self, name, numbers):
        self.file.check(name, numbers, numbers < self.point_count, f"a point number below {self.point_count}")

    def read_clustered_corners(self, corners):
        size, vertex_count = self.file.count("clusters/size", 1, 64), self.file.count("clusters/vertex_count", 1, 2**63)
        starts = self.file.array("cluster.offsets", "U64", -(-self.cell_count // size) + 1)
        good = np.append(starts[0] == 0, starts[1:] >= starts[:-1])
        good[-1] &= starts[-1] == vertex_count
        self.file.check("cluster.offsets", starts, good, f"numbers from 0 to {vertex_count} that do not fall")
        starts = starts.astype(np.int64)
        vertices = self.file.array("cluster.vertices", "U32", vertex_count)
        self.check_point_numbers("cluster.vertices", vertices)
        for begin in range(0, self.cell_count, CELLS_AT_ONCE):
            part = self.cells[begin:begin + CELLS_AT_ONCE]
            cluster = np.arange(begin, begin + len(part)) // size
            self.file.check("cluster.corners", part, part < (starts[cluster + 1] - starts[cluster])[:, None],
                            "a position in the table of its cluster", 4 * begin)
            corners[begin:begin + len(part)] = vertices[starts[cluster][:, None] + part]

    def read_point_values(self, field, values):
        values[:] = self.file.array(field.array, field.type, self.point_count)

    def read_cell_values(self, field, values):
        values[:] = self.file.array(field.array, field.type, self.cell_count)


KINDS = {"grid": Grid, "colors": Grid, "tets": Mesh, "surface": Mesh}


def open_data(path):
    file = RhoFile(path)
    file.require(file.kind in KINDS, "header, kind", shown(file.kind),
                 f"{', '.join(KINDS)}; `rhoray pack` makes them from other files")
    return KINDS[file.kind](file)
