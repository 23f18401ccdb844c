"""A real browser without a window, spoken to by the Chrome DevTools Protocol."""

from __future__ import annotations

import base64
import itertools
import json
import shutil
import subprocess
import time
from pathlib import Path
from types import TracebackType
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
# seconds until the browser is given up
PATIENCE = 240.0
OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--no-first-run",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--disable-background-networking",
    "--disable-component-update",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--remote-debugging-port=0",
)


def find_browser() -> str | None:
    """Path of an installed browser, None without one."""
    return next((path for path in map(shutil.which, NAMES) if path), None)


class Browser:
    """A browser with one page.

    Args:
        folder: Folder for what the browser keeps.
        size: Width and height of the page [pixels].
    """

    def __init__(self, folder: Path, *, size: tuple[int, int] = (1280, 900)) -> None:
        import websocket

        self.console: list[str] = []
        self.requests: list[str] = []
        self._numbers = itertools.count(1)
        self._loaded = 0
        program = find_browser()
        assert program is not None
        window = f"--window-size={size[0]},{size[1]}"
        command = [program, *OPTIONS, window, f"--user-data-dir={folder}", "about:blank"]
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port, path = self._address(folder / "DevToolsActivePort")
        self._socket = websocket.create_connection(
            f"ws://127.0.0.1:{port}{path}", timeout=PATIENCE, suppress_origin=True
        )
        self._session = ""
        page = next(item for item in self.call("Target.getTargets")["targetInfos"] if item["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **metrics)

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()
        self._process.terminate()
        try:
            self._process.wait(timeout=10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def open(self, path: Path) -> None:
        """Open a file, and wait until its scripts have drawn the first picture."""
        loaded = self._loaded
        self.call("Page.navigate", url=path.resolve().as_uri())
        while self._loaded == loaded:
            self._take(self._receive())
        self.run("report.ready.then(() => new Promise((done) => requestAnimationFrame(() => done())))")

    def run(self, script: str) -> Any:
        """Value of an expression in the page; a promise is waited for."""
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def click(self, selector: str) -> None:
        """Press and release the mouse in the middle of an element."""
        script = (
            f"(() => {{ const item = document.querySelector({json.dumps(selector)}); item.scrollIntoView("
            "{block: 'center'}); const box = item.getBoundingClientRect();"
            "return [box.x + box.width / 2, box.y + box.height / 2] })()"
        )
        self.mouse(*self.run(script), press=True)

    def mouse(self, x: float, y: float, *, press: bool = False) -> None:
        """Move the mouse to a place of the window [pixels], and click there if asked to."""
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        for kind in ("mousePressed", "mouseReleased") if press else ():
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def drag(self, x: float, y: float, dx: float, dy: float, *, button: str = "left") -> None:
        """Press the mouse at a place of the window, move it, and let go [pixels]."""
        for kind, part in (("mousePressed", 0.0), ("mouseMoved", 0.5), ("mouseMoved", 1.0), ("mouseReleased", 1.0)):
            place = {"x": x + part * dx, "y": y + part * dy}
            held = {"left": 1, "right": 2}[button] if kind != "mouseReleased" else 0
            self.call("Input.dispatchMouseEvent", type=kind, **place, button=button, buttons=held, clickCount=1)

    def wheel(self, x: float, y: float, by: float) -> None:
        """Turn the wheel at a place of the window [pixels]; negative values scroll up."""
        self.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=by)

    def picture(self, *, whole: bool = False) -> bytes:
        """The page, or what the window shows of it, as a PNG file."""
        return base64.b64decode(self.call("Page.captureScreenshot", captureBeyondViewport=whole)["data"])

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and wait for its answer."""
        number = next(self._numbers)
        session = {"sessionId": self._session} if self._session else {}
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters, **session}))
        while True:
            message = self._receive()
            if message.get("id") == number:
                assert "error" not in message, message["error"]
                return message["result"]
            self._take(message)

    def _receive(self) -> dict[str, Any]:
        return json.loads(self._socket.recv())

    def _take(self, message: dict[str, Any]) -> None:
        """Note what the page says, and what it asks for."""
        method, facts = message.get("method"), message.get("params", {})
        if method == "Page.loadEventFired":
            self._loaded += 1
        elif method == "Network.requestWillBeSent":
            self.requests.append(facts["request"]["url"])
        elif method == "Log.entryAdded":
            self.console.append(facts["entry"]["text"])
        elif method == "Runtime.exceptionThrown":
            self.console.append(facts["exceptionDetails"]["text"])
        elif method == "Runtime.consoleAPICalled":
            self.console.append(" ".join(str(item.get("value")) for item in facts["args"]))

    def _address(self, file: Path) -> tuple[str, str]:
        """Port and path under which the browser listens."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and self._process.poll() is None:
            if file.exists() and len(lines := file.read_text(encoding="utf-8").split()) == 2:
                return lines[0], lines[1]
            time.sleep(0.05)
        self._process.kill()
        raise RuntimeError("the browser did not start")
