"""Plans, senses and controls robot motion through contact.

    import stiction as st
    task = st.load_task("planar_pushing")
    result = st.step(task.model, task.q_start, u, h=0.1)

Names and units are those of the C++ headers. Arrays are NumPy arrays, options are keyword-only, and long calls release Python's lock.
"""

from pathlib import Path as _Path

from ._fits import what_does_not_fit as _what_does_not_fit

if _fault := _what_does_not_fit(_Path(__file__).resolve().parent):
    raise ImportError(_fault)

import numpy as _numpy  # noqa: E402, F401  # without it the extension fails at the first array, in words that say less

from . import _own  # noqa: E402

with _own.libraries():
    from ._core import *  # noqa: F403
from ._core import version  # noqa: E402
from . import _values  # noqa: E402

_values.complete()
from ._extras import MissingExtra as MissingExtra  # noqa: E402
from .joint_states import JointStates as JointStates  # noqa: E402
from .joint_states import load_joint_states as load_joint_states  # noqa: E402
from .demonstrations import read_demonstration as read_demonstration  # noqa: E402
from .demonstrations import repair as repair  # noqa: E402
from .grasps import Grasps as Grasps  # noqa: E402
from .grasps import find_grasps as find_grasps  # noqa: E402
from .grasps import read_grasps as read_grasps  # noqa: E402
from .pages import show as show  # noqa: E402
from .pages import view as view  # noqa: E402
from .scenes import import_scene as import_scene  # noqa: E402
from .streams import stream as stream  # noqa: E402
from .sweeps import sweep as sweep  # noqa: E402

__version__ = version()


def get_cmake_dir() -> str:
    """Returns the folder of stictionConfig.cmake, for C++ projects: cmake -Dstiction_DIR="$(python -c 'import stiction; print(stiction.get_cmake_dir())')".

    Raises ImportError: this build or installation has the file in another place.
    """
    found = _Path(__file__).resolve().parent / "lib" / "cmake" / "stiction"
    if not found.is_dir():
        raise ImportError(f"no {found}: a wheel has it there; `make install PREFIX=…` has it in PREFIX/lib/cmake/stiction")
    return str(found)
