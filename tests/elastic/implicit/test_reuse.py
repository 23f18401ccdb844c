"""Renewals come when they pay."""

from __future__ import annotations

from warp_mps.elastic.implicit.reuse import FEW_ITERATIONS, SLACK, Renewal


def test_few_iterations_are_not_worth_one() -> None:
    renewal = Renewal(30.0)
    for _ in range(1000):
        renewal.count(FEW_ITERATIONS)
    assert not renewal.due


def test_one_comes_once_the_excess_is_its_price() -> None:
    renewal = Renewal(30.0)
    renewal.renew()
    counts = 0
    renewal.count(40)
    while not renewal.due:
        renewal.count(int(40 * SLACK) + 8)
        counts += 1
    assert counts == 4
    renewal.renew()
    assert not renewal.due
    assert renewal.renewals == 2


def test_one_that_is_demanded_comes() -> None:
    renewal = Renewal(1e9)
    renewal.demand()
    assert renewal.due


def test_it_goes_on_where_it_was() -> None:
    first, second = Renewal(30.0), Renewal(30.0)
    first.renew()
    second.assign(first.numbers())
    for iterations in (20, 70):
        first.count(iterations)
        second.count(iterations)
    assert first.due
    assert (first.numbers() == second.numbers()).all()
