"""ParaView plugin that reads packed files (.rho).

grid     vtkImageData or, with positions along axes, vtkRectilinearGrid. vtkStructuredGrid where the grid is not
         axis-aligned, because Contour of ParaView 5.11 ignores the direction matrix of a vtkImageData
tets     vtkUnstructuredGrid
surface  vtkPolyData
colors   as grid, with the array `color`: sRGB, or sRGB and alpha

Arrays have the names of the fields. Units are field data, `FIELD_units` and `length_units`. Values without data stay
NaN or infinite. Cells that have no data in any chosen field are hidden (vtkGhostType); Contour ignores that, and
needs Threshold before it. The chosen fields are copied from the file.
"""
import math
import os
import pathlib
import sys
import weakref

import numpy as np
from paraview.util.vtkAlgorithm import VTKPythonAlgorithmBase, smdomain, smhint, smproperty, smproxy
from vtkmodules.util.numpy_support import create_vtk_array, get_vtk_array_type, numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDataArraySelection, vtkOutputWindow, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (VTK_TETRA, vtkCellArray, vtkDataObject, vtkDataObjectTypes,
                                           vtkDataSetAttributes)
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

sys.path.append(str(pathlib.Path(__file__).parent))  # ParaView loads this file alone
from rho_file import DTYPES, FLOATS, Grid, RhoError, open_data, printable

MEMORY = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def vtk_class(data):
    if not isinstance(data, Grid):
        return "vtkPolyData" if data.is_surface else "vtkUnstructuredGrid"
    if data.coordinates is None:
        return "vtkStructuredGrid"
    return "vtkRectilinearGrid" if data.has_tables else "vtkImageData"


def new_array(shape, dtype, components=1):
    """An array of VTK and one of numpy with the same memory. VTK owns it, because its filters share memory."""
    needed = math.prod(shape) * np.dtype(dtype).itemsize
    if needed > MEMORY:
        raise MemoryError(f"needs {needed / 2**30:.1f} GiB of memory; this machine has {MEMORY / 2**30:.1f} GiB")
    np.empty(shape, dtype)  # raises MemoryError where VTK would end the process
    array = create_vtk_array(get_vtk_array_type(np.dtype(dtype)))
    array.SetNumberOfComponents(components)
    array.SetNumberOfTuples(math.prod(shape) // components)
    return array, vtk_to_numpy(array).reshape(shape)


def add_array(attributes, name, *layout):
    array, values = new_array(*layout)
    array.SetName(name)
    attributes.AddArray(array)
    return values


def add_text(output, name, text):
    array = vtkStringArray()
    array.SetName(name)
    array.InsertNextValue(text)
    output.GetFieldData().AddArray(array)


def add_points(output, shape, dtype):
    points = vtkPoints()
    array, values = new_array(shape, dtype, 3)
    points.SetData(array)
    output.SetPoints(points)
    return values


def fill_lattice(output, grid):
    output.SetDimensions(grid.output_count)
    if grid.coordinates is None:
        grid.read_points(add_points(output, [*grid.output_count[::-1], 3], float))
    elif grid.has_tables:
        output.SetXCoordinates(numpy_to_vtk(grid.coordinates[0], deep=True))
        output.SetYCoordinates(numpy_to_vtk(grid.coordinates[1], deep=True))
        output.SetZCoordinates(numpy_to_vtk(grid.coordinates[2], deep=True))
    else:
        output.SetOrigin([coordinates[0] for coordinates in grid.coordinates])
        output.SetSpacing(grid.spacing)


def fill_cells(output, mesh):
    mesh.read_points(add_points(output, [mesh.point_count, 3], DTYPES[mesh.point_type]))
    array, corners = new_array([mesh.cell_count, mesh.corner_count], np.int64)
    mesh.read_corners(corners)
    cells = vtkCellArray()
    cells.SetData(mesh.corner_count, array)
    if mesh.is_surface:
        output.SetPolys(cells)
    else:
        output.SetCells(VTK_TETRA, cells)
    return corners


def fill(output, data, point_fields, cell_fields):
    """Puts the geometry and the chosen fields into a data set of the class `vtk_class(data)`."""
    corners = None
    if isinstance(data, Grid):
        fill_lattice(output, data)
    else:
        corners = fill_cells(output, data)
    hidden = np.bool_(len(point_fields) > 0)
    for field in point_fields:
        values = add_array(output.GetPointData(), field.name, data.point_shape, DTYPES[field.type], data.components)
        data.read_point_values(field, values)
        if field.type not in FLOATS or np.isfinite(values).all():
            hidden = np.False_
        elif corners is None:
            hidden = hidden & data.cells_with(~np.isfinite(values))
        else:
            hidden = hidden & ~np.isfinite(values)[corners].all(1)
    for field in cell_fields:
        values = add_array(output.GetCellData(), field.name, [data.cell_count], DTYPES[field.type])
        data.read_cell_values(field, values)
    if hidden.any():
        ghosts = add_array(output.GetCellData(), vtkDataSetAttributes.GhostArrayName(), [hidden.size], np.uint8)
        ghosts[:] = hidden.ravel() * vtkDataSetAttributes.HIDDENCELL
    if point_fields:
        output.GetPointData().SetActiveScalars(point_fields[0].name)
    if data.file.text("length_unit"):
        add_text(output, "length_units", data.file.text("length_unit"))
    for field in point_fields + cell_fields:
        if field.unit:
            add_text(output, f"{field.name}_units", field.unit)


def offer(selection, fields):
    """Lists the fields for the user, whose choices stay. Ids are off at first."""
    names = [field.name for field in fields]
    for name in [selection.GetArrayName(i) for i in range(selection.GetNumberOfArrays())]:
        if name not in names:
            selection.RemoveArrayByName(name)
    for field in fields:
        selection.AddArray(field.name, not field.array.endswith("_ids"))


@smproxy.reader(name="RhorayReader", label="Rhoray Reader", extensions="rho", file_description="Rhoray packed files")
class RhorayReader(VTKPythonAlgorithmBase):
    def __init__(self):
        VTKPythonAlgorithmBase.__init__(self, nInputPorts=0, nOutputPorts=1, outputType="vtkDataSet")
        self.file_name, self.data = "", None
        self.point_selection, self.cell_selection = vtkDataArraySelection(), vtkDataArraySelection()
        me = weakref.ref(self)
        for selection in (self.point_selection, self.cell_selection):
            selection.AddObserver("ModifiedEvent", lambda *_: me() and me().Modified())

    @smproperty.stringvector(name="FileName", panel_visibility="never")
    @smdomain.filelist()
    @smhint.filechooser(extensions="rho", file_description="Rhoray packed files")
    def SetFileName(self, name):
        if name != self.file_name:
            self.file_name = name
            self.Modified()

    @smproperty.dataarrayselection(name="PointArrayStatus")
    def GetPointArraySelection(self):
        return self.point_selection

    @smproperty.dataarrayselection(name="CellArrayStatus")
    def GetCellArraySelection(self):
        return self.cell_selection

    def ProcessRequest(self, request, inInfo, outInfo):
        try:
            return VTKPythonAlgorithmBase.ProcessRequest(self, request, inInfo, outInfo)
        except (RhoError, OSError) as error:
            text = str(error)
        except MemoryError as error:
            text = f"{self.file_name}: {error}"
        vtkOutputWindow.GetInstance().DisplayErrorText(f"ERROR: {printable(text)}\n")
        return 0

    def RequestDataObject(self, request, inInfo, outInfo):
        self.data = open_data(self.file_name)
        offer(self.point_selection, self.data.point_fields)
        offer(self.cell_selection, self.data.cell_fields)
        info = outInfo.GetInformationObject(0)
        output = info.Get(vtkDataObject.DATA_OBJECT())
        if output is None or output.GetClassName() != vtk_class(self.data):
            info.Set(vtkDataObject.DATA_OBJECT(), vtkDataObjectTypes.NewDataObject(vtk_class(self.data)))
        return 1

    def RequestInformation(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        if isinstance(self.data, Grid):
            extent = [end for count in self.data.output_count for end in (0, count - 1)]
            info.Set(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT(), extent, 6)
        if vtk_class(self.data) == "vtkImageData":
            info.Set(vtkDataObject.ORIGIN(), [coordinates[0] for coordinates in self.data.coordinates], 3)
            info.Set(vtkDataObject.SPACING(), self.data.spacing, 3)
        return 1

    def RequestData(self, request, inInfo, outInfo):
        points = [field for field in self.data.point_fields if self.point_selection.ArrayIsEnabled(field.name)]
        cells = [field for field in self.data.cell_fields if self.cell_selection.ArrayIsEnabled(field.name)]
        output = self.GetOutputData(outInfo, 0)
        whole = output.NewInstance()  # the output stays empty if the file is refused
        fill(whole, self.data, points, cells)
        output.ShallowCopy(whole)
        return 1
