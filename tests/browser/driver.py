"""Drives a headless Chromium through chromedriver, by the WebDriver protocol and the standard library alone. What is looked
at in it is decided by others."""

import base64
import json
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

# Software rendering, so that WebGL works without a GPU; no sandbox, as containers run as root.
ARGUMENTS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--enable-unsafe-swiftshader",
    "--use-angle=swiftshader",
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
]


class Browser:
    """A browser without network, unless it visits a page of this machine, to be used with `with`; without WebGL where that
    is wanted."""

    def __init__(self, has_webgl=True, has_network=False):
        self.has_network = has_network
        self.arguments = ARGUMENTS if has_webgl else ARGUMENTS + ["--disable-3d-apis"]

    def __enter__(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.home = tempfile.mkdtemp()
        self.driver = subprocess.Popen(
            ["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.base = f"http://127.0.0.1:{port}"
        options = {"args": self.arguments + [f"--user-data-dir={self.home}"]}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
        for _ in range(100):
            try:
                answer = self._send("/session", {"capabilities": {"alwaysMatch": wanted}})
                break
            except (urllib.error.URLError, ConnectionError) as error:
                if isinstance(error, urllib.error.HTTPError):
                    raise
                time.sleep(0.1)
        else:
            raise RuntimeError("chromedriver does not answer")
        self.base += f"/session/{answer['sessionId']}"
        self._send("/timeouts", {"script": 300_000, "pageLoad": 300_000})
        self.devtools("Network.enable", {})
        offline = {"offline": not self.has_network, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
        self.devtools("Network.emulateNetworkConditions", offline)
        return self

    def __exit__(self, *_):
        try:
            self._send("", method="DELETE")
        finally:
            self.driver.terminate()
            self.driver.wait()
            shutil.rmtree(self.home, ignore_errors=True)

    def _send(self, path, body=None, method=None):
        data = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"}
        request = urllib.request.Request(self.base + path, data, headers, method=method)
        try:
            with urllib.request.urlopen(request, timeout=600) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            if error.code == 404 and not path.startswith("/session"):
                raise
            raise RuntimeError(error.read().decode()[:2000]) from None

    def devtools(self, command, parameters):
        """Chromium's own commands."""
        return self._send("/goog/cdp/execute", {"cmd": command, "params": parameters})

    def size(self, width, height):
        """The size of the window's inside; small ones are phones."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.devtools("Emulation.setDeviceMetricsOverride", metrics)

    def open(self, path):
        """Opens a file."""
        self._send("/url", {"url": f"file://{path}"})

    def visit(self, address):
        """Opens a page of a server on this machine."""
        self._send("/url", {"url": address})

    def run(self, script, *arguments):
        """What a function body returns; promises are waited for."""
        return self._send("/execute/sync", {"script": script, "args": list(arguments)})

    def until(self, script, what, seconds=240):
        """Waits until a function body returns something true."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            found = self.run(script)
            if found:
                return found
            time.sleep(0.1)
        raise AssertionError(f"waited {seconds} s for {what}")

    def click(self, x, y):
        """A click of the mouse at a place of the window."""
        move = {"type": "pointerMove", "x": round(x), "y": round(y), "duration": 50}
        actions = [move, {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}]
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}
        self._send("/actions", {"actions": [pointer]})

    def drag(self, places, is_dropped=True, ms=60):
        """Presses the mouse at the first place of the window, moves it over the others, and lets go unless it is held."""
        moves = [{"type": "pointerMove", "x": round(x), "y": round(y), "duration": ms} for x, y in places]
        actions = [moves[0], {"type": "pointerDown", "button": 0}, *moves[1:]]
        if is_dropped:
            actions.append({"type": "pointerUp", "button": 0})
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}
        self._send("/actions", {"actions": [pointer]})

    def drop(self):
        """Lets go of the mouse where it is."""
        up = [{"type": "pointerUp", "button": 0}]
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": up}
        self._send("/actions", {"actions": [pointer]})

    def press(self, key, *held):
        """A key, by its WebDriver code point, while others are held."""
        down = [{"type": "keyDown", "value": one} for one in (*held, key)]
        actions = down + [{"type": "keyUp", "value": one} for one in (key, *reversed(held))]
        self._send("/actions", {"actions": [{"type": "key", "id": "keys", "actions": actions}]})

    def log(self, kind):
        """What was logged since it was last asked: `browser` or `performance`."""
        return self._send("/se/log", {"type": kind})

    def requests(self):
        """The addresses that were asked for since the last time."""
        messages = [json.loads(entry["message"])["message"] for entry in self.log("performance")]
        sent = [m for m in messages if m["method"] == "Network.requestWillBeSent"]
        return [m["params"]["request"]["url"] for m in sent]

    def picture(self, path):
        """Writes the window as PNG."""
        with open(path, "wb") as file:
            file.write(base64.b64decode(self._send("/screenshot")))

    def printed(self):
        """The page as PDF."""
        return base64.b64decode(self._send("/print", {"background": True}))
