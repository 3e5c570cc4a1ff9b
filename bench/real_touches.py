#!/usr/bin/env python3
"""How often is the touched link named? On 26 logs of a real Franka, and on simulated touches with the noise of these logs.

    bench/real_touches.py [--seeds 3] [--touches 1000] [--curve [ARM …]] [--json]

Noise, and the rest of another log, come from the logs other than the one that is judged. The hand is sensed as well and counts as link 7, as in the labels.
With --curve only the calibration of probabilities is measured, with so many simulated touches for each seed: of the touches whose most probable link has 50 to 70 %, in how many is it right? `worst_bin` is the
largest difference and its standard error, without bins of less than a twentieth of the touches. `all arms` puts the touches of all arms together.
"""

import argparse
import csv
import json
import pathlib
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "build/release/python"))
import stiction as st  # noqa: E402

DATA = ROOT / "docs" / "tutorials" / "franka_touches.csv"
PANDA = "package://example-robot-data/robots/panda_description/urdf/panda.urdf"
ARMS = {
    "panda": (PANDA, ["robot/panda_link*", "robot/panda_hand"]),
    "ur5": ("package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf", []),
    "iiwa": (str(ROOT / "models" / "iiwa_primitives.urdf"), []),
}
FINGER = "panda_finger_joint1"  # has no torque sensor; the fingers stay where they are


def load_logs():
    """Rows by log: joint angles and torques with the finger, whether something touches, the link."""
    logs = {}
    lines = [line for line in DATA.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    for row in csv.DictReader(lines):
        log = logs.setdefault(row["file"], {"link": int(row["link"]), "posture": row["posture"], "rest": [], "touched": []})
        q, tau = (np.append([float(row[f"{name}{j}"]) for j in range(7)], last) for name, last in (("q", 0.02), ("tau_ext", 0.0)))
        log["touched" if row["label"] == "1" else "rest"].append((float(row["t"]), q, tau))
    return logs


def calibrate_without(model, logs, left_out):
    """From all logs but one: their rest, and what their touches leave."""
    rows = [(number, kind == "touched", *row) for number, (name, log) in enumerate(logs.items()) if name != left_out for kind in ("rest", "touched") for row in log[kind]]
    records, touched, t, q, tau = zip(*rows)
    return st.calibrate(model, q, tau, t=t, records=list(records), touched=list(touched), unmeasured=[FINGER])


def number_of(link):
    return 7 if link.endswith("hand") else int(link[-1])


def by_number(posterior):
    out = dict.fromkeys(range(1, 8), 0.0)
    for link, probability in posterior.links.items():
        out[number_of(link)] += probability
    return out


def credible(probabilities):
    out, held = [], 0.0
    for link in sorted(probabilities, key=probabilities.get, reverse=True):
        out.append(link)
        held += probabilities[link]
        if held >= 0.95 * sum(probabilities.values()):
            return out
    return out


def judge_logs(sensor, logs, whose_rest):
    """One row of each log: the one that differs most from its last row at rest."""
    score = dict.fromkeys(("logs", "first", "best_two", "in_set", "set_links", "first_candidate", "below_threshold"), 0)
    wrong, seconds = [], []
    for name, log in logs.items():
        if not log["touched"]:
            continue
        calibration = calibrate_without(sensor.model, logs, name)
        rest, noise, freedom = log["rest"][-1][2], calibration.calc_noise(rest_rows=1).covariance, calibration.freedom
        _, q, tau = max(log["touched"], key=lambda row: np.abs(row[2] - rest).max())
        if whose_rest == "another log":
            others = [other["rest"][-1][2] for key, other in logs.items() if other["posture"] == log["posture"] and key != name]
            rest, noise = np.mean(others, axis=0), calibration.noise_between
        elif whose_rest == "none":
            rest, noise, freedom = np.zeros(8), 0.1, None
        started = time.thread_time()
        result = sensor.sense(q, tau, rest=rest, noise=noise, freedom=freedom, sign=-1, unmeasured=[FINGER], posterior=True)
        seconds.append(time.thread_time() - started)
        probabilities = by_number(result.posterior)
        order = sorted(probabilities, key=probabilities.get, reverse=True)
        link, likely = log["link"], credible(probabilities)
        score["logs"] += 1
        score["below_threshold"] += result.verdict == st.Verdict.BelowThreshold
        score["first"] += order[0] == link
        score["best_two"] += link in order[:2]
        score["in_set"] += link in likely
        score["set_links"] += len(likely)
        score["first_candidate"] += bool(result.candidates) and number_of(result.candidates[0].link) == link
        if order[0] != link:
            own = abs(tau - log["rest"][-1][2])[link - 1]
            wrong.append({"log": name, "link": link, "named": order[0], "probability": round(probabilities[link], 3), "own_joint_Nm": round(float(own), 3)})
    score["set_links"] = round(score["set_links"] / score["logs"], 2)
    return {**score, "median_ms": round(1e3 * float(np.median(seconds)), 2), "wrong": wrong}


def touch_before(log, t):
    """Largest torque of each joint in the touch of a log before a time, and how long ago its last row is."""
    rest = log["rest"][-1][2]
    before = [(when, np.abs(tau - rest)) for when, _, tau in log["touched"] if when < t]
    if not before:
        return np.zeros(len(rest)), 0.0
    return np.max([size for _, size in before], axis=0), t - max(when for when, _ in before)


def count_false_alarms(sensor, logs, knows_touches):
    """Rows at rest less the last one of their log, with noise and what touches leave of all other logs. @param knows_touches  which touch was before a row"""
    rows, alarms, nearest, shares = 0, 0, 0.0, []
    for name, log in logs.items():
        calibration = calibrate_without(sensor.model, logs, name) if len(log["rest"]) > 1 else None
        for t, q, tau in log["rest"][:-1]:
            touch, seconds = touch_before(log, t)
            noise = calibration.calc_noise(touch=touch if knows_touches else None, seconds=seconds)
            result = sensor.sense(q, tau, rest=log["rest"][-1][2], noise=noise.covariance, freedom=noise.freedom, sign=-1, unmeasured=[FINGER], posterior=True)
            rows += 1
            alarms += result.verdict != st.Verdict.BelowThreshold
            nearest = max(nearest, result.largest / result.threshold)
            shares.append(calibration.hysteresis.share)
    return {"rows": rows, "alarms": alarms, "nearest_to_threshold": round(nearest, 2), "share": [round(min(shares), 3), round(max(shares), 3)]}


def load_arm(name):
    urdf, links = ARMS[name]
    model = st.load_model({"robots": [{"name": "robot", "urdf": urdf}]})
    return model, links


def noise_of_logs():
    """Covariance of a row, and drift, of the real arm."""
    calibration = calibrate_without(load_arm("panda")[0], load_logs(), None)
    return calibration.within, calibration.drift.ravel() if calibration.drift is not None else np.zeros(8)


def draw_touches(name, touches, force, seed):
    """Touches at points uniform by area with forces in the cone, in random postures, with noise and drift of the real arm, rest from 20 rows a second before. With the sensor, the
    covariance of the noise and the joints without a sensor."""
    within, drift = noise_of_logs()
    model, links = load_arm(name)
    truth = st.Sensor(model, links=links, seed=1, samples=2000)
    n = model.n_a
    joints = min(n, 7)
    sigma = np.eye(n)
    sigma[:joints, :joints] = within[:joints, :joints]
    walk = np.append(drift[:joints], np.zeros(n - joints))
    random = np.random.default_rng(seed)
    root = np.linalg.cholesky(sigma)
    areas = np.array([link.area for link in truth.links])
    out = []
    for _ in range(touches):
        q = random.uniform(-1.5, 1.5, n)
        q[joints:] = 0.02
        link = truth.links[random.choice(len(areas), p=areas / areas.sum())]
        sample = random.integers(len(link.p_L))
        f_L = draw_force(random, -link.n_L[sample], force)
        tau = st.calc_contact_torque(model, q, link.name, link.p_L[sample], f_L)
        offset = random.normal(size=n)
        rest = offset + root @ random.normal(size=n) / np.sqrt(20)
        measured = tau + offset + root @ random.normal(size=n) + walk * random.normal(size=n)
        out.append({"link": link.name, "p_L": link.p_L[sample], "q": q, "tau": measured, "rest": rest})
    noise = sigma * (1 + 1 / 20) + np.diag(walk**2)  # a second passes
    return st.Sensor(model, links=links), noise, list(range(joints, n)), out


def simulate(name, touches, force, seed):
    """What sense() says of touches of draw_touches()."""
    sensor, noise, unmeasured, all_touches = draw_touches(name, touches, force, seed)
    says, right, seen, distances, seconds = [], [], [], [], []
    held = sizes = 0
    for touch in all_touches:
        started = time.thread_time()
        result = sensor.sense(touch["q"], touch["tau"], rest=touch["rest"], noise=noise, unmeasured=unmeasured, posterior=True, **KNOWN[force is None])
        seconds.append(time.thread_time() - started)
        named, probability = next(iter(result.posterior.links.items()))
        seen.append(result.verdict != st.Verdict.BelowThreshold)
        some = sum(result.posterior.links.values())  # 0 if no sample of any link comes near the torques
        says.append(probability / some if some > 0 else 0.0)  # of the link, given that something touches
        right.append(some > 0 and named == touch["link"])
        held += touch["link"] in result.posterior.credible
        sizes += len(result.posterior.credible)
        best = next((c for c in result.candidates if c.explains), None)
        if best is not None and best.link == touch["link"]:
            distances.append(float(np.linalg.norm(best.p_L - touch["p_L"])))
    says, right = np.array(says), np.array(right)
    return judge_curve(says, right) | {
        "below_threshold": round(1 - float(np.mean(seen)), 3),
        "first_of_seen": round(float(right[np.array(seen)].mean()), 3),
        "in_set": round(held / touches, 3),
        "set_links": round(sizes / touches, 2),
        "median_distance_cm": round(100 * float(np.median(distances)), 1),
        "median_ms": round(1e3 * float(np.median(seconds)), 2),
        "p99_ms": round(1e3 * float(np.quantile(seconds, 0.99)), 2),
        "each": (says, right),
    }


def judge_curve(says, right):
    """Bins of the probability of the most probable link: what it says, how often it is right, and the number of touches."""
    bins = [(says >= low) & (says < high) for low, high in ((0, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 1.01))]
    errors = [(abs(float(says[b].mean() - right[b].mean())), float(np.sqrt(says[b].mean() * (1 - says[b].mean()) / b.sum()))) for b in bins if b.mean() >= 0.05]
    return {
        "touches": len(says),
        "first": round(float(right.mean()), 3),
        "says": round(float(says.mean()), 3),
        "curve": [(round(float(says[b].mean()), 3), round(float(right[b].mean()), 3), int(b.sum())) for b in bins if b.any()],
        "worst_bin": [round(x, 3) for x in max(errors)],  # of those with a twentieth of the touches or more; and its standard error
    }


def follow(name, touches, force, seed):
    """Touches that begin after half a second at 200 Hz and last 0.3 s: when they are found, and when the right link is first named from their mean torques."""
    within, drift = noise_of_logs()
    model, links = load_arm(name)
    sensor, truth = st.Sensor(model, links=links), st.Sensor(model, links=links, seed=1, samples=2000)
    n, step = model.n_a, 0.005
    joints = min(n, 7)
    sigma, walk = within[:joints, :joints], drift[:joints]
    root, random = np.linalg.cholesky(sigma), np.random.default_rng(seed)
    areas = np.array([link.area for link in truth.links])
    found, named, last_right, false_alarms = [], [], 0, 0
    for _ in range(touches):
        q = np.append(random.uniform(-1.5, 1.5, joints), np.full(n - joints, 0.02))
        link = truth.links[random.choice(len(areas), p=areas / areas.sum())]
        sample = random.integers(len(link.p_L))
        touch = st.calc_contact_torque(model, q, link.name, link.p_L[sample], draw_force(random, -link.n_L[sample], force))[:joints]
        offset = random.normal(size=joints)
        onset = st.TouchOnset(offset + root @ random.normal(size=joints) / np.sqrt(20), sigma, drift=walk, rest_rows=20)
        when_found = when_named = None
        for row in range(160):
            offset = offset + np.sqrt(step) * walk * random.normal(size=joints)
            touches_now = onset.update(offset + root @ random.normal(size=joints) + touch * (row >= 100), step)
            if not touches_now:
                continue
            if row < 100:
                false_alarms += 1
                break
            when_found = when_found or 1e3 * step * (row - 99)
            noise = np.eye(n)
            noise[:joints, :joints] = onset.noise
            tau, rest = (np.append(values, np.zeros(n - joints)) for values in (onset.mean, onset.rest))
            result = sensor.sense(q, tau, rest=rest, noise=noise, unmeasured=list(range(joints, n)), friction=0.5, posterior=True)
            right = next(iter(result.posterior.links)) == link.name
            when_named = when_named or (1e3 * step * (row - 99) if right else None)
            last_right += right and row == 159
        found.append(when_found or np.inf)
        named.append(when_named or np.inf)
    return {
        "touches": touches,
        "false_alarms": false_alarms,
        "found": round(float(np.mean(np.isfinite(found))), 3),
        "median_found_ms": float(np.median(found)),
        "first_right_ms": float(np.median(named)),
        "right_within_300_ms": round(float(np.mean(np.isfinite(named))), 3),
        "right_at_300_ms": round(last_right / touches, 3),
    }


def draw_force(random, normal, force):
    """A force in the cone with friction 0.5: of a given size, or of the prior."""
    scale = force or PRIOR_FORCE
    while True:
        f = scale * random.normal(size=3)
        along = f @ normal
        if along > 0 and np.linalg.norm(f - along * normal) <= 0.5 * along / np.sqrt(2):  # inside the pyramid of four rays
            return f / np.linalg.norm(f) * force if force else f


PRIOR_FORCE = 20.0
# What the sensor is told of forces: less than how they are drawn, or, where they are of the prior, just that: a round cone, as one of 16 rays.
KNOWN = {False: {"friction": 0.5}, True: {"friction": 0.5 / np.sqrt(2), "rays": 16, "plausible_force": PRIOR_FORCE}}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--touches", type=int, default=1000)
    parser.add_argument("--curve", nargs="*", metavar="ARM", choices=ARMS)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if arguments.curve is not None:
        print_all(measure_curves(arguments.curve or list(ARMS), arguments), arguments.json)
        return
    logs = load_logs()
    model, links = load_arm("panda")
    out = {"logs": {}, "touches": {}}
    for seed in range(arguments.seeds):
        sensor = st.Sensor(model, links=links, seed=seed)
        for whose_rest in ("own", "another log", "none"):
            out["logs"][f"{whose_rest}, seed {seed}"] = judge_logs(sensor, logs, whose_rest)
        out["logs"][f"rest rows, touches unknown, seed {seed}"] = count_false_alarms(sensor, logs, False)
        out["logs"][f"rest rows, seed {seed}"] = count_false_alarms(sensor, logs, True)
    out |= describe_noise(*noise_of_logs())
    for name in ARMS if arguments.touches else ():
        out["touches"][f"{name}, 10 N"] = simulate(name, arguments.touches, 10.0, 0)
        out["touches"][f"{name}, forces of the prior"] = simulate(name, arguments.touches, None, 0)
        out["touches"][f"{name}, 10 N, in time"] = follow(name, arguments.touches // 5, 10.0, 0)
    print_all(out, arguments.json)


def measure_curves(arms, arguments):
    touches = {}
    for kind, force in (("10 N", 10.0), ("forces of the prior", None)):
        everything = []
        for name in arms:
            each = [simulate(name, arguments.touches, force, seed)["each"] for seed in range(arguments.seeds)]
            touches[f"{name}, {kind}"] = judge_curve(*np.concatenate(each, axis=1))
            everything += each
        touches[f"all arms, {kind}"] = judge_curve(*np.concatenate(everything, axis=1))
    return {"logs": {}, "touches": touches} | describe_noise(*noise_of_logs())


def describe_noise(within, drift):
    return {"noise": [round(float(x), 4) for x in np.sqrt(np.diag(within))[:7]], "drift": [round(float(x), 4) for x in drift[:7]]}


def print_all(out, as_json):
    for score in out["touches"].values():
        score.pop("each", None)
    if as_json:
        print(json.dumps(out))
        return
    print(f"noise of the real arm {out['noise']} N m, drift {out['drift']} N m/s^0.5")
    for name, score in {**out["logs"], **out["touches"]}.items():
        print(name, {key: value for key, value in score.items() if key != "wrong"})
        for row in score.get("wrong", []):
            print("   ", row)


if __name__ == "__main__":
    sys.exit(main())
