#!/usr/bin/env python3
"""screenshots.py CHROMIUM REPORT.html FOLDER [ROW]

Pictures of a report's first screen, halfway through the replay of the list's ROW (0, the worst), for the documentation:
light.png, dark.png, and no_webgl.png as a browser without WebGL draws it.
"""

import pathlib
import sys

from check_report import NO_WEBGL, TOOLS, WEBGL
from chromium import Chromium

PICTURES = [("light", WEBGL), ("dark", WEBGL), ("no_webgl", NO_WEBGL)]


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    program, report, folder = sys.argv[1:4]
    row = int(sys.argv[4]) if len(sys.argv) == 5 else 0
    for name, options in PICTURES:
        with Chromium(program, "--hide-scrollbars", *options) as browser:
            browser.resize(1400, 1000)
            browser.prefer("dark" if name == "dark" else "light")
            browser.open(pathlib.Path(report).resolve().as_uri())
            browser.evaluate(TOOLS)
            # Sizes come with the first frames, then the drawings that they need.
            browser.evaluate("test.frames(6)")
            browser.evaluate(f"document.querySelectorAll('button.choose')[{row}].click()")
            browser.evaluate("test.frames(3)")
            browser.evaluate("test.slide(document.querySelector('#replay .scrub'), 0.5 * test.end())")
            browser.evaluate("test.frames(3)")
            (pathlib.Path(folder) / f"{name}.png").write_bytes(browser.screenshot())


if __name__ == "__main__":
    main()
