"""Objects of other libraries as arrays. None of them is imported: objects are known by what they have."""
import sys

import numpy


def arrays_of(thing, refuse):
    """What `volume`, `mesh` or `surface` take of an object: (name of the function, arguments, options), or None.

    refuse: makes the exception for an object that cannot be taken.
    """
    if hasattr(thing, "dims") and hasattr(thing, "coords"):
        return _of_xarray(thing, refuse)
    if hasattr(thing, "cells_dict") and hasattr(thing, "point_data"):
        return _of_meshio(thing, refuse)
    if hasattr(thing, "affine") and hasattr(thing, "dataobj"):
        return "volume", (numpy.asanyarray(thing.dataobj),), {"axes": "xyz", "affine": thing.affine, "length_unit": "mm"}
    if hasattr(thing, "GetDirection") and hasattr(thing, "GetSpacing") and hasattr(thing, "GetOrigin") \
            and not hasattr(thing, "GetPointData"):
        return _of_itk(thing, refuse)
    if hasattr(thing, "GetPointData") and hasattr(thing, "GetCellData"):
        return _of_vtk(thing, refuse)
    return None


def _of_xarray(array, refuse):
    names = {str(name).lower(): name for name in array.dims}
    if sorted(names) != ["x", "y", "z"]:
        raise refuse(f"an xarray.DataArray with the dimensions {', '.join(map(str, array.dims))}; expected x, y and z")
    array = array.transpose(names["z"], names["y"], names["x"])
    options = {}
    if all(names[axis] in array.coords for axis in "xyz"):
        for axis in "xyz":  # positions rise
            if array[names[axis]].values[0] > array[names[axis]].values[-1]:
                array = array.isel({names[axis]: slice(None, None, -1)})
        options["positions"] = [array[names[axis]].values for axis in "xyz"]
        options["length_unit"] = str(array[names["x"]].attrs.get("units", ""))
    name = str(array.name or "values")
    if "units" in array.attrs:
        options["units"] = {name: str(array.attrs["units"])}
    return "volume", ({name: array.values},), options


def _of_meshio(mesh, refuse):
    cells = mesh.cells_dict
    points = numpy.ascontiguousarray(mesh.points)
    volume_cells = [kind for kind in cells if not kind.startswith(("vertex", "line", "triangle", "quad", "polygon"))]
    if volume_cells == ["tetra"]:
        scalars = {name: values for name, values in mesh.point_data.items() if numpy.ndim(values) == 1}
        of_cells = {name: values["tetra"] for name, values in mesh.cell_data_dict.items()
                    if "tetra" in values and numpy.ndim(values["tetra"]) == 1}
        return "mesh", (points, cells["tetra"], scalars, of_cells), {}
    if not volume_cells and list(cells) and "triangle" in cells:
        return "surface", (points, cells["triangle"]), {}
    raise refuse(f"a meshio.Mesh of {', '.join(cells) or 'no cells'}; expected tetra or triangle "
                 "(the program packs files with other cells)")


def _of_itk(image, refuse):
    """SimpleITK and ITK images: LPS axes, which become RAS."""
    package = sys.modules.get(type(image).__module__.split(".")[0])
    for name in ("GetArrayViewFromImage", "array_view_from_image"):
        if hasattr(package, name):
            values = numpy.asarray(getattr(package, name)(image))
            break
    else:
        raise refuse("an image whose library has no GetArrayViewFromImage; expected SimpleITK or ITK")
    if values.ndim != 3:
        raise refuse(f"an image of {values.ndim} axes; expected 3")
    affine = numpy.eye(4)
    direction = numpy.asarray(image.GetDirection(), dtype=float).reshape(3, 3)
    affine[:3, :3] = direction * numpy.asarray(image.GetSpacing(), dtype=float)
    affine[:3, 3] = image.GetOrigin()
    affine[:2] *= -1
    return "volume", (values,), {"affine": affine, "length_unit": "mm"}


def _of_vtk(data, refuse):
    """VTK and pyvista: image data, rectilinear grids, tetrahedra, triangles."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    def fields(attributes, shape=None):
        arrays = {}
        for index in range(attributes.GetNumberOfArrays()):
            array = attributes.GetArray(index)
            if array is not None and array.GetNumberOfComponents() == 1:
                values = vtk_to_numpy(array)
                arrays[array.GetName() or f"array {index}"] = values if shape is None else values.reshape(shape)
        return arrays
    if hasattr(data, "GetDimensions"):
        samples = fields(data.GetPointData(), data.GetDimensions()[::-1])
        if not samples:
            raise refuse(f"a {data.GetClassName()} without scalars at its points")
        if hasattr(data, "GetXCoordinates"):
            axes = (data.GetXCoordinates(), data.GetYCoordinates(), data.GetZCoordinates())
            return "volume", (samples,), {"positions": [vtk_to_numpy(axis) for axis in axes]}
        if hasattr(data, "GetSpacing"):
            matrix = data.GetIndexToPhysicalMatrix()
            affine = [[matrix.GetElement(row, column) for column in range(4)] for row in range(4)]
            return "volume", (samples,), {"affine": affine}
        raise refuse(f"a {data.GetClassName()}; expected image data or a rectilinear grid (the program packs its file)")
    points = vtk_to_numpy(data.GetPoints().GetData())
    if hasattr(data, "GetPolys"):
        polygons = data.GetPolys()
        corners = vtk_to_numpy(polygons.GetConnectivityArray())
        if len(corners) != 3 * polygons.GetNumberOfCells():
            raise refuse("a surface with polygons of more than three corners; expected triangles")
        return "surface", (points, corners.reshape(-1, 3)), {}
    tetrahedron = 10
    if set(numpy.unique(vtk_to_numpy(data.GetCellTypesArray()))) != {tetrahedron}:
        raise refuse("an unstructured grid with other cells than tetrahedra (the program packs its file)")
    corners = vtk_to_numpy(data.GetCells().GetConnectivityArray()).reshape(-1, 4)
    return "mesh", (points, corners, fields(data.GetPointData()), fields(data.GetCellData())), {}
