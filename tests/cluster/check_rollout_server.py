#!/usr/bin/env python3
"""check_rollout_server.py KNAP CONFIG: `knap rollout --server` answers as `knap rollout --json` does, bit for bit, and
every line that asks for nothing possible with an error of its own; then the overhead of a call, for information.
"""

import json
import subprocess
import sys
import time

KNAP, CONFIG = sys.argv[1:]
TIMES = ("forward_s", "gradient_s")

# Each line, and what its error says.
REFUSED = [
    ("nonsense", "parse error"),
    ("[1, 2]", "expected an object"),
    ('{"theta": [1, 2]}', "theta: 2 values; the scenario has 7"),
    ('{"theta": {"left_dept": 0.01}}', "did you mean left_depth?"),
    ('{"theta": {"left_depth": "10 mm"}}', "expected a number"),
    ('{"theta": "left_depth=10"}', "value '10'"),
    ('{"theta": "learned"}', "is a scenario, not a run"),
    ('{"variation": [0.1]}', "variation: 1 values; the scenario has 2"),
    ('{"variation": {"gravity[2]": 1}}', "is not a varied key"),
    ('{"variation": -1}', "expected numbers, an object by keys or a number from 0"),
    ('{"gradient": 1}', "gradient: expected true or false"),
    ('{"thet\\u001ba": 1}', "not a key"),
    ("[" * 100000, "parse error"),
]


def without_times(document):
    return {key: value for key, value in document.items() if key not in TIMES and key != "id"}


def run_once(*arguments):
    done = subprocess.run([KNAP, "rollout", CONFIG, "--json", *arguments], capture_output=True, check=True)
    return json.loads(done.stdout)


def main():
    command = [KNAP, "rollout", CONFIG, "--server"]
    server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    about = json.loads(server.stdout.readline())
    names = [parameter["name"] for parameter in about["parameters"]]
    assert about["server"] == 1 and len(names) == 7 and len(about["variation"]) == 2, about

    def ask(line):
        server.stdin.write(line + "\n")
        server.stdin.flush()
        return json.loads(server.stdout.readline())

    theta = {p["name"]: 0.3 * p["lower"] + 0.7 * p["upper"] for p in about["parameters"]}
    listed = ",".join(repr(value) for value in theta.values())
    pairs = [
        ({"id": 7}, []),
        ({"variation": 3}, ["--variation", "3"]),
        ({"variation": 3, "theta": theta}, ["--variation", "3", f"--theta={listed}"]),
        ({"variation": 3, "theta": list(theta.values())}, ["--variation", "3", f"--theta={listed}"]),
        ({"theta": "left_depth=12 mm"}, ["--theta", "left_depth=12 mm"]),
        ({"theta": {"left_depth": 0.012}}, ["--theta", "left_depth=12 mm"]),
        ({"theta": {"left_depth": 0.012}, "reference_theta": "initial", "variation": 1},
         ["--theta", "left_depth=12 mm", "--reference-theta", "initial", "--variation", "1"]),
    ]
    for question, arguments in pairs:
        answer = ask(json.dumps(question))
        assert answer["id"] == question.get("id"), answer
        assert without_times(answer) == without_times(run_once(*arguments)), (question, answer)
    nominal = ask("{}")["variation"]
    moved = {key: value + 0.001 for key, value in nominal.items()}
    assert ask(json.dumps({"variation": moved}))["variation"] == moved
    alone = ask(json.dumps({"gradient": False, "id": {"any": ["thing"]}}))
    assert alone["id"] == {"any": ["thing"]} and set(alone["gradient"].values()) == {None}, alone

    for line, message in REFUSED:
        answer = ask(line)
        assert message in answer["error"] and "\x1b" not in answer["error"], (line[:50], answer)
    assert ask('{"id": "after"}')["id"] == "after"

    overheads = []
    for _ in range(10):
        began = time.perf_counter()
        answer = ask('{"gradient": false}')
        overheads.append(time.perf_counter() - began - answer["forward_s"])
    print(f"overhead of a call: {1e3 * min(overheads):.2f} to {1e3 * max(overheads):.2f} ms")
    server.stdin.close()
    assert server.wait() == 0

    with open("/dev/full", "w", encoding="utf-8") as full:
        assert subprocess.run(command, input="{}\n", text=True, stdout=full, check=False).returncode == 1
    both = subprocess.run([*command, "--json"], input="", text=True, capture_output=True, check=False)
    assert both.returncode == 2 and "excludes" in both.stderr, both


main()
