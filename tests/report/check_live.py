#!/usr/bin/env python3
"""check_live.py CHROMIUM KNAP KNAP_WORKER CONFIG

Opens the page of a run that goes on, as a reader would, while its only worker is held at chosen moments: what the page
shows follows the run, and the report takes its place at the end. Nobody else gets in. Exits with 1 and says what is
wrong. Needs a network with multicast.
"""

import json
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request

from chromium import Chromium

# Long enough for the page to be opened within it, whoever holds the machine; the worker is held anyway.
OVERRIDES = ["learning.variations=12", "learning.batch=3", "learning.max_evaluations=4", "evaluation.variations=12"]
WAIT_S = 600


def until(holds, what, known=lambda: ""):
    """What holds() answers once it is true. After long enough it is said what did not happen, and what is known()."""
    deadline = time.monotonic() + WAIT_S
    while not (value := holds()):
        if time.monotonic() > deadline:
            sys.exit(f"check_live.py: {what} does not happen\n{known()}")
        time.sleep(0.02)
    return value


def status_of(url, **headers):
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=WAIT_S) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def ask_across_pages(browser, expression):
    """Its value; None while another page takes the place of the one that was asked."""
    try:
        return browser.evaluate(expression)
    except RuntimeError:
        return None


def read_url(printed):
    """The address in the line that begins with "watch"."""
    def find():
        lines = printed.read_text().splitlines(keepends=True)
        return next((line.split()[1] for line in lines if line.startswith("watch") and line.endswith("\n")), None)
    return until(find, "an address that is printed", printed.read_text)


def count_batches(events):
    return sum('"event":"batch_end"' in line for line in events.read_text().splitlines()) if events.exists() else 0


def check(browser, knap, worker, config, folder):
    bus = f"udpm://239.255.{random.randrange(256)}.{random.randrange(256)}:{random.randrange(20000, 31900)}?ttl=0"
    run = folder / "a run"
    said, opened = folder / "learning.txt", folder / "watch.txt"
    learning = subprocess.Popen(
        [knap, "learn", config, *OVERRIDES, "--external", "--lcm-url", bus, "--wait", str(WAIT_S), "--watch", "--out",
         run], stderr=said.open("w"), stdout=subprocess.DEVNULL, cwd=folder)
    children = [learning]
    try:
        url = read_url(said)
        browser.resize(1200, 900)
        browser.open(url)
        text = "document.querySelector('#result').textContent"
        assert browser.becomes_true(f"{text}.includes('waiting for workers')"), browser.evaluate(text)
        assert browser.evaluate("['replay', 'shape', 'repeat'].every((id) => !document.getElementById(id).hidden)")
        ids = "[...document.querySelectorAll('#replay .id')].map((node) => node.textContent)"
        before = browser.evaluate(ids)
        assert len(before) == 2 and before[0] == before[1], before  # nothing is learned yet

        working = subprocess.Popen([worker, "--lcm-url", bus, "--name", "one"], stderr=subprocess.DEVNULL)
        children.append(working)
        until(lambda: count_batches(run / "events.jsonl"), "the end of the first batch")
        working.send_signal(signal.SIGSTOP)
        # The page has the batch's design and its motion, the curves, and who computed what.
        assert browser.becomes_true(f"{ids}[1] !== '{before[0]}'"), "no new design is shown"
        assert browser.evaluate(ids)[0] == before[0], "the initial design's replay has changed"
        shown = "['learning', 'timeline', 'certificates'].every((id) => !document.getElementById(id).hidden)"
        assert browser.becomes_true(shown), "what is known of the run is not shown"
        assert "batch 1" in browser.evaluate("document.querySelector('#shape output').textContent")
        assert browser.becomes_true(f"/[1-9] rollout/.test({text})"), browser.evaluate(text)

        # Others do not get in through the reader's browser, nor without the token.
        port = urllib.parse.urlsplit(url).port
        assert status_of(url) == 200
        assert status_of(url, Host=f"elsewhere.example:{port}") == 403
        open_watch = subprocess.Popen([knap, "watch", run, "--listen", "0.0.0.0:0"], stdout=opened.open("w"))
        children.append(open_watch)
        address = urllib.parse.urlsplit(read_url(opened))
        root = f"http://127.0.0.1:{address.port}/"
        assert status_of(root) == 403 and status_of(f"{root}?token=0") == 403
        assert status_of(f"{root}news.json?seen=0") == 403
        assert status_of(f"{root}?{address.query}") == 200
        with urllib.request.urlopen(f"{root}news.json?seen=none&{address.query}", timeout=WAIT_S) as answer:
            news = json.load(answer)
        assert news["live"]["version"] == 1 and len(news["replays"]) == 2, news["live"]
        open_watch.send_signal(signal.SIGINT)
        assert open_watch.wait() == 0

        working.send_signal(signal.SIGCONT)
        text = "document.documentElement?.outerText.slice(0, 1000)"
        until(lambda: ask_across_pages(browser, "document.querySelector('#result .headline') !== null"), "the report",
              lambda: f"knap learn: {learning.poll()}\n{said.read_text()[-2000:]}\n"
                      f"the page: {ask_across_pages(browser, text)}")
        assert browser.evaluate("document.querySelector('#result .live') === null")
        assert learning.wait() == 0
        ended = subprocess.run([knap, "watch", run], capture_output=True, text=True)
        assert ended.returncode == 2 and "has ended" in ended.stderr, ended.stderr
        check_silence(browser, url)
    finally:
        for child in children:
            child.send_signal(signal.SIGCONT)
            child.kill()
            child.wait()


def check_silence(browser, url):
    """No error of the page, and nothing fetched but from where it came."""
    for event in browser.events:
        parameters = event["params"]
        assert event["method"] not in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled"), parameters
        if event["method"] == "Log.entryAdded":
            assert parameters["entry"]["source"] == "rendering", parameters["entry"]["text"]
        if event["method"] == "Network.requestWillBeSent":
            fetched = parameters["request"]["url"]
            assert fetched.startswith((url, "data:")), fetched


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    chromium, (knap, worker, config) = sys.argv[1], (pathlib.Path(name).resolve() for name in sys.argv[2:])
    with tempfile.TemporaryDirectory() as folder:
        with Chromium(chromium, "--enable-unsafe-swiftshader", "--disable-gpu-watchdog") as browser:
            check(browser, knap, worker, config, pathlib.Path(folder))


if __name__ == "__main__":
    main()
