#!/usr/bin/env python3
"""check_gaps.py CHROMIUM PAGE_DIR DATA.json

Takes out of a report's data each part that a run may lack, one at a time, and the values that may be null, and opens
what is left: the page must say nothing on the console. Prints a line a gap that breaks it; exits with 1 if there is
one.
"""

import copy
import json
import pathlib
import sys
import tempfile

from assemble_page import assemble
from chromium import Chromium

# Parts named by their path; * stands for each element of a list or each member of an object.
MAY_LACK = """
    knap  run  loss_unit  has_success  theta  test  variation  gravity  bodies  replays  fixed_poses  learning  timeline
    certificates  repeat  knap.*  run.*  test.*  test.learned.*  variation.*  variation.initial.*  variation.learned.*
    theta.kinds  bodies.*.shapes.*.basis  bodies.*.shapes.*.vertices.learned  replays.*.forces  replays.*.signals
    replays.*.distrust  replays.*.doubts  replays.*.id  replays.*.loss  replays.*.success  learning.*
    learning.evaluations.*  timeline.*  timeline.events.*.text  certificates.*
""".split()
MAY_BE_NULL = """
    variation.learned.loss.*  learning.evaluations.loss.*  learning.evaluations.best_loss.*
    learning.batches.*.best_loss  replays.*.loss  test.learned.loss_mean  test.learned.success_rate
    test.learned.success_rate_95  test.initial.loss_mean_95  loss_unit
""".split()
# A float32 in base64, to end an array of them that is cut after a multiple of 16 letters, which are three of them.
NOT_A_NUMBER = "AADAfw=="


def holders(data, path):
    """The (container, key) pairs that a path names."""
    *steps, last = path.split(".")
    found = [data]
    for step in steps:
        found = [child for one in found for child in children(one, step)]
    pairs = []
    for one in found:
        keys = range(len(one)) if isinstance(one, list) else list(one)
        pairs += [(one, key) for key in keys if last in ("*", key)]
    return pairs


def children(one, step):
    if step == "*":
        return list(one) if isinstance(one, list) else list(one.values())
    return [one[step]] if isinstance(one, dict) and step in one else []


def variants(data):
    """Names and data, each with one gap: of members by *, one variant a member; of elements of lists, one for all."""
    for path in MAY_LACK:
        by_key = {}
        for index, (container, key) in enumerate(holders(data, path)):
            by_key.setdefault(key if isinstance(container, dict) else "*", []).append(index)
        for key, indices in by_key.items():
            changed = copy.deepcopy(data)
            pairs = holders(changed, path)
            for index in reversed(indices):
                container, own = pairs[index]
                del container[own]
            yield f"without {path} ({key})", changed
    for path in MAY_BE_NULL:
        changed = copy.deepcopy(data)
        for container, key in holders(changed, path):
            container[key] = None
        yield f"{path} null", changed
    changed = copy.deepcopy(data)
    for replay in changed.get("replays", []):
        replay["poses"] = replay["poses"][: len(replay["poses"]) // 32 * 16] + NOT_A_NUMBER
    yield "poses that end early and in NaN", changed


def complaints(browser, address):
    browser.open(address)
    browser.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    browser.evaluate("document.querySelector('#replay .play')?.click()")
    browser.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    told = [event for event in browser.events
            if event["method"] in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")]
    if not told:
        return None
    details = told[0]["params"].get("exceptionDetails") or told[0]["params"]
    return details.get("exception", {}).get("description", str(details))


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    _, program, pages, source = sys.argv
    data = json.loads(pathlib.Path(source).read_text())
    failed = count = 0
    with tempfile.TemporaryDirectory() as folder, Chromium(program, "--disable-gpu", "--disable-3d-apis") as browser:
        page = pathlib.Path(folder) / "report.html"
        for name, changed in variants(data):
            count += 1
            page.write_text(assemble(pages, json.dumps(changed)))
            complaint = complaints(browser, page.as_uri())
            if complaint:
                failed += 1
                print(f"{name}: {complaint[:300]}")
    if not count:
        sys.exit("check_gaps.py: nothing was tried")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
