"""Table 4-1 (ours): two and three contacts at the same time, from joint torques alone and with a wrench measured under the base."""

from __future__ import annotations

from . import touch
from .report import Result

TITLE = "Table 4-1: two and three contacts at the same time"


def name_of(row: dict) -> str:
    base = " and a wrench at the base" if row["base_wrench"] else ""
    noise = f", σ = {row['noise']:g} N m" if row["noise"] > 0 else ""
    return f"{row['arm']}, {row['contacts']} contacts: torques{base}{noise}"


def run(quick: bool) -> Result:
    rows = touch.measure("sensing_contacts", "4" if quick else "40", "--json")
    result = Result(
        f"{rows[0]['cases']} random cases a row, three times as many where two contacts may be isolated: forces of 10 N (μ = 1, n_d = 4) at points uniform by area on as many different links, random postures, "
        "500 samples on each link. *All found*: a set that explains the torques has every contact within 1 cm (5 cm). *Right links*: one has them on the right links. *Isolated*: the known "
        "contacts have no freedom left by rank, and how many of these are found within 1 cm; *ambiguous*: the answer is said to be. The wrench is measured with five times the noise "
        "of a torque in its forces, per metre. The thesis has single contacts only.",
        settings={"cases": rows[0]["cases"]},
    )
    for row in rows:
        text = f"all found {100 * row['within_1_cm']:.0f} % ({100 * row['within_5_cm']:.0f} %), right links {100 * row['right_links']:.0f} %"
        found = f" ({100 * row['isolated_within_1_cm']:.0f} % found)" if row["isolated"] > 0 else ""
        errors = f"; {1e3 * row['median_distance_m']:.1f} mm, {row['median_force_error_N']:.2f} N" if row["right_links"] > 0 else ""
        note = (
            f"isolated {100 * row['isolated']:.0f} %{found}, ambiguous {100 * row['ambiguous']:.0f} %, fewer do {100 * row['fewer_do']:.0f} %{errors}; "
            f"{1e3 * row['median_s']:.0f} ms"
        )
        identifiable = row["contacts"] == 2 and row["base_wrench"] and row["noise"] == 0
        result.add(name_of(row), "–", text, row["isolated_within_1_cm"] >= 0.9 if identifiable and not quick else None, note)
    never = all(row["isolated"] == 0 for row in rows if not row["base_wrench"])
    result.add("torques alone isolate several contacts", "–", "never" if never else "sometimes", never, "6 or 7 torques against 10 or 15 numbers")
    return result
