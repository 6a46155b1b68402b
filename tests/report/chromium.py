"""A headless Chromium, spoken to over a pipe with its DevTools protocol: what a page's test needs of it."""

import base64
import fcntl
import json
import os
import select
import subprocess
import tempfile
import time

# Ends what hangs; nothing is judged by how long it took.
LIMIT_S = 120


class Chromium:
    def __init__(self, program, *options):
        self.profile = tempfile.TemporaryDirectory(prefix="knap-chromium-", ignore_cleanup_errors=True)
        to_browser, self.out = (fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, 10) for fd in os.pipe())
        self.inward, from_browser = (fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, 10) for fd in os.pipe())

        # The browser reads from descriptor 3 and writes to 4.
        def connect():
            os.dup2(to_browser, 3)
            os.dup2(from_browser, 4)

        # Its sandbox refuses to work for root.
        root = ["--no-sandbox"] if os.geteuid() == 0 else []
        self.process = subprocess.Popen(
            [program, "--headless", "--remote-debugging-pipe", "--no-first-run", f"--user-data-dir={self.profile.name}",
             *root, *options], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            pass_fds=(3, 4), preexec_fn=connect)
        os.close(to_browser)
        os.close(from_browser)
        self.rest = b""
        self.calls = 0
        self.events = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    session = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        os.close(self.out)
        os.close(self.inward)
        self.profile.cleanup()

    def _receive(self):
        # The page's own waits end before this one.
        deadline = time.monotonic() + 2 * LIMIT_S
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.inward], [], [], max(0, deadline - time.monotonic()))
            part = os.read(self.inward, 1 << 20) if ready else b""
            if not part:
                raise RuntimeError("Chromium does not answer")
            self.rest += part
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        """Calls a method and returns its result; events that come meanwhile are kept."""
        self.calls += 1
        request = {"id": self.calls, "method": method, "params": parameters}
        if self.session:
            request["sessionId"] = self.session
        data = json.dumps(request).encode() + b"\0"
        while data:
            data = data[os.write(self.out, data):]
        while True:
            message = self._receive()
            if message.get("id") == self.calls:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]
            if "method" in message:
                self.events.append(message)

    def evaluate(self, expression):
        """The value of a JavaScript expression, awaited."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise RuntimeError(f"{expression}: {details.get('exception', {}).get('description', details['text'])}")
        return result["result"].get("value")

    def becomes_true(self, expression):
        """Whether an expression becomes true; asked again at each of the page's frames."""
        return self.evaluate(f"""new Promise((done) => {{
            const end = performance.now() + {1000 * LIMIT_S};
            const ask = () => ({expression}) ? done(true) : performance.now() > end ? done(false) :
                requestAnimationFrame(ask);
            ask();
        }})""")

    def open(self, url):
        self.events.clear()
        self.call("Page.navigate", url=url)
        if not self.becomes_true("document.readyState === 'complete'"):
            raise RuntimeError(f"{url} does not load")

    def resize(self, width, height):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def prefer(self, scheme):
        """Sets prefers-color-scheme."""
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def key(self, key, code=None, text=None):
        named = {"key": key, "code": code or key}
        self.call("Input.dispatchKeyEvent", type="keyDown", **named, **({"text": text} if text else {}))
        self.call("Input.dispatchKeyEvent", type="keyUp", **named)

    def mouse(self, kind, x, y, button="left"):
        pressed = 0 if kind == "mouseReleased" else 1
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=pressed, clickCount=1)

    def click(self, x, y):
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def screenshot(self):
        """The window as PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
