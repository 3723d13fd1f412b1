"""A headless Chromium driven through chromedriver's HTTP interface, with nothing but the standard library.

Console messages, errors and violations of the security policy are read from the browser's own log.
"""

from __future__ import annotations

import base64
import http.client
import json
import socket
import subprocess
import time
from pathlib import Path
from typing import Any

CHROMIUM, DRIVER = Path("/usr/bin/chromium"), Path("/usr/bin/chromedriver")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
)


def missing() -> str:
    """Say what is not installed, or ''."""
    return ", ".join(str(p) for p in (CHROMIUM, DRIVER) if not p.exists())


class Browser:
    """One browser with a new profile; ``close`` ends exactly the process that was started."""

    def __init__(self, profile: Path, *flags: str) -> None:
        """Start chromedriver on a free port and open a session with an empty profile."""
        with socket.socket() as s:
            s.bind(("127.0.0.1", 0))
            self._port, self._session = s.getsockname()[1], ""
        self._driver = subprocess.Popen(
            [DRIVER, f"--port={self._port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self._wait()
        options = {"binary": str(CHROMIUM), "args": [*FLAGS, *flags, f"--user-data-dir={profile}"]}
        wanted = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        answer = self._send("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
        self._session = f"/session/{answer['sessionId']}"

    def _wait(self) -> None:
        for _ in range(200):
            try:
                self._send("GET", "/status")
            except OSError:
                time.sleep(0.05)
            else:
                return
        raise RuntimeError("chromedriver did not start")

    def _send(self, method: str, path: str, body: dict[str, Any] | None = None) -> Any:
        connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=60)
        data = None if body is None else json.dumps(body)
        connection.request(method, self._session + path, data, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        if answer.status != 200:
            raise RuntimeError(text[:600])
        return json.loads(text)["value"]

    def open(self, file: Path, width: int = 1280, height: int = 900) -> None:
        """Load a page from file:// in a viewport of that size, with the browser's log emptied."""
        self.log()
        self.command(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False
        )
        self._send("POST", "/url", {"url": file.as_uri()})
        self.settle()

    def command(self, name: str, **params: Any) -> Any:
        """Send a command of the DevTools protocol."""
        return self._send("POST", "/goog/cdp/execute", {"cmd": name, "params": params})

    def run(self, script: str, *args: Any) -> Any:
        """Return what a function body returns in the page."""
        return self._send("POST", "/execute/sync", {"script": script, "args": list(args)})

    def settle(self) -> None:
        """Wait for two frames, so that what was asked for is drawn."""
        script = (
            "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 60)))"
        )
        self._send("POST", "/execute/async", {"script": script, "args": []})

    def click(self, selector: str) -> None:
        """Click the element as a user does."""
        element = self._send("POST", "/element", {"using": "css selector", "value": selector})
        self._send("POST", f"/element/{next(iter(element.values()))}/click", {})
        self.settle()

    def keys(self, text: str) -> None:
        """Type into whatever has the focus."""
        actions = [{"type": t, "value": c} for c in text for t in ("keyDown", "keyUp")]
        self._send("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": actions}]})
        self.settle()

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the mouse between two points of the viewport."""
        move = {"type": "pointerMove", "duration": 40, "origin": "viewport"}
        actions = [
            move | {"x": int(start[0]), "y": int(start[1])},
            {"type": "pointerDown", "button": 0},
            move | {"x": int(end[0]), "y": int(end[1])},
            {"type": "pointerUp", "button": 0},
        ]
        self._send(
            "POST",
            "/actions",
            {
                "actions": [
                    {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}
                ]
            },
        )
        self.settle()

    def wheel(self, x: float, y: float, delta: int) -> None:
        """Turn the wheel over a point of the viewport."""
        action = {
            "type": "scroll",
            "x": int(x),
            "y": int(y),
            "deltaX": 0,
            "deltaY": delta,
            "duration": 0,
            "origin": "viewport",
        }
        self._send("POST", "/actions", {"actions": [{"type": "wheel", "id": "wheel", "actions": [action]}]})
        self.settle()

    def swipe(self, start: tuple[float, float], across: float) -> None:
        """Draw a finger sideways from a point of the viewport."""
        self.command("Emulation.setTouchEmulationEnabled", enabled=True)
        places = [{"x": start[0] + across * i / 10, "y": start[1]} for i in range(11)]
        self.command("Input.dispatchTouchEvent", type="touchStart", touchPoints=places[:1])
        for place in places[1:]:
            self.command("Input.dispatchTouchEvent", type="touchMove", touchPoints=[place])
        self.command("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        self.command("Emulation.setTouchEmulationEnabled", enabled=False)
        self.settle()

    def dark(self, *, on: bool) -> None:
        """Prefer dark or light colours."""
        self.command(
            "Emulation.setEmulatedMedia",
            features=[{"name": "prefers-color-scheme", "value": "dark" if on else "light"}],
        )
        self.settle()

    def picture(self, file: Path) -> bytes:
        """Write a PNG of the whole page and return it."""
        size = self.run("return [innerWidth, document.documentElement.scrollHeight]")
        clip = {"x": 0, "y": 0, "width": size[0], "height": size[1], "scale": 1}
        data = base64.b64decode(self.command("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)["data"])
        file.write_bytes(data)
        return data

    def log(self) -> list[str]:
        """Return and empty the console's messages: errors, warnings, violations of the policy."""
        return [str(entry["message"]) for entry in self._send("POST", "/se/log", {"type": "browser"})]

    def close(self) -> None:
        """End the session and chromedriver."""
        try:
            self._send("DELETE", "")
        finally:
            self._driver.terminate()
            self._driver.wait(10)
