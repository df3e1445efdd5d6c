#!/usr/bin/env python3
"""Looks at the program's pages in a browser: Chromium without a window, at three widths, light and dark.

    tools/check_pages.py PROGRAM [REPORT]     makes pages of every kind and looks at them; REPORT is the folder
                                              of a report page that is there already (tools/check_report.py
                                              leaves one), else one is made. Status 1 if anything is wrong
    tools/check_pages.py --self-test          plants faults in a page and looks whether they are found
    tools/check_pages.py --shots DIR FILE...  pictures of HTML files, for eyes

What must hold at each width: nothing is wider than its box, but for boxes that scroll, take the focus, have
a name and show by a shadow that there is more; the page itself does not scroll sideways; letters in figures have
LEAST_LETTER pixels at least; axe-core finds no violation.

Chromium is Debian's; it is talked to through its pipe (DevTools protocol). axe-core comes with a PyPI
package; `tools/setup.sh browser` installs both. Python's standard library only.
"""
import base64
import fcntl
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
WIDTHS = (390, 1024, 1440)
SCHEMES = ("light", "dark")
HEIGHT = 900
LEAST_LETTER = 10.5             # Pixels, of the letters in figures; sub- and superscripts aside
PATIENCE = 120                  # Seconds that an answer of the browser may take

# In the page: [what is wrong, ...]
LAYOUT = """(leastLetter) => {
    const wrong = [], wide = document.documentElement.clientWidth;
    const name = e => {
        const id = e.closest('[id]');
        return e.tagName.toLowerCase() + (e.className && e.className.baseVal === undefined ? '.' + e.className : '') +
            (id ? ' in #' + id.id : '') + ' "' + e.textContent.trim().slice(0, 30).replace(/\\s+/g, ' ') + '"';
    };
    if (document.documentElement.scrollWidth > wide || innerWidth > wide + 20)
        wrong.push('the page scrolls sideways: ' + document.documentElement.scrollWidth + ' in ' + wide);
    const scrolls = e => ['auto', 'scroll'].includes(getComputedStyle(e).overflowX);
    for (const e of document.body.querySelectorAll('*:not(svg *)')) {
        const box = e.getBoundingClientRect(), look = getComputedStyle(e);
        if (box.width === 0 || look.visibility === 'hidden' || look.clipPath !== 'none') continue;
        if (scrolls(e)) {
            if (e.scrollWidth <= e.clientWidth) continue;
            if (e.tabIndex < 0 || !e.getAttribute('role') || !e.getAttribute('aria-label'))
                wrong.push('scrolls, but takes no focus or has no name: ' + name(e));
            if (!look.backgroundAttachment.includes('local'))
                wrong.push('scrolls without a cue: ' + name(e));
            continue;
        }
        if (look.display !== 'inline' && e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0)
            wrong.push('wider than its box by ' + (e.scrollWidth - e.clientWidth) + ': ' + name(e));
        let parent = e.parentElement;
        while (parent && !scrolls(parent)) parent = parent.parentElement;
        if (!parent && (box.right > wide + 1 || box.left < -1))
            wrong.push('reaches out of the page, ' + Math.round(box.left) + ' to ' + Math.round(box.right) + ': ' + name(e));
    }
    for (const svg of document.querySelectorAll('svg')) {
        let least = 1e9;
        for (const text of svg.querySelectorAll('text')) {
            const scale = text.getScreenCTM();
            if (scale && text.textContent.trim())
                least = Math.min(least, parseFloat(getComputedStyle(text).fontSize)*Math.hypot(scale.a, scale.b));
        }
        if (least < leastLetter) wrong.push('letters of ' + least.toFixed(1) + ' pixels: ' + name(svg).slice(0, 60));
    }
    return wrong;
}"""

# What axe-core cannot judge: texts on the shadows of scrolling boxes, whose ground it does not know; what is drawn
# in figures, thousands of lines that it would go through one by one: a figure counts by its title. Of the rows of
# a table that are built alike two are enough.
PREPARE_AXE = """() => {
    const style = document.createElement('style');
    style.textContent = '.scroll{background-image:none!important}';
    document.head.append(style);
    for (const e of document.querySelectorAll('svg > :not(title, desc)')) e.remove();
    for (const e of document.querySelectorAll('details')) e.open = true;
    for (const body of document.querySelectorAll('tbody')) {
        const alike = {};
        for (const row of [...body.rows]) {
            const built = [...row.cells].map(c => c.tagName + c.className).join();
            alike[built] = (alike[built] || 0) + 1;
            if (alike[built] > 2) row.remove();
        }
    }
}"""

AXE = """async (only) => {
    const found = await axe.run(document, {resultTypes: ['violations'], ...only});
    return found.violations.map(v => 'axe: ' + v.id + ', ' + v.help + ': ' + v.nodes.length + ' times, first ' +
                                     v.nodes[0].html.slice(0, 120) + (v.nodes[0].any[0] ? ' (' + v.nodes[0].any[0].message + ')' : ''));
}"""


class Browser:
    """Chromium without a window, through its pipe: file descriptors 3 (to it) and 4 (from it)."""

    def __init__(self):
        program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
        if program is None:
            sys.exit("no chromium here: tools/setup.sh browser installs it")
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        # The browser's ends get numbers out of the way; the shell puts them to 3 and 4.
        low_read, self.to_write = os.pipe()
        self.from_read, low_write = os.pipe()
        to_read, from_write = (fcntl.fcntl(low, fcntl.F_DUPFD, 20) for low in (low_read, low_write))
        command = [program, "--headless=new", "--remote-debugging-pipe", "--no-first-run", "--disable-gpu",
                   "--disable-extensions", "--disable-background-networking", "--hide-scrollbars",
                   "--disable-dev-shm-usage", f"--user-data-dir={self.profile.name}", "about:blank"]
        if os.geteuid() == 0:
            command.insert(1, "--no-sandbox")
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec 3<&{to_read} 4>&{from_write} {to_read}<&- {from_write}>&-; exec "$@"', "-", *command],
            pass_fds=(to_read, from_write), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for end in (low_read, low_write, to_read, from_write):
            os.close(end)
        self.buffer, self.count, self.session = b"", 0, None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.ask("Page.enable")

    def close(self):
        self.process.terminate()
        self.process.wait()
        self.profile.cleanup()

    def message(self):
        while b"\0" not in self.buffer:
            piece = os.read(self.from_read, 1 << 20)
            if not piece:
                sys.exit("chromium ended unexpectedly")
            self.buffer += piece
        line, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(line)

    def ask(self, method, **parameters):
        self.count += 1
        question = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            question["sessionId"] = self.session
        data = json.dumps(question).encode() + b"\0"
        while data:
            data = data[os.write(self.to_write, data):]
        while True:
            answer = self.message()
            if answer.get("id") == self.count:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']}")
                return answer["result"]

    def run(self, function, *arguments):
        done = self.ask("Runtime.evaluate", expression=f"({function})({','.join(map(json.dumps, arguments))})",
                        awaitPromise=True, returnByValue=True, timeout=1000*PATIENCE)
        if "exceptionDetails" in done:
            sys.exit(f"in the page: {done['exceptionDetails']}")
        return done["result"].get("value")

    def open(self, path):
        done = self.ask("Page.navigate", url=pathlib.Path(path).resolve().as_uri())
        if "errorText" in done:
            sys.exit(f"{path}: {done['errorText']}")
        while self.run("() => document.readyState") != "complete":
            time.sleep(0.02)

    def look(self, width, scheme):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=HEIGHT, deviceScaleFactor=1,
                 mobile=width < 600)
        self.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def picture(self, path):
        height = min(self.run("() => document.documentElement.scrollHeight"), 60000)
        width = self.run("() => innerWidth")
        data = self.ask("Page.captureScreenshot", captureBeyondViewport=True,
                        clip={"x": 0, "y": 0, "width": width, "height": height, "scale": 1})["data"]
        pathlib.Path(path).write_bytes(base64.b64decode(data))


def axe_source():
    """The text of axe-core, as the package carries it; the package itself, which needs playwright, is not loaded."""
    found = sorted((ROOT / ".venv").glob("lib/python*/site-packages/axe_playwright_python/axe.min.js"))
    if not found:
        sys.exit("no axe-core here: tools/setup.sh browser installs it")
    return found[-1].read_text(encoding="utf-8")


def faults_of(browser, axe, path):
    """What is wrong with a page: (width, scheme, fault). Layout does not depend on the scheme."""
    browser.open(path)
    for opened in (False, True):
        browser.run("(opened) => { for (const e of document.querySelectorAll('details')) e.open = opened }", opened)
        for width in WIDTHS:
            browser.look(width, SCHEMES[0])
            yield from ((width, SCHEMES[0], fault) for fault in browser.run(LAYOUT, LEAST_LETTER))
    browser.run(PREPARE_AXE)
    browser.run("(text) => { (0, eval)(text) }", axe)
    for width in WIDTHS:
        for scheme in SCHEMES:
            browser.look(width, scheme)
            only = {} if scheme == SCHEMES[0] else {"runOnly": ["color-contrast"]}      # all that it can change
            yield from ((width, scheme, fault) for fault in browser.run(AXE, only))


def run(program, *arguments, folder, status=0):
    done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != status:
        sys.exit(f"gracecg {' '.join(arguments)}: status {done.returncode}: {done.stderr}")
    return done.stdout


def make_pages(program, report, folder):
    """One page of each kind: (what it is, its path)."""
    if report is None:
        report = folder / "report"
        run(program, "report", "--out", "report", "--runs", "15", folder=folder)
    yield "the report", report / "index.html"

    run(program, "simulate", "front-1", "--out", "ordinary", folder=folder)
    run(program, "estimate", "ordinary", "--algorithm", "optimal", "--report", "ordinary.html", folder=folder)
    yield "an ordinary calibration", folder / "ordinary.html"

    setup = folder / "ordinary" / "setup.nml"       # the rods fired with more than twice what the setup says
    setup.write_text(setup.read_text(encoding="utf-8").replace("amplitude = 30 ", "amplitude = 14 "), encoding="utf-8")
    run(program, "estimate", "ordinary", "--algorithm", "assest-fde", "--report", "refused.html", folder=folder, status=1)
    yield "a refused calibration", folder / "refused.html"

    setup.unlink()
    run(program, "estimate", "ordinary", "--algorithm", "ascfest", "--report", "unread.html", folder=folder, status=1)
    yield "a calibration that could not be read", folder / "unread.html"

    run(program, "simulate", str((report / "designed_front.nml").resolve()), "--out", "designed", folder=folder)
    run(program, "estimate", "designed", "--algorithm", "sequential", "--report", "designed.html", folder=folder)
    yield "a designed manoeuvre", folder / "designed.html"

    (folder / "level1.nml").write_text("&level1_simulation\n spans = 2\n/\n", encoding="utf-8")
    run(program, "level1", "simulate", "front-1", "--level1", "level1.nml", "--out", "level1", folder=folder)
    run(program, "level1", "estimate", "level1", "--setup", "level1/setup.nml", "--report", "level1.html", folder=folder)
    yield "a calibration from Level-1 files", folder / "level1.html"

    results = []
    for date in ("2020-02-01", "2020-11-20", "2021-10-05"):
        (folder / "level1.nml").write_text(f"&level1_simulation\n spans = 2, epoch = '{date}'\n/\n", encoding="utf-8")
        run(program, "level1", "simulate", "front-1", "--level1", "level1.nml", "--out", date, folder=folder)
        found = run(program, "level1", "estimate", date, "--setup", f"{date}/setup.nml", "--format", "json", folder=folder)
        (folder / f"{date}.json").write_text(found, encoding="utf-8")
        results.append(f"{date}.json")
    (folder / "soe.txt").write_text("650000000 GRACEC VCM 3 0 0 0 trimmed\n", encoding="utf-8")
    run(program, "level1", "trend", *results, "--setup", "level1/setup.nml", "--soe", "soe.txt", "--report", "trend.html",
        folder=folder)
    yield "Level-1 calibrations over time", folder / "trend.html"


def check(program, report):
    program, axe, browser, found = os.path.abspath(program), axe_source(), Browser(), 0
    with tempfile.TemporaryDirectory() as name:
        for kind, path in make_pages(program, report, pathlib.Path(name)):
            for width, scheme, fault in faults_of(browser, axe, path):
                found += 1
                print(f"{kind}, {width}, {scheme}: {fault}")
    browser.close()
    return 1 if found else 0


SOUND = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Sound</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>body{color:#111;background:#fff}
.scroll{overflow-x:auto;background:linear-gradient(#fff,#fff) local}
@media (prefers-color-scheme:dark){body{color:#eee;background:#111}.scroll{background:linear-gradient(#111,#111) local}}
</style></head><body><main><h1>Sound</h1><p id="here">Text</p>
<div class="scroll" role="region" tabindex="0" aria-label="A table"><table style="width:2000px"><caption>Wide</caption>
<tr><th scope="col">a</th></tr><tr><td>1</td></tr></table></div>
<figure><svg role="img" aria-labelledby="t" viewBox="0 0 300 100"><title id="t">Drawn</title>
<text x="10" y="50" font-size="12">letters</text></svg></figure></main></body></html>"""
FAULTS = {      # what is put in the place of the paragraph, and what must be said of it
    "a table that is cut": ('<div style="overflow:hidden"><table style="width:2000px"><tr><th scope="col">a</th></tr>'
                            '<tr><td>1</td></tr></table></div>', "wider than its box"),
    "a table out of the page": ('<table style="width:2000px"><tr><th scope="col">a</th></tr><tr><td>1</td></tr></table>',
                                "scrolls sideways"),
    "a box that takes no focus": ('<div class="scroll"><div style="width:2000px">a</div></div>', "takes no focus"),
    "a box without a cue": ('<div style="overflow-x:auto" role="region" tabindex="0" aria-label="b">'
                            '<div style="width:2000px">a</div></div>', "without a cue"),
    "small letters": ('<svg role="img" aria-label="s" viewBox="0 0 3000 100"><text x="9" y="50" font-size="12">a</text></svg>',
                      "letters of"),
    "an image without a text": ('<img src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=">', "image-alt"),
    "too little contrast in the dark": ('<p style="color:#555">grey</p>', "dark: axe: color-contrast"),
}


def self_test():
    axe, browser, missed = axe_source(), Browser(), 0
    with tempfile.TemporaryDirectory() as name:
        path = pathlib.Path(name) / "page.html"
        for kind, (fault, said) in {"nothing": ("", ""), **FAULTS}.items():
            path.write_text(SOUND.replace('<p id="here">Text</p>', fault), encoding="utf-8")
            found = [f"{width}, {scheme}: {text}" for width, scheme, text in faults_of(browser, axe, path)]
            if fault and not any(said in text for text in found):
                missed += 1
                print(f"planted, but not found: {kind}; found: {found}")
            if not fault and found:
                missed += 1
                print(f"found in a page without faults: {found}")
    browser.close()
    return 1 if missed else 0


def shots(folder, paths):
    browser = Browser()
    for path in map(pathlib.Path, paths):
        browser.open(path)
        for width in WIDTHS:
            for scheme in SCHEMES:
                browser.look(width, scheme)
                browser.picture(pathlib.Path(folder) / f"{path.parent.name}_{path.stem}_{width}_{scheme}.png")
    browser.close()
    return 0


def main():
    if sys.argv[1:2] == ["--shots"] and len(sys.argv) > 3:
        return shots(sys.argv[2], sys.argv[3:])
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    return check(sys.argv[1], pathlib.Path(sys.argv[2]) if len(sys.argv) == 3 else None)


if __name__ == "__main__":
    sys.exit(main())
