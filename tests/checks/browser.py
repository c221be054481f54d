"""A page in headless Chromium, driven as a person would: mouse and keys, over the pipe of its debugging protocol."""

import base64
import json
import os
import shutil
import subprocess
from pathlib import Path

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
OPTIONS = [
    "--headless",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--host-resolver-rules=MAP * ~NOTFOUND",  # no network
    "--remote-debugging-pipe",
]


class Browser:
    """One page, opened from a file.

    Args:
        page: the file.
        profile: an empty folder.
        size: of the window, pixels.
    """

    def __init__(self, page: Path, profile: Path, size: tuple[int, int] = (1100, 800)):
        assert CHROMIUM is not None
        to_it, self._out = os.pipe()
        self._in, from_it = os.pipe()
        line = [CHROMIUM, *OPTIONS, f"--window-size={size[0]},{size[1]}", f"--user-data-dir={profile}", "about:blank"]

        def as_it_wants():  # it reads from 3 and writes to 4
            high = [os.dup2(fd, to) for fd, to in ((to_it, 103), (from_it, 104))]
            for fd, to in zip(high, (3, 4), strict=True):
                os.dup2(fd, to)

        quiet = subprocess.DEVNULL
        self._process = subprocess.Popen(
            line, stdin=quiet, stdout=quiet, stderr=quiet, close_fds=False, preexec_fn=as_it_wants
        )
        os.close(to_it)
        os.close(from_it)
        self._rest, self._number, self._session = b"", 0, None
        self.errors: list[str] = []
        targets = self.call("Target.getTargets")["targetInfos"]
        target = next(one["targetId"] for one in targets if one["type"] == "page")
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call("Runtime.enable")
        self.call("Page.enable")
        self.call("Page.navigate", url=page.as_uri())
        self.until("document.readyState === 'complete'")

    def call(self, method: str, **params) -> dict:
        """What the browser answers; exceptions of the page are kept in `errors`."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self._rest:
                piece = os.read(self._in, 1 << 20)
                assert piece, "the browser is gone"
                self._rest += piece
            text, _, self._rest = self._rest.partition(b"\0")
            answer = json.loads(text)
            if answer.get("method") == "Runtime.exceptionThrown":
                self.errors.append(json.dumps(answer["params"]["exceptionDetails"]))
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]

    def ask(self, expression: str):
        """The value of an expression of JavaScript in the page; of a promise, what it gives."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def until(self, condition: str):
        """Wait until it holds, ten seconds at most."""
        look = f"if ({condition}) done(); else if (Date.now() > end) fail('in vain'); else setTimeout(look, 20);"
        self.ask(f"new Promise((done, fail) => {{ const end = Date.now() + 1e4; (function look() {{ {look} }})(); }})")

    def frames(self, count: int = 2):
        """Wait for so many frames."""
        following = "left-- ? requestAnimationFrame(next) : done();"
        self.ask(f"new Promise(done => {{ let left = {count}; (function next() {{ {following} }})(); }})")

    def drag(self, start: tuple[float, float], end: tuple[float, float], steps: int = 5):
        """Press, move and let go."""
        self._mouse("mousePressed", *start)
        for i in range(1, steps + 1):
            self._mouse("mouseMoved", *(a + (b - a) * i / steps for a, b in zip(start, end, strict=True)))
        self._mouse("mouseReleased", *end)
        self.frames()

    def _mouse(self, kind: str, x: float, y: float):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    def key(self, name: str):
        """Press a key and let go."""
        code = {"ArrowRight": 39, "ArrowLeft": 37}[name]
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=name, code=name, windowsVirtualKeyCode=code)
        self.frames()

    def touch(self, start: tuple[float, float], end: tuple[float, float]):
        """Drag with a finger."""
        self.call("Emulation.setTouchEmulationEnabled", enabled=True)
        for kind, *at in (("touchStart", start), ("touchMove", end), ("touchEnd",)):
            self.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y} for x, y in at])
        self.frames()

    def middle(self, selector: str, part: float = 0.5) -> tuple[float, float]:
        """A place on an element, `part` of its width from the left."""
        box = self.ask(f"(r => [r.x + {part} * r.width, r.y + r.height / 2])"
                       f"(document.querySelector({selector!r}).getBoundingClientRect())")  # fmt: skip
        return box[0], box[1]

    def picture(self, path: Path) -> Path:
        """A screenshot."""
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))
        return path

    def close(self):
        self._process.terminate()
        self._process.wait(10)
        os.close(self._out)
        os.close(self._in)
