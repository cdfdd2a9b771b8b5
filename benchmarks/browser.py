"""A headless Chromium with a hand: real clicks, keys, downloads and pictures of the page.

It is spoken to through a pipe (Chrome DevTools Protocol): nothing but the browser is needed.
"""

import base64
import contextlib
import fcntl
import json
import os
import select
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = [
    "--headless", "--no-sandbox", "--no-first-run", "--disable-dev-shm-usage",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader",  # WebGL without a graphics card
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--remote-debugging-pipe",
]  # fmt: skip
KEYS = {"Enter": 13, "Escape": 27, "Backspace": 8, "Delete": 46}
CONTROL, SHIFT = 2, 8  # bits of the modifier keys
WAIT = 60.0  # s


def installed() -> str | None:
    """Return the path of a browser, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class _Pipe:
    """Messages to and from the browser: JSON, a zero byte after each."""

    def __init__(self, out: int, back: int) -> None:
        self._out, self._back, self._rest = out, back, b""

    def send(self, message: dict[str, Any]) -> None:
        os.write(self._out, json.dumps(message).encode() + b"\0")

    def receive(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._back], [], [], WAIT)
            part = os.read(self._back, 2**20) if ready else b""
            if not part:
                raise RuntimeError("the browser does not answer")
            self._rest += part
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)


class Page:
    """One page in the browser; what it logs and throws is kept in `complaints`."""

    def __init__(self, pipe: _Pipe, downloads: Path) -> None:
        self._pipe, self._number = pipe, 0
        self.downloads = downloads
        self._session: str | None = None
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.clicks = self.keys = 0
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(downloads))

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """Ask the browser for something and wait for the answer."""
        number = self._ask(method, **params)
        while True:
            answer = self._pipe.receive()
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self._note(answer)

    def _ask(self, method: str, **params: Any) -> int:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": params}
        if self._session and not method.startswith("Browser."):
            message["sessionId"] = self._session
        self._pipe.send(message)
        return self._number

    def _note(self, event: dict[str, Any]) -> None:
        method, params = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", str(details)))
        elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.complaints.append(params["entry"]["text"])
        elif method == "Page.javascriptDialogOpening":  # leave without saving?
            self._ask("Page.handleJavaScriptDialog", accept=True)
        elif method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"][:200])

    def open(self, file: Path, width: int = 1280, height: int = 900) -> None:
        """Open a page of this program and wait until it is ready."""
        self.size(width, height)
        self.call("Page.navigate", url=file.resolve().as_uri())
        self.wait("document.body && document.body.dataset.ready === 'yes'")

    def size(self, width: int, height: int) -> None:
        """Make the window so large [px]."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=False)  # fmt: skip

    def value(self, expression: str) -> Any:
        """Return the value of an expression in the page."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True,
                          awaitPromise=True)  # fmt: skip
        if "exceptionDetails" in found:
            raise RuntimeError(found["exceptionDetails"]["exception"]["description"])
        return found["result"].get("value")

    def wait(self, condition: str) -> None:
        """Wait until a condition holds in the page."""
        self.value(
            f"new Promise((good, bad) => {{ const until = Date.now() + {1000 * WAIT:.0f};"
            f"const look = () => ({condition}) ? good(true) : Date.now() > until ? "
            "bad(new Error('waited in vain')) : setTimeout(look, 20); look(); })"
        )

    def on_screen(self, x: float, y: float) -> tuple[float, float]:
        """Where on the screen a point of the photograph is shown."""
        return tuple(self.value(
            f"(() => {{ const f = view.getBoundingClientRect(), k = screenScale();"
            f"return [f.left + f.width / 2 + ({x} + 0.5 - box.x - box.w / 2) / k,"
            f"f.top + f.height / 2 + ({y} + 0.5 - box.y - box.h / 2) / k]; }})()"
        ))  # fmt: skip

    def move(self, x: float, y: float) -> None:
        """Move the mouse to a point of the photograph."""
        self._mouse("mouseMoved", *self.on_screen(x, y))

    def click(self, x: float, y: float, shift: bool = False) -> None:
        """Click a point of the photograph."""
        self.click_screen(*self.on_screen(x, y), SHIFT * shift)

    def press(self, element: str) -> None:
        """Click an element of the page, by its id."""
        middle = self.value(
            f"(() => {{ const e = document.getElementById('{element}'); e.scrollIntoView("
            "{block: 'nearest'}); const f = e.getBoundingClientRect();"
            "return [f.left + f.width / 2, f.top + f.height / 2]; })()"
        )
        self.click_screen(*middle)

    def click_screen(self, x: float, y: float, modifiers: int = 0) -> None:
        """Click a point of the window [px]."""
        self._mouse("mouseMoved", x, y, modifiers=modifiers)
        for kind in ("mousePressed", "mouseReleased"):
            self._mouse(kind, x, y, button="left", clickCount=1, modifiers=modifiers)
        self.clicks += 1

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag the mouse between two points of the window [px]."""
        self._mouse("mouseMoved", *start)
        self._mouse("mousePressed", *start, button="left", clickCount=1)
        for share in (0.3, 0.6, 1.0):
            at = [a + share * (b - a) for a, b in zip(start, end, strict=True)]
            self._mouse("mouseMoved", *at, button="left")
        self._mouse("mouseReleased", *end, button="left", clickCount=1)

    def wheel(self, x: float, y: float, delta: float) -> None:
        """Turn the wheel over a point of the photograph."""
        self._mouse("mouseWheel", *self.on_screen(x, y), deltaX=0, deltaY=delta)

    def _mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def key(self, key: str, control: bool = False) -> None:
        """Press a key."""
        code = KEYS.get(key, ord(key.upper()) if len(key) == 1 else 0)
        more = {"key": key, "windowsVirtualKeyCode": code, "modifiers": CONTROL * control}
        text = {"text": key} if len(key) == 1 and not control else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", **more, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", **more)
        self.keys += 1

    def picture(self, path: Path) -> None:
        """Write what the window shows as a PNG."""
        coded = self.call("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(coded))


@contextlib.contextmanager
def page(folder: Path) -> Iterator[Page]:
    """Start a browser with its profile and downloads in a folder; yields its page."""
    program = installed()
    if program is None:
        raise RuntimeError(f"no browser: none of {', '.join(NAMES)} is installed")
    (theirs_in, ours_out), (ours_in, theirs_out) = os.pipe(), os.pipe()
    far = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (theirs_in, theirs_out)]  # not 3 and 4
    quiet = [(os.POSIX_SPAWN_OPEN, n, os.devnull, os.O_RDWR, 0) for n in (1, 2)]
    pipes = [(os.POSIX_SPAWN_DUP2, end, n) for end, n in zip(far, (3, 4), strict=True)]
    arguments = [program, *FLAGS, f"--user-data-dir={folder / 'profile'}"]
    running = os.posix_spawn(program, arguments, os.environ, file_actions=[*quiet, *pipes])
    for end in (theirs_in, theirs_out, *far):
        os.close(end)
    downloads = folder / "downloads"
    downloads.mkdir(exist_ok=True)
    try:
        yield Page(_Pipe(ours_out, ours_in), downloads)
    finally:
        os.kill(running, signal.SIGTERM)
        os.waitpid(running, 0)
        os.close(ours_out), os.close(ours_in)
