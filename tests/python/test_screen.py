"""bench/screen.py: what changes planning times is told from what does not, also where runs are cut off."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture
def screen(root: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(root / "bench"))
    monkeypatch.delitem(sys.modules, "screen", raising=False)
    import screen

    return screen


def test_effects_of_synthetic_times_are_found_where_a_third_is_cut_off(screen) -> None:
    """Times are exponential with mean 8 s, twice as long with the first option high, half with the second, the same with the third."""
    random = np.random.default_rng(1)
    levels = [screen.draw_levels(seed, 3) for seed in range(600)]
    times = [random.exponential(8 * 2.0 ** (a - 0.5) * 0.5 ** (b - 0.5)) for a, b, _ in levels]
    solved = [time < 10 for time in times]
    assert 0.2 < 1 - np.mean(solved) < 0.45
    mean, ((first, z_first), (second, z_second), (third, z_third)) = screen.fit_ratios(levels, solved, np.minimum(times, 10))
    assert mean == pytest.approx(8, rel=0.15)
    assert first == pytest.approx(2, rel=0.3) and z_first > 4
    assert second == pytest.approx(0.5, rel=0.3) and z_second < -4
    assert third == pytest.approx(1, rel=0.25) and abs(z_third) < 2.5


def test_every_option_is_drawn_at_both_values_independently(screen) -> None:
    levels = np.array([screen.draw_levels(seed, 8) for seed in range(50000, 50400)])
    assert np.all(np.abs(levels.mean(axis=0) - 0.5) < 0.1)
    assert np.all(np.abs(np.corrcoef(levels.T) - np.eye(8)) < 0.2)


@pytest.mark.parametrize("text", ["goal_bias", "goal_bias=0.5", "goal_bias=1,2,3", "=1,2"])
def test_an_option_without_two_values_is_refused(screen, text: str) -> None:
    with pytest.raises(screen.argparse.ArgumentTypeError, match="OPTION=LOW,HIGH expected"):
        screen.read_factor(text)
