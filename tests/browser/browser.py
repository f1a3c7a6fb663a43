"""Headless Chromium by chromedriver's HTTP interface: what the checks of pages have in common."""

import base64
import contextlib
import json
import os
import pathlib
import re
import subprocess
import time
import urllib.error
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
VDB_PACK = os.environ.get("VDB_PACK", str(ROOT / "build/release/tools/vdb_pack"))
SCREENS = {"desk": (1280, 900), "phone": (375, 800)}
CHROMIUM = ["--headless", "--no-sandbox", "--disable-quic", "--no-first-run",
            "--disable-background-networking", "--disable-component-update", "--disable-sync"]
# WebGL2 drawn by the processor.
SOFTWARE_WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def vdb_pack(*arguments):
    subprocess.run([VDB_PACK, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


@contextlib.contextmanager
def driver(folder):
    """The address of a chromedriver that runs meanwhile."""
    process = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, text=True,
                               env={**os.environ, "HOME": str(folder)})
    try:
        port = next(found[1] for line in process.stdout
                    if (found := re.search(r"started successfully on port (\d+)", line)))
        yield f"http://localhost:{port}"
    finally:
        process.terminate()
        process.wait()


class Browser:
    """A session of chromedriver over its HTTP interface, for screens of one size."""

    def __init__(self, driver_url, width, height, profile, flags=SOFTWARE_WEBGL):
        self.driver_url = driver_url
        self.width = width
        self.profile = str(profile)
        options = {
            "args": [*CHROMIUM, *flags, f"--user-data-dir={profile}", f"--window-size={width},{height}"],
            "binary": "/usr/bin/chromium",
        }
        if width < 500:  # no window is as narrow
            options["mobileEmulation"] = {
                "deviceMetrics": {"width": width, "height": height, "pixelRatio": 2}}
        capabilities = {"browserName": "chrome", "goog:chromeOptions": options,
                        "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
        answer = self.ask("POST", "/session", {"capabilities": {"alwaysMatch": capabilities}})
        self.path = "/session/" + answer["sessionId"]

    def ask(self, method, path, body=None):
        request = urllib.request.Request(
            self.driver_url + path, method=method,
            data=None if body is None else json.dumps(body).encode(),
            headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise SystemExit(f"chromedriver: {error.read().decode()}")

    def command(self, name, **parameters):
        return self.ask("POST", self.path + "/goog/cdp/execute",
                        {"cmd": name, "params": parameters})

    def log(self, kind):
        return self.ask("POST", self.path + "/se/log", {"type": kind})

    def open(self, url, scheme):
        self.command("Emulation.setEmulatedMedia",
                     features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.log("performance")
        self.ask("POST", self.path + "/url", {"url": url})

    def script(self, text, *arguments):
        return self.ask("POST", self.path + "/execute/sync", {"script": text, "args": list(arguments)})

    def wait_for(self, condition, seconds=60):
        """Until a JavaScript expression is true."""
        end = time.monotonic() + seconds
        while not self.script(f"return Boolean({condition})"):
            if time.monotonic() > end:
                raise SystemExit(f"waited {seconds} s for {condition}")
            time.sleep(0.05)

    def actions(self, *sources):
        self.ask("POST", self.path + "/actions", {"actions": list(sources)})

    def requests(self):
        """Addresses that were asked for since the page was opened."""
        messages = [json.loads(entry["message"])["message"] for entry in self.log("performance")]
        return [m["params"]["request"]["url"] for m in messages
                if m["method"] == "Network.requestWillBeSent"]

    def problems(self, page):
        """Requests for anything but the page, and messages in the console."""
        found = [f"request for {url}" for url in self.requests()
                 if url != page.as_uri() and not url.startswith(("data:", "blob:"))]
        return found + ["console: " + entry["message"] for entry in self.log("browser")]

    def processor_seconds(self):
        """Of all processes of the browser so far."""
        parents, seconds, roots = {}, {}, set()
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                name = int(process.name)
                fields = (process / "stat").read_text().rsplit(")", 1)[1].split()
                parents[name] = int(fields[1])
                seconds[name] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
                if self.profile in (process / "cmdline").read_text(errors="replace"):
                    roots.add(name)
            except (OSError, IndexError):
                continue  # it has ended

        def belongs(name):
            while name in parents and name not in roots:
                name = parents[name]
            return name in roots

        return sum(time for name, time in seconds.items() if belongs(name))

    def picture(self, path):
        """What the window shows; a picture of the whole page resizes it."""
        image = self.command("Page.captureScreenshot")
        pathlib.Path(path).write_bytes(base64.b64decode(image["data"]))

    def screenshot(self, path):
        """The whole page."""
        size = self.command("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        image = self.command("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        pathlib.Path(path).write_bytes(base64.b64decode(image["data"]))

    def close(self):
        self.ask("DELETE", self.path)
