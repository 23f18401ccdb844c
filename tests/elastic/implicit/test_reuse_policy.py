"""The policy of rebuilding a reused preconditioner: a rebuild comes when it pays."""

from __future__ import annotations

from warp_mps.elastic.implicit.reuse_policy import FEW_ITERATIONS, SLACK, ReusePolicy


def test_few_iterations_never_trigger_a_rebuild() -> None:
    policy = ReusePolicy(30.0)
    for _ in range(1000):
        policy.record_solve(FEW_ITERATIONS)
    assert not policy.rebuild_due


def test_a_rebuild_is_due_once_the_excess_is_its_cost() -> None:
    policy = ReusePolicy(30.0)
    policy.record_rebuild()
    counts = 0
    policy.record_solve(40)
    while not policy.rebuild_due:
        policy.record_solve(int(40 * SLACK) + 8)
        counts += 1
    assert counts == 4
    policy.record_rebuild()
    assert not policy.rebuild_due
    assert policy.rebuilds == 2


def test_a_requested_rebuild_is_due() -> None:
    policy = ReusePolicy(1e9)
    policy.request_rebuild()
    assert policy.rebuild_due


def test_a_restored_policy_takes_the_same_decisions() -> None:
    first, second = ReusePolicy(30.0), ReusePolicy(30.0)
    first.record_rebuild()
    second.assign(first.state())
    for iterations in (20, 70):
        first.record_solve(iterations)
        second.record_solve(iterations)
    assert first.rebuild_due
    assert (first.state() == second.state()).all()
