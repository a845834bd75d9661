"""Uses the page of `perirobot plan` in a headless Chromium as a person would: drags, aims, types, undoes, saves.

    python3 planner.py ADDRESS

The address is the one that the command prints, with the token. Prints the counts that the page shows at the end, as JSON: those
of a sweep of the saved study.
"""

import json
import sys

from driver import Browser

CONTROL, SHIFT, ESCAPE, DELETE, ENTER = "\ue009", "\ue008", "\ue00c", "\ue017", "\ue007"
UP, RIGHT = "\ue013", "\ue014"
COUNTED = ("unknown", "seen", "missed", "false")


class Page:
    """The planner's page in a browser."""

    def __init__(self, browser, address):
        self.browser = browser
        browser.visit(address)
        browser.until("return document.body.dataset.ready === 'yes' || !document.getElementById('failure').hidden", "the page")
        self.rest()

    def rest(self):
        """Waits until nothing is dragged, edited or counted; what is shown then is exact."""
        self.browser.until("return document.body.dataset.busy === '' && !document.body.planner.draft", "a rest", 60)
        self.browser.until("return document.body.dataset.voxel === 'fine'", "the study's voxels", 60)

    def known(self, what):
        """A part of what the page knows."""
        return self.browser.run(f"const {{ planner }} = document.body; return planner.{what}")

    def placed(self):
        return self.known("state.placed")

    def counts(self):
        """The counts of the chosen region, as they stand on the page."""
        return {name: int(self.browser.run(f"return document.getElementById('count-{name}').dataset.value")) for name in COUNTED}

    def click(self, id):
        self.browser.run("document.getElementById(arguments[0]).click()", id)

    def place(self, at_m, tab="view"):
        """Where a place of the cell is in the window."""
        return self.browser.run(
            """const home = document.getElementById(arguments[1]), { left, top } = home.getBoundingClientRect();
            const [x, y] = arguments[1] === 'view' ? home.stage.place(arguments[0]) : home.place(arguments[0]);
            return [left + x, top + y]""",
            at_m,
            tab,
        )

    def drag(self, index, pixels, tab="view", **more):
        """Drags a sensor by pixels in some steps; the order is that of the plan."""
        x, y = self.place(self.placed()[index]["at_m"], tab)
        steps = [(x + pixels[0] * n / 8, y + pixels[1] * n / 8) for n in range(9)]
        self.browser.drag(steps, **more)


def a_drag_is_counted_and_undone(page):
    before, n = page.placed()[0], int(page.browser.run("return document.body.dataset.n"))
    page.drag(0, (90, 30), is_dropped=False)
    page.browser.until(f"return Number(document.body.dataset.n) > {n}", "counts while dragging")
    assert page.known("draft") and page.placed()[0] == before, "the study changes when it is let go"
    page.browser.drop()
    page.rest()
    after = page.placed()[0]
    assert after["at_m"] != before["at_m"] and page.known("answer.isDraft") is False, (before, after)
    assert all(round(x, 3) == x for x in after["at_m"]), after
    page.click("undo")
    page.rest()
    assert page.placed()[0]["at_m"] == before["at_m"], (before, page.placed()[0])
    page.click("redo")
    page.rest()
    assert page.placed()[0]["at_m"] == after["at_m"], (after, page.placed()[0])


def escape_ends_a_drag(page):
    before = page.placed()[0]
    page.drag(0, (-60, 40), is_dropped=False)
    page.browser.press(ESCAPE)
    page.browser.drop()
    page.rest()
    assert page.placed()[0] == before, (before, page.placed()[0])


def keys_are_enough(page):
    """A sensor is chosen, moved, turned, copied and removed without a mouse."""
    count = len(page.placed())
    page.browser.run("document.getElementById('sensor-0').focus()")
    before = page.placed()[0]
    page.browser.press(ENTER)
    assert page.browser.run("return document.activeElement.id") == "pose-x"
    page.browser.press(UP)
    page.browser.press(UP)
    page.browser.until("return document.body.planner.draft === null", "the edit")
    page.rest()
    moved = page.placed()[0]["at_m"][0] - before["at_m"][0]
    assert abs(moved - 0.1) < 1e-6, moved
    page.browser.press(ESCAPE)
    page.browser.press("d")
    page.browser.until(f"return document.body.planner.state.placed.length === {count + 1}", "the copy", 30)
    page.rest()
    page.browser.press(DELETE)
    page.browser.until(f"return document.body.planner.state.placed.length === {count}", "one less", 30)
    page.rest()


def the_plan_edits_the_same(page):
    page.click("tab-plan")
    page.browser.until("return !!document.querySelector('#plan .badge')", "the floor plan")
    before = page.placed()[0]
    page.drag(0, (30, 0), "plan")
    page.rest()
    assert page.placed()[0]["at_m"] != before["at_m"], before
    page.browser.press("z", CONTROL)
    page.rest()
    assert page.placed()[0]["at_m"] == before["at_m"], before


def main():
    with Browser(has_network=True) as browser:
        browser.size(1440, 900)
        page = Page(browser, sys.argv[1])
        a_drag_is_counted_and_undone(page)
        escape_ends_a_drag(page)
        keys_are_enough(page)
        said = [entry["message"] for entry in browser.log("browser") if entry["level"] == "SEVERE"]
        assert not said, said
        page.click("save")
        browser.until("return !!document.getElementById('save-now')", "the difference", 30)
        page.click("save-now")
        browser.until("return document.body.planner.state.changed === false", "the saved study", 30)
        print(json.dumps(page.counts()))
    with Browser(has_webgl=False, has_network=True) as browser:
        browser.size(1440, 900)
        page = Page(browser, sys.argv[1])
        assert browser.run("return document.getElementById('tab-3d').hidden && document.body.dataset.tab === 'plan'")
        the_plan_edits_the_same(page)


if __name__ == "__main__":
    main()
