"""scripts/picture.py PAGE PICTURE: what the page of a plan shows in the middle of its motion, by the browser of the page's tests."""

import sys
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/python"))
import browser  # noqa: E402


def main(page: Path, picture: Path) -> None:
    with browser.Browser() as window:
        window.open(page)
        window.wait_for(lambda: window.evaluate("!!document.querySelector('.mantine-Slider-track')"), 60, "the time bar")
        # Of this machine, not of the plan: that it has no graphics card.
        window.evaluate("document.head.insertAdjacentHTML('beforeend', '<style>[class*=Notification] {display: none !important}</style>')")
        before = window.screenshot()
        window.scrub(0.6)
        window.wait_for(lambda: (window.screenshot() != before).mean() > 0.01, 60, "the scene")
        assert not window.errors, window.errors
        Image.fromarray(window.screenshot()).save(picture)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
