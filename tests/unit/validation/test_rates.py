import math

import pytest

from assetpipe.validation.statistics import Distribution, Rate


def test_wilson_matches_the_published_example():
    # Newcombe 1998, table I: 81 of 263 -> [0.2553, 0.3662]; 0 of 20 -> [0, 0.1611]
    rate = Rate.wilson(81, 263)
    assert (round(rate.low, 4), round(rate.high, 4)) == (0.2553, 0.3662)
    assert round(Rate.wilson(0, 20).high, 4) == 0.1611


def test_nothing_asked_is_no_knowledge():
    rate = Rate.wilson(0, 0)
    assert (rate.low, rate.high, rate.value) == (0.0, 1.0, 0.0)


def test_ends_are_exact_at_all_and_none():
    assert Rate.wilson(0, 7).low == 0.0
    assert Rate.wilson(7, 7).high == 1.0


def test_impossible_counts_are_refused():
    with pytest.raises(ValueError, match="between"):
        Rate.wilson(3, 2)


def test_distribution_keeps_the_sign_of_the_worst():
    d = Distribution.over([0.1, -0.5, 0.2])
    assert d.worst == -0.5
    assert (d.least, d.greatest, d.p50) == (-0.5, 0.2, 0.2)


def test_empty_distribution():
    d = Distribution.over([])
    assert d.samples == 0
    assert not math.isnan(d.worst)
