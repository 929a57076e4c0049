"""A headless Chromium under the DevTools protocol, over its pipe: enough to open a page, look at it and use it."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Browser", "pixels"]

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",  # WebGL in software
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
)

#: Chromium reads commands from descriptor 3 and answers on descriptor 4.
RUN = "import os, sys; a, b, *c = sys.argv[1:]; os.dup2(int(a), 3); os.dup2(int(b), 4); os.execvp(c[0], c)"


class Browser:
    """One page in one browser. `problems` collects what its console and network say is wrong, `requests` all
    addresses it asked for."""

    def __init__(self, chromium: str, profile: Path) -> None:
        its_read, self.write = os.pipe()
        self.read, its_write = os.pipe()
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (its_read, its_write)]  # out of the way of 3 and 4
        self.process = subprocess.Popen(
            [sys.executable, "-c", RUN, *map(str, ends), chromium, *FLAGS, f"--user-data-dir={profile}"],
            pass_fds=ends,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for end in (its_read, its_write, *ends):
            os.close(end)
        self.buffer = b""
        self.number = 0
        self.session: str | None = None
        self.loaded = False
        self.problems: list[str] = []
        self.requests: list[str] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.session = None
            self.call("Browser.close")
            self.process.wait(timeout=10)
        finally:
            self.process.kill()
            self.process.wait()
            os.close(self.read)
            os.close(self.write)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self.number += 1
        message: dict[str, Any] = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.write, data) :]
        while True:
            answer = self.next_message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def next_message(self) -> dict[str, Any]:
        while b"\0" not in self.buffer:
            chunk = os.read(self.read, 1 << 20)
            if not chunk:
                raise RuntimeError("the browser went away")
            self.buffer += chunk
        text, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(text)
        self.note(message.get("method", ""), message.get("params", {}))
        return message

    def note(self, method: str, what: dict[str, Any]) -> None:
        if method == "Page.loadEventFired":
            self.loaded = True
        elif method == "Runtime.exceptionThrown":
            self.problems.append(json.dumps(what["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
            self.problems.append(json.dumps(what["args"]))
        elif method == "Log.entryAdded" and what["entry"]["level"] == "error":
            self.problems.append(what["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(what["request"]["url"])

    def size(self, width: int, height: int) -> None:
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def open(self, url: str) -> None:
        self.loaded = False
        self.call("Page.navigate", url=url)
        while not self.loaded:
            self.next_message()

    def evaluate(self, expression: str) -> Any:
        """Value of an expression in the page; promises are awaited."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(json.dumps(answer["exceptionDetails"]))
        return answer["result"].get("value")

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def click(self, x: float, y: float) -> None:
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", buttons=1, clickCount=1)

    def drag(self, start: tuple[float, float], end: tuple[float, float], *, shift: bool = False) -> None:
        held = {"button": "left", "buttons": 1, "modifiers": 8 if shift else 0}
        self.mouse("mousePressed", *start, clickCount=1, **held)
        self.mouse("mouseMoved", *end, **held)
        self.mouse("mouseReleased", *end, clickCount=1, **held)

    def pinch(self, centre: tuple[float, float], apart: float, then_apart: float) -> None:
        """Two fingers side by side about a point, first and then so far apart."""
        x, y = centre
        for kind, distance in (("touchStart", apart), ("touchMove", then_apart)):
            points = [{"x": x + side * distance / 2, "y": y, "id": n} for n, side in enumerate((-1, 1))]
            self.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def frame(self) -> None:
        """Wait until what was asked for is on the screen."""
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def screenshot(self, selector: str | None = None, *, whole: bool = False) -> bytes:
        """PNG of the window, of an element, or of the whole page."""
        extra: dict[str, Any] = {}
        if selector:
            box = "(r => ({x: r.x + scrollX, y: r.y + scrollY, width: r.width, height: r.height, scale: 1}))"
            find = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
            extra = {"clip": self.evaluate(f"{box}({find})"), "captureBeyondViewport": True}
        elif whole:
            size = self.evaluate("({x: 0, y: 0, width: innerWidth, height: document.documentElement.scrollHeight})")
            extra = {"clip": {**size, "scale": 1}, "captureBeyondViewport": True}
        return base64.b64decode(self.call("Page.captureScreenshot", format="png", **extra)["data"])


def pixels(png: bytes) -> npt.NDArray[np.uint8]:
    """(height, width, 3) of a PNG with 8 bits a channel and no interlacing, as browsers write it."""
    width, height, depth, kind, _, _, interlace = struct.unpack_from(">IIBBBBB", png, 16)
    channels = {2: 3, 6: 4}[kind]
    assert (depth, interlace) == (8, 0)
    data, at = b"", 8
    while at < len(png):
        (length,) = struct.unpack_from(">I", png, at)
        if png[at + 4 : at + 8] == b"IDAT":
            data += png[at + 8 : at + 8 + length]
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + width * channels)
    image = np.zeros((height, width, channels), np.uint8)
    above = np.zeros((width, channels), np.uint8)
    for y, row in enumerate(rows):
        above = image[y] = _unfilter(int(row[0]), row[1:].reshape(width, channels), above)
    return image[..., :3]


def _unfilter(kind: int, row: npt.NDArray[np.uint8], above: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """One row of a PNG [RFC 2083, 6]: none, sub, up, average, Paeth."""
    if kind == 0:
        return row
    if kind == 1:
        return np.cumsum(row, axis=0, dtype=np.uint8)
    if kind == 2:
        return row + above
    result, left, corner = [], [0] * row.shape[1], [0] * row.shape[1]
    for values, up in zip(row.tolist(), above.tolist(), strict=True):
        if kind == 3:
            left = [(v + (a + b) // 2) & 255 for v, a, b in zip(values, left, up, strict=True)]
        else:
            left = [(v + _paeth(a, b, c)) & 255 for v, a, b, c in zip(values, left, up, corner, strict=True)]
        corner = up
        result.append(left)
    return np.array(result, np.uint8)


def _paeth(a: int, b: int, c: int) -> int:
    near = [abs(b - c), abs(a - c), abs(a + b - 2 * c)]
    return (a, b, c)[near.index(min(near))]
