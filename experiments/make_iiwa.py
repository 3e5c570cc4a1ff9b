"""Writes models/iiwa_primitives.urdf, an iiwa 7 of capsules with inertias computed from shape and mass, models/iiwa_meshes.urdf, the same with the
meshes that `make experiments` unpacks, and models/iiwa_tray.urdf, the same with a tray.

python -m experiments.make_iiwa
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

MODELS = Path(__file__).resolve().parents[1] / "models"
MESH = "package://iiwa_description/iiwa7/link_{}.obj"
MESH_SHIFT = {6: -0.0607}  # along z, from the frame of the file to that of the link [m]
HALF, PI = 1.5707963267948966, 3.141592653589793


@dataclass
class Link:
    """A capsule from `start` to `end` (a sphere where they are equal), and the joint that carries it."""

    mass: float  # [kg]
    start: tuple[float, float, float]  # [m]
    end: tuple[float, float, float]
    radius: float
    xyz: tuple[float, float, float] = (0, 0, 0)  # of the joint in the parent
    rpy: tuple[float, float, float] = (0, 0, 0)
    limit: float = 0.0  # [rad], both ways
    effort: float = 0.0  # [N m], of the data sheet
    velocity: float = 0.0  # [rad/s]


LINKS = [
    Link(3.863, (0, 0, 0.06), (0, 0, 0.09), 0.08),
    Link(2.7025, (0, 0, 0.04), (0, -0.05, 0.175), 0.067, (0, 0, 0.1575), (0, 0, 0), 2.96706, 176, 1.71),
    Link(2.7258, (0, 0.01, 0.05), (0, 0.18, 0), 0.065, (0, 0, 0.183), (HALF, 0, -PI), 2.0944, 176, 1.71),
    Link(3.175, (0, 0, 0.035), (0, 0.05, 0.21), 0.063, (0, 0.184, 0), (HALF, 0, -PI), 2.96706, 110, 1.745),
    Link(2.73, (0, 0.01, 0.052), (0, 0.177, 0), 0.063, (0, 0, 0.2155), (HALF, 0, 0), 2.0944, 110, 2.269),
    Link(1.69, (0, 0, 0.03), (0, 0.045, 0.2), 0.055, (0, 0.184, 0), (HALF, 0, PI), 2.96706, 110, 2.443),
    Link(1.8, (0, -0.03, 0.007), (0, 0.05, 0), 0.055, (0, 0, 0.2155), (HALF, 0, 0), 2.0944, 40, 3.142),
    Link(0.4, (0, 0, 0.06), (0, 0, 0.06), 0.031, (0, 0.0805, 0), (HALF, 0, -PI), 3.05433, 40, 3.142),
]


def capsule_inertia(mass: float, radius: float, length: float) -> tuple[float, float]:
    """Moments of a uniform capsule about its centre, across and along its axis [kg m²]."""
    cylinder = length * radius**2
    caps = 4 / 3 * radius**3
    m_cylinder, m_caps = mass * cylinder / (cylinder + caps), mass * caps / (cylinder + caps)
    along = m_cylinder * radius**2 / 2 + m_caps * 2 * radius**2 / 5
    across = m_cylinder * (length**2 / 12 + radius**2 / 4)
    across += m_caps * (2 * radius**2 / 5 + length**2 / 4 + 3 * length * radius / 8)  # two half-balls, their centres 3r/8 beyond the ends
    return across, along


def triple(values: np.ndarray | tuple[float, ...]) -> str:
    return " ".join(f"{value:.10g}" for value in values)


def write_mesh(index: int) -> str:
    return f"""    <collision name="body">
      <origin xyz="0 0 {MESH_SHIFT.get(index, 0):g}"/>
      <geometry><mesh filename="{MESH.format(index)}"/></geometry>
    </collision>
"""


def write_link(index: int, link: Link, meshes: bool) -> str:
    start, end = np.array(link.start), np.array(link.end)
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length if length > 0 else np.array([0.0, 0.0, 1.0])
    across, along = capsule_inertia(link.mass, link.radius, length)
    inertia = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    # All capsules lie in the y-z plane of their link: a turn about x takes z to their axis.
    roll = float(np.arctan2(-axis[1], axis[2])) + 0.0
    shape = f'<sphere radius="{link.radius:g}"/>' if length == 0 else f'<capsule radius="{link.radius:g}" length="{length:.10g}"/>'
    names = [("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2), ("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2)]
    moments = " ".join(f'{name}="{inertia[i, j]:.8g}"' for name, i, j in names)
    capsule = f"""    <collision name="body">
      <origin xyz="{triple((start + end) / 2)}" rpy="{roll:.10g} 0 0"/>
      <geometry>{shape}</geometry>
    </collision>
"""
    return f"""  <link name="link_{index}">
    <inertial>
      <origin xyz="{triple((start + end) / 2)}"/>
      <mass value="{link.mass:g}"/>
      <inertia {moments}/>
    </inertial>
{write_mesh(index) if meshes else capsule}  </link>
"""


def write_joint(index: int, link: Link) -> str:
    return f"""  <joint name="joint_{index}" type="revolute">
    <origin xyz="{triple(link.xyz)}" rpy="{triple(link.rpy)}"/>
    <parent link="link_{index - 1}"/>
    <child link="link_{index}"/>
    <axis xyz="0 0 1"/>
    <limit lower="{-link.limit:g}" upper="{link.limit:g}" effort="{link.effort:g}" velocity="{link.velocity:g}"/>
  </joint>
"""


def make(meshes: bool) -> str:
    links = "".join(write_link(i, link, meshes) for i, link in enumerate(LINKS))
    joints = "".join(write_joint(i, link) for i, link in enumerate(LINKS) if i > 0)
    name = "iiwa_meshes" if meshes else "iiwa_primitives"
    what = "A KUKA iiwa 7 with meshes of package iiwa_description" if meshes else "A KUKA iiwa 7 of capsules"
    inertias = "inertias are those of capsules" if meshes else "inertias follow from shape and mass"
    return f'<?xml version="1.0"?>\n<!-- {what}. Made by experiments/make_iiwa.py: {inertias}. SI units. -->\n<robot name="{name}">\n{links}{joints}</robot>\n'


TRAY_MASS, TRAY_SIZE, TRAY_DISTANCE = 0.4, (0.24, 0.24, 0.01), 0.1  # [kg], [m], of its middle from the last joint [m]


def write_tray() -> str:
    x, y, z = TRAY_SIZE
    moments = [TRAY_MASS / 12 * (y * y + z * z), TRAY_MASS / 12 * (x * x + z * z), TRAY_MASS / 12 * (x * x + y * y)]
    return f"""  <link name="tray">
    <inertial>
      <mass value="{TRAY_MASS:g}"/>
      <inertia ixx="{moments[0]:.8g}" iyy="{moments[1]:.8g}" izz="{moments[2]:.8g}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision name="body">
      <geometry><box size="{triple(TRAY_SIZE)}"/></geometry>
    </collision>
  </link>
  <joint name="tray_mount" type="fixed">
    <origin xyz="0 0 {TRAY_DISTANCE:g}"/>
    <parent link="link_7"/>
    <child link="tray"/>
  </joint>
"""


def make_tray() -> str:
    """The arm of capsules with a tray."""
    text = make(False).replace('"iiwa_primitives"', '"iiwa_tray"').replace("A KUKA iiwa 7 of capsules.", "A KUKA iiwa 7 of capsules with a tray.")
    return text.replace("</robot>", f"{write_tray()}</robot>")


if __name__ == "__main__":
    for meshes in (False, True):
        (MODELS / f"iiwa_{'meshes' if meshes else 'primitives'}.urdf").write_text(make(meshes), encoding="utf-8")
    (MODELS / "iiwa_tray.urdf").write_text(make_tray(), encoding="utf-8")
