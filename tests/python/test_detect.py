"""detect(): against a count by barycentric coordinates, under renumbering, and its errors."""

import warnings

import numpy as np
import pytest

import palpate


def pairs_by_hand(points, tets, body):
    """All (point, body) of which the point is in a tet of the body, by solving for barycentric coordinates."""
    body_of_point = np.zeros(len(points), int)
    body_of_point[tets.ravel()] = np.repeat(body, 4)
    found = set()
    for tet, owner in zip(tets, body):
        corners = points[tet]
        weights = np.linalg.solve((corners[1:] - corners[0]).T, (points - corners[0]).T).T
        inside = (weights >= 0).all(axis=1) & (weights.sum(axis=1) <= 1) & (body_of_point != owner)
        found.update((int(p), int(owner)) for p in np.flatnonzero(inside))
    return found


def test_contacts_are_those_of_barycentric_coordinates(boxes):
    points, tets, body = boxes
    contacts = palpate.detect(points, tets, body)
    assert set(zip(contacts.point.tolist(), contacts.body.tolist())) == pairs_by_hand(points, tets, body)
    assert len(contacts) == len(contacts.point) > 20


def test_weights_put_each_point_where_it_is(boxes):
    points, tets, body = boxes
    contacts = palpate.detect(points, tets, body)
    again = np.einsum("nk,nkx->nx", contacts.weights, points[tets[contacts.tet]])
    np.testing.assert_allclose(again, points[contacts.point], atol=1e-12)
    assert (body[contacts.tet] == contacts.body).all()


def test_depth_and_direction_of_flat_contact(boxes):
    """A point of the upper box in the middle of its bottom is 0.1 below the top of the lower one, whose exit is up."""
    points, tets, body = boxes
    contacts = palpate.detect(points, tets, body)
    middle = np.linalg.norm(points[contacts.point][:, :2], axis=1) < 0.1
    bottom = middle & (contacts.body == 0) & np.isclose(points[contacts.point][:, 2], 0.4)
    assert bottom.sum() == 1
    assert contacts.depth[bottom] == pytest.approx(0.1, rel=0.01)  # except for the effect of the sides
    np.testing.assert_allclose(contacts.direction[bottom], [[0, 0, 1]], atol=0.1)


def test_bodies_are_the_connected_pieces_unless_told(boxes):
    points, tets, body = boxes
    told, found = palpate.detect(points, tets, body), palpate.detect(points, tets)
    for name in ["point", "body", "tet", "weights", "depth", "direction", "certainty"]:
        assert np.array_equal(getattr(told, name), getattr(found, name)), name


def test_any_numbering_of_points_tets_and_bodies_gives_the_same_contacts(boxes):
    points, tets, body = boxes
    random = np.random.default_rng(1)
    new_point, new_tet = random.permutation(len(points)), random.permutation(len(tets))
    other_points, other_tets, other_body = np.empty_like(points), np.empty_like(tets), np.empty_like(body)
    other_points[new_point] = points
    other_tets[new_tet] = new_point[tets]
    other_body[new_tet] = 7 - 3 * body
    turned = random.random(len(tets)) < 0.3
    other_tets[turned] = other_tets[turned][:, [0, 1, 3, 2]]
    one, other = palpate.detect(points, tets, body), palpate.detect(other_points, other_tets, other_body)
    assert (np.lexsort((other.body, other.point)) == np.arange(len(other))).all()
    depths = {(new_point[p], 7 - 3 * b): d for p, b, d in zip(one.point, one.body, one.depth)}
    assert set(depths) == set(zip(other.point.tolist(), other.body.tolist()))
    for p, b, d in zip(other.point, other.body, other.depth):
        assert d == pytest.approx(depths[p, b], rel=1e-5)
    again = np.einsum("nk,nkx->nx", other.weights, other_points[other_tets[other.tet]])
    np.testing.assert_allclose(again, other_points[other.point], atol=1e-12)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("integer", [np.int32, np.int64, np.uint16])
@pytest.mark.parametrize("order", ["C", "F"])
def test_types_and_layouts(boxes, real, integer, order):
    points, tets, body = boxes
    rounded = points.astype(np.float32)  # so that all types hold the same numbers
    expected = palpate.detect(rounded, tets, body)
    contacts = palpate.detect(np.asarray(rounded, real, order=order), np.asarray(tets, integer, order=order), body)
    assert np.array_equal(contacts.depth, expected.depth) and np.array_equal(contacts.tet, expected.tet)


def test_lists_and_strided_arrays_will_do(boxes):
    points, tets, body = boxes
    wide = np.zeros((len(points), 6))
    wide[:, ::2] = points
    assert len(palpate.detect(wide[:, ::2], tets.tolist(), body.tolist())) == len(palpate.detect(points, tets, body))


def refused(words, *arguments, **keywords):
    with pytest.raises(palpate.Error) as caught:
        palpate.detect(*arguments, **keywords)
    text = str(caught.value)
    assert "\n" not in text and "expected" in text
    for word in words:
        assert word in text, text


def test_bad_input_is_refused_with_a_sentence(boxes):
    points, tets, body = boxes
    refused(["points", "give points.T"], points.T, tets)
    refused(["tets", "give tets.T"], points, tets.T)
    refused(["shape (270,)"], points[:90].ravel(), tets)
    refused(["complex128"], points.astype(complex), tets)
    refused(["float64", "integers"], points, tets.astype(float))
    refused(["not an array"], [[1, 2, 3], [4]], tets)
    refused(["<U"], np.full((5, 3), "a"), tets)
    refused(["no tets"], points, np.zeros((0, 4), int))
    bad = points.copy()
    bad[7, 1] = np.nan
    refused(["point 7", "finite"], bad, tets)
    bad[7, 1] = np.inf
    refused(["point 7", "finite"], bad, tets)
    for index in [len(points), -1, 2**31, 2**40, -(2**40)]:
        wrong = tets.astype(np.int64)
        wrong[5, 2] = index
        refused(["tets", str(index)], points, wrong)
    twice = tets.copy()
    twice[300] = twice[300][[0, 0, 1, 2]]
    refused(["tet 300", "twice"], points, twice)
    flat = points.copy()
    flat[tets[0]] = flat[tets[0][0]]
    refused(["tet 0", "zero volume"], flat, tets)
    refused(["shape (640,)"], points, tets, body[:-1])
    refused(["body -1"], points, tets, body - 1)
    refused(["structure", "'uniform'"], points, tets, structure="unifrom")
    refused(["cells_per_primitive"], points, tets, cells_per_primitive=0)
    refused(["threads"], points, tets, threads=-1)


def test_bodies_that_share_points_are_refused(boxes):
    points, tets, body = boxes
    overlapping = body.copy()
    overlapping[5] = 1
    refused(["body", "tet", "points that belong to one body"], points, tets, overlapping)


def test_error_is_a_value_error_with_its_four_parts(boxes):
    points, tets, _ = boxes
    with pytest.raises(ValueError) as caught:
        palpate.detect(points, tets, structure="none")
    error = caught.value
    assert (error.source, error.where) == ("detection", "contact.structure")
    assert str(error) == f"{error.source}: {error.where}: found {error.found}, expected {error.expected}"


def test_bodies_that_meet_by_edges_alone_are_told():
    bar = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    five = np.array([[0, 1, 3, 5], [0, 3, 2, 6], [0, 5, 4, 6], [3, 5, 7, 6], [0, 3, 5, 6]])
    tets = np.vstack([five, five + 8])
    crossed = np.vstack([bar * [10, 1, 1], bar * [1, 10, 1] + [4.5, -4.5, 0.9]])
    alone = "bodies 0 and 1 overlap without a point in a tet: edges pass through in [0-9]+ places"
    with pytest.warns(UserWarning, match=alone):
        assert len(palpate.detect(crossed, tets)) == 0
    # Contacts of other bodies do not hide them.
    apart = np.vstack([bar, bar + [0, 0, 0.9]]) + [20, 0, 0]
    with pytest.warns(UserWarning, match=alone):
        assert len(palpate.detect(np.vstack([crossed, apart]), np.vstack([tets, tets + 16]))) > 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        palpate.detect(crossed + np.repeat([[0, 0, 0], [0, 0, 0.2]], 8, axis=0), tets)


def test_cells_that_are_left_out_are_told():
    points, tets = palpate.ball(radius=1.0, resolution=6)
    both = np.vstack([points, points + [0.9, 0.2, 0.1]]), np.vstack([tets, tets + len(points)])
    with pytest.warns(UserWarning, match="contacts may be missing: cells_per_primitive left out [0-9]+ cells"):
        few = palpate.detect(*both, cells_per_primitive=1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(palpate.detect(*both)) > len(few)
