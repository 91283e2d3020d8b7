"""Functions that do what the subcommands of the program do."""
import atexit
import glob
import os
import pathlib
import tempfile

import numpy

from rhoray import _program
from rhoray._data import Data, first_of, made, open, pack, remove  # noqa: A004  (the command's name)
from rhoray._errors import Error, UsageError


def file_of(what):
    """The file that the program opens: of Data, or the path itself."""
    return what.path if isinstance(what, Data) else os.fspath(what)


def _with_field(what, options):
    """The options, with the field that Data show."""
    return {"field": what._name or None, **options} if isinstance(what, Data) else options


def _output(path, replace):
    return [f"--output={os.fspath(path)}", *(["--force"] if replace else [])]


def info(what, *, stats=False, progress=None, **options):
    """Says what data or a file hold: the JSON document of `rhoray info`, as a dict.

    what: Data, or the path of any file that is read.
    stats: also look for faults in the data. Other options: raw, spacing, origin, time, memory.
    """
    words = _program.option_words({"stats": stats, **options})
    return _program.run("info", [file_of(what)], words, progress)


def validate(what, iso, *, report="", replace=False, progress=None, **options):
    """Checks an isosurface against CGAL: the JSON document of `rhoray validate`, as a dict.

    result["holds"] says whether everything is within its limits, result["checks"] which limits there are. A check
    whose "holds" is None had nothing to measure.
    what: Data, or the path of any file that is read. iso: a number, "auto" or "p95".
    report: a folder for the report. replace: overwrite one.
    Options: field; accuracy ("preview" to "exact") or method; samples (number of rays); seed;
    max_depth_error (in diagonals of a mesh's box, or in cells of a grid); raw, spacing, origin, time;
    threads; time_limit (s of CPU); memory.
    """
    words = _program.option_words({"iso": iso, "report": report or None, **_with_field(what, options)})
    return _program.run("validate", [file_of(what)], words + (["--force"] if replace else []), progress, accept=6)


def resample(mesh, path="", *, replace=False, progress=None, **options):
    """Resamples tetrahedra on a grid with a certified error, as `rhoray resample` does. Returns Data.

    mesh: Data of tetrahedra, or the path of any mesh that is read.
    path: of the packed grid (.rho), or of an OpenVDB file; without it, the grid is temporary.
    size (N samples along the longest axis, or three numbers) or spacing (one number or three, in the
    mesh's unit) chooses the grid; max_error ("0.5%" of the range, or a number in the field's unit)
    refines it, and an Error with code 6 says that it was not reached.
    Other options: field (one name or several), cell_data, threads, memory.
    result.report: the JSON summary, with the errors that are certified.
    """
    file, options = file_of(mesh), {"field": _shown_first(mesh), **options}
    words = _program.option_words(options)

    def make(output):
        return _program.run("resample", [file], [*_output(output, replace), *words], progress)
    if os.path.splitext(path)[1] == ".vdb":
        report = make(path)
        data = open(path, progress=progress)
        data.report = report
        return data
    try:
        return made(make, path, pathlib.Path(file).stem + "_grid.rho", first_of(options["field"]))
    except Error as error:
        if error.code == 6 and not path:
            raise Error(error.fact, 6, "path=... keeps the best grid; allow a larger error or more memory, or start "
                                       "from a finer grid with size=...") from None
        raise


def _shown_first(mesh):
    """All fields of points, the shown one first; None: the program's order is this."""
    if not isinstance(mesh, Data):
        return None
    names = [field.name for field in mesh.fields.values() if not field.of_cells]
    return [mesh._name, *(name for name in names if name != mesh._name)] if mesh._name in names[1:] else None


def tetrahedralize(*surfaces, path="", replace=False, progress=None, regions=True, max_volume=None, **options):
    """Fills closed surfaces with tetrahedra (TetGen), as `rhoray tetrahedralize` does. Returns Data.

    surfaces: Data of triangles, or paths of surfaces. Nested ones make regions, numbered from the outside
    in the field of cells "region"; regions=False leaves the numbers out.
    path: a .vtu file as the program writes it, or a packed file (.rho); without it, the mesh is temporary.
    max_volume: of a tetrahedron, or a dict of such volumes by region, in cubed units of length.
    Options: repair, max_move (share of the box's diagonal), largest_part; wrap (a share, likewise);
    quality (largest ratio of circumradius to shortest edge); size_field (a file, "FILE:FIELD" or
    "distance:SURFACE:NEAR:FAR:GROWTH"); sizes (a .mtr file); cavities; tetgen; time_limit (s of CPU);
    memory.
    result.report: the JSON summary. An error may name a file of faulty facets: it lies beside a .vtu file,
    else it exists until Python ends.
    """
    if isinstance(max_volume, dict):
        max_volume = ",".join(f"{region}:{volume}" for region, volume in max_volume.items())
    words = _program.option_words({"max_volume": max_volume, **options}) + ([] if regions else ["--no-regions"])
    is_packed = os.path.splitext(path)[1] == ".rho"
    if is_packed:
        _require_writable(path, replace)
    folder = tempfile.mkdtemp(prefix="rhoray-")
    try:
        files = [_surface_file(surface, f"{folder}/surface{number}.ply") for number, surface in enumerate(surfaces, 1)]
        mesh = path if path and not is_packed else f"{folder}/{pathlib.Path(files[0]).stem if files else 'mesh'}.vtu"
        report = _program.run("tetrahedralize", files, [*_output(mesh, replace), *words], progress)
        data = pack(mesh, path=path if is_packed else "", replace=replace, progress=progress)
    except BaseException:
        if glob.glob(f"{glob.escape(folder)}/*.faults.ply"):
            atexit.register(remove, folder, os.getpid())
        else:
            remove(folder)
        raise
    remove(folder)
    data.report = {**report, "file": os.fspath(path) or data.path}
    return data


def _require_writable(path, replace):
    """Refuses now what packing would refuse after a long time."""
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise UsageError(f"{os.fspath(path)}: there is no folder {folder}", hint="create the folder first")
    if os.path.exists(path) and not replace:
        raise UsageError(f"{os.fspath(path)} already exists", hint="use replace=True to overwrite it")


def _surface_file(surface, path):
    """The path of a surface. Data are written to `path` (PLY, 64-bit coordinates)."""
    if not isinstance(surface, Data):
        return os.fspath(surface)
    if surface.kind != "triangles":
        raise UsageError(f"tetrahedralize: found {surface.kind}; expected triangles")
    surface.path  # noqa: B018  (refuses the boundary of a mesh)
    points, triangles = surface.array("points"), surface.array("triangles")
    faces = numpy.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    with pathlib.Path(path).open("wb") as file:
        file.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
                    "property double x\nproperty double y\nproperty double z\n"
                    f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n").encode())
        file.write(points.astype("<f8").tobytes())
        file.write(faces.tobytes())
    return path
