#!/usr/bin/env python3
"""assemble_page.py PAGE_DIR DATA.json > report.html

Puts the page's parts and data together as `knap report` does.
"""

import pathlib
import sys


def assemble(folder, data):
    folder = pathlib.Path(folder)
    names = (folder / "scripts.txt").read_text().split()
    script = "\n".join((folder / name).read_text() for name in names)
    parts = {
        "fetch": "",  # a report may fetch nothing
        "style": f"<style>\n{(folder / 'page.css').read_text()}</style>",
        # In a script element only an end tag, or the beginning of a comment, would be taken for markup.
        "data": f'<script type="application/json" id="data">{data.replace("<", chr(92) + "u003c")}</script>',
        "script": f"<script>\n{script}</script>",
    }
    page = (folder / "page.html").read_text()
    for name, part in parts.items():
        before, after = page.split(f"<!--knap:{name}-->")
        page = before + part + after
    return page


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.stdout.write(assemble(sys.argv[1], pathlib.Path(sys.argv[2]).read_text()))


if __name__ == "__main__":
    main()
