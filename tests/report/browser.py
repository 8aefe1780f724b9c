"""Browsers driven by their own protocols: Chromium's DevTools, and WebDriver BiDi in Firefox.

Only Debian's packages are needed (`apt-get install chromium firefox-esr`), no driver beside them.
"""

import base64
import json
import re
import shutil
import subprocess
import tempfile
import time

import websocket

CHROMIUM = next(filter(shutil.which, ("chromium", "chromium-browser", "google-chrome")), None)
FIREFOX = next(filter(shutil.which, ("firefox-esr", "firefox")), None)
PATIENCE_S = 60


class Browser:
    """A page in a browser: what it says, asks for and shows."""

    def __init__(self, command, listening):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.process = subprocess.Popen(
            [part.format(profile=self.profile.name) for part in command],
            stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        self.errors, self.requests, self.number, self.extra = [], [], 0, {}
        self.showing = None  # what a test left on the page, for the next one
        for line in self.process.stderr:
            found = re.search(listening + r"(ws://\S+)", line)
            if found:
                self.address = found[1]
                return
        raise AssertionError(f"{command[0]} ended with {self.process.wait()}")

    def close(self):
        self.socket.close()
        self.process.terminate()
        self.process.wait(PATIENCE_S)
        self.process.stderr.close()
        self.profile.cleanup()

    def connect(self, address):
        self.socket = websocket.create_connection(address, timeout=PATIENCE_S, suppress_origin=True)

    def send(self, method, **parameters):
        """Return the answer to a command; what the page does meanwhile is noted."""
        self.number += 1
        self.socket.send(
            json.dumps({"id": self.number, "method": method, "params": parameters} | self.extra)
        )
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                assert "error" not in message, message
                return message["result"]
            self.note(message.get("method"), message.get("params"))

    def wait(self, condition):
        """Wait until a JavaScript expression holds."""
        end = time.monotonic() + PATIENCE_S
        while not self.run(condition):
            assert time.monotonic() < end, condition
            time.sleep(0.1)


class Chromium(Browser):
    def __init__(self):
        command = [
            CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
            "--disable-background-networking", "--enable-unsafe-swiftshader",
            "--remote-debugging-port=0", "--user-data-dir={profile}", "about:blank",
        ]  # fmt: skip
        super().__init__(command, "listening on ")
        self.connect(self.address)
        targets = self.send("Target.getTargets")["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        attached = self.send("Target.attachToTarget", targetId=page, flatten=True)
        self.extra = {"sessionId": attached["sessionId"]}
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.send(f"{domain}.enable")

    def note(self, method, what):
        if method == "Runtime.exceptionThrown":
            self.errors.append(what["exceptionDetails"]["text"])
        elif method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning"):
            self.errors.append(str(what["args"]))
        elif method == "Log.entryAdded" and what["entry"]["level"] == "error":
            self.errors.append(what["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(what["request"]["url"])

    def open(self, address, width=1200, dark=False):
        self.width(width)
        self.scheme(dark)
        self.send("Page.navigate", url=address)
        self.wait("document.readyState === 'complete'")

    def scheme(self, dark):
        """Prefer dark pages or light ones."""
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.send("Emulation.setEmulatedMedia", features=[scheme])

    def width(self, width):
        self.showing = None
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=900,
                  deviceScaleFactor=1, mobile=width < 700)  # fmt: skip

    def run(self, script):
        found = self.send(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def tab(self):
        """Press the tabulator."""
        for kind in ("keyDown", "keyUp"):
            self.send("Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab",
                      windowsVirtualKeyCode=9)  # fmt: skip

    def print(self, width_in, height_in):
        """Return the page as PDF bytes."""
        done = self.send("Page.printToPDF", paperWidth=width_in, paperHeight=height_in,
                         printBackground=True)  # fmt: skip
        return base64.b64decode(done["data"])


class Firefox(Browser):
    def __init__(self):
        command = [
            FIREFOX, "--headless", "--remote-debugging-port=0", "--profile", "{profile}",
            "--no-remote",
        ]  # fmt: skip
        super().__init__(command, "WebDriver BiDi listening on ")
        self.connect(self.address + "/session")
        self.send("session.new", capabilities={})
        self.send("session.subscribe", events=["log.entryAdded", "network.beforeRequestSent"])
        self.context = self.send("browsingContext.getTree")["contexts"][0]["context"]

    def note(self, method, what):
        if method == "log.entryAdded" and what["level"] in ("error", "warn"):
            self.errors.append(what["text"])
        elif method == "network.beforeRequestSent":
            self.requests.append(what["request"]["url"])

    def open(self, address, width=1200, dark=False):
        self.width(width)
        self.send("browsingContext.navigate", context=self.context, url=address, wait="complete")

    def scheme(self, dark):
        """Leave the page as it is: nothing here asks for dark ones."""

    def width(self, width):
        self.showing = None
        self.send("browsingContext.setViewport", context=self.context,
                  viewport={"width": width, "height": 900})  # fmt: skip

    def run(self, script):
        script = f"Promise.resolve({script}).then(found => JSON.stringify(found) ?? 'null')"
        found = self.send("script.evaluate", expression=script,
                          target={"context": self.context}, awaitPromise=True)  # fmt: skip
        assert found["type"] == "success", found
        return json.loads(found["result"]["value"])

    def tab(self):
        """Press the tabulator."""
        keys = [{"type": kind, "value": "\ue004"} for kind in ("keyDown", "keyUp")]
        self.send("input.performActions", context=self.context,
                  actions=[{"type": "key", "id": "keyboard", "actions": keys}])  # fmt: skip

    def print(self, width_in, height_in):
        """Return the page as PDF bytes."""
        page = {"width": width_in * 2.54, "height": height_in * 2.54}
        done = self.send("browsingContext.print", context=self.context, page=page, background=True)
        return base64.b64decode(done["data"])


def here():
    """Return the browsers that are installed, by name."""
    known = (("chromium", CHROMIUM, Chromium), ("firefox", FIREFOX, Firefox))
    return {name: kind for name, found, kind in known if found}
