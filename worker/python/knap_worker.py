"""A knap worker around a simulator in Python, with nothing but the standard library and the message types of lcm-gen.

    lcm-gen -p --ppath types lcmtypes/*.lcm        # once; then PYTHONPATH=types:worker/python

    class Scenario:
        def run(self, request, progress):          # request.theta, .controls, .reference, .variation: lists of floats
            ...
            return knap_worker.Answer(loss, gradient)

    class Engine:
        name = "my_simulator"
        def load(self, files):                     # {"scenario.yaml": bytes, "meshes/tool.obj": bytes, ...}
            return Scenario()

    knap_worker.main(Engine())                     # --lcm-url URL --key FILE --name NAME, as knap-worker

It says what docs/protocol.md asks of a worker, over udpm:// alone. `run` and `load` are called from one thread, while
another keeps the worker's status going. What they raise is told apart:

    ValueError              what was asked for cannot be, whoever computes it: the run ends with that line
    MemoryError, OSError    this machine lacks something: the worker leaves, others take its requests
    anything else           a defect: the worker ends with a traceback

The same request must give the same bits on every worker: no clock, no random numbers but from what is asked for. An
engine that has versions, or uses functions that may be rounded in two ways, says so in its name.
"""

import argparse
import collections
import hashlib
import hmac
import math
import os
import queue
import select
import signal
import socket
import struct
import sys
import threading
import time
import traceback
import urllib.parse

from knap.control_t import control_t
from knap.rollout_request_t import rollout_request_t
from knap.rollout_result_t import rollout_result_t
from knap.run_status_t import run_status_t
from knap.scenario_t import scenario_t
from knap.worker_status_t import worker_status_t

PROTOCOL = 5
PUBLIC_KEY = b"knap public key, protects nought"

MOST_BYTES = 1300  # of a message
MOST_VALUES = 1 << 20  # of a request
VALUES_PER_PART = 96
PIECE = 1024  # bytes of a scenario
MOST_SCENARIO = 64 << 20
MOST_REQUESTS = 16
MOST_KEPT = 512  # answers
DIGEST = 16

STATUS_S = 0.25
RESULT_RETRY_S = 0.2
PIECE_RETRY_S = 0.1
RUN_SILENCE_S = 2.0
MESSAGES_AT_A_TIME = 256


class Request:
    """What is asked for. `reference` (theta, then controls) is empty for the task loss; `nodes` mostly is."""

    def __init__(self, theta, controls, reference, variation, nodes, gradient):
        self.theta, self.controls, self.reference = theta, controls, reference
        self.variation, self.nodes, self.gradient = variation, nodes, gradient


class Answer:
    """`gradient`: by theta, then by controls; what nobody asked for is dropped. Lengths and losses in SI units."""

    def __init__(self, loss, gradient=(), success=False, converged=True, gradient_reliable=True, distrust="", steps=1):
        self.loss = float(loss)
        self.gradient = [float(value) for value in gradient]
        self.success, self.converged, self.gradient_reliable = success, converged, gradient_reliable
        self.distrust, self.steps = distrust, steps
        self.error = ""

    @property
    def finite(self):
        return math.isfinite(self.loss) and all(math.isfinite(value) for value in self.gradient)


def clean(text, most):
    """On one line without control characters, cut at a whole character to `most` bytes."""
    line = "".join(c if c.isprintable() else " " for c in str(text))
    return line.encode("utf-8", "replace")[:most].decode("utf-8", "ignore")


class Wire:
    """Bytes and digests (section 2), over LCM's short UDP datagrams (section 1)."""

    MAGIC = 0x4C433032  # "LC02"

    def __init__(self, url, key, channels):
        parts = urllib.parse.urlsplit(url)
        if parts.scheme != "udpm" or not parts.hostname or not parts.port:
            raise SystemExit(f"--lcm-url: '{url}': expected udpm://GROUP:PORT?ttl=N; others are not spoken here")
        self.address = (parts.hostname, parts.port)
        ttl = int(urllib.parse.parse_qs(parts.query).get("ttl", ["0"])[0])
        self.key = key
        self.channels = {channel.encode() for channel in channels}
        self.count = 0
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
        self.socket.bind(self.address)
        membership = socket.inet_aton(self.address[0]) + struct.pack("=I", socket.INADDR_ANY)
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        self.socket.setblocking(False)

    def receive(self):
        """(channel, bytes) of the next datagram that may be ours, or None."""
        for _ in range(MESSAGES_AT_A_TIME):
            try:
                datagram = self.socket.recv(65536)
            except BlockingIOError:
                return None
            end = datagram.find(b"\0", 8)
            if len(datagram) < 8 or end < 0 or struct.unpack_from(">I", datagram)[0] != self.MAGIC:
                continue
            if datagram[8:end] in self.channels:
                return datagram[8:end].decode(), datagram[end + 1 :]
        return None

    def publish(self, channel, message):
        message.digest = bytes(DIGEST)
        encoded = message.encode()
        encoded = encoded[:-DIGEST] + hmac.digest(self.key, encoded, "sha256")[:DIGEST]
        assert len(encoded) <= MOST_BYTES, f"a message of {len(encoded)} bytes"
        datagram = struct.pack(">II", self.MAGIC, self.count & 0xFFFFFFFF) + channel.encode() + b"\0" + encoded
        self.count += 1
        try:
            self.socket.sendto(datagram, self.address)
        except OSError:
            pass  # lost, like any other datagram

    def decode(self, kind, encoded):
        """The message, or None for one that is not whole, not of this kind or not of a holder of the key."""
        if not 8 + DIGEST <= len(encoded) <= MOST_BYTES or encoded[:8] != kind._get_packed_fingerprint():
            return None
        zeroed = encoded[:-DIGEST] + bytes(DIGEST)
        if not hmac.compare_digest(hmac.digest(self.key, zeroed, "sha256")[:DIGEST], encoded[-DIGEST:]):
            return None
        try:
            return kind.decode(encoded)
        except (struct.error, ValueError):
            return None


def calc_request_id(engine, scenario, request):
    def text(value):
        return struct.pack("<Q", len(value)) + value.encode()

    content = text("knap-request-3") + text(engine) + scenario
    for values in (request.theta, request.controls, request.reference, request.variation, request.nodes):
        content += struct.pack(f"<Q{len(values)}d", len(values), *values)
    content += struct.pack("<QQ", 1 if request.reference else 0, 1 if request.gradient else 0)
    return hashlib.sha256(content).digest()


class Job:
    """One request, put together from its parts (section 4, "Take requests")."""

    def __init__(self, scenario, head):
        self.id, self.scenario, self.attempt, self.gradient = head.id, scenario, head.attempt, head.gradient != 0
        self.sizes = self.get_sizes(head)
        self.values = [0.0] * sum(self.sizes)
        self.missing = set(range(0, max(1, len(self.values)), VALUES_PER_PART))

    @staticmethod
    def get_sizes(head):
        return (head.theta_size, head.control_size, head.reference_size, head.variation_size, head.nodes_size)

    def add(self, part):
        first = part.first_value
        expected = min(VALUES_PER_PART, len(self.values) - first)
        if self.get_sizes(part) != self.sizes or first not in self.missing or len(part.values) != expected:
            return
        self.values[first : first + expected] = part.values
        self.missing.discard(first)

    def make_request(self):
        lists, begin = [], 0
        for size in self.sizes:
            lists.append(self.values[begin : begin + size])
            begin += size
        return Request(*lists, self.gradient)


class ScenarioFetch:
    """Gathers one scenario's pieces (section 4, "Fetch the scenario")."""

    def __init__(self, scenario):
        self.scenario = scenario
        self.start_again()

    def start_again(self):
        self.total, self.count, self.pieces, self.asked, self.asked_at = 0, 0, {}, [], 0.0

    def add(self, piece):
        count = -(-piece.total_size // PIECE)
        if piece.scenario != self.scenario or not 0 < piece.total_size <= MOST_SCENARIO or piece.chunk_count != count:
            return
        if not 0 <= piece.chunk < count or (self.total and piece.total_size != self.total):
            return
        if len(piece.data) == min(PIECE, piece.total_size - PIECE * piece.chunk):
            self.total, self.count = piece.total_size, count
            self.pieces[piece.chunk] = piece.data

    def take_files(self):
        """{name: bytes} once all is there and what was wanted; None before. Starts again where it is not."""
        if not self.total or len(self.pieces) < self.count:
            return None
        bundle = b"".join(self.pieces[i] for i in range(self.count))
        if hashlib.sha256(bundle).digest() != self.scenario:
            self.start_again()
            return None
        files, at = {}, len(b"knap-scenario-1\n")
        while at < len(bundle):
            texts = []
            for _ in range(2):
                (size,) = struct.unpack_from("<Q", bundle, at)
                texts.append(bundle[at + 8 : at + 8 + size])
                at += 8 + size
            files[texts[0].decode()] = texts[1]
        return files

    def choose_wanted(self, now):
        """The pieces to ask for now; none while what was asked for may still come."""
        missing = [piece for piece in self.asked if piece not in self.pieces]
        if missing and now - self.asked_at < PIECE_RETRY_S:
            return []
        if not missing:
            absent = (piece for piece in range(self.count) if piece not in self.pieces)
            missing = [piece for piece, _ in zip(absent, range(32))] if self.total else [0]
        self.asked, self.asked_at = missing, now
        return missing


class Kept:
    """An answer's messages, and whether they must still be repeated."""

    def __init__(self, parts):
        self.parts, self.acknowledged, self.sent_at = parts, False, 0.0


def bound(entries, most):
    while len(entries) > most:
        entries.popitem(last=False)


class Worker:
    """The state machine around the engine (section 4)."""

    def __init__(self, engine, wire, name):
        self.engine, self.wire, self.name = engine, wire, name
        self.instance = 0
        while self.instance == 0:
            (self.instance,) = struct.unpack("<q", os.urandom(8))
        self.sequence = self.run_id = self.finished = self.repeated = self.refused = 0
        self.run_heard_at = self.status_due_at = 0.0
        self.run_scenario = self.leaving = None
        self.jobs = collections.deque()  # taken and not answered, the running one first
        self.partial, self.cancelled = collections.OrderedDict(), collections.OrderedDict()
        self.results = collections.OrderedDict()
        self.fetch, self.loaded = None, None  # what is fetched; the id of the scenario at hand
        self.state = worker_status_t.kIdle
        self.progress = (0, 0)
        self.to_do, self.done = queue.Queue(), queue.Queue()
        threading.Thread(target=self.compute, daemon=True).start()

    # ---- The thread that computes ----

    def compute(self):
        scenario = None
        while True:
            job = self.to_do.get()
            try:
                if isinstance(job, dict):
                    scenario = None
                    scenario, result = self.engine.load(job), None
                else:
                    result = scenario.run(job, self.set_progress)
            except ValueError as e:
                result = Answer(math.nan)
                result.error = clean(e, 600) or "ValueError"
            except BaseException as e:  # told apart by the other thread
                result = e
                if not isinstance(e, (MemoryError, OSError)):
                    traceback.print_exc()
            self.done.put(result)

    def set_progress(self, done, total):
        self.progress = (int(done), int(total))

    # ---- The thread that talks ----

    def run(self):
        """Until told to stop; returns the exit code."""
        while self.leaving is None:
            select.select([self.wire.socket], [], [], 0.002)
            for _ in range(MESSAGES_AT_A_TIME):
                received = self.wire.receive()
                if received is None:
                    break
                self.handle(*received)
            self.tick(time.monotonic())
        lack = self.leaving
        self.publish_status(worker_status_t.kStopping, clean(lack, 200))
        if lack:
            print(f"{self.name}: leaves: {lack}", file=sys.stderr)
        return 1 if lack else 0

    def handle(self, channel, encoded):
        kinds = {"KNAP_RUN_STATUS": run_status_t, "KNAP_SCENARIO": scenario_t,
                 f"KNAP_REQUEST_{self.name}": rollout_request_t}
        message = self.wire.decode(kinds.get(channel, control_t), encoded)
        if message is None:
            self.refused += 1
        elif channel == "KNAP_SCENARIO":
            if self.fetch:
                self.fetch.add(message)
        elif channel == "KNAP_RUN_STATUS":
            if message.run_id == self.run_id:
                self.run_heard_at = time.monotonic()
        elif message.receiver == self.instance:
            if isinstance(message, rollout_request_t):
                if message.run_id == self.run_id:
                    self.handle_request(message)
            else:
                self.handle_control(message)

    @staticmethod
    def split(ids):
        return [ids[i : i + 32] for i in range(0, len(ids) - 31, 32)]

    def acknowledge(self, id):
        if id in self.results:
            self.results[id].acknowledged = True

    def handle_control(self, control):
        if control.kind == control_t.kJoin:
            self.join(control)
            return
        if control.run_id != self.run_id:
            return
        self.run_heard_at = time.monotonic()
        for id in self.split(control.ids):
            self.acknowledge(id)
            if control.kind == control_t.kCancel:
                running = self.get_running()
                self.jobs = collections.deque(job for job in self.jobs if job is running or job.id != id)
                self.partial.pop(id, None)
                self.cancelled[id] = control.sequence
                bound(self.cancelled, 256)
        if control.kind == control_t.kStop:
            self.leaving = ""

    def join(self, control):
        now = time.monotonic()
        if control.run_id == 0:
            return
        if control.run_id != self.run_id:
            if self.run_id != 0 and now - self.run_heard_at < RUN_SILENCE_S:
                return
            running = self.get_running()
            self.jobs = collections.deque([running] if running else [])
            self.partial.clear()
            self.cancelled.clear()
            for kept in self.results.values():
                kept.acknowledged = True
            self.run_id, self.status_due_at = control.run_id, now
        self.run_heard_at, self.run_scenario = now, control.scenario

    def handle_request(self, message):
        self.run_heard_at = time.monotonic()
        for id in self.split(message.acknowledged):
            self.acknowledge(id)
        for part in message.assignments:
            self.take(message, part)

    def take(self, message, part):
        id = part.id
        if self.cancelled.get(id, -1) > message.sequence:
            return
        self.cancelled.pop(id, None)
        if id in self.results:
            self.repeated += 1
            self.publish_result(self.results[id])
            return
        if any(job.id == id for job in self.jobs) or len(self.jobs) >= MOST_REQUESTS:
            return
        if min(Job.get_sizes(part)) < 0 or sum(Job.get_sizes(part)) > MOST_VALUES:
            self.refused += 1
            return
        if id not in self.partial:
            self.partial[id] = Job(message.scenario, part)
            bound(self.partial, 32)
        job = self.partial[id]
        job.add(part)
        if job.missing:
            return
        del self.partial[id]
        if calc_request_id(self.engine.name, job.scenario, job.make_request()) != id:
            self.refused += 1
            return
        self.jobs.append(job)

    def get_running(self):
        return self.jobs[0] if self.state == worker_status_t.kComputing else None

    def tick(self, now):
        if self.state != worker_status_t.kIdle and not self.done.empty():
            self.finish(self.done.get())
        if self.leaving is None and self.state == worker_status_t.kIdle:
            self.begin(now)
        for kept in self.results.values():
            if not kept.acknowledged and now - kept.sent_at >= RESULT_RETRY_S:
                self.publish_result(kept)
        if now >= self.status_due_at:
            self.publish_status(self.state)

    def begin(self, now):
        """The next thing to do: a scenario to load, or the first request."""
        wanted = self.jobs[0].scenario if self.jobs else self.run_scenario
        if wanted is None:
            return
        if wanted == self.loaded:
            if self.jobs:
                self.state, self.progress = worker_status_t.kComputing, (0, 0)
                self.to_do.put(self.jobs[0].make_request())
            return
        if self.fetch is None or self.fetch.scenario != wanted:
            self.fetch = ScenarioFetch(wanted)
        files = self.fetch.take_files()
        if files is not None:
            self.state, self.loaded, self.fetch = worker_status_t.kLoading, wanted, None
            self.to_do.put(files)
            return
        pieces = self.fetch.choose_wanted(now)
        if pieces:
            control = control_t()
            control.receiver, control.kind, control.scenario = self.run_id, control_t.kWantScenario, wanted
            control.chunks, control.chunk_count, control.ids = pieces, len(pieces), b""
            control.worker = self.name
            self.publish("KNAP_CONTROL", control)

    def finish(self, result):
        state, self.state = self.state, worker_status_t.kIdle
        if isinstance(result, BaseException):
            self.leaving = f"{type(result).__name__}: {result}"
            if state == worker_status_t.kComputing:
                self.state = state  # its status names the request that it could not compute
        elif state == worker_status_t.kComputing:
            self.keep(self.jobs.popleft(), result)
        elif result is not None and self.jobs:  # no such scenario: an answer to whoever asks
            self.loaded = None
            self.keep(self.jobs.popleft(), result)

    def keep(self, job, answer):
        self.finished += 1
        gradient = answer.gradient if job.gradient and not answer.error else []
        parts = []
        for first in range(0, max(1, len(gradient)), VALUES_PER_PART):
            part = rollout_result_t()
            part.loss, part.steps, part.attempt, part.id = answer.loss, answer.steps, job.attempt, job.id
            part.loss_error = math.nan
            part.success, part.finite = int(answer.success), int(answer.finite)
            part.converged, part.gradient_reliable = int(answer.converged), int(answer.gradient_reliable)
            part.status = rollout_result_t.kError if answer.error else rollout_result_t.kOk
            part.values = gradient[first : first + VALUES_PER_PART]
            part.gradient_size, part.first_value, part.value_count = len(gradient), first, len(part.values)
            part.worker, part.distrust, part.error = self.name, clean(answer.distrust, 200), answer.error
            parts.append(part)
        self.results[job.id] = Kept(parts)
        bound(self.results, MOST_KEPT)
        self.publish_result(self.results[job.id])

    def publish(self, channel, message):
        self.sequence += 1
        message.utime, message.run_id = int(time.time() * 1e6), self.run_id
        message.sender, message.sequence = self.instance, self.sequence
        self.wire.publish(channel, message)

    def publish_result(self, kept):
        kept.sent_at = time.monotonic()
        for part in kept.parts:
            self.publish("KNAP_RESULT", part)

    def publish_status(self, state, reason=""):
        status = worker_status_t()
        running = self.get_running()
        status.steps_done, status.steps_total = self.progress if running else (0, 0)
        status.step_fraction = status.steps_done / status.steps_total if status.steps_total else 0.0
        status.finished, status.repeated, status.refused = self.finished, self.repeated, self.refused
        status.state, status.protocol, status.pid = state, PROTOCOL, os.getpid()
        status.unacknowledged = sum(not kept.acknowledged for kept in self.results.values())
        status.queue_capacity = MOST_REQUESTS
        status.queue = b"".join(job.id for job in self.jobs)
        status.queue_size = len(status.queue)
        status.running = running.id if running else bytes(32)
        status.scenario = self.loaded or bytes(32)
        status.fingerprint = bytes(32)  # the name stands for one arithmetic
        status.name, status.engine, status.build, status.reason = self.name, self.engine.name, "", reason
        status.host = clean(socket.gethostname(), 64)
        self.publish("KNAP_WORKER_STATUS", status)
        self.status_due_at = time.monotonic() + STATUS_S


def main(engine, arguments=None):
    """Parses the command line, works until told to stop, and exits."""
    parser = argparse.ArgumentParser(description=f"A knap worker around the engine {engine.name}.")
    default = os.environ.get("LCM_DEFAULT_URL") or "udpm://239.255.76.67:7667?ttl=0"
    parser.add_argument("--lcm-url", default=default, help="udpm://GROUP:PORT?ttl=N (default: %(default)s)")
    parser.add_argument("--key", help="file with the run's key (default: the public key)")
    parser.add_argument("--name", default=f"python-{os.getpid()}", help="1 to 40 of A-Z a-z 0-9 _ -")
    flags = parser.parse_args(arguments)
    if not 1 <= len(flags.name) <= 40 or not all(c.isascii() and (c.isalnum() or c in "_-") for c in flags.name):
        parser.error(f"--name: '{flags.name}': expected 1 to 40 of A-Z a-z 0-9 _ -")
    key = PUBLIC_KEY
    if flags.key:
        with open(flags.key, "rb") as file:
            key = file.read()
        if len(key) != 32:
            parser.error(f"--key: {flags.key} holds {len(key)} bytes; expected 32")
    channels = ["KNAP_RUN_STATUS", "KNAP_SCENARIO", f"KNAP_REQUEST_{flags.name}", f"KNAP_CONTROL_{flags.name}"]
    worker = Worker(engine, Wire(flags.lcm_url, key, channels), flags.name)

    def stop(*_):
        worker.leaving = ""

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    code = worker.run()
    sys.stderr.flush()
    os._exit(code)  # a rollout that still runs is nobody's any more
