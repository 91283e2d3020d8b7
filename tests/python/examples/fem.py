"""A finite-element result: its outside, an isosurface, and the accuracy of the figure."""
import sys

import numpy
import rhoray as rr


def beam(cells: int = 12) -> rr.Data:
    """A cantilever of tetrahedra, with the deflection of beam theory at its points."""
    x, y, z = (numpy.linspace(0, length, count) for length, count in ((6, 3 * cells + 1), (1, cells + 1), (1, cells + 1)))
    shape = (len(z), len(y), len(x))
    points = numpy.stack([axis.ravel() for axis in numpy.meshgrid(x, y, z, indexing="ij")], axis=-1)
    index = numpy.arange(len(points)).reshape(shape[::-1])
    corner = [index[dx:dx + shape[2] - 1, dy:dy + shape[1] - 1, dz:dz + shape[0] - 1].ravel()
              for dz in (0, 1) for dy in (0, 1) for dx in (0, 1)]
    around = [(1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1)]  # each cube: six tetrahedra around its diagonal
    tets = numpy.concatenate([numpy.stack([corner[0], corner[a], corner[b], corner[7]], axis=-1) for a, b in around])
    stress = (6 - points[:, 0]) * (points[:, 2] - 0.5)
    material = (points[tets].mean(axis=1)[:, 0] > 3).astype(numpy.int32)
    return rr.mesh(points, tets, {"stress": stress}, {"material": material}, units={"stress": "MPa"}, length_unit="m")


def main(folder: str = ".") -> None:
    data = beam()
    rr.render(data, size=(800, 400)).save(f"{folder}/beam.png", replace=True)
    picture = rr.render(data, iso=[-1.0, 1.0], accuracy="certified", size=(800, 400), opacity=1,
                        channels=["depth", "error"])
    picture.save(f"{folder}/beam_stress.png", replace=True)
    check = picture.verify(200)
    print(f"exact arithmetic finds {check['random']['missed']} pixels missed, {check['random']['false_hits']} false")
    values, cells = rr.sample(data, [[3.0, 0.5, 0.75]])
    print(f"stress at (3, 0.5, 0.75): {values[0]:.3f} MPa, in cell {cells[0]}")


if __name__ == "__main__":
    main(*sys.argv[1:])
