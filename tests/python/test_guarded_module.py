"""Guarded moves from Python: of a file and of a dict, what was felt, and mistakes."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not MODULE.is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402


def scenario(name: str) -> dict:
    return yaml.safe_load((ROOT / "scenarios" / f"{name}.yaml").read_text(encoding="utf-8"))


def test_guarded_moves_from_python_say_what_each_felt() -> None:
    done = st.guarded_moves("lower_until_touch", seed=1)
    assert done.status == st.Status.Solved and done.reached and done.reason == "" and done.friction is None
    assert [move.name for move in done.moves] == ["lower", "lift", "aside", "near", "again"]
    lower = done.moves[0]
    assert lower.outcome == st.MoveOutcome.Felt and done.moves[1].outcome == st.MoveOutcome.Arrived
    (felt,) = lower.felt
    assert felt.link == "arm/link_7" and abs(felt.force - 5) < 0.5 and felt.direction_W[2] > 0.9
    assert lower.contact <= felt.alarm <= felt.time <= lower.end
    assert lower.corrected == "table" and abs(lower.correction_error) < 1e-3 and done.moves[1].correction is None
    # What was felt is where the simulation has it, and not where the file says.
    (table,) = scenario("lower_until_touch")["scene"]["fixed"]
    assert abs(lower.correction) > 0.005 and abs(done.places["table"].p[2] - (table["pose"]["position"][2] - lower.correction)) < 1e-3


def test_guarded_moves_of_a_dict_end_early_where_nothing_is_felt() -> None:
    text = scenario("lower_until_touch")
    text["moves"] = [text["moves"][0] | {"travel": 0.01}, text["moves"][1]]
    done = st.guarded_moves(st.load_touch_scenario(text, base=ROOT / "scenarios"), seed=1)
    assert not done.reached and done.status == st.Status.Solved
    assert [move.outcome for move in done.moves] == [st.MoveOutcome.NotFelt] and "nothing was felt" in done.reason
    assert done.places == {}
    with pytest.raises(st.InvalidInput, match="moves: got none"):
        st.guarded_moves("reach_past_pillar")
    with pytest.raises(st.InvalidInput, match=r"moves\[0\].*force"):
        st.load_touch_scenario(text | {"moves": [text["moves"][0] | {"until": {"force": 50}}]}, base=ROOT / "scenarios")
