"""Uses the page of `perirobot plan` in a headless Chromium as a person would: drags, aims, types, undoes, saves.

    python3 planner.py opened ADDRESS
    python3 planner.py used ADDRESS
    python3 planner.py chosen ADDRESS
    python3 planner.py left ADDRESS
    python3 planner.py shared ADDRESS
    python3 planner.py found ADDRESS [FOLDER]
    python3 planner.py ended ADDRESS PROCESS
    python3 planner.py strangers ADDRESS
    python3 planner.py speed ADDRESS
    python3 planner.py pictures ADDRESS FOLDER

The address is the one that the command prints, with the token. `opened` looks at all that is shown first. `used` saves the study, and prints the counts that the page
shows then, as JSON: those of a sweep of the saved study. `chosen` takes a
template of the page without a study; the folder `palletiser` is taken. `left` makes a report and mounting sheets. `shared` uses two windows at once. `found` searches for the cheapest
set of the template palletiser, stops it, and takes a set; then it places a sensor badly; with a folder it draws what it sees there. `ended` ends the planner, by its process number, in the middle of a
drag. `strangers` asks from pages of other origins. `speed` prints how soon pictures follow the pointer. `pictures` draws those
of the guide, of the template palletiser.
"""

import http.server
import json
import math
import os
import signal
import statistics
import sys
import threading
import time

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


def object_of(page, name):
    """An object of the first scene file, as the page knows it."""
    return next(one for one in page.known("state.scene_files[0].objects") if one["name"] == name)


def a_person_is_moved(page):
    """The operator is dragged and turned on the floor plan, and moved by the keyboard alone; undo takes each back."""
    page.click("tab-plan")
    page.browser.until("return !!document.querySelector('#plan .person.drags')", "the person")
    before, worlds = object_of(page, "operator"), page.known("state.worlds")
    x, y = page.place(before["positions_m"][0], "plan")
    page.browser.drag([(x + 5 * n, y - 4 * n) for n in range(9)], is_dropped=False)
    assert page.known("carry.at.position_m") != before["positions_m"][0] and object_of(page, "operator") == before
    page.browser.drop()
    page.browser.until("return document.body.planner.carry === null", "the edit", 30)
    page.rest()
    moved = object_of(page, "operator")
    assert moved["positions_m"][0] != before["positions_m"][0] and moved["positions_m"][1:] == before["positions_m"][1:]
    assert page.known("state.worlds") == worlds + 1, "the scene is voxelized anew"
    handle = """const { left, top, width, height } = document.getElementById('object-turn').getBoundingClientRect();
        return [left + width / 2, top + height / 2]"""
    x, y = page.browser.run(handle)
    page.browser.drag([(x, y - 6 * n) for n in range(9)])
    page.browser.until("return document.body.planner.carry === null", "the edit", 30)
    page.rest()
    turned = object_of(page, "operator")
    assert turned["yaws_deg"][0] != moved["yaws_deg"][0] and turned["positions_m"] == moved["positions_m"], turned
    page.browser.run("document.querySelector('#objects details').open = true; document.querySelector('#object-list [aria-selected=true]').focus()")
    page.browser.press(ENTER)
    assert page.browser.run("return document.activeElement.id") == "place-x"
    page.browser.press(UP)
    page.browser.until("return document.body.planner.carry === null", "the edit", 30)
    page.rest()
    assert abs(object_of(page, "operator")["positions_m"][0][0] - turned["positions_m"][0][0] - 0.05) < 1e-6
    for expected in (turned, moved, before):
        page.click("undo")
        page.rest()
        assert object_of(page, "operator") == expected, expected
    for _ in range(3):
        page.click("redo")
        page.rest()
    page.click("tab-3d")


def a_curtain_is_moved(page):
    """The curtain of the study is added, dragged with its zone by its letter, and made longer at one end."""
    shape = "state.sensors.find(one => one.name === 'curtain').shape"
    page.click("tab-plan")
    page.click("add")
    page.browser.run("[...document.querySelectorAll('#models .model')].find(one => one.textContent.startsWith('curtain')).click()")
    page.browser.until("return !!document.getElementById('zone-box-1')", "its handles", 30)
    page.rest()
    before = page.known(shape)
    middle = [(low + high) / 2 for low, high in zip(before["box"]["min_m"], before["box"]["max_m"])]
    x, y = page.place(middle, "plan")
    page.browser.drag([(x + 4 * n, y + 5 * n) for n in range(9)])
    page.browser.until(f"return document.body.planner.{shape}.box.min_m[1] < {before['box']['min_m'][1]}", "the edit", 30)
    page.rest()
    moved = page.known(shape)
    for part in ("box", "zone"):
        for end in ("min_m", "max_m"):
            by = [new - old for new, old in zip(moved[part][end], before[part][end])]
            assert by[0] > 0.1 and by[1] < -0.1 and by[2] == 0, by
    x, y = page.browser.run("""const { left, top, width, height } = document.getElementById('zone-box-1').getBoundingClientRect();
        return [left + width / 2, top + height / 2]""")
    page.browser.drag([(x - 5 * n, y + 3 * n) for n in range(9)])
    page.browser.until(f"return document.body.planner.{shape}.box.max_m[0] < {moved['box']['max_m'][0]}", "the edit", 30)
    page.rest()
    shorter = page.known(shape)
    moved["box"]["max_m"][0] = shorter["box"]["max_m"][0]
    assert shorter == moved, (shorter, moved)
    page.click("tab-3d")


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


def opened(address):
    with Browser(has_network=True) as browser:
        browser.size(1440, 900)
        page = Page(browser, address)
        browser.until("return document.body.dataset.judged !== undefined", "verdicts", 300)
        browser.until("return document.body.dataset.moments === document.body.dataset.n", "all moments", 300)
        page.click("tab-plan")
        browser.until("return !!document.querySelector('#plan .badge, #plan rect')", "the floor plan")
        assert sum(page.counts().values()) > 0, page.counts()
        assert browser.run("return document.getElementById('failure').hidden")
        said = [entry["message"] for entry in browser.log("browser") if entry["level"] == "SEVERE"]
        assert not said, said


def used(address):
    with Browser(has_network=True) as browser:
        browser.size(1440, 900)
        page = Page(browser, address)
        a_drag_is_counted_and_undone(page)
        escape_ends_a_drag(page)
        keys_are_enough(page)
        a_person_is_moved(page)
        a_curtain_is_moved(page)
        said = [entry["message"] for entry in browser.log("browser") if entry["level"] == "SEVERE"]
        assert not said, said
        page.click("save")
        browser.until("return !!document.getElementById('save-now')", "the difference", 30)
        page.click("save-now")
        browser.until("return document.body.planner.state.changed === false", "the saved study", 30)
        print(json.dumps(page.counts()))
    with Browser(has_webgl=False, has_network=True) as browser:
        browser.size(1440, 900)
        page = Page(browser, address)
        assert browser.run("return document.getElementById('tab-3d').hidden && document.body.dataset.tab === 'plan'")
        the_plan_edits_the_same(page)


def type_number(page, id, value):
    page.browser.run("const home = document.getElementById(arguments[0]); home.value = arguments[1]; home.dispatchEvent(new Event('change'))", id, str(value))


def text(page, id):
    return page.browser.run("return document.getElementById(arguments[0]).textContent", id)


def a_search_shows_what_it_finds(page, draw):
    """Sets and the bound come while it searches; a stop keeps them; a click takes a set."""
    browser = page.browser
    before = page.placed()
    page.click("find")
    type_number(page, "find-budget", 12345)
    page.rest()
    browser.until("return document.body.planner.state.budget === 12345", "the budget", 30)
    browser.until("return document.getElementById('money').textContent.includes('12,345')", "the status bar", 10)
    browser.run("document.getElementById('find-keep').checked = false")
    page.click("find-begin")
    browser.until("return document.body.dataset.finding === 'yes'", "the search", 10)
    browser.until("return document.querySelectorAll('#front circle').length > 0", "a set", 400)
    assert browser.run("return document.body.dataset.finding") == "yes", "the set comes before the end"
    said = text(page, "find-words")
    assert "found" in said and "none below" in said and "tested" in said, said
    browser.until("return !!document.querySelector('#front path.bound') && !!document.querySelector('#front path.own')", "the bound and today's plan", 120)
    draw("find.png")
    page.click("find-stop")
    browser.until("return !document.body.dataset.finding", "the end", 120)
    assert browser.run("return document.querySelectorAll('#found button').length") > 0, "a stop keeps what was found"
    said = text(page, "find-words")
    assert "No set of the listed poses that passes costs less than" in said, said
    browser.run("document.querySelector('#front circle').dispatchEvent(new MouseEvent('click', { bubbles: true }))")
    browser.until("return document.body.planner.state.can_undo && document.body.dataset.busy === ''", "the set", 30)
    page.rest()
    assert page.placed() != before, before
    page.click("undo")
    page.rest()
    assert page.placed() == before, page.placed()
    page.click("find-close")


def verdicts_name_letters(page, draw):
    """Verdicts say B (camera), not camera:planned/1, and the page explains their conditions."""
    page.browser.until("return document.querySelectorAll('#requirements li').length > 0", "verdicts", 300)
    said = text(page, "requirements")
    poses = [f"{one['sensor']}:{one['pose']}" for one in page.placed()]
    assert not any(pose in said for pose in poses), said
    assert "parts_detected" not in said and "As planned" in text(page, "conditions"), said
    assert page.browser.run("return !!document.querySelector('#requirements abbr[title]')")
    page.browser.run("document.getElementById('verdicts').scrollIntoView()")
    draw("verdicts.png")


def bad_places_are_told(page, draw):
    """A sensor in mid-air, outside of the cell: the inspector says so and what to do; what is below it does not jump."""
    browser = page.browser
    (x0, y0, _), (x1, y1, z1) = page.known("state.scenes[0].room_m")
    browser.run("document.getElementById('sensor-0').focus()")
    top = "return document.getElementById('pose').getBoundingClientRect().top"
    before = browser.run(top)
    room = page.known("state.scenes[0].things")
    free = next(
        (x, y)
        for x in (x0 + (x1 - x0) * n / 20 for n in range(3, 18))
        for y in (y0 + (y1 - y0) * n / 20 for n in range(3, 18))
        if not any(one["low_m"][0] - 0.6 < x < one["high_m"][0] + 0.6 and one["low_m"][1] - 0.6 < y < one["high_m"][1] + 0.6 for one in room)
    )
    for id, value in zip(("pose-x", "pose-y", "pose-z"), (*free, z1 / 2)):
        type_number(page, id, round(value, 3))
        page.rest()
    browser.until("return !document.getElementById('chosen-problem').hidden", "the warning", 60)
    said = text(page, "chosen-problem")
    assert "mid-air" in said and "wall" in said, said
    draw("mid-air.png")
    type_number(page, "pose-x", x1 + 40)
    page.rest()
    browser.until("return document.getElementById('chosen-problem').textContent.includes('outside')", "the warning", 60)
    for _ in range(4):
        page.click("undo")
        page.rest()
    assert browser.run(top) == before, "the numbers stay where they are"


def poses_at_a_dot_are_listed(page, draw):
    """Several poses at one dot of the floor plan are a list, the highest first."""
    browser = page.browser
    page.click("tab-plan")
    page.click("add")
    browser.run("[...document.querySelectorAll('#models button')].find(one => one.querySelector('strong').textContent === 'camera').click()")
    browser.until("return [...document.querySelectorAll('#plan .dot')].some(one => one.textContent.includes('camera'))", "the dots of the camera")
    many = browser.run(
        """const middle = dot => { const { left, top, width, height } = dot.getBoundingClientRect(); return [left + width / 2, top + height / 2]; };
        // Not one below the badge of a sensor.
        const dot = [...document.querySelectorAll('#plan .dot')].find(one => /^[0-9]+ poses/.test(one.textContent) && document.elementFromPoint(...middle(one)) === one);
        return dot ? middle(dot) : null"""
    )
    assert many, "a dot with several poses"
    browser.click(*many)
    browser.until("return !document.getElementById('pose-list').hidden", "the list of poses", 30)
    heights = browser.run("return [...document.querySelectorAll('#poses-here strong')].map(one => parseFloat(one.textContent))")
    assert len(heights) > 1 and heights == sorted(heights, reverse=True), heights
    draw("poses.png")
    count = len(page.placed())
    browser.run("document.querySelector('#poses-here button:not(:disabled)').click()")
    browser.until(f"return document.body.planner.state.placed.length === {count + 1}", "the sensor", 30)
    page.rest()
    page.click("undo")
    page.rest()


def arm(page, sensor):
    """Takes a sensor of the study to be placed."""
    page.click("add")
    page.browser.run("[...document.querySelectorAll('#models button')].find(one => one.querySelector('strong').textContent === arguments[0]).click()", sensor)
    page.browser.until("return !!document.body.planner.armed", "the sensor that is held")


def a_held_sensor_takes_the_pose_of_a_dot(page):
    """In 3D, where the held sensor is drawn under the pointer, and so above the dot."""
    browser = page.browser
    page.click("tab-3d")
    arm(page, "camera")
    listed = {tuple(pose["at_m"]) for sensor in page.known("state.sensors") if sensor["name"] == "camera" for pose in sensor["poses"]}
    x, y = browser.run(
        """const { stage } = document.getElementById('view'), dots = stage.parts.get('pose dots'), { left, top } = stage.canvas.getBoundingClientRect();
        const all = Array.from({ length: dots.at.length / 3 }, (_, n) => stage.place(dots.at.slice(3 * n, 3 * n + 3)));
        const middle = all.find(([x, y]) => x > 300 && x < stage.canvas.clientWidth - 300 && y > 100 && y < stage.canvas.clientHeight - 100);
        return [left + middle[0], top + middle[1]]"""
    )
    count = len(page.placed())
    browser.click(x, y)
    if not browser.run("return document.getElementById('pose-list').hidden"):
        browser.run("document.querySelector('#poses-here button:not(:disabled)').click()")
    browser.until(f"return document.body.planner.state.placed.length === {count + 1}", "the sensor", 30)
    page.rest()
    taken = page.placed()[page.known("selected")]
    assert tuple(taken["at_m"]) in listed and not taken["pose"].startswith("planned"), taken


def a_click_on_the_plan_aims(page):
    """The chosen camera, and back."""
    page.click("tab-plan")
    browser, index = page.browser, page.known("selected")
    before = page.placed()[index]
    browser.run("document.querySelector('#tools [data-tool=aim]').click()")
    (x0, y0, z0), (x1, y1, _) = page.known("state.scenes[0].room_m")
    target = [x0 + 0.62 * (x1 - x0), y0 + 0.38 * (y1 - y0), z0 + 1]
    browser.click(*page.place(target, "plan"))
    browser.until(f"return JSON.stringify(document.body.planner.state.placed[{index}].turned_deg) !== arguments[0]".replace("arguments[0]", json.dumps(json.dumps(before["turned_deg"], separators=(",", ":")))), "another direction", 30)
    page.rest()
    after = page.placed()[index]
    dx, dy = target[0] - after["at_m"][0], target[1] - after["at_m"][1]
    pan = math.degrees(math.atan2(dy, dx))
    assert after["at_m"] == before["at_m"] and abs((after["turned_deg"][0] - pan + 180) % 360 - 180) < 3, (after, pan)
    browser.press("w")
    page.click("undo")
    page.rest()
    assert page.placed()[index] == before, page.placed()[index]


def unknown_noise_is_asked_about(page):
    """A device of unknown noise joins after a question; one undo takes it and the key of the study away."""
    browser = page.browser
    page.click("tab-plan")
    model = next(one["model"] for one in page.known("state.catalogue") if one["mixes_noise"])
    page.click("add")
    type_number(page, "model-cost", 900)
    browser.run("[...document.querySelectorAll('#models button')].find(one => one.querySelector('strong').textContent === arguments[0]).click()", model)
    browser.until("return !!document.getElementById('mix-noise')", "the question", 30)
    count = len(page.placed())
    page.click("mix-noise")
    browser.until("return !!document.body.planner.armed && !!document.body.planner.draft", "the device that is held", 30)
    browser.press(ENTER)
    browser.until(f"return document.body.planner.state.placed.length === {count + 1}", "the device", 60)
    page.rest()
    written = browser.run("return fetch('/text', { headers: { 'X-Perirobot-Token': location.hash.replace(/^#(token=)?/, '') } }).then(answer => answer.json()).then(({ text }) => text)")
    assert "mixed_noise = true" in written, written[:600]
    page.click("undo")
    page.rest()
    assert len(page.placed()) == count
    assert not browser.run("return document.body.planner.state.sensors.some(one => one.model === arguments[0])", model)


def errors_name_the_fields_of_the_page(page):
    browser = page.browser
    page.click("find")
    browser.run("document.getElementById('find-keep').checked = false; document.getElementById('find-budget').value = '1'")
    page.click("find-begin")
    browser.until("return document.getElementById('find-words').textContent.startsWith('Budget 1 is below the ')", "the reason", 60)
    assert page.known("state.path") not in text(page, "find-words"), text(page, "find-words")
    page.click("find-close")
    assert browser.run("return document.activeElement.id") == "find", "the focus goes back"


def a_typed_place_is_asked_about(page):
    """Why, by the keyboard alone; its card is closed and the focus is where it was."""
    browser = page.browser
    browser.press("q")
    for axis, value in zip("xyz", (1.5, 1.25, 1.0)):
        browser.run("document.getElementById(arguments[0]).value = arguments[1]", f"why-{axis}", str(value))
    browser.run("document.getElementById('why-z').focus()")
    browser.press(ENTER)
    browser.until("return document.querySelectorAll('#why-words li').length === document.body.planner.state.placed.length", "an answer for each sensor", 30)
    assert page.known("why.at_m") == [1.5, 1.25, 1], page.known("why.at_m")
    browser.run("document.querySelector('#why [data-closes-tool]').click()")
    assert browser.run("return document.getElementById('why').hidden && document.activeElement.dataset.tool === 'why'")


def found(address, folder=None):
    with Browser(has_network=True) as browser:
        browser.size(1440, 900)
        page = Page(browser, address)
        browser.until("return document.body.dataset.judged !== undefined", "verdicts", 300)

        def draw(name):
            if folder:
                browser.picture(os.path.join(folder, name))

        verdicts_name_letters(page, draw)
        bad_places_are_told(page, draw)
        browser.until("return document.body.dataset.judged === document.body.dataset.n", "verdicts", 300)
        a_search_shows_what_it_finds(page, draw)
        poses_at_a_dot_are_listed(page, draw)
        a_held_sensor_takes_the_pose_of_a_dot(page)
        a_click_on_the_plan_aims(page)
        a_typed_place_is_asked_about(page)
        unknown_noise_is_asked_about(page)
        errors_name_the_fields_of_the_page(page)
        said = [entry["message"] for entry in browser.log("browser") if entry["level"] == "SEVERE"]
        assert not said, said


def ended(address, process):
    """The planner ends while a sensor is dragged: the page says so, and lets nothing be edited."""
    with Browser(has_network=True) as browser:
        browser.size(1440, 900)
        page = Page(browser, address)
        page.drag(0, (60, 20), is_dropped=False)
        os.kill(int(process), signal.SIGKILL)
        browser.drop()
        browser.until("return document.body.dataset.lost === 'yes'", "the banner", 30)
        assert not browser.run("return document.getElementById('banner').hidden")
        assert browser.run("return document.getElementById('save').disabled && document.getElementById('undo').disabled")


def chosen(address):
    """A template is written by a click, unless a file is in the way, and the same window shows its planner."""
    with Browser(has_network=True) as browser:
        browser.visit(address)
        browser.until("return document.body.dataset.ready === 'yes'", "the templates")
        count, sketches = browser.run("return [document.querySelectorAll('article').length, document.querySelectorAll('.sketch svg .badge').length]")
        assert count == 5 and sketches >= 5, (count, sketches)
        browser.run("document.getElementById('open-palletiser').click()")
        browser.until("return !document.getElementById('complaint').hidden", "words")
        words = browser.run("return document.getElementById('complaint').textContent")
        assert "exists and would be overwritten" in words, words
        browser.run("document.getElementById('folder-palletiser').value = './second'; document.getElementById('open-palletiser').click()")
        browser.until("return document.body.dataset.version !== undefined", "the planner")
        browser.until("return document.body.dataset.ready === 'yes'", "the planner")
        assert browser.run("return document.getElementById('study').textContent") == "study.toml"


def left(address):
    """A report and mounting sheets of what the page shows are a click away, in a tab that needs no token."""
    base = address.split("/#")[0]
    with Browser(has_network=True) as browser:
        page = Page(browser, address)
        page.click("copy")
        page.rest()
        papers = {}
        # A tab that is opened would hide this one, and pages that are hidden draw nothing.
        browser.run("window.open = (...words) => { document.body.dataset.opened = words.join(' '); return null; }")
        for kind in ("report", "sheets"):
            page.click(kind)
            browser.until("return document.getElementById('paper-link')", kind, 120)
            assert "not saved" in browser.run("return document.getElementById('paper-unsaved').textContent")
            papers[kind] = browser.run("return document.getElementById('paper-link').getAttribute('href')")
            assert browser.run("return document.body.dataset.opened") == f"{papers[kind]} _blank noopener"
            browser.run("document.getElementById('dialog').close()")
        placed = page.placed()
        # Nothing asks whether to leave the page.
        page.click("undo")
        page.rest()
        for kind, path in papers.items():
            browser.visit(base + path)
            browser.until("return document.readyState === 'complete' && !document.body.dataset.waits", kind)
            captions = browser.run("return [...document.querySelectorAll('.mount caption')].map(one => one.textContent)")
            assert captions == [f"Mounting sheet {one['letter']}: {one['sensor']}, {one['pose']}" for one in placed], (captions, placed)
        browser.visit(base + papers["report"])
        browser.until("return document.getElementById('view')?.stage", "the 3D view of the report")
        words = browser.run("return [...document.getElementById('view').stage.parts.keys()]")
        assert "sensors: own names" in words, words


def shared(address):
    """A change on an older version is refused, and the window shows the newer one."""
    with Browser(has_network=True) as first, Browser(has_network=True) as second:
        one, other = Page(first, address), Page(second, address)
        # The other window does not look by itself meanwhile.
        second.run("Object.defineProperty(document, 'hidden', { value: true })")
        count = len(one.placed())
        one.click("copy")
        first.until(f"return document.body.planner.state.placed.length === {count + 1}", "a copy", 30)
        one.rest()
        assert len(other.placed()) == count
        other.click("remove")
        second.until("return document.getElementById('notice').textContent.includes('another window has changed the study')", "words", 30)
        other.rest()
        assert len(other.placed()) == len(one.placed()) == count + 1, (other.placed(), one.placed())
        other.click("remove")
        second.until(f"return document.body.planner.state.placed.length === {count}", "a sensor less", 30)


# What a page of another origin may try: to read, and to write, as a form or as a script does.
TRIES = """
const outcomes = [], tries = [
  [`${address}/state`, {}],
  [`${address}/state`, { mode: "no-cors" }],
  [`${address}/edit`, { method: "POST", mode: "no-cors", body: '{"edit":"remove","index":0}' }],
  [`${address}/edit`, { method: "POST", headers: { "X-Perirobot-Token": token, "Content-Type": "application/json" }, body: '{"edit":"remove","index":0}' }],
];
for (const [url, how] of tries) {
  try { const answer = await fetch(url, how); outcomes.push(answer.type === "opaque" ? "opaque" : String(answer.status)); }
  catch (error) { outcomes.push("refused"); }
}
return outcomes;
"""


def strangers(address):
    """A page of another origin reads nothing and changes nothing, even if it knew the token."""
    base, token = address.split("/#")

    class Quiet(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>stranger</title>")

        def log_message(self, *_):
            pass

    stranger = http.server.HTTPServer(("127.0.0.1", 0), Quiet)
    threading.Thread(target=stranger.serve_forever, daemon=True).start()
    with Browser(has_network=True) as browser:
        page = Page(browser, address)
        before = page.placed()
        assert before, "something could be removed"
        for host in ("127.0.0.1", "localhost"):
            browser.visit(f"http://{host}:{stranger.server_port}/")
            tries = f"const address = {json.dumps(base)}, token = {json.dumps(token)};" + TRIES
            outcomes = browser.run(tries)
            assert all(one in ("refused", "opaque") for one in outcomes), outcomes
        framed = browser.run(
            """const frame = document.createElement("iframe");
            frame.src = arguments[0];
            document.body.append(frame);
            await new Promise(done => { frame.onload = done; setTimeout(done, 3000); });
            try { return frame.contentDocument === null ? "closed" : frame.contentDocument.title; } catch { return "closed"; }""",
            base + "/",
        )
        assert framed == "closed", framed
        browser.visit("about:blank")
        page = Page(browser, address)
        assert page.placed() == before, (before, page.placed())
    stranger.shutdown()


def speed(address):
    """How soon the picture follows the pointer, how soon all is exact after a drag, and how smooth the view is meanwhile."""
    with Browser(has_network=True) as browser:
        browser.size(1440, 900)
        begin = time.monotonic()
        page = Page(browser, address)
        ready = time.monotonic() - begin
        browser.until("return document.body.dataset.judged !== undefined", "verdicts", 300)
        times = browser.run(
            """const { planner } = document.body, took = [], frames = [];
            let last = performance.now(), isOver = false;
            const frame = now => { frames.push(now - last); last = now; if (!isOver) requestAnimationFrame(frame); };
            requestAnimationFrame(frame);
            const view = document.getElementById("view"), canvas = view.querySelector("canvas");
            const { left, top } = canvas.getBoundingClientRect(), [x, y] = view.stage.place(planner.state.placed[0].at_m);
            const send = (kind, dx, dy) => canvas.dispatchEvent(new PointerEvent(kind, { bubbles: true, pointerId: 1, isPrimary: true, button: 0, buttons: kind === "pointerup" ? 0 : 1, altKey: true, clientX: left + x + dx, clientY: top + y + dy }));
            const until = async (is, seconds) => { for (const end = performance.now() + 1000 * seconds; !is(); await new Promise(requestAnimationFrame)) if (performance.now() > end) return false; return true; };
            const capture = canvas.setPointerCapture, release = canvas.releasePointerCapture;
            canvas.setPointerCapture = canvas.releasePointerCapture = () => {};
            send("pointerdown", 0, 0);
            for (let step = 1; step <= 60; step++) {
              const before = document.body.dataset.n, at = performance.now();
              send("pointermove", 2 * step, step / 2);
              if (await until(() => document.body.dataset.n !== before, 2)) took.push(performance.now() - at);
            }
            const at = performance.now();
            send("pointerup", 120, 30);
            await until(() => document.body.dataset.busy === "" && !planner.draft, 30);
            const exact = performance.now() - at, { n } = document.body.dataset;
            await until(() => document.body.dataset.moments === n, 60);
            const counted = performance.now() - at;
            await until(() => document.body.dataset.judged === n, 60);
            const judged = performance.now() - at;
            isOver = true;
            Object.assign(canvas, { setPointerCapture: capture, releasePointerCapture: release });
            return { took, frames, exact, counted, judged };"""
        )
        took = sorted(times["took"])
        assert len(took) > 30, f"of 60 steps only {len(took)} were counted"
        frames = sorted(times["frames"])
        row = {
            "page ready (s)": ready,
            "pointer to picture, median (ms)": statistics.median(took),
            "pointer to picture, 95th percentile (ms)": took[int(0.95 * len(took))],
            "exact after release (ms)": times["exact"],
            "all moments after release (ms)": times["counted"],
            "verdicts after release (ms)": times["judged"],
            "frames a second, median": 1000 / statistics.median(frames),
        }
        print(json.dumps({name: round(value, 1) for name, value in row.items()}))


def pictures(address, folder):
    with Browser(has_network=True) as browser:
        browser.size(1280, 800)
        page = Page(browser, address)
        browser.until("return document.body.dataset.judged !== undefined", "verdicts", 300)
        for tab, name in (("tab-3d", "planner-3d.png"), ("tab-plan", "planner-plan.png")):
            page.click(tab)
            # Views at rest are drawn finely.
            time.sleep(3)
            browser.picture(os.path.join(folder, name))


if __name__ == "__main__":
    {"opened": opened, "used": used, "chosen": chosen, "left": left, "shared": shared, "found": found, "ended": ended, "strangers": strangers, "speed": speed, "pictures": pictures}[sys.argv[1]](*sys.argv[2:])
