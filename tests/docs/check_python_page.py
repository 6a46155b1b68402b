#!/usr/bin/env python3
"""check_python_page.py server|worker PAGE KNAP TYPES ROOT

Runs an example of docs/python.md as it stands there: KNAP is the program, TYPES the folder of lcm-gen's modules, ROOT
the project's. Exits with 77 where what the example imports is not installed.
"""

import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile

SKIPPED = 77


def find_python(module):
    """An interpreter that has it: this one or the system's."""
    for python in (sys.executable, "/usr/bin/python3"):
        if os.path.exists(python) and subprocess.run([python, "-c", f"import {module}"], stderr=subprocess.DEVNULL,
                                                     check=False).returncode == 0:
            return python
    print(f"skipped: no Python here has {module}")
    sys.exit(SKIPPED)


def check_server(example, knap, root):
    python = find_python("scipy")
    environment = dict(os.environ, PATH=f"{knap.parent}:{os.environ['PATH']}")
    done = subprocess.run([python, "-c", example], cwd=root, env=environment, capture_output=True, text=True,
                          check=False)
    print(done.stdout, done.stderr)
    assert done.returncode == 0
    before, after = re.fullmatch(r"loss ([\d.]+) -> ([\d.]+) mm² in \d+ evaluations\n", done.stdout).groups()
    assert float(after) < 0.5 * float(before), "the example's optimizer got nowhere"


def count_workers(knap, bus):
    status = subprocess.run([knap, "status", "--json", *bus], capture_output=True, check=True)
    return len(json.loads(status.stdout)["workers"])


def check_worker(example, knap, types, root):
    url = f"udpm://239.255.{random.randrange(256)}.{random.randrange(256)}:{random.randrange(20000, 32000)}?ttl=0"
    environment = dict(os.environ, PYTHONPATH=f"{types}:{root / 'worker/python'}", PYTHONDONTWRITEBYTECODE="1")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "springs.py").write_text(example)
        (folder / "key").write_bytes(os.urandom(32))
        (folder / "key").chmod(0o600)
        workers = [subprocess.Popen([sys.executable, folder / "springs.py", "--lcm-url", url, "--key", folder / "key",
                                     "--name", name], env=environment) for name in ("one", "two")]
        bus = ["--lcm-url", url, "--key", folder / "key", "--wait", "600"]
        try:
            while count_workers(knap, bus) < len(workers):
                pass
            subprocess.run([knap, "learn", root / "configs/pushing.yaml", "learning.variations=10",
                            "evaluation.variations=20", "--external", "--engine", "springs_1", *bus,
                            "--out", folder / "run"], check=True)
            # A run this short may end before the other worker was invited, which then waits for a next one.
            stopped, code = os.wait()
            assert code == 0 and stopped in [worker.pid for worker in workers], "the run tells its workers to stop"
            other = next(worker for worker in workers if worker.pid != stopped)
            other.send_signal(signal.SIGTERM)
            assert other.wait() == 0, "a worker that is told to stop leaves in order"
            test = json.loads((folder / "run/result.json").read_text())["test"]
            assert test["learned"]["loss_mean"] < 0.9 * test["initial"]["loss_mean"], test
        finally:
            for worker in workers:
                worker.send_signal(signal.SIGKILL)


def main():
    which, page, knap, types, root = sys.argv[1:]
    blocks = re.findall(r"```python\n(.*?)```", pathlib.Path(page).read_text(), re.DOTALL)
    server, worker = blocks
    if which == "server":
        check_server(server, pathlib.Path(knap), pathlib.Path(root))
    else:
        check_worker(worker, pathlib.Path(knap), types, pathlib.Path(root))


if __name__ == "__main__":
    main()
