"""vtk_boxes.py FOLDER: writes a box of 80 x 60 x 50 as VTK files, box.vtp (compressed) and box.vtk, both binary, and
others that are not a surface or are damaged."""
import math
import sys
from pathlib import Path

from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkIntArray, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, vtkCellArray, vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

folder = Path(sys.argv[1])


def cells(*each):
    made = vtkCellArray()
    for corners in each:
        made.InsertNextCell(len(corners), corners)
    return made


def array(kind, name, values):
    made = kind()
    made.SetName(name)
    for value in values:
        made.InsertNextValue(value)
    return made


def box():
    """Five quadrilaterals and a strip, and a vertex, whose cell is the first. Its point belongs to no facet."""
    points = vtkPoints()
    points.SetDataTypeToDouble()
    for k in range(8):
        points.InsertNextPoint(0.1 + 80 * (k & 1), 0.2 + 60 * (k >> 1 & 1), 0.1 * 3 + 50 * (k >> 2))
    points.InsertNextPoint(500, 500, 500)
    data = vtkPolyData()
    data.SetPoints(points)
    data.SetVerts(cells((8,)))
    data.SetPolys(cells((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2)))
    data.SetStrips(cells((1, 3, 5, 7)))
    for made in (array(vtkIntArray, "part", (3, 7, *[-1] * 5)), array(vtkStringArray, "label", ("none", "bed", *["all the rest"] * 5)),
                 array(vtkDoubleArray, "share", [0.5] * 7)):
        data.GetCellData().AddArray(made)
    return data


def save(data, name, writer):
    writer.SetInputData(data)
    writer.SetFileName(str(folder / name))
    if name.endswith(".vtp"):
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOff()
        writer.SetCompressorTypeToZLib()
    if not writer.Write():
        sys.exit(f"{name}: VTK cannot write it")
    return (folder / name).read_bytes()


xml = save(box(), "box.vtp", vtkXMLPolyDataWriter())
binary = vtkPolyDataWriter()
binary.SetFileTypeToBinary()
save(box(), "box.vtk", binary)
legacy = save(box(), "text.vtk", vtkPolyDataWriter())
(folder / "cut.vtp").write_bytes(xml[:-100])
(folder / "cut.vtk").write_bytes(legacy[:legacy.index(b"CONNECTIVITY", legacy.index(b"POLYGONS")) + 40])
(folder / "huge.vtp").write_bytes(xml.replace(b'NumberOfPoints="9"', b'NumberOfPoints="80000000000000"'))
(folder / "beyond.vtk").write_bytes(legacy.replace(b"6 7 3", b"6 9 3"))
triangles = box()   # triangles and a strip, without a larger polygon
triangles.SetPolys(cells((0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2)))
triangles.GetCellData().Initialize()
triangles.GetCellData().AddArray(array(vtkIntArray, "part", (3, 7, 7, *[-1] * 8, 5)))
save(triangles, "triangles.vtp", vtkXMLPolyDataWriter())
(folder / "again.vtk").write_bytes(b"# vtk DataFile Version 3.0\nagain\nASCII\nDATASET POLYDATA\nPOINTS 2 double\n0 0 0 1 0 0\nPOLYGONS 1 4\n3 0 1 1\n")
(folder / "words.vtk").write_bytes(b"# vtk DataFile Version 3.0\nwords\nASCII\nDATASET POLYDATA\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n"
                                   b"POLYGONS 1 4\n3 0 1 2\ncaf\xe9word 2\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\n")
points = box()
points.SetPolys(cells())
points.SetStrips(cells())
points.GetCellData().Initialize()
save(points, "points.vtp", vtkXMLPolyDataWriter())
torn = box()
torn.GetPoints().SetPoint(7, 0, math.nan, 0)
save(torn, "nan.vtp", vtkXMLPolyDataWriter())
grid = vtkUnstructuredGrid()
grid.SetPoints(box().GetPoints())
grid.InsertNextCell(VTK_HEXAHEDRON, 8, (0, 1, 3, 2, 4, 5, 7, 6))
save(grid, "grid.vtk", vtkUnstructuredGridWriter())
(folder / "grid.vtp").write_bytes(save(grid, "grid.vtu", vtkXMLUnstructuredGridWriter()))
