"""The peers that come as Python packages: IPC Toolkit and PBAT. Called by palpate-bench-peers.

describe PEER points|edges             prints what it does for a task and its modes, or why it does nothing
PEER MODE THREADS FOLDER               "start" reads the meshes of the folder; each "find" answers the frame in it

Seconds (passed, and of the processor) are those of the peer's own calls, with the arrays already in its format; lists that it returns are part
of them, what turns its answer into pairs is not.
"""

import importlib
import importlib.metadata
import os
import pathlib
import shutil
import sys
import time

try:
    import numpy
except ImportError:  # describe() tells
    numpy = None

DESCRIPTIONS = {
    ("ipctk", "edges"): ("IPC Toolkit, broad phase", "candidates", ["HashGrid", "SpatialHash", "LBVH", "SweepAndPrune"]),
    ("ipctk", "points"): "no query of points in tets; it works on surfaces only",
    ("pbatoolkit", "points"): ("PBAT AABB hierarchies", "own_test", ["update", "rebuild"]),
    ("pbatoolkit", "edges"): "no query of edges against triangles in its package",
}


def describe(peer, task):
    try:
        importlib.import_module(peer)
        version = importlib.metadata.version(peer)
    except (ImportError, importlib.metadata.PackageNotFoundError, OSError) as error:
        return f"it cannot be imported: {error}"
    found = DESCRIPTIONS[peer, task]
    if isinstance(found, str):
        return found
    name, answer, modes = found
    return "\t".join([f"{name} {version}", answer, *modes])


def now():
    return numpy.array([time.perf_counter(), time.process_time()])


def pairs_of(first, second):
    return numpy.stack([numpy.asarray(first), numpy.asarray(second)], axis=1).astype(numpy.int32)


class IpcToolkit:
    """Candidates of border edges and surface triangles whose boxes meet, of all bodies at once."""

    def __init__(self, mode, threads, meshes):
        import ipctk
        ipctk.set_num_threads(threads)
        self.phase = getattr(ipctk, mode)()
        self.triangles = numpy.asfortranarray(meshes["triangles"])

    def find(self, positions, edges):
        points, ends = numpy.asfortranarray(positions), numpy.asfortranarray(edges[:, :2])
        start = now()
        self.phase.build(points, ends, self.triangles)
        found = self.phase.detect_edge_face_candidates()
        spent = now() - start
        self.phase.clear()
        pairs = pairs_of([c.edge_id for c in found], [c.face_id for c in found])
        return spent, pairs


class Pbat:
    """A hierarchy of the tets of each body, asked for the tets that hold the points of others within its bounds."""

    def __init__(self, mode, threads, meshes):
        from pbatoolkit import pbat
        self.make, self.rebuild = pbat.geometry.TetrahedralAabbHierarchy, mode == "rebuild"
        self.parallel = threads > 1
        self.bodies = []
        for points_begin, points_end, tets_begin, tets_end, _, _ in meshes["ranges"]:
            tets = meshes["tets"][tets_begin:tets_end] - points_begin
            self.bodies.append({"points": (points_begin, points_end), "first_tet": tets_begin,
                                "tets": numpy.asfortranarray(tets.T.astype(numpy.int64)), "tree": None})

    def find(self, positions, edges):
        firsts, seconds_of = [], []
        start = now()
        for body in self.bodies:
            begin, end = body["points"]
            own = positions[begin:end]
            if self.rebuild or body["tree"] is None:
                body["place"] = numpy.asfortranarray(own.T)
                body["tree"] = self.make(body["place"], body["tets"])
            else:
                body["place"][:] = own.T
                body["tree"].update()
            near = numpy.all((positions >= own.min(axis=0)) & (positions <= own.max(axis=0)), axis=1)
            near[begin:end] = False
            points = numpy.flatnonzero(near)
            if points.size == 0:
                continue
            tets = body["tree"].primitives_containing_points(numpy.asfortranarray(positions[points].T), self.parallel)
            inside = tets >= 0
            firsts.append(points[inside])
            seconds_of.append(tets[inside] + body["first_tet"])
        spent = now() - start
        if not firsts:
            return spent, numpy.zeros((0, 2), numpy.int32)
        return spent, pairs_of(numpy.concatenate(firsts), numpy.concatenate(seconds_of))


PEERS = {"ipctk": IpcToolkit, "pbatoolkit": Pbat}


def serve(peer, mode, threads, folder):
    folder = pathlib.Path(folder)

    def table(name, columns, kind=numpy.int32):
        return numpy.fromfile(folder / name, kind).reshape(-1, columns)

    # Packages that print must not get between our lines.
    answers, sys.stdout = sys.stdout, sys.stderr
    finder = None
    try:
        for line in sys.stdin:
            if line.strip() == "start":
                finder = PEERS[peer](mode, int(threads), {"tets": table("tets", 4), "triangles": table("triangles", 3),
                                                             "ranges": table("ranges", 6)})
                print("ready", file=answers, flush=True)
            else:
                spent, pairs = finder.find(table("positions", 3, numpy.float64), table("edges", 3))
                pairs.tofile(folder / "pairs")
                print(f"found {spent[0]} {spent[1]}", file=answers, flush=True)
    except BrokenPipeError:
        # Nobody listens any more; what Python writes once more at its end must not fail either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), answers.fileno())
    finally:
        # Also where the program that made it was killed.
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    if sys.argv[1] == "describe":
        print(describe(*sys.argv[2:4]))
    else:
        serve(*sys.argv[1:5])
