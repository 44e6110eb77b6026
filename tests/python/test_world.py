"""World: the same as detect(), frame after frame; lifetimes of arrays; threads."""

import threading

import numpy as np
import pytest

import palpate
from threads import in_threads


@pytest.fixture
def stack():
    """A world of three boxes on each other, and its points."""
    points, tets = palpate.box((4, 4, 4), (1.0, 1.0, 1.0))
    world = palpate.World()
    parts = [points + [0.01 * i, 0.0, 0.95 * i] for i in range(3)]
    for i, part in enumerate(parts):
        assert world.add(part, tets, name=f"box {i}") == i
    return world, np.concatenate(parts)


def arrays(contacts):
    return [getattr(contacts, name).copy()
            for name in ["point", "body", "tet", "weights", "depth", "direction", "certainty"]]


def same(one, other):
    return all(np.array_equal(a, b) for a, b in zip(arrays(one), arrays(other)))


def test_frames_agree_with_detect(stack):
    world, points = stack
    tets = world.bodies.tets
    random = np.random.default_rng(2)
    for _ in range(5):
        # detect() takes them as the shape at rest: faces stay flat.
        moved = points @ (np.eye(3) + random.normal(0, 0.03, (3, 3))) + random.normal(0, 1e-5, points.shape)
        world.update(moved)
        assert len(world.contacts) > 50
        assert same(world.contacts, palpate.detect(moved, tets))
        assert world.stats.contacts == len(world.contacts)
        assert world.stats.crossings == len(world.crossings)


def test_a_world_remembers_its_last_frame(stack):
    world, points = stack
    world.update(points)
    assert world.stats.movers == len(points)
    world.update(points)
    assert world.stats.movers == 0


def test_bodies_and_their_ranges(stack):
    world, points = stack
    bodies = world.bodies
    assert [bodies[i].name for i in range(len(bodies))] == ["box 0", "box 1", "box 2"]
    assert np.array_equal(bodies.points_rest[bodies["box 1"].points], points[125:250])
    assert (bodies.body_of_point[bodies[2].points] == 2).all()
    assert bodies.tets[bodies[1].tets].min() == 125 and bodies.triangles.max() < 375
    with pytest.raises(IndexError):
        bodies[3]
    with pytest.raises(KeyError):
        bodies["box 3"]


def test_positions_of_each_body_as_a_list(stack):
    world, points = stack
    world.update(points)
    whole = world.contacts
    world.update([points[:125], points[125:250].astype(np.float32).astype(np.float64), points[250:]])
    assert len(whole) == len(world.contacts)
    world.update(points.tolist())
    assert same(whole, world.contacts)


def test_arrays_outlive_the_world_and_later_frames(stack):
    world, points = stack
    world.update(points)
    contacts, depth, tets = world.contacts, world.contacts.depth, world.bodies.tets
    kept = (arrays(contacts), depth.copy(), tets.copy())
    for shift in [0.0, 0.01, 0.02]:
        world.update(points + [0, 0, 1] * np.repeat([[0.0], [shift], [2 * shift]], 125, axis=0))
        assert len(world.contacts) >= 0
    world.add(*palpate.ball(0.3, 4))
    del world
    assert all(np.array_equal(a, b) for a, b in zip(arrays(contacts), kept[0]))
    assert np.array_equal(depth, kept[1]) and np.array_equal(tets, kept[2])


def test_arrays_are_views_that_cannot_be_written(stack):
    world, points = stack
    world.update(points)
    assert world.contacts is world.contacts or np.shares_memory(world.contacts.depth, world.contacts.depth)
    with pytest.raises(ValueError):
        world.contacts.depth[0] = 1.0
    with pytest.raises(ValueError):
        world.bodies.tets[0] = 1


def test_crossings_lie_on_the_surface_of_the_penetrated_body(stack):
    world, points = stack
    world.update(points)
    crossings, contacts = world.crossings, world.contacts
    start, end = points[contacts.point[crossings.contact]], points[crossings.free_point]
    place = start + crossings.parameter[:, None] * (end - start)
    corners = points[world.bodies.triangles[crossings.triangle]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    distance = np.einsum("nx,nx->n", place - corners[:, 0], normal) / np.linalg.norm(normal, axis=1)
    assert len(crossings) > 20 and np.abs(distance).max() < 1e-12
    body = world.bodies.body_of_point[world.bodies.triangles[crossings.triangle][:, 0]]
    assert (body == contacts.body[crossings.contact]).all()


@pytest.mark.parametrize("structure", ["uniform", "hash", "cuckoo", "brute"])
def test_structures_and_threads_have_the_same_bits(stack, structure):
    world, points = stack
    world.update(points)
    other = palpate.World(structure=structure, threads=3)
    for i in range(3):
        other.add(points[125 * i : 125 * (i + 1)], palpate.box((4, 4, 4), (1, 1, 1))[1])
    other.update(points)
    assert same(world.contacts, other.contacts)


@pytest.mark.parametrize("structure", ["compact", "hash"])
def test_pair_filter(structure):
    points, tets = palpate.box((3, 3, 3), (1.0, 1.0, 1.0))
    world = palpate.World(structure=structure)
    for i in range(3):
        world.add(points + 0.3 * i, tets)
    everywhere = np.concatenate([points + 0.3 * i for i in range(3)])
    world.update(everywhere)

    def touching():
        own = world.bodies.body_of_point[world.contacts.point]
        return {tuple(sorted(pair)) for pair in zip(own.tolist(), world.contacts.body.tolist())}

    assert touching() == {(0, 1), (0, 2), (1, 2)}
    mask = np.zeros((3, 3), bool)
    mask[2, 1] = True
    for ignored, left in [
        ([(1, 0)], {(0, 2), (1, 2)}),
        (lambda a, b: b == 2, {(0, 1)}),
        (mask, {(0, 1), (0, 2)}),
        ([], {(0, 1), (0, 2), (1, 2)}),
        ([(0, 1), (0, 2), (2, 1)], set()),
    ]:
        world.set_pair_filter(ignored)
        world.update(everywhere)
        assert touching() == left
    for wrong in [[(0, 3)], [(1, 1)], [(-1, 1)], [1, 2], np.zeros((2, 2), bool), [("a", "b")]]:
        with pytest.raises(palpate.Error):
            world.set_pair_filter(wrong)
    assert touching() == set()


def test_movable_and_self_collision():
    points, tets = palpate.box((3, 3, 3), (1.0, 1.0, 1.0))
    world = palpate.World()
    world.add(points, tets, movable=False)
    world.add(points + 0.3, tets, movable=False)
    world.update([points, points + 0.3])
    assert len(world.contacts) == 0
    folded = palpate.World()
    folded.add(*palpate.box((8, 2, 2), (4.0, 1.0, 1.0)), self_collision=True)
    bent = folded.bodies.points_rest.copy()
    bent[:, 0] = np.abs(bent[:, 0])  # one half through the other
    folded.update(bent)
    assert folded.stats.contacts + folded.stats.folded_pairs > 0


def test_what_cannot_be_is_refused_and_changes_nothing(stack):
    world, points = stack
    with pytest.raises(palpate.Error, match="was not called for these bodies"):
        world.contacts
    world.update(points)
    before = world.contacts
    for bad, words in [
        (points.T, "give positions.T"),
        (points[:-1], "374 points"),
        (np.where(points == points[3], np.nan, points), "finite"),
        (None, "positions"),
        ("text", "positions"),
        ([points], "1 arrays, expected 3"),
        ([points[:124], points[124:250], points[250:]], r"positions\[0\]: found 124 points, expected 125"),
    ]:
        with pytest.raises(palpate.Error, match=words):
            world.update(bad)
    with pytest.raises(palpate.Error, match="two share|zero volume|index"):
        world.add(points, [[0, 1, 2, 1000]])
    assert same(before, world.contacts)
    with pytest.raises(palpate.Error, match="no body|bodies"):
        palpate.World().update(points)
    with pytest.raises(palpate.Error):
        palpate.World(cell_size=-1.0)
    with pytest.raises(palpate.Error):
        palpate.World(cell_size=float("nan"))
    with pytest.raises(TypeError):
        palpate.World(no_such_setting=1)


def test_a_budget_says_what_it_missed(stack):
    whole, points = stack
    whole.update(points)
    assert whole.stats.completeness == 1.0 and len(whole.late_bodies) == 0
    world = palpate.World(budget={"tests": 500})
    for i in range(3):
        world.add(points[125 * i : 125 * (i + 1)], palpate.box((4, 4, 4), (1, 1, 1))[1])
    world.update(points)
    assert world.stats.completeness < 1.0 and world.stats.late_clusters > 0 and world.late_bodies.any()
    assert len(world.contacts) < len(whole.contacts)
    with pytest.raises(palpate.Error, match="budget"):
        palpate.World(budget={"tests": 0})


def test_two_worlds_in_two_threads(stack):
    _, points = stack
    tets = palpate.box((4, 4, 4), (1, 1, 1))[1]
    frames = [points + 0.001 * i for i in range(40)]
    alone = [palpate.detect(frame, np.concatenate([tets, tets + 125, tets + 250])) for frame in frames]
    failures = []

    def work():
        world = palpate.World(threads=2)
        for i in range(3):
            world.add(points[125 * i : 125 * (i + 1)], tets)
        for frame, expected in zip(frames, alone):
            world.update(frame)
            if not same(world.contacts, expected):
                failures.append(frame)

    in_threads(work, 2)
    assert not failures


def test_one_world_in_two_threads_is_refused_or_right_never_a_crash():
    points, tets = palpate.box((10, 10, 10), (1.0, 1.0, 1.0))
    world = palpate.World()
    world.add(points, tets)
    world.add(points + 0.5, tets)
    frame = np.concatenate([points, points + 0.5])
    world.update(frame)
    expected, refusals, wrong = len(world.contacts), [], []

    def work():
        for _ in range(15):
            try:
                world.update(frame)
                if len(world.contacts) != expected:
                    wrong.append(len(world.contacts))
            except palpate.Error as error:
                refusals.append(str(error))

    in_threads(work, 3)
    assert not wrong
    assert all("one thread at a time" in text or "was not called for these bodies" in text for text in refusals)


def test_other_threads_run_during_update():
    """A thread counts while update() runs: Python's lock is released."""
    points, tets = palpate.box((20, 20, 20), (1.0, 1.0, 1.0))
    world = palpate.World(threads=1)
    world.add(points, tets)
    world.add(points + 0.5, tets)
    frame = np.concatenate([points, points + 0.5])
    inside, seen = threading.Event(), threading.Event()

    def watch():
        while not seen.is_set():
            try:
                world.stats
            except palpate.Error as error:
                if "another thread is inside" in str(error):
                    seen.set()
            if inside.is_set():
                return

    watcher = threading.Thread(target=watch)
    watcher.start()
    for _ in range(50):
        world.update(frame)
        if seen.is_set():
            break
    inside.set()
    watcher.join()
    assert seen.is_set()


def test_worlds_that_are_gone_leave_no_memory_behind():
    points, tets = palpate.box((12, 12, 12), (1.0, 1.0, 1.0))

    def use():
        world = palpate.World(threads=1)
        world.add(points, tets)
        world.add(points + 0.9, tets)
        world.update([points, points + 0.9])
        return world.contacts.depth, world.bodies.tets, world.crossings.parameter

    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096

    for _ in range(5):
        use()
    before = resident()
    for _ in range(30):
        use()  # some 5 MB each
    assert resident() - before < 20e6
