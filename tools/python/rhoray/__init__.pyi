import dataclasses
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy
from numpy.typing import ArrayLike, NDArray

_Path = str | os.PathLike[str]
_Accuracy = Literal["preview", "float", "double", "certified", "exact"]
_Point = tuple[float, float, float]
_Progress = Callable[[str, int, int], object]
_Channel = Literal["depth", "normal", "cell", "value", "error", "cost"]

version: str

class Error(Exception):
    fact: str
    code: int
    hint: str
    def __init__(self, fact: str, code: int = ..., hint: str = ...) -> None: ...

class UsageError(Error, ValueError): ...
class FileError(Error, OSError): ...
class ResourceError(Error, MemoryError): ...

@dataclasses.dataclass(frozen=True)
class Field:
    name: str
    unit: str
    of_cells: bool
    range: tuple[float, float] | None
    no_data_count: int
    histogram: NDArray[numpy.uint64]
    labels: dict[int, str]

class Data:
    @property
    def kind(self) -> Literal["grid", "tetrahedra", "triangles"]: ...
    @property
    def fields(self) -> dict[str, Field]: ...
    @property
    def field(self) -> Field | None: ...
    @property
    def bounds(self) -> tuple[_Point, _Point]: ...
    @property
    def length_unit(self) -> str: ...
    @property
    def notes(self) -> list[str]: ...
    def with_field(self, name: str) -> Data: ...
    @property
    def array_names(self) -> list[str]: ...
    def array(self, name: str) -> NDArray[Any]: ...
    def boundary(self, field: str | None = ..., label: int | None = ...) -> Data: ...
    def damaged_blocks(self) -> list[tuple[int, int]]: ...
    def save(self, path: _Path, replace: bool = ...) -> None: ...

def open(path: _Path, field: str | None = ...) -> Data: ...
def volume(
    values: NDArray[Any] | Mapping[str, NDArray[Any]],
    *,
    axes: Literal["zyx", "xyz"] = ...,
    spacing: Sequence[float] = ...,
    origin: Sequence[float] = ...,
    affine: ArrayLike | None = ...,
    positions: Sequence[ArrayLike] | None = ...,
    units: Mapping[str, str] | None = ...,
    length_unit: str = ...,
    path: _Path = ...,
    replace: bool = ...,
    progress: _Progress | None = ...,
) -> Data: ...
def mesh(
    points: NDArray[Any],
    tetrahedra: NDArray[Any],
    point_fields: Mapping[str, NDArray[Any]] | None = ...,
    cell_fields: Mapping[str, NDArray[Any]] | None = ...,
    *,
    units: Mapping[str, str] | None = ...,
    length_unit: str = ...,
    path: _Path = ...,
    replace: bool = ...,
    progress: _Progress | None = ...,
) -> Data: ...
def surface(
    points: NDArray[Any],
    triangles: NDArray[Any],
    *,
    path: _Path = ...,
    replace: bool = ...,
    progress: _Progress | None = ...,
) -> Data: ...
def pack(what: Any, *arrays: Any, path: _Path = ..., **options: Any) -> Data: ...

class Picture:
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def color(self) -> NDArray[numpy.float32]: ...
    @property
    def depth(self) -> NDArray[numpy.float32] | None: ...
    @property
    def normal(self) -> NDArray[numpy.float32] | None: ...
    @property
    def cell(self) -> NDArray[numpy.uint64] | None: ...
    @property
    def value(self) -> NDArray[numpy.float64] | None: ...
    @property
    def error(self) -> NDArray[numpy.float32] | None: ...
    @property
    def cost(self) -> NDArray[numpy.uint32] | None: ...
    @property
    def stats(self) -> dict[str, float]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def rgba(self) -> NDArray[numpy.uint8]: ...
    @property
    def scene(self) -> dict[str, Any]: ...
    def verify(self, pixels: int = ..., seed: int = ...) -> dict[str, Any]: ...
    def save(self, path: _Path, replace: bool = ...) -> None: ...

def render(
    what: Data | Mapping[str, Any] | _Path,
    *,
    data: Mapping[str, Data] | None = ...,
    channels: Sequence[_Channel] = ...,
    iso: float | str | Sequence[float | str] | None = ...,
    mode: Literal["iso", "mip", "boundary", "triangles"] | None = ...,
    size: tuple[int, int] | None = ...,
    accuracy: _Accuracy | None = ...,
    view: str | None = ...,
    azimuth: float | None = ...,
    elevation: float | None = ...,
    zoom: float | None = ...,
    camera: Mapping[str, Any] | None = ...,
    color: str | Sequence[float] | None = ...,
    color_by: str | None = ...,
    colormap: str | None = ...,
    range: Sequence[float] | None = ...,
    opacity: float | None = ...,
    normals: str | None = ...,
    style: str | None = ...,
    lights: Sequence[Mapping[str, Any]] | None = ...,
    effects: Mapping[str, Any] | None = ...,
    clip: Mapping[str, Any] | None = ...,
    background: str | Sequence[float] | None = ...,
    antialias: int | None = ...,
) -> Picture: ...

@dataclasses.dataclass(frozen=True)
class Hits:
    t: NDArray[numpy.float64]
    value: NDArray[numpy.float64]
    cell: NDArray[numpy.uint64]
    error: NDArray[numpy.float64] | None
    gradient: NDArray[numpy.float64] | None
    @property
    def is_hit(self) -> NDArray[numpy.bool_]: ...

@dataclasses.dataclass(frozen=True)
class AllHits:
    first: NDArray[numpy.uint64]
    t: NDArray[numpy.float64]
    error: NDArray[numpy.float64]
    cell: NDArray[numpy.uint64]
    enters: NDArray[numpy.bool_]
    truncated: NDArray[numpy.bool_]

def trace(
    data: Data,
    origins: ArrayLike,
    directions: ArrayLike,
    *,
    iso: float | None = ...,
    query: Literal["first", "any", "all", "largest"] = ...,
    accuracy: _Accuracy = ...,
    field: str | None = ...,
    t_min: ArrayLike | None = ...,
    t_max: ArrayLike | None = ...,
    max_hits: int = ...,
) -> Any: ...
def sample(
    data: Data, points: ArrayLike, *, field: str | None = ...
) -> tuple[NDArray[numpy.float64], NDArray[numpy.uint64]]: ...
