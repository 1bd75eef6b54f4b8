"""A browser for tests: Chromium without a window, spoken to in the DevTools protocol over a pair of pipes.

Messages are JSON with a NUL after each (https://chromedevtools.github.io/devtools-protocol/); no other library needed.
"""

import base64
import json
import os
import select
import shutil
import subprocess
import time

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def find_browser():
    """Path of the browser; where CI is set there has to be one, so that its tests fail there and are not skipped."""
    found = next((path for path in map(shutil.which, NAMES) if path), None)
    return NAMES[0] if found is None and os.environ.get("CI") else found


class Browser:
    """One page. `errors` gathers what its scripts threw."""

    def __init__(self, path, profile):
        assert shutil.which(path), (
            f"no browser found, expected one of {', '.join(NAMES)}: where CI is set its tests run"
        )
        self.errors = []
        self._number = 0
        self._rest = b""
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()
        options = (
            "--headless=new --no-sandbox --disable-dev-shm-usage --remote-debugging-pipe --no-first-run "
            "--use-angle=swiftshader --enable-unsafe-swiftshader --ignore-gpu-blocklist --window-size=1300,1000"
        )
        # the protocol's pipes are the file descriptors 3 and 4, wherever ours happen to be
        script = f'exec "$@" 3<&{to_browser} 4>&{from_browser}'
        command = ["bash", "-c", script, "bash", path, *options.split(), f"--user-data-dir={profile}", "about:blank"]
        self._process = subprocess.Popen(
            command, pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(to_browser)
        os.close(from_browser)
        target = self._send("Target.createTarget", {"url": "about:blank"})["targetId"]
        attached = self._send("Target.attachToTarget", {"targetId": target, "flatten": True})
        self._session = attached["sessionId"]
        for domain in ("Runtime", "Page", "DOM"):
            self.send(f"{domain}.enable")

    def close(self):
        self._process.terminate()
        self._process.wait(120)
        os.close(self._out)
        os.close(self._in)

    def send(self, method, **parameters):
        return self._send(method, parameters, self._session)

    def run(self, script):
        """Value of an expression (awaited) in the page."""
        answer = self.send("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise AssertionError(answer["exceptionDetails"]["exception"].get("description", answer))
        return answer["result"].get("value")

    def wait(self, script, seconds=300):
        """Until an expression is true."""
        for _ in range(int(seconds * 20)):
            if self.run(script):
                return
            time.sleep(0.05)
        raise AssertionError(f"never true: {script}; page says {self.run('document.body.innerText')!r}")

    def open(self, url):
        self.run("window.isOld = true")
        self.send("Page.navigate", url=url)
        self.wait("window.isOld === undefined && document.readyState === 'complete'")

    def give_file(self, selector, path):
        root = self.send("DOM.getDocument")["root"]["nodeId"]
        node = self.send("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.send("DOM.setFileInputFiles", nodeId=node, files=[str(path)])

    def screenshot(self):
        return base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])

    def _send(self, method, parameters, session=None):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("method") == "Runtime.exceptionThrown":
                self.errors.append(answer["params"]["exceptionDetails"])
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise AssertionError(f"{method}: {answer['error']}")
                return answer["result"]

    def _receive(self):
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._in], [], [], 300)
            piece = os.read(self._in, 1 << 20) if ready else b""
            if not piece:
                raise AssertionError("the browser does not answer")
            self._rest += piece
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)
