"""The stage between wire and server: what goes in comes out once, or as the disturbance has it."""

from __future__ import annotations

import random

from hypothesis import given, settings, strategies as st

from benchtool.emulator.servers.disturbance import NEVER_S, Disturbance, Disturbances, Harm, Stage, Way

TO_DRIVE = frozenset({Way.TO_DRIVE})
FRAMES = 200
SPACING_S = 0.001


def _run(*active: Disturbance, seed: int = 0, way: Way = Way.TO_DRIVE) -> list[tuple[float, int]]:
    """Send frames 0, 1, 2 ... and return them with the times of their arrival."""
    stage: Stage[int] = Stage(way, Disturbances(seed, active), _negative)
    arrived: list[tuple[float, int]] = []
    for number in range(FRAMES):
        now_s = number * SPACING_S
        while (due_s := stage.next_s()) <= now_s:
            arrived += [(due_s, each) for each in stage.due(due_s)]
        arrived += [(now_s, each) for each in stage.passed(number, now_s)]
    while (due_s := stage.next_s()) < NEVER_S:
        arrived += [(due_s, each) for each in stage.due(due_s)]
    return arrived


def _negative(frame: int, draw: random.Random) -> int:
    return -frame - 1


def _order(arrived: list[tuple[float, int]]) -> list[int]:
    return [frame for _, frame in arrived]


@settings(max_examples=30)
@given(st.sampled_from(list(Harm)), st.integers(0, 5))
def test_the_other_way_is_left_alone(harm: Harm, seed: int) -> None:
    arrived = _run(Disturbance(harm, TO_DRIVE, 1.0, 0.01), seed=seed, way=Way.TO_HOST)
    assert arrived == [(number * SPACING_S, number) for number in range(FRAMES)]


@settings(max_examples=30)
@given(st.floats(0.0, 1.0), st.integers(0, 100))
def test_a_share_is_lost_the_rest_comes_in_order(share: float, seed: int) -> None:
    order = _order(_run(Disturbance(Harm.LOST, TO_DRIVE, share), seed=seed))
    assert order == sorted(set(order))
    spread = 5.0 * (FRAMES * share * (1.0 - share)) ** 0.5 + 1.0
    assert abs(FRAMES - len(order) - share * FRAMES) <= spread


@settings(max_examples=30)
@given(st.floats(1e-4, 0.05))
def test_late_frames_keep_their_order_and_their_delay(delay_s: float) -> None:
    arrived = _run(Disturbance(Harm.LATE, TO_DRIVE, 1.0, delay_s))
    assert _order(arrived) == list(range(FRAMES))
    assert all(abs(at_s - number * SPACING_S - delay_s) < 1e-9 for at_s, number in arrived)


@settings(max_examples=30)
@given(st.floats(0.05, 0.95), st.integers(0, 100))
def test_overtaken_frames_all_arrive_by_their_time(share: float, seed: int) -> None:
    arrived = _run(Disturbance(Harm.OVERTAKEN, TO_DRIVE, share, 0.01), seed=seed)
    assert sorted(_order(arrived)) == list(range(FRAMES))
    assert _order(arrived) != list(range(FRAMES))
    waits_s = [at_s - number * SPACING_S for at_s, number in arrived]
    assert min(waits_s) > -1e-9
    assert max(waits_s) < 0.01 + 1e-9


def test_each_frame_comes_twice_if_all_are_duplicated() -> None:
    order = _order(_run(Disturbance(Harm.TWICE, TO_DRIVE)))
    assert order == [number for number in range(FRAMES) for _ in range(2)]


def test_held_frames_arrive_at_once_in_their_order() -> None:
    arrived = _run(Disturbance(Harm.HELD, TO_DRIVE, until_s=0.5))
    assert arrived == [(0.5, number) for number in range(FRAMES)]


def test_corrupted_frames_are_altered_or_dropped() -> None:
    order = _order(_run(Disturbance(Harm.CORRUPTED, TO_DRIVE, 0.5)))
    assert len(order) == FRAMES
    assert {frame for frame in order if frame < 0} == {-n - 1 for n in range(FRAMES) if n not in order}


@settings(max_examples=30)
@given(st.integers(0, 1000))
def test_the_same_seed_gives_the_same_arrivals(seed: int) -> None:
    active = (Disturbance(Harm.LOST, TO_DRIVE, 0.2), Disturbance(Harm.OVERTAKEN, TO_DRIVE, 0.2, 0.003))
    assert _run(*active, seed=seed) == _run(*active, seed=seed)
