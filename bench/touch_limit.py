#!/usr/bin/env python3
"""How often can any method name the touched link? Bayes' rule with the very distributions from which the touches of bench/real_touches.py are drawn.

    bench/touch_limit.py [ARM ...] [--touches 200] [--force 10] [--confusions]

`limit`: a method that knows where forces act (uniform by area), their cone, the noise, and that each has exactly the given size. No method is right more often in the mean.
Beside it Sensor.sense() as it is, and told the scale of the forces (plausible_force). A place and a direction are integrated over cells, in which torques are linear: a cell
adds its spread of torques to the noise.
"""

import argparse
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import real_touches as real  # noqa: E402
import stiction as st  # noqa: E402

HALF_ANGLE = np.arctan(0.5 / np.sqrt(2))  # of the round cone of real_touches.draw_force()
MARGIN = 25  # places whose coarse likelihood is e^-25 of the best carry no weight


def make_cap(rings, sectors):
    """Directions of equal solid angle about the x axis, and the side of such a cell."""
    along = 1 - (1 - np.cos(HALF_ANGLE)) * (np.arange(rings) + 0.5) / rings
    along, turn = (a.ravel() for a in np.meshgrid(along, 2 * np.pi * (np.arange(sectors) + 0.5) / sectors, indexing="ij"))
    across = np.sqrt(1 - along**2)
    return np.stack([along, across * np.cos(turn), across * np.sin(turn)], 1), np.sqrt(2 * np.pi * (1 - np.cos(HALF_ANGLE)) / (rings * sectors))


COARSE, COARSE_SIDE = make_cap(2, 6)
FINE, FINE_SIDE = make_cap(5, 16)


def tangents(k):
    t1 = np.cross(k, np.where(np.abs(k[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    t1 /= np.linalg.norm(t1, axis=1)[:, None]
    return t1, np.cross(k, t1)


class Link:
    """Places on a link, and the torques of forces there."""

    def __init__(self, link):
        self.name, self.p, self.k = link.name, np.asarray(link.p_L), -np.asarray(link.n_L)
        self.t1, self.t2 = tangents(self.k)
        self.side = np.sqrt(link.area / len(self.p))
        self.cross = np.zeros((len(self.p), 3, 3))  # [p]x
        for row, column, axis, sign in ((0, 1, 2, -1), (0, 2, 1, 1), (1, 0, 2, 1), (1, 2, 0, -1), (2, 0, 1, -1), (2, 1, 0, 1)):
            self.cross[:, row, column] = sign * self.p[:, axis]

    def set_posture(self, model, q, whiten):
        """Torques are map_f f + map_m (p x f), in units of noise."""
        joints = whiten.shape[0]

        def torque(p, f):
            return whiten @ st.calc_contact_torque(model, q, self.name, p, f)[:joints]

        e, zero = np.eye(3), np.zeros(3)
        self.map_f = np.stack([torque(zero, f) for f in e], 1)
        self.map_m = np.stack([torque(e[(i + 1) % 3], e[(i + 2) % 3]) - torque(zero, e[(i + 2) % 3]) for i in range(3)], 1)

    def log_likelihood(self, places, direction, tau, force, side_scale, angle):
        """ln of the density of tau of a force with this direction in the contact frame, in cells about these places."""
        t1, t2, k = self.t1[places], self.t2[places], self.k[places]
        u = direction[0] * k + direction[1] * t1 + direction[2] * t2
        e1, e2 = tangents(u)
        maps = self.map_f + np.einsum("jk,nkl->njl", self.map_m, self.cross[places])
        left = tau - force * np.einsum("njl,nl->nj", maps, u)
        place, turn = force * side_scale * self.side / np.sqrt(12), force * angle / np.sqrt(12)
        spread = np.stack(
            [place * np.cross(t1, u) @ self.map_m.T, place * np.cross(t2, u) @ self.map_m.T]
            + [turn * np.einsum("njl,nl->nj", maps, e) for e in (e1, e2)],
            2,
        )
        inner = np.einsum("nja,njb->nab", spread, spread) + np.eye(4)
        along = np.einsum("nja,nj->na", spread, left)
        solved = np.linalg.solve(inner, along[:, :, None])[:, :, 0]
        return -0.5 * ((left**2).sum(1) - (along * solved).sum(1)), -0.5 * np.log(np.linalg.det(inner))


def calc_limit(links, areas, tau, force):
    """Probability of each link."""
    coarse = []
    for link in links:
        every = np.arange(len(link.p))
        coarse.append(np.max([link.log_likelihood(every, d, tau, force, 1.5, 1.5 * COARSE_SIDE)[0] for d in COARSE], axis=0))
    best = max(values.max() for values in coarse)
    logs = np.full(len(links), -np.inf)
    for i, link in enumerate(links):
        places = np.flatnonzero(coarse[i] > best - MARGIN)
        if len(places) == 0:
            continue
        values = np.stack([sum(link.log_likelihood(places, d, tau, force, 1, FINE_SIDE)) for d in FINE])
        most = values.max()
        logs[i] = most + np.log(np.exp(values - most).sum() / (len(values) * len(link.p))) + np.log(areas[i])
    out = np.exp(logs - logs.max())
    return out / out.sum()


def judge(right, probabilities):
    first, of_right = probabilities.argmax(1), probabilities[np.arange(len(right)), right]
    return {
        "first": round(float((first == right).mean()), 3),
        "says": round(float(probabilities.max(1).mean()), 3),
        "log_score": round(float(np.log(of_right + 1e-9).mean()), 3),
    }


def list_confusions(names, right, probabilities):
    """Share of all touches by link touched and link named, the most frequent first."""
    counts = np.zeros((len(names), len(names)), int)
    np.add.at(counts, (right, probabilities.argmax(1)), 1)
    np.fill_diagonal(counts, 0)
    pairs = [(int(counts[i, j]), names[i].split("/")[-1], names[j].split("/")[-1]) for i in range(len(names)) for j in range(len(names)) if counts[i, j]]
    return [f"{count} of {a} as {b}" for count, a, b in sorted(pairs, reverse=True)[:8]]


def run(arm, touches, force, places, seed):
    sensor, noise, unmeasured, all_touches = real.draw_touches(arm, touches, force, seed)
    joints = sensor.model.n_a - len(unmeasured)
    dense = st.Sensor(sensor.model, links=real.ARMS[arm][1], samples=places, seed=7)
    links, areas = [Link(link) for link in dense.links], np.array([link.area for link in dense.links])
    names = [link.name for link in links]
    whiten = np.linalg.inv(np.linalg.cholesky(noise[:joints, :joints]))
    right, says = [], {"limit": [], "sense": [], "sense, told the scale": []}
    told = {"sense": {}, "sense, told the scale": {"plausible_force": force / np.sqrt(3)}}
    for touch in all_touches:
        right.append(names.index(touch["link"]))
        for link in links:
            link.set_posture(sensor.model, touch["q"], whiten)
        tau = whiten @ (touch["tau"] - touch["rest"])[:joints]
        says["limit"].append(calc_limit(links, areas, tau, force))
        for name, options in told.items():
            result = sensor.sense(touch["q"], touch["tau"], rest=touch["rest"], noise=noise, unmeasured=unmeasured, posterior=True, **real.KNOWN[False], **options)
            of_links = np.array([result.posterior.links[n] for n in names])
            says[name].append(of_links / of_links.sum())
    return names, np.array(right), {name: np.array(values) for name, values in says.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("arms", nargs="*", default=list(real.ARMS))
    parser.add_argument("--touches", type=int, default=200)
    parser.add_argument("--force", type=float, default=10.0)
    parser.add_argument("--places", type=int, default=1500, help="on each link")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--confusions", action="store_true")
    arguments = parser.parse_args()
    for arm in arguments.arms:
        names, right, says = run(arm, arguments.touches, arguments.force, arguments.places, arguments.seed)
        for name, probabilities in says.items():
            print(arm, name, judge(right, probabilities), flush=True)
            if arguments.confusions:
                print("   ", list_confusions(names, right, probabilities), flush=True)


if __name__ == "__main__":
    sys.exit(main())
