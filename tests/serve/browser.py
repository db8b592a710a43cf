"""A headless Chromium and a `tissuectl serve`, for the tests of the page and for screenshot.py."""
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

FLAGS = ["--headless=new", "--no-sandbox", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--no-first-run", "--hide-scrollbars"]
FLAT, SOLID = ["--disable-gpu"], ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]   # SOLID: WebGL, in software


PATIENCE_S = 120  # longest wait; waits take a few seconds at most except in a failing test or on a busy machine


failed = 0  # checks


def check(sentence, holds, seen=""):
    global failed
    failed += not holds
    print(f"ok - {sentence}" if holds else f"not ok - {sentence}: {seen}", flush=True)


def run(test, **options):
    """Calls test(page, folder) with a new Browser and a temporary folder, and ends all servers. Returns the exit status."""
    try:
        page = Browser(**options)
    except Missing as package:
        check("a browser is available", False, f"missing package {package}; scripts/install_deps names it")
        return 1
    with tempfile.TemporaryDirectory() as folder:
        try:
            test(page, folder)
        finally:
            page.end()
            for server in Server.started:
                server.end()
    return 1 if failed else 0


class Missing(Exception):
    """A package that is not installed."""


class Server:
    """`tissuectl serve` with these options; port 0: any free port. Its output goes to a file in `folder`."""

    started = []

    def __init__(self, program, models, folder, *options, port=0):
        self.log = Path(folder) / "serve.log"
        with open(self.log, "w") as log:
            self.process = subprocess.Popen([program, "serve", *options, "--port", str(port), *models],
                                            stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.started.append(self)
        self.url = None
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            found = re.search(r"http://\S+", self.log.read_text())
            if found:
                self.url = found[0]
                self.port = int(re.search(r":(\d+)", self.url)[1])
                return
            if self.process.poll() is not None:
                break
            time.sleep(0.1)
        self.end()
        raise RuntimeError(f"tissuectl serve did not start: {self.log.read_text()}")

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
        try:
            self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


class Browser:
    """One Chromium with a profile of its own. Lengths in CSS pixels, times in seconds."""

    def __init__(self, width=1360, height=900, scale=1, mobile=False, flags=FLAT, **media):
        try:
            from selenium import webdriver
            from selenium.webdriver.chrome.service import Service
        except ImportError:
            raise Missing("python3-selenium") from None
        programs = [shutil.which("chromium"), shutil.which("chromedriver")]
        for found, package in zip(programs, ("chromium", "chromium-driver")):
            if not found:
                raise Missing(package)
        self.profile = tempfile.mkdtemp()
        options = webdriver.ChromeOptions()
        options.binary_location = programs[0]
        for flag in [*FLAGS, *flags, f"--user-data-dir={self.profile}", f"--window-size={width},{height}"]:
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(programs[1]))
        self.resize(width, height, scale, mobile)
        self.media(**media)

    def end(self):
        self.driver.quit()
        shutil.rmtree(self.profile, ignore_errors=True)

    def cdp(self, command, **arguments):
        return self.driver.execute_cdp_cmd(command, arguments)

    def resize(self, width, height, scale=1, mobile=False):
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=mobile)

    def media(self, **features):
        """Emulates media features, such as prefers_color_scheme="dark"."""
        self.cdp("Emulation.setEmulatedMedia",
                 features=[{"name": name.replace("_", "-"), "value": value} for name, value in features.items()])

    def open(self, url):
        self.driver.get(url)

    def js(self, expression, *arguments):
        return self.driver.execute_script(f"return ({expression})", *arguments)

    def until(self, expression, seconds=PATIENCE_S):
        """Waits until an expression is true; False after the time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.js(expression):
                return True
            time.sleep(0.05)
        return False

    def after(self, states):
        """Waits until the page has received this many more states."""
        return self.until(f"tissue.states >= {self.js('tissue.states') + states}")

    def rests(self, expression):
        """Waits until the value is not zero and changes by less than 1 % over 30 states, and returns it. Zero does not
        count as rest: tissue that oscillates away from the tool has no force for a while."""
        end = time.monotonic() + PATIENCE_S
        before = self.js(expression)
        while self.after(30):
            value = self.js(expression)
            if value and abs(value - before) <= 0.01 * abs(value) or time.monotonic() > end:
                return value
            before = value

    def watch(self, expression, seconds):
        """Values of an expression, one for every state that the page receives in this time."""
        return self.driver.execute_async_script(f"""
            const [seconds, done] = arguments, values = [], end = performance.now() + 1e3 * seconds;
            let seen = tissue.states;
            const look = () => {{
                if (tissue.states !== seen) values.push({expression});
                seen = tissue.states;
                if (performance.now() < end) setTimeout(look, 4); else done(values);
            }};
            look();""", seconds)

    def text(self, name):
        return self.js("document.getElementById(arguments[0]).textContent", name)

    def click(self, name):
        self.driver.find_element("id", name).click()

    def choose(self, name, value):
        """Selects an option of a <select> by its value."""
        self.driver.find_element("css selector", f"#{name} option[value='{value}']").click()

    def on_screen(self, *point_m):
        """CSS pixels of a point of the plane or of space, which is scrolled into view first."""
        point = "tissue.on_screen([...arguments])"
        x, y = self.js(point, *point_m)
        if not self.js("arguments[0] > 0 && arguments[0] < innerWidth && arguments[1] > 0 && arguments[1] < innerHeight", x, y):
            self.js("document.querySelector('#stage:not([hidden]), #space_stage:not([hidden])').scrollIntoView({block: 'center'})")
            x, y = self.js(point, *point_m)
        return x, y

    def mouse(self, kind, *point_m):
        """kind: Pressed, Moved, Released, at a point of the plane or of space."""
        self.mouse_at(kind, *self.on_screen(*point_m))

    def mouse_at(self, kind, x, y):
        """The same, in CSS pixels."""
        down = kind != "Released"
        self.cdp("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, button="left", buttons=int(down), clickCount=1)

    def drag(self, *way, steps=6):
        """Presses the mouse button at the first point [m] and moves along the others. The button stays down."""
        self.mouse("Pressed", *way[0])
        for a, b in zip(way, way[1:]):
            for k in range(1, steps + 1):
                self.mouse("Moved", *(p + (q - p) * k / steps for p, q in zip(a, b)))

    def touch(self, kind, *point_m):
        """kind: Start, Move, End."""
        points = [dict(zip("xy", self.on_screen(*point_m)))] if point_m else []
        self.cdp("Input.dispatchTouchEvent", type=f"touch{kind}", touchPoints=points)

    def key(self, name, times=1, shift=False):
        code = {"Space": " "}.get(name, name)
        text = {"text": " "} if name == "Space" else {"text": "\r"} if name == "Enter" else {}
        number = {"Tab": 9, "Enter": 13, "Escape": 27, "Space": 32, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39,
                  "ArrowDown": 40, "PageUp": 33, "PageDown": 34, "Home": 36, "+": 187, "-": 189}[name]
        for _ in range(times):
            for kind in ("keyDown", "keyUp"):
                self.cdp("Input.dispatchKeyEvent", type=kind, key=code, code=name, modifiers=8 if shift else 0,
                         windowsVirtualKeyCode=number, **(text if kind == "keyDown" else {}))

    def complaints(self):
        """Warnings and errors of the console since the last call."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("WARNING", "SEVERE")]
