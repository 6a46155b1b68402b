#!/usr/bin/env python3
"""check_report.py CHROMIUM REPORT.html

Opens a report in headless Chromium from disk, with and without WebGL, and uses it as a reader would, with mouse and
keyboard. Prints a line a check that fails; exits with 1 if there is one. What a report does not have (a test, a design,
recordings) is not looked for: give --expect replay,map,… to demand sections.
"""

import argparse
import pathlib
import re
import sys
import tempfile

from chromium import Chromium

LARGEST_FILE = 5_000_000
# The watchdog would end a graphics process that a busy machine holds up.
WEBGL = ["--enable-unsafe-swiftshader", "--disable-gpu-watchdog"]
NO_WEBGL = ["--disable-gpu", "--disable-3d-apis"]

# What the checks ask the page again and again.
TOOLS = (pathlib.Path(__file__).parent / "page_tools.js").read_text()


class Checks:
    def __init__(self, browser, page, mode):
        self.browser = browser
        self.page = page
        self.mode = mode
        self.failures = []

    def expect(self, holds, what):
        if not holds:
            self.failures.append(f"{self.mode}: {what}")

    def ask(self, expression):
        return self.browser.evaluate(expression)

    def shown(self, section):
        return self.ask(f"test.shown('{section}')")

    def click(self, selector_or_expression):
        x, y = self.ask(f"test.middle({selector_or_expression})")
        self.browser.click(x, y)

    def open(self, width=1000, height=700):
        self.browser.resize(width, height)
        self.browser.open(self.page.as_uri())
        self.browser.evaluate(TOOLS)
        # Sizes, then drawings, come with the first frames.
        self.browser.evaluate("test.frames(6)")

    # --- The page as a whole ---------------------------------------------------------------------------------------

    def check_silence(self):
        """No error, warning or message of the page, and nothing fetched."""
        for event in self.browser.events:
            parameters = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                self.expect(False, f"an exception: {parameters['exceptionDetails']}")
            elif event["method"] == "Runtime.consoleAPICalled":
                self.expect(False, f"console.{parameters['type']}: {parameters['args']}")
            elif event["method"] == "Log.entryAdded":
                # The test reads pixels back, and the graphics driver says that this is slow.
                entry = parameters["entry"]
                driver = entry["source"] == "rendering" and "ReadPixels" in entry["text"]
                self.expect(driver, f"the browser logs: {entry['text']}")
            elif event["method"] == "Network.requestWillBeSent":
                url = parameters["request"]["url"]
                self.expect(url == self.page.as_uri() or url.startswith("data:"), f"fetches {url}")

    def check_sections(self, expected):
        for name in expected:
            self.expect(self.shown(name), f"section {name} is not shown")

    def check_context(self):
        """The views draw with what this mode is to test."""
        kinds = self.ask("""[...document.querySelectorAll('canvas.view')]
            .map((canvas) => canvas.getContext('webgl2') ? 'WebGL' : 'no WebGL')""")
        self.expect(set(kinds) <= {self.mode}, f"views draw with {kinds}")

    def check_drawings(self):
        """Every chart has a line for each series, every map its dots, the timeline its bars."""
        empty = self.ask("""[...document.querySelectorAll('.chart')].filter((chart) => {
            const lines = [...chart.querySelectorAll('.plot path.series')];
            return !lines.length || lines.some((line) => line.getAttribute('d').length < 8);
        }).map((chart) => chart.querySelector('.title').textContent)""")
        self.expect(empty == [], f"charts without data: {empty}")
        empty = self.ask("""[...document.querySelectorAll('.dotted')].filter((figure) =>
            figure.checkVisibility() && !figure.querySelector('circle')
        ).map((figure) => figure.querySelector('.title').textContent)""")
        self.expect(empty == [], f"rows of dots without a dot: {empty}")
        if self.shown("learning"):
            self.expect(self.ask("document.querySelector('#learning .chart') !== null"), "no learning curve")
        if self.shown("map"):
            for design in ("initial", "learned"):
                dots = self.ask(f"document.querySelectorAll('#map .{design} .dot').length")
                self.expect(dots > 0, f"the {design} map has no dot")
        if self.shown("timeline"):
            self.expect(self.ask("""[...document.querySelectorAll('#timeline .plot .bars')]
                .some((bar) => bar.getAttribute('d').length > 8)"""), "the timeline has no bar")

    def check_labels(self):
        """What one can see or use has a name for those who cannot see it."""
        nameless = self.ask("""[...document.querySelectorAll('canvas, button, input, select, [role=img], .dot')]
            .filter((node) => !node.getAttribute('aria-label') && !node.closest('button, label')?.textContent.trim())
            .map((node) => node.outerHTML.slice(0, 80))""")
        self.expect(nameless == [], f"without a label: {nameless}")

    def check_theme(self):
        paper = "getComputedStyle(document.body).backgroundColor"
        self.browser.prefer("light")
        light = self.ask(paper)
        self.browser.prefer("dark")
        dark = self.ask(paper)
        self.expect(light != dark, "looks the same whether the system prefers dark or light")
        self.click("document.getElementById('theme')")
        self.expect(self.ask(paper) == light, "the button does not override the system's dark")
        self.browser.prefer("light")
        self.click("document.getElementById('theme')")
        self.expect(self.ask(paper) == dark, "the button does not override the system's light")
        self.click("document.getElementById('theme')")

    def check_narrow(self):
        self.browser.resize(420, 900)
        self.ask("test.frames(6)")
        wide = self.ask("""[...document.querySelectorAll('body *')]
            .filter((node) => node.getBoundingClientRect().right > 421 && !node.closest('.table, .plots'))
            .map((node) => node.outerHTML.slice(0, 60)).slice(0, 5)""")
        width = self.ask("document.documentElement.scrollWidth")
        self.expect(width <= 420, f"is {width} pixels wide in a window of 420: {wide}")
        self.browser.resize(1000, 700)
        self.ask("test.frames(6)")

    # --- The replay ------------------------------------------------------------------------------------------------

    def check_stills(self):
        """Before anything is played both views show a tool in its colour."""
        for design in ("initial", "learned"):
            if self.ask(f"!document.querySelector('#replay .pane.{design} .empty').hidden"):
                continue
            pixels = self.ask(f"test.coloured(test.canvas('{design}'))")
            self.expect(pixels > 100, f"the {design} view shows {pixels} pixels of a tool")

    def check_lost_graphics(self):
        """Where WebGL is there but dies at once, the stills are drawn without it."""
        self.mode = "lost WebGL"
        has_replay = self.shown("replay")
        self.browser.call("Page.addScriptToEvaluateOnNewDocument", source="""{
            const getContext = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (...options) {
                const context = getContext.apply(this, options);
                if (options[0] === 'webgl2') context?.getExtension('WEBGL_lose_context')?.loseContext();
                return context;
            };
        }""")
        self.open()
        self.expect(self.shown("replay") == has_replay, "the replay is not shown")
        if self.shown("replay"):
            self.check_stills()

    def check_playing(self):
        start = self.ask("test.pixels()")
        self.click("document.querySelector('#replay .play')")
        self.expect(self.ask("test.playing()"), "the play button does not play")
        moved = self.browser.becomes_true(f"test.time() > 0 && test.pixels() !== {start!r}")
        self.expect(moved, "nothing moves while the replay plays")
        first = self.ask("test.pixels()")
        self.expect(self.browser.becomes_true(f"test.pixels() !== {first!r}"), "moves once, then no more")
        self.ask("document.activeElement.blur()")
        self.browser.key(" ", "Space", " ")
        self.ask("test.frames(2)")
        self.expect(not self.ask("test.playing()"), "space does not pause")
        still = self.ask("[test.time(), test.pixels()]")
        self.ask("test.frames(20)")
        self.expect(self.ask("[test.time(), test.pixels()]") == still, "goes on after the pause")

    def check_end(self):
        """Playing stops by itself at the end."""
        self.ask("test.slide(document.querySelector('#replay .scrub'), 0.97 * test.end())")
        self.click("document.querySelector('#replay .play')")
        self.expect(self.browser.becomes_true("!test.playing()"), "does not stop at the end")
        self.expect(abs(self.ask("test.time() - test.end()")) < 0.011, "stops before the end")

    def check_scrubbing(self):
        scrub = "document.querySelector('#replay .scrub')"
        self.ask(f"test.slide({scrub}, 0)")
        self.ask("test.frames(3)")
        start = self.ask("test.pixels()")
        self.ask(f"test.slide({scrub}, 0.5 * test.end())")
        self.ask("test.frames(3)")
        self.expect(abs(self.ask("test.time() / test.end()") - 0.5) < 0.01, "the clock does not follow the slider")
        self.expect(self.ask("test.pixels()") != start, "the views do not follow the slider")
        self.check_cursors()
        before = self.ask("test.time()")
        self.ask("document.activeElement.blur()")
        self.browser.key("ArrowRight")
        self.expect(self.ask("test.time()") > before, "the right arrow key does not step on")
        self.ask(f"test.slide({scrub}, 0)")
        self.ask("test.frames(3)")
        self.expect(self.ask("test.pixels()") == start, "the same time does not look the same again")

    def check_cursors(self):
        """The time cursors of the plots stand at half of their axes, which begin at 0 and end with the replay."""
        off = self.ask("""[...document.querySelectorAll('#replay .chart')].filter((chart) => {
            const [line, cursor] = [chart.querySelector('.axes line'), chart.querySelector('.cursor')];
            const [low, high] = ['x1', 'x2'].map((name) => Number(line.getAttribute(name)));
            const share = (Number(cursor.getAttribute('x1')) - low) / (high - low);
            return getComputedStyle(cursor).visibility !== 'visible' || Math.abs(share - 0.5) > 0.02;
        }).length""")
        self.expect(off == 0, f"{off} plots have their time cursor elsewhere")

    def check_turning(self):
        """A drag in one view turns both."""
        before = self.ask("['initial', 'learned'].map((design) => test.canvas(design).toDataURL())")
        x, y = self.ask("test.middle(test.canvas('learned'))")
        self.browser.mouse("mousePressed", x, y)
        self.browser.mouse("mouseMoved", x + 60, y + 10)
        self.browser.mouse("mouseReleased", x + 60, y + 10)
        self.ask("test.frames(3)")
        after = self.ask("['initial', 'learned'].map((design) => test.canvas(design).toDataURL())")
        self.expect(before[1] != after[1], "a drag does not turn the view")
        both = self.ask("[...document.querySelectorAll('#replay .pane .empty')].every((node) => node.hidden)")
        self.expect(not both or before[0] != after[0], "the other view does not turn with it")

    def check_forces(self):
        """Where forces are largest there are arrows, which can be switched off."""
        time = self.ask("test.timeOfForce()")
        if time is None:
            return
        self.ask(f"test.slide(document.querySelector('#replay .scrub'), {time})")
        self.ask("test.frames(3)")
        with_forces = self.ask("test.pixels()")
        self.ask("document.querySelector('#replay input[type=checkbox]').click()")
        self.ask("test.frames(3)")
        self.expect(self.ask("test.pixels()") != with_forces, f"no force is drawn at {time} s, where it is largest")
        self.ask("document.querySelector('#replay input[type=checkbox]').click()")

    # --- Map and shape ---------------------------------------------------------------------------------------------

    def check_map(self):
        if self.ask("test.openDot(true) !== undefined"):
            before = self.ask("[test.ids(), test.pixels()]")
            self.click("test.openDot(true)")
            self.ask("test.frames(3)")
            after = self.ask("[test.ids(), test.pixels()]")
            self.expect(before[0] != after[0], "a click on the map changes no id of the replay")
            self.expect(before[1] != after[1], "a click on the map changes no picture of the replay")
            self.expect(self.ask("test.playing()"), "the variation clicked on does not play")
            self.expect(self.ask("document.querySelector('#replay .notice').hidden"),
                        "a recorded dot is called missing")
        if self.ask("test.openDot(false) !== undefined"):
            row = self.ask("test.openDot(false).dataset.row")
            self.click("test.openDot(false)")
            self.ask("test.frames(3)")
            notice = self.ask("document.querySelector('#map .details').textContent")
            self.expect(f"Variation {row}" in notice and "not recorded" in notice,
                        f"a dot without recording does not say so: {notice}")

    def check_map_keys(self):
        self.ask("document.querySelector('#map .learned .dot[tabindex=\"0\"]').focus()")
        row = "document.activeElement.dataset.row"
        before = self.ask(row)
        reached = [self.press(key, row) for key in ("ArrowRight", "ArrowLeft", "ArrowUp", "ArrowDown")]
        alone = self.ask("document.querySelectorAll('#map .learned .dot').length === 1")
        self.expect(alone or any(other != before for other in reached), "arrow keys move to no other dot")
        self.browser.key("Enter", text="\r")
        self.expect(self.ask(f"document.querySelector('#map .details strong').textContent === `Variation ${{{row}}}`"),
                    "Enter does not choose the dot")
        self.ask("document.querySelector('#replay button.choose')?.click()")

    def press(self, key, expression):
        self.browser.key(key)
        return self.ask(expression)

    def check_shape(self):
        rows = self.ask("document.querySelectorAll('#shape .row').length")
        self.expect(rows > 0, "no parameter is shown")
        last = self.ask("test.image()")
        values = "[...document.querySelectorAll('#shape .value')].map((node) => node.textContent).join()"
        learned = self.ask(values)
        self.ask("test.slide(document.querySelector('#shape .steps'), 0)")
        self.ask("test.frames(3)")
        self.expect(self.ask(values) != learned, "the slider of batches changes no parameter")
        if last is None:
            return
        self.expect(self.ask("test.image()") != last, "the slider of batches changes no shape")
        if self.ask("!document.querySelector('#shape .row input').disabled"):
            initial = self.ask("test.image()")
            self.ask("""{
                const input = document.querySelector('#shape .row input');
                test.slide(input, input.value === input.max ? input.min : input.max);
            }""")
            self.ask("test.frames(3)")
            self.expect(self.ask("test.image()") != initial, "trying a parameter changes no shape")

    def check_comparison(self):
        """A dot a run and group in the first drawing, a row a group in the table; parameters open."""
        groups, runs = self.ask("""(() => {
            const { groups } = JSON.parse(document.getElementById('data').textContent).comparison;
            const rated = (run) => run.test.success_rate ?? run.test.loss_mean;
            return [groups.length, groups.flatMap((one) => one.runs).filter((run) => rated(run) !== null).length];
        })()""")
        dots = self.ask("document.querySelector('#comparison .dotted').querySelectorAll('circle').length")
        self.expect(dots == runs, f"{dots} dots for {runs} runs")
        rows = self.ask("document.querySelectorAll('#comparison tbody tr').length")
        self.expect(rows == groups, f"{rows} rows for {groups} groups")
        if self.ask("document.querySelector('#comparison details') !== null"):
            self.ask("document.querySelector('#comparison summary').click()")
            self.ask("test.frames(6)")
            names = self.ask("JSON.parse(document.getElementById('data').textContent).theta.names.length")
            drawn = self.ask("document.querySelectorAll('#comparison details .dotted circle').length")
            self.expect(drawn > 0 and drawn % names == 0, f"{drawn} dots for {names} parameters")

    # --- All -------------------------------------------------------------------------------------------------------

    def check_uses(self):
        if self.shown("replay"):
            self.check_stills()
            self.check_playing()
            self.check_end()
            self.check_scrubbing()
            self.check_turning()
            self.check_forces()
        if self.shown("map") and self.shown("replay"):
            self.check_map()
            self.check_map_keys()
        if self.shown("shape"):
            self.check_shape()
        if self.shown("comparison"):
            self.check_comparison()


def check_text(page):
    """What can be read off the file itself."""
    text = page.read_text()
    failures = []
    size = page.stat().st_size
    if size > LARGEST_FILE:
        failures.append(f"{size} bytes, more than {LARGEST_FILE}")
    if "default-src 'none'" not in text:
        failures.append("no content security policy")
    own = re.sub(r'<script type="application/json".*?</script>', "", text, flags=re.S)
    failures += [f"an address: {found}" for found in re.findall(r"\b(?:https?|wss?|ftp)://[^\s\"'<]*", own)]
    failures += [f"a reference: {found}" for found in re.findall(r"(?:src|href)=[\"'](?!#|data:)[^\"']*", own)]
    failures += [f"a style reference: {found}" for found in re.findall(r"@import[^;]*|url\((?!data:)[^)]*", own)]
    return failures


def check_globals(browser, page):
    """The page's script leaves one name behind; an empty page from disk has all that the browser gives."""
    names = "Object.getOwnPropertyNames(window)"
    with tempfile.NamedTemporaryFile(suffix=".html") as empty:
        browser.open(pathlib.Path(empty.name).as_uri())
        before = set(browser.evaluate(names))
    browser.open(page.as_uri())
    added = set(browser.evaluate(names)) - before
    return [] if added == {"knap"} else [f"names besides knap: {sorted(added - {'knap'})}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("chromium")
    parser.add_argument("report", type=pathlib.Path)
    parser.add_argument("--expect", default="", help="sections that must be there, separated by commas")
    arguments = parser.parse_args()
    page = arguments.report.resolve()
    failures = check_text(page)
    for mode, options in (("WebGL", WEBGL), ("no WebGL", NO_WEBGL)):
        with Chromium(arguments.chromium, *options) as browser:
            checks = Checks(browser, page, mode)
            checks.open()
            checks.check_context()
            checks.check_sections([name for name in arguments.expect.split(",") if name])
            checks.check_drawings()
            checks.check_labels()
            checks.check_uses()
            checks.check_theme()
            checks.check_narrow()
            checks.check_drawings()
            checks.check_silence()
            if mode == "WebGL":
                checks.check_lost_graphics()
                failures += check_globals(browser, page)
            failures += checks.failures
    for failure in failures:
        print(f"{arguments.report.name}: {failure[:400]}")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
