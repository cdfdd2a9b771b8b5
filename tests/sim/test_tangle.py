"""Entanglement of many strands against closed forms, the exact pair sums and known networks."""

import numpy as np
import pytest
from scipy.integrate import dblquad

import sim
from sim.topology.network import nearest_places


def wandering(rng, strands=6, nodes=60):
    """Return strands that wander through one another."""
    steps = [rng.normal(size=(nodes, 3)) for _ in range(strands)]
    return [np.cumsum(one, axis=0) + 5 * rng.normal(size=3) for one in steps]


def rods(centres, directions, length):
    half = directions * length / 2
    return [np.array([c - h, c + h]) for c, h in zip(centres, half, strict=True)]


def test_matrices_are_those_of_the_pairs_one_by_one(rng):
    strands = wandering(rng)
    found = sim.entanglement(strands, error=0)
    for a, one in enumerate(strands):
        assert found.link[a, a] == pytest.approx(sim.writhe(one), abs=1e-10)
        for b, other in enumerate(strands[:a]):
            assert found.link[a, b] == pytest.approx(sim.gauss_link(one, other), abs=1e-10)
            assert found.crossings[b, a] == found.crossings[a, b]
            assert found.crossings[a, b] == pytest.approx(sim.average_crossing_number(one, other))


@pytest.mark.parametrize("error", [1e-1, 1e-2, 1e-3])
def test_far_pairs_keep_the_stated_error(rng, error):
    strands = wandering(rng)
    exact, found = sim.entanglement(strands, error=0), sim.entanglement(strands, error=error)
    assert (abs(found.crossings - exact.crossings) <= error * exact.crossings).all()
    assert (abs(found.link - exact.link) <= error * exact.crossings).all()
    assert not np.array_equal(found.crossings, exact.crossings)  # there are far pairs


@pytest.mark.parametrize(("x", "y"), [(2.0, 2.0), (8.0, 1.0)])
def test_two_rods_at_right_angles_see_the_rectangle_that_they_span(x, y):
    """Their Gauss integral is the solid angle of the rectangle, seen from the distance between."""
    crossed = [np.array([[-x / 2, 0, 0], [x / 2, 0, 0]]), np.array([[0, -y / 2, 1], [0, y / 2, 1]])]
    angle = 4 * np.arctan(x * y / 4 / np.sqrt((x**2 + y**2) / 4 + 1))
    found = sim.entanglement(crossed)
    assert found.crossings[0, 1] == pytest.approx(angle / (2 * np.pi), rel=1e-12)
    assert abs(found.link[0, 1]) == pytest.approx(angle / (4 * np.pi), rel=1e-12)


@pytest.mark.parametrize("distance", [0.3, 20.0])
def test_two_rods_at_an_angle_have_gauss_integral(distance):
    """The integral by quadrature, near (exact formula) and far (series)."""
    turn = np.radians(35)
    first, second = np.array([1.0, 0, 0]), np.array([np.cos(turn), np.sin(turn), 0])
    offset = np.array([0.4, -0.2, distance])

    def integrand(v, u):
        r = u * first - offset - v * second
        return abs(np.dot(np.cross(first, second), r)) / np.linalg.norm(r) ** 3

    expected = dblquad(integrand, -1, 1, -1, 1)[0] / (2 * np.pi)
    found = sim.entanglement(rods(np.array([0 * offset, offset]), np.array([first, second]), 2.0))
    assert found.crossings[0, 1] == pytest.approx(expected, rel=2e-5)


def test_rods_thrown_into_a_ball_cross_as_often_as_chance_has_it(rng):
    """n(n - 1)/2 x 9 L^2/(64 R^2) crossings, for short rods.

    In a view two rods of projected lengths a, b cross with probability (2/pi) a b times the
    integral of the squared density of centres, 9/(8 pi R^2) in a ball; a projected rod has pi L/4.
    """
    n, length, radius = 500, 0.3, 1.0
    centres = rng.normal(size=(n, 3))
    centres *= (radius * rng.random(n) ** (1 / 3) / np.linalg.norm(centres, axis=1))[:, None]
    directions = rng.normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    found = sim.entanglement(rods(centres, directions, length))
    expected = n * (n - 1) / 2 * 9 * length**2 / (64 * radius**2)
    assert found.between == pytest.approx(expected, rel=0.05)  # three standard errors
    assert "500 strands" in repr(found)


def test_the_densities_of_segments_and_the_field_add_up_to_the_matrices(rng):
    found = sim.entanglement(wandering(rng))
    one = found.segments
    total = np.triu(found.crossings).sum()
    assert (one["crossings"] * one["length"]).sum() == pytest.approx(total)
    links = np.triu(found.link, 1).sum() + np.trace(found.link) / 2
    assert (one["link"] * one["length"]).sum() == pytest.approx(links)
    field = found.field(2.0)
    assert field["crossings"].sum() * 2.0**3 == pytest.approx(total)
    assert field["length"].sum() * 2.0**3 == pytest.approx(one["length"].sum())
    inside = abs(one[["x", "y", "z"]].to_numpy()[:, None] - field[["x", "y", "z"]].to_numpy())
    assert ((inside.max(axis=-1) <= 1.0).sum(axis=1) >= 1).all()


def ring(centre, normal, n=60):
    u = np.linalg.svd(np.atleast_2d(normal))[2][1:]
    t = np.linspace(0, 2 * np.pi, n + 1)[:, None]
    return np.asarray(centre) + np.cos(t) * u[0] + np.sin(t) * u[1]


def test_a_chain_of_rings_is_linked_one_with_the_next():
    rings = [ring([1.2 * k, 0, 0], [0, k % 2, 1 - k % 2]) for k in range(4)]
    link = abs(sim.entanglement(rings).link)
    expected = np.eye(4, k=1) + np.eye(4, k=-1)
    np.testing.assert_allclose(link - np.diag(np.diag(link)), expected, atol=1e-2)


def test_contacts_are_counted_once_and_join_strands_to_clusters():
    """Two strands that lie along each other, one that crosses both, one far away."""
    z = np.linspace(0, 1, 21)
    along = [np.column_stack([0 * z + x, 0 * z, z]) for x in (0.0, 0.09)]
    across = np.column_stack([z - 0.5, 0 * z + 0.08, 0 * z + 0.52])
    network = sim.contact_network([*along, across, along[0] + [5.0, 0, 0]], 0.1)
    assert list(network.per_strand) == [2, 2, 2, 0]
    assert network.largest == 3
    assert len(set(network.cluster)) == 2
    one = network.contacts.set_index(["strand_a", "strand_b"])
    assert one.loc[(1, 2), "gap"] == pytest.approx(0.09)
    assert one.loc[(1, 2), "length"] == pytest.approx(1.0)
    assert one.loc[(1, 3), "gap"] == pytest.approx(0.08)
    assert one.loc[(1, 3), ["s_a", "s_b"]].tolist() == pytest.approx([0.52, 0.5])
    assert one.loc[(1, 3), ["x", "y", "z"]].tolist() == pytest.approx([0.0, 0.04, 0.52])


def test_a_strand_touches_itself_where_it_comes_back_and_not_along_its_bend():
    t = np.linspace(0.7, 6.5, 200)
    loop = np.column_stack([np.sin(2 * t), np.sin(t), 0.05 * np.cos(t)])  # crosses itself once
    network = sim.contact_network([loop], 0.12)
    assert len(network.contacts) == 1
    assert network.contacts["gap"][0] == pytest.approx(0.1, rel=0.01)
    assert list(network.per_strand) == [1]


def test_a_network_without_contacts_has_as_many_clusters_as_strands():
    z = np.linspace(0, 1, 5)
    network = sim.contact_network([np.column_stack([0 * z + x, 0 * z, z]) for x in (0, 1, 2)], 0.1)
    assert network.contacts.empty
    assert sorted(network.cluster) == [0, 1, 2]
    assert network.largest == 1


def test_a_node_that_stands_twice_hides_no_contact():
    z = np.array([0.0, 0.5, 0.5, 1.0])
    strands = [np.column_stack([0 * z + x, 0 * z, z]) for x in (0.0, 0.05)]
    assert list(sim.contact_network(strands, 0.1).per_strand) == [1, 1]
    np.testing.assert_allclose(np.concatenate(sim.nearest_strand(strands)), 0.05)


def test_nearest_places_of_segments_are_no_farther_than_any_sampled_ones(rng):
    p, u, q, v = rng.normal(size=(4, 200, 3))
    a, b, distance = nearest_places(p, u, q, v)
    away = np.linalg.norm(p + a[:, None] * u - q - b[:, None] * v, axis=1)
    np.testing.assert_allclose(away, distance)
    grid = np.linspace(0, 1, 41)
    sampled = np.linalg.norm(
        (p - q)[:, None, None] + grid[:, None, None] * u[:, None, None]
        - grid[:, None] * v[:, None, None], axis=-1,
    ).min(axis=(1, 2))  # fmt: skip
    step = (np.linalg.norm(u, axis=1) + np.linalg.norm(v, axis=1)) / 80
    assert (distance <= sampled + 1e-12).all()
    assert (distance >= sampled - step).all()


def test_the_nearest_strand_is_that_of_the_closest_point(rng):
    strands = wandering(rng, strands=4, nodes=15)
    for number, found in enumerate(sim.nearest_strand(strands)):
        others = [one for k, one in enumerate(strands) if k != number]
        fine = np.concatenate([_finely(one) for one in others])
        sampled = np.linalg.norm(strands[number][:, None] - fine, axis=-1).min(axis=1)
        assert (found <= sampled + 1e-12).all()
        np.testing.assert_allclose(found, sampled, atol=0.02)


def _finely(strand):
    index = np.linspace(0, len(strand) - 1, 200 * (len(strand) - 1) + 1)
    return np.column_stack([np.interp(index, np.arange(len(strand)), x) for x in strand.T])


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda: sim.entanglement([]), "at least one strand"),
        (lambda: sim.entanglement([np.zeros((5, 2))]), "shape"),
        (lambda: sim.contact_network([np.eye(3)], 0.0), "distance"),
        (lambda: sim.nearest_strand([np.eye(3)]), "two strands"),
    ],
)
def test_what_is_no_tangle_is_refused(call, word):
    with pytest.raises(ValueError, match=word):
        call()
