"""Writes orbit.mesh: the bone of a box-like orbit in mm, a floor with a square hole and three walls, of cells of 2 mm
with 5 tets each. Usage: python3 make.py"""

import pathlib

CELL = 2  # mm
X, Y, Z = range(-22, 22, CELL), range(-18, 22, CELL), range(-2, 14, CELL)
FIVE = [((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)), ((1, 1, 0), (0, 1, 0), (1, 0, 0), (1, 1, 1)),
        ((1, 0, 1), (0, 0, 1), (1, 1, 1), (1, 0, 0)), ((0, 1, 1), (1, 1, 1), (0, 0, 1), (0, 1, 0)),
        ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1))]


def is_bone(x, y, z):
    """Whether the cell with this lower corner is bone."""
    if z < 0:
        return not (-6 <= x < 6 and -6 <= y < 6)  # the hole
    return x < -18 or x >= 18 or y >= 18


def main():
    numbers, tets = {}, []
    for x, y, z in ((x, y, z) for z in Z for y in Y for x in X if is_bone(x, y, z)):
        odd = (x // CELL + y // CELL + z // CELL) % 2  # neighbours are mirrored, so that their faces agree
        for tet in FIVE:
            corners = [(x + CELL * (1 - i if odd else i), y + CELL * j, z + CELL * k) for i, j, k in tet]
            if odd:
                corners[0], corners[1] = corners[1], corners[0]
            tets.append([numbers.setdefault(corner, len(numbers) + 1) for corner in corners])
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(numbers))]
    lines += [f"{x} {y} {z} 0" for x, y, z in numbers]
    lines += ["Tetrahedra", str(len(tets))] + [" ".join(map(str, tet)) + " 0" for tet in tets] + ["End", ""]
    pathlib.Path(__file__).with_name("orbit.mesh").write_text("\n".join(lines))


if __name__ == "__main__":
    main()
