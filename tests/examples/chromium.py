"""A page in Chromium without a window, driven over the DevTools protocol."""

from __future__ import annotations

import base64
import contextlib
import json
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
PATIENCE = 60.0
"""Seconds: software rendering on a busy machine is slow."""


def installed() -> str:
    """The program; skips the test where it, or the package that talks to it, is missing."""
    pytest.importorskip("websocket", reason="websocket-client is not installed: pip install 'warp-rods[test]'")
    found = next((path for path in map(shutil.which, NAMES) if path), None)
    return found or pytest.skip("Chromium is not installed: apt-get install chromium")


class Page:
    """A page that is open; ``errors`` on its console and ``requests`` it made since it was opened."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._last = socket, 0
        self.errors: list[str] = []
        self.requests: list[str] = []

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to a command of the protocol."""
        self._last += 1
        self._socket.send(json.dumps({"id": self._last, "method": method, "params": parameters}))
        while True:
            said = json.loads(self._socket.recv())
            if said.get("id") == self._last:
                assert "error" not in said, said
                return said["result"]
            self._note(said)

    def _note(self, said: dict[str, Any]) -> None:
        method, parameters = said.get("method"), said.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.errors.append(str(parameters["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            self.errors.append(" ".join(str(part.get("value")) for part in parameters["args"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.errors.append(parameters["entry"]["text"])

    def value(self, expression: str) -> Any:
        """The value of an expression in JavaScript."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Wait until an expression is true."""
        until = time.monotonic() + PATIENCE
        while not self.value(expression):
            assert time.monotonic() < until, (expression, self.errors, self.value("document.body.innerText"))
            time.sleep(0.1)

    def screenshot(self) -> bytes:
        """What is seen, as PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])


@contextlib.contextmanager
def opened(page: Path, folder: Path, size: tuple[int, int] = (960, 640)) -> Iterator[Page]:
    """Open a file in Chromium, whose profile is in ``folder``."""
    import websocket

    command = [
        installed(), "--headless=new", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--no-first-run",
        "--disable-background-networking", "--remote-debugging-port=0", "--remote-allow-origins=*",
        f"--window-size={size[0]},{size[1]}", f"--user-data-dir={folder}", "about:blank",
    ]  # fmt: skip
    browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        socket = websocket.create_connection(_address(folder, browser), timeout=PATIENCE)
        socket = _of_tab(socket)
        shown = Page(socket)
        for domain in ("Page", "Network", "Runtime", "Log"):
            shown.call(f"{domain}.enable")
        shown.call(
            "Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False
        )
        shown.call("Page.navigate", url=page.resolve().as_uri())
        yield shown
        socket.close()
    finally:
        browser.terminate()
        browser.wait(timeout=PATIENCE)


def _address(folder: Path, browser: subprocess.Popen) -> str:
    """Where the browser listens, which it writes into its profile."""
    port, until = folder / "DevToolsActivePort", time.monotonic() + PATIENCE
    while not (port.is_file() and len(lines := port.read_text().split()) == 2):
        assert browser.poll() is None and time.monotonic() < until, "Chromium did not start"
        time.sleep(0.05)
    return f"ws://127.0.0.1:{lines[0]}{lines[1]}"


def _of_tab(socket: Any) -> Any:
    """The connection to the first tab."""
    import websocket

    socket.send(json.dumps({"id": 1, "method": "Target.getTargets"}))
    while (said := json.loads(socket.recv())).get("id") != 1:
        pass
    tab = next(t["targetId"] for t in said["result"]["targetInfos"] if t["type"] == "page")
    address = socket.sock.getpeername()
    socket.close()
    return websocket.create_connection(f"ws://127.0.0.1:{address[1]}/devtools/page/{tab}", timeout=PATIENCE)
