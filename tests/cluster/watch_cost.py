#!/usr/bin/env python3
"""watch_cost.py KNAP CONFIG [WORKERS [a.b=c …]]

What a page that is open costs the coordinator: learns twice with so many workers (64), with `--watch` and a reader that
asks for news every two seconds, and without, and prints the processor time of the process a second of the run. A
measurement, no test; run it where nothing else runs. Needs a network with multicast.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request

TICKS = os.sysconf("SC_CLK_TCK")


def cpu_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def learn(knap, config, workers, overrides, watch):
    """(processor time, wall time) of the coordinator in the middle of a run, pages read."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.Popen(
            [knap, "learn", config, *overrides, "--workers", workers, "--out", f"{folder}/run",
             *(["--watch"] if watch else [])], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        url = next((line.split()[1] for line in run.stderr if line.startswith("watch")), None) if watch else None
        time.sleep(5)  # all workers are there
        before, began, pages, size = cpu_seconds(run.pid), time.monotonic(), 0, 0
        seen = ""
        while run.poll() is None and time.monotonic() - began < 40:
            if watch:
                with urllib.request.urlopen(urllib.parse.urljoin(url, f"news.json?seen={seen}")) as answer:
                    news = answer.read()
                seen = news.split(b'"version":')[1].split(b",")[0].decode()
                pages, size = pages + 1, len(news)
            time.sleep(2)
        spent = cpu_seconds(run.pid) - before if run.poll() is None else None
        wall = time.monotonic() - began
        run.kill()
        run.wait()
        if spent is None:
            sys.exit("watch_cost.py: the run ended too soon; give it more variations")
        return spent / wall, pages, size


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    knap, config = sys.argv[1:3]
    workers = sys.argv[3] if len(sys.argv) > 3 else "64"
    without, _, _ = learn(knap, config, workers, sys.argv[4:], False)
    with_watch, pages, size = learn(knap, config, workers, sys.argv[4:], True)
    print(f"{workers} workers: the coordinator takes {100 * without:.1f}% of a core without --watch, "
          f"{100 * with_watch:.1f}% with it; {pages} pieces of news, the last of {size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
