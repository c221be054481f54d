from dataclasses import replace

import numpy as np
import pytest

from lssd_learn.collections import People
from lssd_learn.collections.generated.body.poses import bone_rotations
from lssd_learn.collections.generated.skinned import BONES, Skin, some_turns
from lssd_learn.models.measuring.figure import Figure
from lssd_learn.models.measuring.posable import Pose


def posed(figure, seed=0):
    rng = np.random.default_rng(seed)
    return Pose(rng.normal(size=len(figure.rest_modes)), some_turns(2, 10, seed)[1], rng.normal(size=3))


def test_a_body_of_known_parts_is_the_generated_one_to_the_last_digit(figure):
    people = People(n=3, seed=3)
    skin, i = Skin(), 2
    person = skin.of(dict(zip(people.slider_names, people.sliders[i].tolist(), strict=True)))
    turns = np.tile(np.eye(3), (len(BONES), 1, 1))
    for bone, turn in bone_rotations(people.pose(i), people._offsets[i]).items():
        turns[BONES.index(bone)] = turn
    body = replace(figure.body, mean=person.parts, heads=person.heads)
    points, wanted = body.lying(Pose(np.zeros(0), turns, np.zeros(3))).points, people[i].vertices
    np.testing.assert_allclose(points - points.mean(0), wanted - wanted.mean(0), atol=1e-12)


def test_rows_are_the_derivatives_of_where_vertices_lie(figure):
    pose, rng, k = posed(figure), np.random.default_rng(1), 7
    pose = replace(pose, weights=pose.weights[:k])
    body, lying = figure.body, figure.body.lying(pose)
    at, planes = rng.integers(len(body.mean), size=(40, 3)), rng.normal(size=(40, 3))
    portions = rng.dirichlet(np.ones(3), size=40)
    rows, eps = body.rows(lying, at, portions, planes, k), 1e-6
    assert rows.shape == (40, 3 + 3 * len(BONES) + k)
    for column in range(0, rows.shape[1], 3):
        step = np.zeros(rows.shape[1])
        step[column] = eps
        points = (body.lying(body.moved(pose, sign * step)).points[at] for sign in (1, -1))
        ends = [np.einsum("mc,mcx->mx", portions, corners) for corners in points]
        np.testing.assert_allclose(rows[:, column], ((ends[0] - ends[1]) * planes).sum(1) / 2 / eps, atol=1e-7)


def test_a_turn_of_the_first_joint_turns_all_and_measures_are_of_the_person(figure):
    pose = posed(figure)
    turn = some_turns(2, 10, 5)[0][6] @ some_turns(2, 10, 6)[1][13]
    more = replace(pose, turns=np.concatenate([turn[None] @ pose.turns[:1], pose.turns[1:]]))
    one, other = (figure.body.lying(each).points - pose.place for each in (pose, more))
    np.testing.assert_allclose(other, one @ turn.T, atol=1e-12)


def test_people_are_measured_as_the_body_model_measures_them(known, figure):
    people = People(n=24)
    whole = Figure.of(known, 23)
    rows, wanted = whole.rest_modes.reshape(len(whole.rest_modes), -1), known.rest[4] - whole.rest
    weights = np.linalg.lstsq(rows.T, wanted.ravel(), rcond=None)[0]
    np.testing.assert_allclose(whole.measured(weights), people.parameters[4], rtol=2e-3)


def test_the_file_holds_what_there_is(figure):
    again = Figure.unpacked(figure.packed())
    weights = np.random.default_rng(0).normal(size=len(figure.rest_modes))
    np.testing.assert_allclose(again.measured(weights), figure.measured(weights), rtol=1e-6)
    pose = posed(figure)
    np.testing.assert_allclose(again.body.lying(pose).points, figure.body.lying(pose).points, atol=1e-6)
    assert again.names == figure.names


def test_tapes_lie_on_the_body_and_are_as_long_as_the_girths(figure):
    pose = posed(figure)
    tapes = figure.tapes(pose.weights, figure.body.lying(replace(pose, turns=np.tile(np.eye(3), (len(BONES), 1, 1)))))
    girths = figure.measured(pose.weights)[1:9]
    assert len(tapes) == 8
    for tape, girth in zip(tapes.values(), girths, strict=True):
        around = 1000 * np.linalg.norm(np.roll(tape, 1, axis=0) - tape, axis=1).sum()
        assert around == pytest.approx(girth, rel=0.1)
