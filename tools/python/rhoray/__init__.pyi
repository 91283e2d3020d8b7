import dataclasses
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, overload

import numpy
from numpy.typing import ArrayLike, NDArray

_Path = str | os.PathLike[str]
_Accuracy = Literal["preview", "float", "double", "certified", "exact"]
_Point = tuple[float, float, float]
_Progress = bool | Callable[[str, int, int], object] | None
_Numbers = Sequence[float] | NDArray[Any]
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

@dataclasses.dataclass(frozen=True, eq=False)
class Field:
    name: str
    unit: str
    of_cells: bool
    range: tuple[float, float] | None
    no_data_count: int
    histogram: NDArray[numpy.uint64]
    labels: dict[int, str]

class Data:
    report: dict[str, Any] | None
    @property
    def kind(self) -> Literal["grid", "tetrahedra", "triangles"]: ...
    @property
    def path(self) -> str: ...
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
    def unpack(self) -> tuple[Any, ...]: ...
    def boundary(self, field: str | None = ..., label: int | None = ...) -> Data: ...
    def damaged_blocks(self) -> list[tuple[int, int]]: ...
    def save(self, path: _Path, replace: bool = ...) -> None: ...

def open(
    path: _Path,
    field: str | None = ...,
    *,
    raw: str | None = ...,
    spacing: _Numbers | None = ...,
    origin: _Numbers | None = ...,
    time: str | float | None = ...,
    progress: _Progress = ...,
) -> Data: ...
def volume(
    values: ArrayLike | Mapping[str, ArrayLike],
    *,
    axes: Literal["zyx", "xyz"] = ...,
    spacing: Sequence[float] | None = ...,
    origin: Sequence[float] | None = ...,
    affine: ArrayLike | None = ...,
    positions: Sequence[ArrayLike] | None = ...,
    units: Mapping[str, str] | None = ...,
    length_unit: str = ...,
    path: _Path = ...,
    replace: bool = ...,
    progress: _Progress = ...,
) -> Data: ...
def mesh(
    points: ArrayLike,
    tetrahedra: ArrayLike,
    point_fields: Mapping[str, ArrayLike] | None = ...,
    cell_fields: Mapping[str, ArrayLike] | None = ...,
    *,
    units: Mapping[str, str] | None = ...,
    length_unit: str = ...,
    path: _Path = ...,
    replace: bool = ...,
    progress: _Progress = ...,
) -> Data: ...
def surface(
    points: ArrayLike,
    triangles: ArrayLike,
    *,
    path: _Path = ...,
    replace: bool = ...,
    progress: _Progress = ...,
) -> Data: ...
@overload
def pack(what: _Path, *, color: Literal[True], path: _Path, **options: Any) -> None: ...  # type: ignore[misc]
@overload
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
    @property
    def command(self) -> str: ...
    def compare(self, other: Picture | _Path) -> dict[str, Any]: ...
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

@dataclasses.dataclass(frozen=True, eq=False)
class Hits:
    t: NDArray[numpy.float64]
    value: NDArray[numpy.float64]
    cell: NDArray[numpy.uint64]
    error: NDArray[numpy.float64] | None
    gradient: NDArray[numpy.float64] | None
    @property
    def is_hit(self) -> NDArray[numpy.bool_]: ...

@dataclasses.dataclass(frozen=True, eq=False)
class AllHits:
    first: NDArray[numpy.uint64]
    t: NDArray[numpy.float64]
    error: NDArray[numpy.float64]
    cell: NDArray[numpy.uint64]
    enters: NDArray[numpy.bool_]
    truncated: NDArray[numpy.bool_]

def info(what: Data | _Path, *, stats: bool = ..., progress: _Progress = ..., **options: Any) -> dict[str, Any]: ...
def validate(
    what: Data | _Path,
    iso: float | str,
    *,
    report: _Path = ...,
    replace: bool = ...,
    progress: _Progress = ...,
    field: str | None = ...,
    accuracy: _Accuracy | None = ...,
    method: str | None = ...,
    samples: int | None = ...,
    seed: int | None = ...,
    max_depth_error: float | None = ...,
    threads: int | None = ...,
    time_limit: float | None = ...,
    memory: str | int | None = ...,
    **options: Any,
) -> dict[str, Any]: ...
def resample(
    mesh: Data | _Path,
    path: _Path = ...,
    *,
    replace: bool = ...,
    progress: _Progress = ...,
    size: int | Sequence[int] | None = ...,
    spacing: float | _Numbers | None = ...,
    max_error: float | str | None = ...,
    field: str | Sequence[str] | None = ...,
    cell_data: bool = ...,
    threads: int | None = ...,
    memory: str | int | None = ...,
) -> Data: ...
def tetrahedralize(
    *surfaces: Data | _Path,
    path: _Path = ...,
    replace: bool = ...,
    progress: _Progress = ...,
    regions: bool = ...,
    max_volume: float | str | Mapping[int, float] | None = ...,
    repair: bool = ...,
    max_move: float | None = ...,
    largest_part: bool = ...,
    wrap: float | None = ...,
    quality: float | None = ...,
    size_field: _Path | None = ...,
    sizes: _Path | None = ...,
    cavities: bool = ...,
    tetgen: str | None = ...,
    time_limit: float | None = ...,
    memory: str | int | None = ...,
) -> Data: ...
@dataclasses.dataclass(frozen=True, eq=False)
class Accuracy:
    columns: dict[str, NDArray[Any]]
    units: dict[str, str]
    meanings: dict[str, str]
    conclusions: list[str]
    notes: list[str]
    facts: dict[str, Any]
    report: str | None

def accuracy(
    what: Data | Mapping[str, Any] | _Path,
    folder: _Path = ...,
    *,
    data: Mapping[str, Data] | None = ...,
    replace: bool = ...,
    progress: _Progress = ...,
    iso: float | str | Sequence[float | str] | None = ...,
    mode: Literal["iso", "mip"] | None = ...,
    field: str | None = ...,
    size: str | Sequence[int] | None = ...,
    time_limit: float | None = ...,
    repeat: int | None = ...,
    seed: int | None = ...,
    max_error: float | None = ...,
    budget_ms: float | None = ...,
    threads: int | None = ...,
    memory: str | int | None = ...,
    **options: Any,
) -> Accuracy: ...
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
    out: Hits | None = ...,
) -> Any: ...
def sample(
    data: Data, points: ArrayLike, *, field: str | None = ...
) -> tuple[NDArray[numpy.float64], NDArray[numpy.uint64]]: ...

class View:
    url: str
    size: tuple[int, int] | None
    error: str | None
    @property
    def scene(self) -> dict[str, Any]: ...
    @scene.setter
    def scene(self, document: Mapping[str, Any]) -> None: ...
    def picture(self, size: tuple[int, int] | None = ..., channels: Sequence[_Channel] = ...) -> Picture: ...
    def observe(self, function: Callable[[View], object]) -> Callable[[], None]: ...
    def close(self) -> None: ...
    def __enter__(self) -> View: ...
    def __exit__(self, kind: object, error: object, trace: object) -> None: ...

def view(
    what: Data | Mapping[str, Any] | _Path,
    *,
    data: Mapping[str, Data] | None = ...,
    port: int | None = ...,
    hosts: str | Sequence[str] = ...,
    browser: bool | None = ...,
    **options: Any,
) -> View: ...
