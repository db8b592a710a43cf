"""Writes the surface of an organ as from a segmentation, made of three ellipsoids: two lobes with a valley between
them, and a thin rim.

    scripts/make_organ.py fem/lobes3.obj

One closed smooth surface in millimetres without named parts: 130 x 100 x 62 mm, 331 ml, its lowest corner at the
origin. Its inside is where the smooth minimum of the ellipsoids' approximate distances is negative. Every ray from
CENTRE crosses the surface once.
"""
import itertools
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / "figures"))
from save import written  # noqa: E402

# centre and half axes [mm]
ELLIPSOIDS = [((-24, 0, 4), (38, 40, 31)), ((32, -4, 8), (34, 30, 20)), ((8, 26, -2), (46, 34, 10))]
CENTRE = np.array([4.0, 14.0, 1.0])
BLEND_MM = 4
DIVISIONS = 15  # of an edge of the icosahedron
FARTHEST_MM = 110


def outside_mm(points):
    """Approximate distance from the organ [mm] of points (... x 3), negative inside."""
    each = np.stack([(np.linalg.norm((points - np.array(middle)) / axes, axis=-1) - 1) * min(axes) for middle, axes in ELLIPSOIDS])
    least = each.min(axis=0)
    return least - BLEND_MM * np.log(np.exp((least - each) / BLEND_MM).sum(axis=0))


def sphere(divisions):
    """Directions (N x 3) and triangles (T x 3), counter-clockwise seen from outside, of a refined icosahedron."""
    golden = (1 + 5 ** 0.5) / 2
    corners = np.array([np.roll([0, s, t * golden], k) for k in range(3) for s in (1, -1) for t in (1, -1)])
    directions, triangles, numbers = [], [], {}

    def node(point):
        point = point / np.linalg.norm(point)
        key = tuple(np.round(point, 9) + 0.0)
        if key not in numbers:
            numbers[key] = len(directions)
            directions.append(point)
        return numbers[key]

    for face in itertools.combinations(corners, 3):
        if max(np.linalg.norm(p - q) for p, q in itertools.combinations(face, 2)) > 2 + 1e-9:  # an edge has length 2
            continue
        a, b, c = face if np.linalg.det(face) > 0 else face[::-1]
        at = lambda i, j: node(a * (divisions - i - j) + b * i + c * j)  # noqa: E731
        for i in range(divisions):
            for j in range(divisions - i):
                triangles.append([at(i, j), at(i + 1, j), at(i, j + 1)])
                if i + j < divisions - 1:
                    triangles.append([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
    return np.array(directions), np.array(triangles)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    directions, triangles = sphere(DIVISIONS)
    inside, outside = np.zeros(len(directions)), np.full(len(directions), float(FARTHEST_MM))
    for _ in range(50):
        middle = (inside + outside) / 2
        is_in = outside_mm(CENTRE + directions * middle[:, None]) < 0
        inside, outside = np.where(is_in, middle, inside), np.where(is_in, outside, middle)
    points = CENTRE + directions * inside[:, None]
    points -= points.min(axis=0)
    lines = ["# A made-up organ, in millimetres, written by scripts/make_organ.py"]
    lines += ["v {:.2f} {:.2f} {:.2f}".format(*point) for point in points] + ["f {} {} {}".format(*t) for t in triangles + 1]
    with written(sys.argv[1]) as part:
        Path(part).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
