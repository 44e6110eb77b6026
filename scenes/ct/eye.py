"""The orbit of the eye scene from a CT of a head: a label map, and the titanium plate as a mesh."""

import numpy as np

import sheet
import volume as v

EDGE = 0.75  # of the cubes, mm
LOWER, UPPER = (121.0, 28.0, 25.0), (202.0, 130.0, 93.0)  # of the left orbit in the image of Cranium.inv3, mm
SKIN_DEPTH = (0.4, 3.8)
# Of the triangles, mm: found with --tets, so that the scene has the counts of the paper's Table 1.
SIZES = {"bulb": 4.2, "optic nerve": 2.34, "lateral rectus": 2.37, "superior rectus": 2.32, "medial rectus": 2.81,
         "inferior rectus": 2.73, "skin": 4.3, "bone": 6.2, "fat": 3.9}
PLATE_CELLS, PLATE_CELL, PLATE_THICKNESS = (9, 11), 1.9, 0.8


def fit_bulb(ct):
    """Centre and radius of the ball that holds most watery tissue with least of it just outside: behind its front, fat is round it."""
    x, y, z = v.places(ct)
    values = v.array(ct)
    watery = ((values > -20) & (values < 130)).astype(float)
    best = (-np.inf, None, None)
    centre = np.array([0.5 * (a + b) for a, b in zip(LOWER, UPPER)])
    for step, reach in ((4.0, 16.0), (1.5, 4.5), (0.5, 1.5)):
        start = centre
        for dx in np.arange(-reach, reach + 0.1, step):
            for dy in np.arange(-reach, reach + 0.1, step):
                for dz in np.arange(-reach, reach + 0.1, step):
                    here = start + (dx, dy, dz)
                    near = tuple(slice(max(0, int((here[a] - LOWER[a] - 17) / EDGE)), int((here[a] - LOWER[a] + 17) / EDGE)) for a in (2, 1, 0))
                    r = np.sqrt((x[near] - here[0]) ** 2 + (y[near] - here[1]) ** 2 + (z[near] - here[2]) ** 2)
                    behind = y[near] > here[1]
                    for radius in (11.5, 12.0, 12.5):
                        inside, shell = r < radius, (r >= radius + 0.5) & (r < radius + 3.0) & behind
                        if inside.sum() < 1000 or not shell.any():
                            continue
                        score = 4.0 * watery[near][inside].mean() - watery[near][shell].mean() + 0.05 * radius
                        if score > best[0]:
                            best = (score, here, radius)
        centre = best[1]
    return best[1], best[2]


def orbit(ct, centre, ijk):
    """The hollow of the bony orbit behind the front of the bulb: flooded from behind the bulb, walls thickened so that cracks are shut."""
    x, y, z = v.places(ct)
    values = v.array(ct)
    walls = (values > 130) | (values < -250)
    thick = 1.9
    # From the inner rim of the orbit to the outer one, which lies further back; and to where the fissures open.
    within = (y - centre[1] > -4.0 + 0.5 * (x - centre[0])) & (y < centre[1] + 28.0)
    hollow = ~v.grown(ct, walls, thick) & within
    behind = (ijk[2], ijk[1] + int(15.0 / EDGE), ijk[0] - int(3.0 / EDGE))
    inside = v.flooded(ct, hollow, behind)
    return v.grown(ct, inside, thick) & ~walls & within, walls


def band(ct, outward, axis, centre, radius, length):
    """A flat band that lies on the bulb and runs to the apex, the shape of a rectus: the CT does not show all of each."""
    x, y, z = v.places(ct)
    across = np.cross(outward, axis)
    t, u, w = (((x - centre[0]) * e[0] + (y - centre[1]) * e[1] + (z - centre[2]) * e[2]) for e in (axis, outward, across))
    reach, end, height = radius + 1.9, length - 2.0, 4.0
    touch = np.arctan2(end, height) - np.arccos(reach / np.hypot(end, height))
    turns = np.linspace(np.radians(-8.0), touch, 8)
    path = [(reach * np.sin(a), reach * np.cos(a)) for a in turns] + [(end, height)]
    off = np.full(t.shape, np.inf)
    for (t0, u0), (t1, u1) in zip(path, path[1:]):
        fraction = np.clip(((t - t0) * (t1 - t0) + (u - u0) * (u1 - u0)) / ((t1 - t0) ** 2 + (u1 - u0) ** 2), 0.0, 1.0)
        off = np.minimum(off, np.hypot(t - t0 - fraction * (t1 - t0), u - u0 - fraction * (u1 - u0)))
    width = 4.5 - 2.0 * np.clip(t / length, 0.0, 1.0)
    return (off / 1.6) ** 2 + (w / width) ** 2 < 1.0


def recti(ct, cavity, walls, bulb, nerve, centre, radius, apex):
    """Four bands, and what is as dense as muscle beside them."""
    length = np.linalg.norm(apex - centre)
    axis = (apex - centre) / length
    up = np.array([0.0, 0.0, 1.0])
    up = (up - axis * axis[2]) / np.linalg.norm(up - axis * axis[2])
    left = np.cross(up, axis)
    left *= np.sign(left[0])
    room = cavity & ~v.grown(ct, nerve, 0.6) & ~bulb
    dense = room & (v.array(ct) > -5) & ~v.grown(ct, walls, 1.6)
    organs, taken = {}, np.zeros_like(room)
    for name, outward in (("lateral rectus", left), ("superior rectus", up), ("medial rectus", -left), ("inferior rectus", -up)):
        flat = band(ct, outward, axis, centre, radius, length) & room & ~taken
        organs[name] = v.largest(ct, v.opened(ct, flat | (dense & v.grown(ct, flat, 1.5) & ~taken), 0.8))
        taken |= organs[name]
    return organs


def floor_of(ct, cavity, x, y):
    """Height of the floor of the orbit at places, smoothed over two cells of the plate."""
    z = v.places(ct)[2]
    lowest = np.where(cavity, z, np.inf).min(axis=0)
    j, i = np.nonzero(np.isfinite(lowest))
    px, py = LOWER[0] + EDGE * i, LOWER[1] + EDGE * j
    heights = lowest[j, i]
    def at(a, b):
        near = np.exp(-((px - a) ** 2 + (py - b) ** 2) / (2 * 3.5**2)) + 1e-12
        return (near * heights).sum() / near.sum()
    return np.vectorize(at)(x, y)


def plate(ct, cavity, centre):
    """Points and tets of the plate: cells of five tets, mirrored in alternate cells, a hole in each inner cell of odd numbers."""
    nx, ny = PLATE_CELLS
    gx, gy = np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), indexing="xy")
    x = centre[0] - 4.0 + PLATE_CELL * (gx - nx / 2)
    y = centre[1] - 2.0 + PLATE_CELL * gy
    bottom = floor_of(ct, cavity, x, y) + 0.4
    holes = {(j, i) for j in range(1, ny - 1, 2) for i in range(1, nx - 1, 2)}
    return sheet.sheet(x, y, bottom, PLATE_THICKNESS, holes)


def ndmax(heights, reach):
    """The largest of the heights within so many cubes along both axes."""
    for axis in (0, 1):
        heights = np.max([np.roll(heights, shift, axis) for shift in range(-reach, reach + 1)], axis=0)
    return heights


def anatomy(ct):
    """Each organ as a mask, in the order in which a cube that is in several is given away; the plate; the centre of the bulb."""
    x, y, z = v.places(ct)
    centre, radius = fit_bulb(ct)
    ijk = [int(round((centre[a] - LOWER[a]) / EDGE)) for a in range(3)]
    bulb = np.sqrt((x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2) < radius
    values = v.array(ct)
    air = v.largest(ct, v.opened(ct, values < -250, 4.0))
    depth = v.distance_to(v.mask(ct, air))
    cavity, walls = orbit(ct, centre, ijk)

    end = cavity & (y > y[cavity].max() - 3.0)
    apex = np.array([x[end].mean(), y[end].max(), z[end].mean()])
    along = apex - centre
    fraction = np.clip(((x - centre[0]) * along[0] + (y - centre[1]) * along[1] + (z - centre[2]) * along[2]) / (along @ along), 0.0, 0.97)
    off = np.sqrt(sum((p - centre[a] - fraction * along[a]) ** 2 for a, p in enumerate((x, y, z))))
    nerve = v.largest(ct, (off < 2.3) & ~bulb & cavity)
    muscles = recti(ct, cavity, walls, bulb, nerve, centre, radius, apex)

    points, tets = plate(ct, cavity, centre)
    # The fat begins above the plate: what lies between plate and floor would be thinner than its tets.
    top = np.full(x.shape[1:], -np.inf)
    corners = ((points - LOWER) / EDGE).round().astype(int)
    np.maximum.at(top, (corners[:, 1], corners[:, 0]), points[:, 2])
    top = ndmax(top, int(np.ceil(PLATE_CELL / EDGE)) + 1)
    slab = cavity & (z <= top[None])

    skin = (depth > SKIN_DEPTH[0]) & (depth < SKIN_DEPTH[1]) & (np.hypot(x - centre[0], z - centre[2]) < 24.0) & (y < centre[1] + 8.0)
    shell = v.grown(ct, cavity, 2.4) & (y - centre[1] > -1.0 + 0.5 * (x - centre[0]))
    bone = (shell | ((values > 150) & v.grown(ct, cavity, 8.0))) & ~cavity & (depth >= SKIN_DEPTH[1])
    organs = {"plate": slab, "bulb": bulb, "optic nerve": nerve} | muscles
    skin = v.largest(ct, v.opened(ct, skin & ~bulb, 0.8))
    organs |= {"skin": skin, "bone": v.largest(ct, v.opened(ct, bone, 0.8))}
    given = np.any(list(organs.values()), axis=0)
    organs["fat"] = v.largest(ct, v.opened(ct, cavity & ~given & (depth > SKIN_DEPTH[1]), 0.8))
    return organs, (points, tets), centre, apex


def make(source, folder, write_mesh):
    """Writes label map and plate; returns the flags of `palpate mesh`. The centre of the bulb becomes the origin."""
    ct = v.cubes(v.read_inv3(source), LOWER, UPPER, EDGE)
    organs, (points, tets), centre, _ = anatomy(ct)
    v.write_labels(folder / "organs.seg.nrrd", ct, organs, centre)
    write_mesh(folder / "plate.mesh", points - centre, tets)
    flags = ["--gap", "0.8"]
    for name, size in SIZES.items():
        flags += ["--only", name, "--size", f"{name}={size}"]
    return flags
