# SPDX-License-Identifier: Apache-2.0
"""Drives real browsers for the page's tests, with Python's standard library alone.

    with Server(folder) as server, Chromium() as browser:   # or Firefox()
        browser.open(server.url + "index.html")
        browser.pointer("mouse", "down", 200, 150)
        print(browser.run("return document.title"), browser.errors(), browser.requests())

Chromium speaks the DevTools protocol over a pipe, Firefox speaks Marionette over loopback. Both begin with a fresh
profile and draw WebGL2 by the CPU. Input events are the browser's own (isTrusted). Positions are CSS pixels.
"""
import base64
import fcntl
import functools
import http.server
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import urllib.parse

MODIFIERS = {"control": 2, "shift": 8}
# Keys by their names in the DOM: WebDriver's code, Windows' code.
SPECIAL_KEYS = {"ArrowLeft": ("\ue012", 37), "ArrowUp": ("\ue013", 38), "ArrowRight": ("\ue014", 39),
                "ArrowDown": ("\ue015", 40), "Enter": ("\ue007", 13), "Escape": ("\ue00c", 27), "Tab": ("\ue004", 9),
                "Control": ("\ue009", 17), "Shift": ("\ue008", 16)}


class Browser:
    """Of both browsers: a fresh profile, processes that end with it, and waiting for a state."""

    def __init__(self):
        self.profile, self.processes = pathlib.Path(tempfile.mkdtemp(prefix="touchable-browser-")), []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in reversed(self.processes):
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def start(self, arguments, environment=(), **settings):
        with open(self.profile / "log", "ab") as log:
            self.processes.append(subprocess.Popen(
                arguments, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
                env={**os.environ, "HOME": str(self.profile), **dict(environment)}, **settings))

    def wait(self, script, seconds=60):
        """What the script returns, once it is neither false nor null."""
        end = time.monotonic() + seconds
        while not (value := self.run(script)):
            if time.monotonic() > end:
                raise TimeoutError(f"after {seconds} s still not: {script}; errors: {self.errors()}")
            time.sleep(0.05)
        return value


class Chromium(Browser):
    name = "Chromium"

    @staticmethod
    def program():
        return shutil.which("chromium") or shutil.which("google-chrome")

    def __init__(self, width=1280, height=800, reached="127.0.0.1"):
        super().__init__()
        (commands, self.out), (self.input, answers) = os.pipe(), os.pipe()

        def as_3_and_4():
            high = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (commands, answers)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        # Other hosts than this one resolve to nothing, so that no request can leave the machine.
        self.start([self.program(), "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--no-first-run",
                    f"--user-data-dir={self.profile}", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                    "--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage",
                    f"--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE {reached}", "about:blank"],
                   pass_fds=(3, 4), preexec_fn=as_3_and_4)
        os.close(commands)
        os.close(answers)
        self.calls, self.answers, self.changed, self.ended = 0, {}, threading.Condition(threading.RLock()), False
        self.faults, self.urls, self.held, self.session = [], [], "none", None
        threading.Thread(target=self.receive, daemon=True).start()
        target = next(found for found in self.call("Target.getTargets")["targetInfos"] if found["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        self.watch(self.session)
        self.size(width, height)

    def __exit__(self, *_):
        super().__exit__()
        os.close(self.out)

    def watch(self, session):
        """Notes requests and errors of a page or worker. A new worker waits until this is set up."""
        for domain in ("Network", "Runtime", "Log"):
            self.send(f"{domain}.enable", session)
        self.send("Target.setAutoAttach", session, autoAttach=True, waitForDebuggerOnStart=True, flatten=True)
        self.send("Runtime.runIfWaitingForDebugger", session)

    def send(self, method, session, **parameters):
        with self.changed:
            self.calls += 1
            message = {"id": self.calls, "method": method, "params": parameters}
            os.write(self.out, json.dumps({**message, **({"sessionId": session} if session else {})}).encode() + b"\0")
            return self.calls

    def receive(self):
        """Notes the browser's messages until it ends, in a thread of its own."""
        buffer = b""
        while received := os.read(self.input, 1 << 20):
            *lines, buffer = (buffer + received).split(b"\0")
            with self.changed:
                for line in lines:
                    self.note(json.loads(line))
                self.changed.notify_all()
        os.close(self.input)
        with self.changed:
            self.ended = True
            self.changed.notify_all()

    def note(self, message):
        method, facts = message.get("method"), message.get("params", {})
        if "id" in message:
            self.answers[message["id"]] = message
        elif method == "Target.attachedToTarget":
            self.watch(facts["sessionId"])
        elif method == "Network.requestWillBeSent":
            self.urls.append(facts["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            thrown = facts["exceptionDetails"]
            self.faults.append(thrown.get("exception", {}).get("description") or thrown["text"])
        elif method == "Runtime.consoleAPICalled" and facts["type"] == "error":
            self.faults.append(" ".join(str(shown.get("value", shown.get("description"))) for shown in facts["args"]))
        elif method == "Log.entryAdded" and facts["entry"]["level"] == "error":
            self.faults.append(facts["entry"]["text"] + " " + facts["entry"].get("url", ""))

    def call(self, method, **parameters):
        with self.changed:
            number = self.send(method, self.session, **parameters)
            self.changed.wait_for(lambda: number in self.answers or self.ended, 120)
            if number not in self.answers:
                raise ConnectionError(f"{method}: no answer; " + (self.profile / "log").read_text()[-2000:])
            answer = self.answers.pop(number)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        return answer["result"]

    def open(self, url):
        self.call("Page.navigate", url=url)
        self.wait(f"return location.href === {json.dumps(url)} && document.readyState === 'complete'")

    def run(self, script):
        """What an async function with this body returns."""
        answer = self.call("Runtime.evaluate", expression=f"(async () => {{ {script} }})()", awaitPromise=True,
                           returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", "script failed"))
        return answer["result"].get("value")

    def pointer(self, kind, what, x, y, press=0.5, number=0, keys=(), button="left"):
        """kind: mouse, pen or touch. what: down, move or up. number: of a touch. keys: control or shift, held."""
        modifiers = sum(MODIFIERS[key] for key in keys)
        if kind == "touch":
            type_ = {"down": "touchStart", "move": "touchMove", "up": "touchEnd"}[what]
            self.call("Input.dispatchTouchEvent", type=type_, modifiers=modifiers,
                      touchPoints=[{"x": x, "y": y, "id": number, "force": press}])
            return
        self.held = {"down": button, "move": self.held, "up": "none"}[what]
        self.call("Input.dispatchMouseEvent", x=x, y=y, modifiers=modifiers, pointerType=kind, clickCount=1,
                  type={"down": "mousePressed", "move": "mouseMoved", "up": "mouseReleased"}[what],
                  button=button if what == "up" else self.held, force=press if kind == "pen" else 0,
                  buttons={"none": 0, "left": 1, "right": 2, "middle": 4}[self.held])

    def key(self, key, keys=(), what="press"):
        """what: press (down and up), down or up."""
        code = SPECIAL_KEYS[key][1] if key in SPECIAL_KEYS else ord(key.upper())
        facts = {"key": key, "windowsVirtualKeyCode": code, "modifiers": sum(MODIFIERS[key] for key in keys)}
        text = {"text": key} if len(key) == 1 and not keys else {"text": "\r"} if key == "Enter" else {}
        if what != "up":
            self.call("Input.dispatchKeyEvent", type="keyDown", **facts, **text)
        if what != "down":
            self.call("Input.dispatchKeyEvent", type="keyUp", **facts)

    def size(self, width, height):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def slow_down(self, factor):
        self.call("Emulation.setCPUThrottlingRate", rate=factor)

    def reduce_motion(self, less):
        wanted = {"name": "prefers-reduced-motion", "value": "reduce" if less else ""}
        self.call("Emulation.setEmulatedMedia", features=[wanted])

    def choose_file(self, selector, path):
        """As if a person had chosen the file in an <input type=file>."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        node = self.call("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.call("DOM.setFileInputFiles", files=[str(path)], nodeId=node)

    def screenshot(self, file):
        pathlib.Path(file).write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))

    def memory(self):
        """Bytes of the process that runs the page (PSS): the largest, as processes of earlier pages may be about to end."""
        most = 0
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (process / "cmdline").read_bytes()
                if str(self.profile).encode() in words and b"--type=renderer" in words:
                    most = max(most, 1024 * int((process / "smaps_rollup").read_text().split("\nPss:")[1].split()[0]))
            except OSError:
                pass  # it ended in between
        return most

    def requests(self):
        return [url for url in self.urls if not url.startswith(("blob:", "data:"))]

    def errors(self):
        return self.faults


class Firefox(Browser):
    """In a display of its own, because it has WebGL2 only in a window. Marionette knows no pens."""

    name = "Firefox"
    PREFERENCES = {"marionette.port": 0, "browser.aboutwelcome.enabled": False, "app.update.enabled": False,
                   "datareporting.policy.dataSubmissionEnabled": False, "network.captive-portal-service.enabled": False,
                   "network.connectivity-service.enabled": False, "browser.shell.checkDefaultBrowser": False,
                   "webgl.force-enabled": True, "dom.w3c_touch_events.enabled": 1}

    @staticmethod
    def program():
        return shutil.which("Xvfb") and (shutil.which("firefox-esr") or shutil.which("firefox"))

    def __init__(self, width=1280, height=800, reached=None):
        super().__init__()
        number, display = os.pipe()
        self.start(["Xvfb", "-displayfd", str(display), "-screen", "0", "1600x1200x24", "-nolisten", "tcp"],
                   pass_fds=(display,))
        os.close(display)
        (self.profile / "user.js").write_text("".join(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n"
                                                      for name, value in self.PREFERENCES.items()))
        self.start([self.program(), "--marionette", "--remote-allow-system-access", "--no-remote", "--profile",
                    str(self.profile), "about:blank"],
                   {"DISPLAY": ":" + os.read(number, 16).decode().strip(), "LIBGL_ALWAYS_SOFTWARE": "1"})
        port, end = self.profile / "MarionetteActivePort", time.monotonic() + 120
        while not (port.exists() and port.read_text()):
            if time.monotonic() > end or self.processes[-1].poll() is not None:
                raise TimeoutError("Firefox did not start: " + (self.profile / "log").read_text()[-2000:])
            time.sleep(0.05)
        self.socket = socket.create_connection(("127.0.0.1", int(port.read_text())), timeout=180)
        self.stream, self.calls = self.socket.makefile("rb"), 0
        self.read()  # its greeting
        self.call("WebDriver:NewSession")
        self.call("WebDriver:SetTimeouts", script=120000, pageLoad=120000)
        self.size(width, height)

    def __exit__(self, *_):
        self.stream.close()
        self.socket.close()
        super().__exit__()

    def read(self):
        digits = b""
        while not digits.endswith(b":"):
            byte = self.stream.read(1)
            if not byte:
                raise ConnectionError("the browser ended")
            digits += byte
        return json.loads(self.stream.read(int(digits[:-1])))

    def call(self, method, **parameters):
        self.calls += 1
        message = json.dumps([0, self.calls, method, parameters]).encode()
        self.socket.sendall(str(len(message)).encode() + b":" + message)
        _, _, error, result = self.read()
        if error:
            raise RuntimeError(f"{method}: {error['message']}")
        return result.get("value") if isinstance(result, dict) and set(result) == {"value"} else result

    def open(self, url):
        self.call("WebDriver:Navigate", url=url)

    def run(self, script):
        answer = self.call("WebDriver:ExecuteAsyncScript", args=[], script=(
            f"const done = arguments[arguments.length - 1]; (async () => {{ {script} }})()"
            ".then(value => done({value}), error => done({error: String(error)}))"))
        if answer.get("error"):
            raise RuntimeError(answer["error"])
        return answer.get("value")

    def act(self, kind, source, *actions, **settings):
        action = {"type": kind, "id": source, "actions": list(actions), **settings}
        self.call("WebDriver:PerformActions", actions=[action])

    def pointer(self, kind, what, x, y, press=0.5, number=0, keys=(), button="left"):
        actions = [{"type": "pointerMove", "x": int(x), "y": int(y), "duration": 0, "pressure": press}]
        if what != "move":
            code = {"left": 0, "middle": 1, "right": 2}[button]
            actions.append({"type": "pointer" + what.capitalize(), "button": code, "pressure": press})
        for key in keys:
            self.key(key.capitalize(), what="down")
        self.act("pointer", f"{kind}{number}", *actions, parameters={"pointerType": kind})
        for key in keys:
            self.key(key.capitalize(), what="up")

    def key(self, key, keys=(), what="press"):
        codes = [SPECIAL_KEYS.get(one, (one, 0))[0] for one in [*(held.capitalize() for held in keys), key]]
        down = [{"type": "keyDown", "value": code} for code in codes]
        up = [{"type": "keyUp", "value": code} for code in reversed(codes)]
        self.act("key", "keys", *({"press": down + up, "down": down, "up": up}[what]))

    def size(self, width, height):
        """Of the page. Firefox makes none narrower than 500."""
        self.call("WebDriver:SetWindowRect", width=width, height=height)
        inner = self.run("return [innerWidth, innerHeight]")
        self.call("WebDriver:SetWindowRect", width=2 * width - inner[0], height=2 * height - inner[1])

    def choose_file(self, selector, path):
        found = self.call("WebDriver:FindElement", using="css selector", value=selector)
        self.call("WebDriver:ElementSendKeys", id=next(iter(found.values())), text=str(path))

    def screenshot(self, file):
        pathlib.Path(file).write_bytes(base64.b64decode(self.call("WebDriver:TakeScreenshot", full=False)))

    def requests(self):
        return self.run("return [location.href, ...performance.getEntriesByType('resource').map(entry => entry.name)]")

    def errors(self):
        """Of scripts and policies of pages, as its console shows them."""
        self.call("Marionette:SetContext", value="chrome")
        try:
            return self.call("WebDriver:ExecuteScript", args=[], script="""
                return Services.console.getMessageArray().filter(message => message instanceof Ci.nsIScriptError &&
                    !(message.flags & Ci.nsIScriptError.warningFlag) && /^(http|file|blob)/.test(message.sourceName))
                    .map(message => message.errorMessage)""")
        finally:
            self.call("Marionette:SetContext", value="content")


class Server:
    """Serves a folder, on loopback by default. ranges=False: as Python's own server, which answers a range with the
    whole file. cut: {path: bytes after which the connection ends}. changed: {path: other bytes, or None: gone}. rate, delay: a link
    of so many bytes a second, shared by all connections, and seconds before a connection and before an answer.
    asked, sent: paths, and bytes of answers. headers: more of them."""

    def __init__(self, folder, ranges=True, cut=(), changed=(), rate=None, delay=0,
                 host="127.0.0.1", headers=()):
        self.folder, self.ranges, self.rate, self.delay = pathlib.Path(folder).resolve(), ranges, rate, delay
        self.cut, self.changed, self.headers, self.asked, self.sent = dict(cut), dict(changed), dict(headers), [], 0
        self.link, self.free_at = threading.Lock(), 0
        self.server = http.server.ThreadingHTTPServer((host, 0), functools.partial(Handler, self))
        self.url = f"http://{host}:{self.server.server_address[1]}/"

    def __enter__(self):
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()

    def pass_link(self, count):
        """Waits for as long as so many bytes take."""
        with self.link:
            self.sent += count
            self.free_at = max(self.free_at, time.monotonic()) + (count / self.rate if self.rate else 0)
            until = self.free_at
        time.sleep(max(0, until - time.monotonic()))


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css",
             ".json": "application/json", ".wasm": "application/wasm", ".png": "image/png"}

    def __init__(self, owner, *arguments):
        self.owner = owner
        super().__init__(*arguments)

    def setup(self):
        super().setup()
        time.sleep(self.owner.delay)

    def do_GET(self):
        owner, path = self.owner, urllib.parse.unquote(urllib.parse.urlsplit(self.path).path).lstrip("/")
        owner.asked.append(path)
        time.sleep(owner.delay)
        file = (owner.folder / path).resolve()
        is_there = file.is_file() and file.is_relative_to(owner.folder)
        if owner.changed.get(path, b"" if is_there else None) is None:
            return self.send_error(404)
        whole = owner.changed[path] if path in owner.changed else file.read_bytes()
        wanted, body = self.headers.get("Range"), whole
        if wanted and owner.ranges:
            first, last = wanted.removeprefix("bytes=").split("-")
            body = whole[int(first):int(last or len(whole)) + 1]
            self.send_response(206)
            self.send_header("Content-Range", f"bytes {first}-{int(first) + len(body) - 1}/{len(whole)}")
        else:
            self.send_response(200)
        self.send_header("Content-Type", self.TYPES.get(file.suffix, "application/octet-stream"))
        self.send_header("Content-Length", str(len(body)))
        for name, value in owner.headers.items():
            self.send_header(name, value)
        self.end_headers()
        end = min(len(body), owner.cut.get(path, len(body)))
        try:
            for at in range(0, end, 16384):
                part = body[at:min(at + 16384, end)]
                owner.pass_link(len(part))
                self.wfile.write(part)
        except ConnectionError:
            pass  # the page went away
        self.close_connection = self.close_connection or end < len(body)

    def log_message(self, *_):
        pass
