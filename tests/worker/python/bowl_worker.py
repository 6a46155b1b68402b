"""The engine `bowl` in Python: the same closed form, operation by operation, as tests/worker/bowl_engine.h."""

import os
import sys
import time

import knap_worker

STEPS = 100


class Bowl:
    def run(self, request, progress):
        for step in range(STEPS):
            if STEP_S:
                time.sleep(STEP_S)
            progress(step + 1, STEPS)
        theta = request.theta + request.controls
        if FAILS == "refuses":
            raise ValueError("a bowl\x1b[31m\nwithout a bottom")
        if FAILS == "lacks":
            raise MemoryError("no room for a bowl")
        loss, gradient = 0.0, []
        for i, x in enumerate(theta):
            task = not request.reference
            weight = 1.0 + 0.5 * i if task else 1.0
            target = 0.01 + 0.005 * i if task else request.reference[i]
            if task and request.variation:
                target = target + 0.1 * request.variation[i % len(request.variation)]
            error = x - target
            loss = loss + 0.5 * weight * error * error
            gradient.append(weight * error)
        return knap_worker.Answer(loss, gradient, success=loss < 0.001, steps=STEPS)


class Engine:
    name = "bowl"

    def load(self, files):
        return Bowl()


# What every rollout comes to, and the wall time of each of its steps.
FAILS = os.environ.get("KNAP_FAILS")
STEP_S = 1e-6 * int(os.environ.get("KNAP_STEP_US", "0"))
if __name__ == "__main__":
    knap_worker.main(Engine(), sys.argv[1:])
