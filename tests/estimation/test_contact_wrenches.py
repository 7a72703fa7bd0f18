"""A x = b: closed forms, and what must not matter."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.contact_wrenches import (
    ContactUnknown,
    Units,
    contact_wrenches,
    force_along,
    full_wrench,
    known_wrench,
    pure_force,
)

KINDS = ["full", "force", "along", "known"]


def at(*point: float) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array(point))


def random_contact(kind: str, rng: np.random.Generator) -> ContactUnknown:
    place = pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.3, 0.3, 3))
    if kind == "along":
        return force_along(place, rng.normal(size=3))
    if kind == "known":
        return known_wrench(place, rng.normal(size=6))
    return full_wrench(place) if kind == "full" else pure_force(place)


def net_of(contacts: list[ContactUnknown], wrenches: np.ndarray) -> np.ndarray:
    """Net wrench of contacts about the body's origin."""
    forces = [c.placement.act(pin.Force(w)).vector for c, w in zip(contacts, wrenches, strict=True)]
    return np.sum(forces, axis=0) if forces else np.zeros(6)


def closed_form(contacts: list[ContactUnknown], net: np.ndarray, units: Units) -> np.ndarray:
    """W A' (A W A')^-1 b: the least x'W^-1 x with A x = b, for A of full row rank."""
    blocks = [c.placement.toDualActionMatrix() @ c.free for c in contacts]
    matrix = np.hstack(blocks)
    weights = np.concatenate([(c.free.T * units.wrench**2).sum(axis=1) for c in contacts])
    weighted = weights[:, None] * matrix.T
    x = weighted @ np.linalg.solve(matrix @ weighted, net)
    parts = np.split(x, np.cumsum([c.free.shape[1] for c in contacts])[:-1])
    return np.array([c.free @ part for c, part in zip(contacts, parts, strict=True)])


def test_without_contacts_the_net_wrench_is_the_residual():
    net = np.arange(6.0)
    system = contact_wrenches([])
    shared = system.solve(net)
    assert (system.unknowns, system.rank, system.condition) == (0, 0, 1.0)
    assert shared.wrench.shape == (0, 6) and system.undecided.shape == (0, 0, 6)
    np.testing.assert_array_equal(shared.residual, net)


def test_one_full_wrench_is_the_net_wrench_seen_from_its_frame():
    contact = random_contact("full", np.random.default_rng(1))
    net = np.array([1.0, -2.0, 3.0, 0.4, -0.5, 0.6])
    system = contact_wrenches([contact])
    shared = system.solve(net)
    np.testing.assert_allclose(shared.wrench[0], contact.placement.actInv(pin.Force(net)).vector)
    np.testing.assert_allclose(shared.residual, 0.0, atol=1e-12)
    assert (system.unknowns, system.rank) == (6, 6) and system.decided.all()


def test_one_pure_force_is_the_net_force_and_leaves_the_moment_about_its_point():
    shared = contact_wrenches([pure_force(at(0.2, 0.0, 0.0))]).solve(
        np.array([0.0, 0.0, 10.0, 0.0, -2.5, 0.0])
    )
    np.testing.assert_allclose(shared.wrench, [[0.0, 0.0, 10.0, 0.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(shared.residual, [0.0, 0.0, 0.0, 0.0, -0.5, 0.0], atol=1e-12)


def test_one_force_along_a_direction_is_the_net_forces_component():
    contact = force_along(at(0.0, 0.1, 0.0), np.array([0.0, 3.0, 4.0]))
    system = contact_wrenches([contact])
    shared = system.solve(np.array([7.0, 0.0, 10.0, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(shared.wrench[0, :3], 8.0 * np.array([0.0, 0.6, 0.8]))
    assert (system.unknowns, system.rank, system.condition) == (1, 1, 1.0)


def test_two_directions_share_a_force_between_them_by_their_levers():
    up = np.array([0.0, 0.0, 1.0])
    contacts = [force_along(at(-0.1, 0.0, 0.0), up), force_along(at(0.3, 0.0, 0.0), up)]
    wrenches = np.array([[0.0, 0.0, 6.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0, 0.0, 0.0]])
    system = contact_wrenches(contacts)
    assert (system.unknowns, system.rank) == (2, 2) and system.decided.all()
    shared = system.solve(net_of(contacts, wrenches))
    np.testing.assert_allclose(shared.wrench, wrenches, atol=1e-12)


def test_between_two_pure_forces_the_pressure_along_their_line_is_undecided():
    contacts = [pure_force(at(0.0, 0.0, 0.0)), pure_force(at(0.2, 0.0, 0.0))]
    system = contact_wrenches(contacts)
    assert (system.unknowns, system.rank) == (6, 5)
    assert not system.decided.any()
    squeeze = system.undecided[0, :, :3]
    np.testing.assert_allclose(np.abs(squeeze), [[0.5**0.5, 0.0, 0.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(squeeze[0], -squeeze[1], atol=1e-12)
    wrenches = np.array([[4.0, 1.0, 2.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 3.0, 0.0, 0.0, 0.0]])
    shared = system.solve(net_of(contacts, wrenches))
    # What is left of 4 N and -1 N along the line is half of their sum each.
    np.testing.assert_allclose(shared.wrench[:, 0], [1.5, 1.5], atol=1e-12)
    np.testing.assert_allclose(shared.wrench[:, 1:], wrenches[:, 1:], atol=1e-12)


def test_two_full_wrenches_at_one_place_bear_half_each():
    place = random_contact("full", np.random.default_rng(2)).placement
    net = np.arange(1.0, 7.0)
    shared = contact_wrenches([full_wrench(place), full_wrench(place)]).solve(net)
    half = place.actInv(pin.Force(net / 2.0)).vector
    np.testing.assert_allclose(shared.wrench, [half, half], atol=1e-12)


@pytest.mark.parametrize("kinds", [["full"] * 2, ["full", "force"], ["force"] * 3, ["full"] * 5])
@pytest.mark.parametrize("units", [Units(), Units(force=2.0, moment=0.06)])
def test_more_unknowns_than_equations_are_the_weighted_minimum_norm(kinds, units):
    rng = np.random.default_rng(len(kinds))
    contacts = [random_contact(kind, rng) for kind in kinds]
    net = rng.normal(size=6)
    system = contact_wrenches(contacts, units)
    assert system.rank == 6
    expected = closed_form(contacts, net, units)
    np.testing.assert_allclose(system.solve(net).wrench, expected, atol=1e-9)


def test_a_smaller_unit_of_moment_moves_a_couple_from_moments_to_forces():
    contacts = [full_wrench(at(-0.1, 0.0, 0.0)), full_wrench(at(0.1, 0.0, 0.0))]
    couple = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    cheap = contact_wrenches(contacts, Units(moment=10.0)).solve(couple).wrench
    dear = contact_wrenches(contacts, Units(moment=0.001)).solve(couple).wrench
    np.testing.assert_allclose(cheap[:, 4], 0.5, atol=1e-3)
    np.testing.assert_allclose(dear[:, 2], [5.0, -5.0], atol=1e-3)


def test_a_known_wrench_is_taken_off_first():
    rng = np.random.default_rng(3)
    skin, hand = random_contact("known", rng), random_contact("full", rng)
    wrench = rng.normal(size=6)
    system = contact_wrenches([skin, hand])
    shared = system.solve(net_of([skin, hand], np.array([skin.known, wrench])))
    np.testing.assert_allclose(shared.wrench, [skin.known, wrench], atol=1e-12)
    assert (system.unknowns, system.rank) == (6, 6) and system.decided.all()


def test_a_contact_that_is_decided_is_told_from_those_that_are_not():
    contacts = [pure_force(at(0.0, 0.0, 0.0)), pure_force(at(0.2, 0.0, 0.0))]
    sideways = force_along(at(0.1, 0.0, 0.1), np.array([0.0, 1.0, 0.0]))
    system = contact_wrenches([*contacts, sideways])
    assert (system.unknowns, system.rank) == (7, 6)
    np.testing.assert_array_equal(system.decided, [False, False, True])


KIND_LISTS = st.lists(st.sampled_from(KINDS), min_size=1, max_size=5)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(KIND_LISTS, st.integers(0, 2**32 - 1))
def test_the_answer_depends_on_neither_order_nor_frame(kinds, seed):
    rng = np.random.default_rng(seed)
    contacts = [random_contact(kind, rng) for kind in kinds]
    net = rng.normal(size=6)
    here = contact_wrenches(contacts)
    shared = here.solve(net)
    order = rng.permutation(len(contacts))
    mixed = contact_wrenches([contacts[i] for i in order])
    assert (mixed.rank, mixed.unknowns) == (here.rank, here.unknowns)
    scale = 1e-9 * max(1.0, here.condition)
    np.testing.assert_allclose(mixed.solve(net).wrench, shared.wrench[order], atol=scale)
    np.testing.assert_array_equal(mixed.decided, here.decided[order])
    move = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
    elsewhere = [ContactUnknown(move * c.placement, c.free, c.known) for c in contacts]
    for system in contact_wrenches(elsewhere), here.carried(move):
        moved = system.solve(move.act(pin.Force(net)).vector)
        np.testing.assert_allclose(moved.wrench, shared.wrench, atol=scale)
        residual = move.actInv(pin.Force(moved.residual)).vector
        np.testing.assert_allclose(residual, shared.residual, atol=scale)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(KIND_LISTS, st.integers(0, 2**32 - 1))
def test_wrenches_and_residual_add_up_and_undecided_patterns_change_nothing(kinds, seed):
    rng = np.random.default_rng(seed)
    contacts = [random_contact(kind, rng) for kind in kinds]
    net = rng.normal(size=6)
    system = contact_wrenches(contacts)
    shared = system.solve(net)
    scale = 1e-9 * max(1.0, system.condition)
    total = net_of(contacts, shared.wrench) + shared.residual
    np.testing.assert_allclose(total, net, atol=scale)
    assert len(system.undecided) == system.unknowns - system.rank
    for pattern in system.undecided:
        np.testing.assert_allclose(net_of(contacts, pattern), 0.0, atol=1e-5)
    in_units = system.undecided / Units().wrench
    overlap = np.einsum("ncj,mcj->nm", in_units, in_units)
    np.testing.assert_allclose(overlap, np.eye(len(in_units)), atol=1e-9)
    np.testing.assert_allclose(
        np.einsum("ncj,cj->n", in_units, shared.wrench / Units().wrench)
        - np.einsum("ncj,cj->n", in_units, [c.known / Units().wrench for c in contacts]),
        0.0,
        atol=scale,
    )


def test_the_gain_carries_a_change_of_the_net_wrench():
    rng = np.random.default_rng(4)
    system = contact_wrenches([random_contact(kind, rng) for kind in KINDS])
    net, change = rng.normal(size=(2, 6))
    moved = system.solve(net + change).wrench - system.solve(net).wrench
    np.testing.assert_allclose(moved, system.gain @ change, atol=1e-12)


def test_contacts_that_are_carried_are_those_found_there():
    rng = np.random.default_rng(5)
    contacts = [random_contact(kind, rng) for kind in KINDS[:2]]
    move = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
    there = contact_wrenches(
        [ContactUnknown(move * c.placement, c.free, c.known) for c in contacts]
    )
    carried = contact_wrenches(contacts).carried(move)
    for name in "maps", "gain":
        np.testing.assert_allclose(getattr(carried, name), getattr(there, name), atol=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: force_along(at(0, 0, 0), np.zeros(3)), "direction of a force is zero"),
        (lambda: force_along(at(0, 0, 0), np.array([0.0, np.nan, 1.0])), "3 finite numbers"),
        (lambda: known_wrench(at(0, 0, 0), np.ones(3)), "a wrench of 6 finite numbers"),
    ],
)
def test_a_contact_that_makes_no_sense_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
