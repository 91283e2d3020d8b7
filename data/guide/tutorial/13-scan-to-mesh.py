"""Python: from a scan to tetrahedra

The surface of a scanned object is filled with tetrahedra, and finite elements compute how warm it
gets.
"""
# %% A surface
# The scan is made here: an ellipsoid with a blurred edge, one sample per mm. Marching cubes of
# scikit-image makes triangles where the value is 0.5. The coordinates of its vertices are in the
# order of the axes of the array, k, j, i; they are reversed to x, y, z.
#
# For a surface of your own, `surface = rr.open("heart.ply")` takes the place of this cell.
import meshio
import numpy
import rhoray as rr
import scipy.sparse
import scipy.sparse.linalg
import skimage.measure

centre, radii = numpy.array([35.0, 25.0, 20.0]), numpy.array([30.0, 20.0, 15.0])  # mm; x, y, z
k, j, i = numpy.mgrid[0:41, 0:51, 0:71]
distance = numpy.linalg.norm((numpy.stack([i, j, k], axis=-1) - centre) / radii, axis=-1)
scan = 1 / (1 + numpy.exp(30 * (distance - 1)))
vertices, triangles, _, _ = skimage.measure.marching_cubes(scan, 0.5, step_size=2)
surface = rr.surface(vertices[:, ::-1], triangles)
facets = rr.render(surface, normals="flat", size=(480, 360))
facets.save("scan_surface.png", replace=True)  # an ellipsoid of flat triangles
facets

# %% Tetrahedra
# `tetrahedralize` checks that the surface is closed, and fills it. No tetrahedron is larger than 2
# cubic mm, and `Y` tells TetGen to keep the triangles. `repair=True` mends a faulty surface. With a
# path, the mesh is also a file for other programs; here meshio reads it.
mesh = rr.tetrahedralize(surface, max_volume=2, tetgen="Y", path="scan.vtu", replace=True)
file = meshio.read("scan.vtu")
points, tetrahedra = file.points, file.cells_dict["tetra"]
print(len(triangles), "triangles;", len(tetrahedra), "tetrahedra;", mesh)

# %% Finite elements
# The object produces the same heat everywhere, and its surface is kept at 0 degrees: the Laplacian
# of the temperature is -0.05 K per square mm. Linear elements give one equation for each point
# inside. A mesh without a field of its own has the field `boundary_distance`.
corners = points[tetrahedra]
edges = corners[:, 1:] - corners[:, :1]
volumes = numpy.linalg.det(edges) / 6
gradients = numpy.linalg.inv(edges).transpose(0, 2, 1)  # of the last three barycentric coordinates
gradients = numpy.concatenate([-gradients.sum(axis=1, keepdims=True), gradients], axis=1)
entries = volumes[:, None, None] * (gradients @ gradients.transpose(0, 2, 1))
rows, columns = numpy.repeat(tetrahedra, 4, axis=1), numpy.tile(tetrahedra, 4)
stiffness = scipy.sparse.csr_matrix((entries.ravel(), (rows.ravel(), columns.ravel())))
heat = 0.05 * numpy.bincount(tetrahedra.ravel(), numpy.repeat(volumes / 4, 4))
inside = rr.sample(mesh, points, field="boundary_distance")[0] > 1e-6
temperature = numpy.zeros(len(points))
temperature[inside] = scipy.sparse.linalg.spsolve(stiffness[inside][:, inside], heat[inside])

# %% The result
# An octant of the boundary is clipped away, and three slices through the centre close the cut.
data = rr.mesh(points, tetrahedra, {"temperature": temperature}, units={"temperature": "K"},
               length_unit="mm")
scene = rr.render(data, color="lightgray", size=(480, 360)).scene
scene["layers"] += [{"type": "slice", "data": "data", "colormap": "inferno", "axis": axis,
                     "position": position} for axis, position in zip("xyz", centre)]
scene["clip"] = {"box": [[35, 0, 20], [70, 25, 40]], "keep": "outside"}
cut = rr.render(scene, data={"data": data})
cut.save("scan_temperature.png", replace=True)  # an ellipsoid without an octant, warm in its middle
cut

# %% What this script claims
# In an ellipsoid, the temperature is a polynomial of degree two, and its largest value is known.
# The flat triangles take away less than one percent of the volume. No axis was exchanged.
expected = 0.05 / 2 / (1 / radii ** 2).sum()
print(f"warmest: {temperature.max():.2f} K; closed formula: {expected:.2f} K")
assert abs(temperature.max() / expected - 1) < 0.01
assert 0.99 < volumes.sum() / (4 / 3 * numpy.pi * radii.prod()) < 1
assert numpy.allclose(mesh.bounds, [centre - radii, centre + radii], atol=0.1)
