"""Figure 4-9: a motion that tells two possible contacts apart."""

from __future__ import annotations

import numpy as np

from . import touch
from .report import Result

TITLE = "Figure 4-9: a motion that tells two possible contacts apart"


def run(quick: bool) -> Result:
    motion = touch.maps(quick)["discrimination"]
    result = Result(touch.case(quick) + " The best point of each link is a candidate; (4.13) is solved by our own branch and bound, with lengths of our choice.", settings={})
    for c in motion["candidates"]:
        point = ", ".join(f"{x:.3f}" for x in c["p_W"])
        result.add(f"candidate on {c['link']}", "shown only", f"({point}) m, {np.linalg.norm(c['f_W']):.2f} N", None, "pull away" if c["pull"] == 1 else "push into")
    pulls = {c["link"][-1]: c["pull"] for c in motion["candidates"]}
    result.add("a motion that pulls from one and pushes into the other", "pulls from link 6", motion["status"], motion["status"] == "Solved" and sorted(pulls.values()) == [0, 1])
    result.add("pulls from link 6 and pushes into link 5", "yes", "yes" if pulls == {"5": 0, "6": 1} else "no", None, "the other way around is as good by (4.13a)")
    dq = np.array(motion["dq"])
    result.add("largest joint of the motion", "–", f"{1e3 * np.abs(dq).max():.2f} mrad")
    result.data["motion"] = {"dq_rad": dq}
    return result
