"""Certified rays: where a million rays meet an isosurface, and how far each answer may be off."""
import numpy
import rhoray as rr


def main(count: int = 1_000_000) -> None:
    # The distance from a point, sampled on a lattice: its isosurface is nearly a sphere.
    k, j, i = numpy.mgrid[0:64, 0:64, 0:64]
    values = numpy.sqrt((i - 31.5) ** 2 + (j - 31.5) ** 2 + (k - 31.5) ** 2)
    data = rr.volume({"distance": values}, length_unit="mm")

    random = numpy.random.default_rng(1)
    directions = random.normal(size=(count, 3))
    directions /= numpy.linalg.norm(directions, axis=1, keepdims=True)
    origins = numpy.broadcast_to([31.5, 31.5, 31.5], (count, 3))
    hits = rr.trace(data, origins, directions, iso=20, accuracy="certified")

    print(f"{hits.is_hit.sum()} of {count} rays meet the surface")
    print(f"distance from the centre: {hits.t.min():.4f} to {hits.t.max():.4f} mm")
    print(f"no distance is off by more than {hits.error.max():.1e} mm")


if __name__ == "__main__":
    main()
