"""Opens reports in a headless Chromium without network, at a laptop's and a phone's width, and uses them.

    python3 reports.py [--pictures FOLDER] REPORT.html ...
"""

import argparse
import pathlib
import time

from driver import Browser

WIDTHS = {"laptop": (1440, 900), "phone": (390, 844)}
MOST_BYTES = 3_000_000
TAB, ENTER, SPACE = "\ue004", "\ue007", " "


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--pictures", type=pathlib.Path)
    parser.add_argument("reports", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    for report in arguments.reports:
        assert report.stat().st_size < MOST_BYTES, f"{report}: {report.stat().st_size} bytes"
        for name, size in WIDTHS.items():
            with Browser() as browser:
                look(browser, report.resolve(), name, size, arguments.pictures)
        with Browser(has_webgl=False) as browser:
            the_own_picture_stands_in(browser, report.resolve())


def the_own_picture_stands_in(browser, report):
    """Where a browser has no WebGL, the picture that the program has drawn stands in place of the 3D view."""
    open_whole(browser, report)
    assert not browser.run("return document.createElement('canvas').getContext('webgl2')"), "the browser has WebGL"
    shown = browser.run(
        """const view = document.getElementById('view'), picture = document.getElementById('picture'), image = picture.querySelector('img');
        return image.decode().then(() => [view.hidden, picture.hidden, image.naturalWidth, image.getBoundingClientRect().height])"""
    )
    assert shown[:2] == [True, False] and shown[2] > 300 and shown[3] > 200, shown
    quiet(browser)


def open_whole(browser, report):
    """Opens a report and waits until it is drawn."""
    browser.open(report)
    browser.until("return document.body.dataset.ready === 'yes' || !document.getElementById('failure').hidden", "plots")


def look(browser, report, name, size, pictures):
    """One report at one width."""
    browser.size(*size)
    begin = time.monotonic()
    open_whole(browser, report)
    print(f"{report}, {name}: ready after {time.monotonic() - begin:.1f} s", flush=True)
    quiet(browser)
    if browser.run("return !!document.getElementById('purchase')"):
        the_cheapest_sets_are_shown(browser, size)
        return
    all_plots_are_drawn(browser)
    a_missing_plot_is_found(browser)
    nothing_sticks_out(browser, size[0])
    the_answer_comes_first(browser, size)
    nothing_is_cut_off(browser, size[0])
    colours_follow_the_scheme(browser)
    if pictures:
        sections(browser, pictures, f"{report.parent.name}-{name}")
    recommended = browser.run("return [document.querySelector('#selected strong').textContent, document.getElementById('series').value]")
    every_score_is_plotted(browser)
    one_region_is_shown(browser)
    headings_stay_visible(browser)
    labels_of_sketches_do_not_collide(browser)
    layers_hide_and_show(browser)
    causes_hide_and_show(browser)
    if browser.run("return !!document.getElementById('front')"):
        the_front_is_drawn(browser)
    else:
        # Of sets that were chosen there is one choice each, and nothing to change or to sort.
        a_map_says_why_its_best_is_not_recommended(browser, recommended)
        a_position_changes_the_cell(browser)
        the_table_sorts(browser)
        the_summary_chooses(browser)
        haste_breaks_nothing(browser)
        another_pose_is_shown_where_it_has_labels(browser)
        keys_are_enough(browser)
    quiet(browser)
    if name == "laptop":
        pdf = browser.printed()
        assert pdf[:5] == b"%PDF-" and len(pdf) > 20_000
        if pictures:
            (pictures / f"{report.parent.name}.pdf").write_bytes(pdf)


def quiet(browser):
    """Nothing was complained of, and nobody but the file was asked for anything."""
    # Slow ways of a software renderer are no fault of the page.
    harmless = ("GPU stall due to ReadPixels", "Automatic fallback to software WebGL", "Multiple readback operations")
    said = [entry["message"] for entry in browser.log("browser") if entry["level"] in ("SEVERE", "WARNING")]
    said = [message for message in said if not any(text in message for text in harmless)]
    assert not said, said
    asked = [url for url in browser.requests() if not url.startswith(("file:", "data:", "blob:", "chrome:"))]
    assert not asked, asked


# Of each plot what it shows: how many marks of a picture, or of a 3D view how many corners, and how many colours its pixels have.
PLOTS = """return [...document.querySelectorAll('.plots > div, .plot')].filter(plot => !plot.hidden && plot.getBoundingClientRect().width).map(plot => {
    const marks = plot.querySelector('.none') ? 2 : plot.querySelectorAll('svg rect, svg path, svg circle, .bar i').length, { width, height } = plot.getBoundingClientRect();
    const view = plot.stage ? plot : null, canvas = plot.querySelector('canvas');
    let corners = 0, colours = 0;
    if (view && view.stage !== 'none') for (const part of view.stage.parts.values()) corners += part.at.length / 3;
    if (canvas) {
        const copy = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
        Object.assign(copy.canvas, { width: 160, height: 120 });
        copy.drawImage(canvas, 0, 0, 160, 120);
        const seen = new Set(new Uint32Array(copy.getImageData(0, 0, 160, 120).data.buffer));
        colours = seen.size;
    }
    return [plot.id || plot.getAttribute('aria-label'), marks, canvas ? [corners, colours] : null, width, height]; })"""


def all_plots_are_drawn(browser):
    empty = browser.run("return [...document.querySelectorAll('.plots')].filter(home => !home.hidden && !home.children.length).map(home => home.id)")
    assert not empty, empty
    plots = browser.run(PLOTS)
    assert len(plots) >= (4 if browser.run("return !!document.getElementById('maps')") else 3), plots
    for what, marks, view, width, height in plots:
        assert width > 200 and height > 60, (what, width, height)
        assert view or marks >= 2, (what, marks)
        assert view is None or (view[0] > 10 and view[1] > 5), (what, "a 3D view shows nothing", view)
    beside = browser.run("return [...document.querySelectorAll('.plot svg text, .plots svg text')].filter(text => { const box = text.getBoundingClientRect(), own = text.ownerSVGElement.getBoundingClientRect(); return box.left < own.left - 2 || box.right > own.right + 2; }).map(text => text.textContent)")
    assert not beside, f"words beside their picture: {beside[:5]}"


def a_missing_plot_is_found(browser):
    """Plots are taken away one by one; the check above notices each."""
    for home in ("#distributions", "#maps"):
        if not browser.run(f"return !!document.querySelector('{home} svg')"):
            continue
        browser.run(f"const plot = document.querySelector('{home} svg'); window.kept = [plot, plot.parentElement]; plot.remove()")
        must_fail(all_plots_are_drawn, browser, f"a plot of {home} is gone")
        browser.run("kept[1].append(kept[0])")
    browser.run("const { parts } = document.getElementById('view').stage; window.kept = [...parts]; parts.clear()")
    must_fail(all_plots_are_drawn, browser, "nothing is shown in three dimensions")
    browser.run("for (const [name, part] of kept) document.getElementById('view').stage.parts.set(name, part)")
    all_plots_are_drawn(browser)


def must_fail(check, browser, why):
    try:
        check(browser)
    except AssertionError:
        return
    raise AssertionError(f"not found: {why}")


def nothing_sticks_out(browser, width):
    """The page is no wider than the window; what is wide scrolls for itself."""
    found = browser.run("return document.documentElement.scrollWidth")
    assert found <= width, f"{found} px in {width} px"


def the_answer_comes_first(browser, size):
    """What is recommended, its numbers and the floor plan are on the first screen of a laptop, and on the first two of a phone."""
    screens = 1 if size[0] > 600 else 2
    for what in ("h1", "#answer .sensors", "#answer .tiles", "#answer .plan", "#answer .disclaimer"):
        found = browser.run(
            """scrollTo(0, 0);
            const found = document.querySelector(arguments[0])?.getBoundingClientRect();
            return found ? [found.top, found.bottom, found.width] : null""",
            what,
        )
        assert found and found[0] >= 0 and found[1] <= screens * size[1] and found[2] > 50, (what, found)
    sensors = browser.run("return [...document.querySelectorAll('#answer .sensors li')].map(item => item.textContent)")
    letters = browser.run("return [...document.querySelectorAll('#answer .floor-plan .letter')].map(item => item.textContent)")
    assert sensors and len(letters) == browser.run("return document.querySelectorAll('#answer .sensors .letter').length"), (sensors, letters)
    tiles = browser.run("return [...document.querySelectorAll('#answer .tiles strong')].map(item => item.textContent)")
    # A study may be without costs.
    numbers = [tile for tile in tiles if tile != "–"]
    assert len(numbers) >= 4 and all(any(letter.isdigit() for letter in tile) for tile in numbers), tiles
    drawn = browser.run(
        """const plan = document.querySelector('#answer .floor-plan .plan'), { left, right, top, bottom } = plan.getBoundingClientRect();
        return [...plan.querySelectorAll('path, circle, text')].map(part => [part.className.baseVal, part.getBoundingClientRect()])
            .filter(([, box]) => box.left < left - 1 || box.right > right + 1 || box.top < top - 1 || box.bottom > bottom + 1)
            .map(([name, box]) => [name, box.left, box.top])"""
    )
    assert not drawn, f"outside of the plan: {drawn}"
    names_do_not_collide(browser)
    said = browser.run("return document.getElementById('answer').textContent")
    raw = [name for name in RAW_NAMES if name in said]
    assert not raw and "Good enough?" in said, raw
    chosen = browser.run("return document.getElementById('selected').textContent")
    place = browser.run("return document.querySelector('#answer .sensors li span').lastChild.textContent.trim() || document.querySelector('#answer .sensors li span').textContent")
    assert chosen and place, (chosen, place)


# Names of files and keys, which nobody should have to know.
RAW_NAMES = ("human_seen", "human_claimed", "people_detected", "parts_detected", "false_alarm", "nearest_unnoticed_m", "as_planned", "pooled")

# Pairs of words of the plan of which one covers the other.
COLLIDING = """const words = [...document.querySelectorAll('#answer .floor-plan svg.plan > text')].map(text => [text.textContent, text.getBoundingClientRect()]);
return words.flatMap(([a, one], n) => words.slice(n + 1).filter(([, other]) =>
    Math.min(one.right, other.right) - Math.max(one.left, other.left) > 2 && Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top) > 4
).map(([b]) => [a, b]));"""


def names_do_not_collide(browser):
    """The walls are named in the plan, and no name covers another; where two are put onto each other that is found."""
    walls = browser.run("return [...document.querySelectorAll('#answer .floor-plan .of-wall')].map(text => text.textContent)")
    assert walls, "no wall has a name"
    colliding = browser.run(COLLIDING)
    assert not colliding, colliding
    first = "document.querySelector('#answer .floor-plan .{}')"
    wall, axis = first.format("of-wall"), first.format("axis")
    browser.run(f"const {{ x, y }} = {axis}.getBBox(); window.kept = {wall}.getAttribute('transform'); {wall}.setAttribute('transform', `translate(${{x}} ${{y + 10}})`)")
    assert browser.run(COLLIDING), "one name lies on another, and nobody notices"
    browser.run(f"{wall}.setAttribute('transform', kept)")


def nothing_is_cut_off(browser, width):
    """On a phone rows of wide tables are cards, with the name of each column in them, and no cell is beside the screen."""
    if width > 600:
        return
    cut = browser.run(
        """document.querySelectorAll('details').forEach(part => { part.open = true; });
        const wide = [...document.querySelectorAll('.cards td')].filter(cell => {
            const box = cell.getBoundingClientRect();
            return box.width && (box.right > innerWidth + 1 || box.left < -1);
        });
        const named = [...document.querySelectorAll('.cards td[data-name]')].filter(cell => cell.textContent);
        const unnamed = named.filter(cell => !getComputedStyle(cell, '::before').content.includes(cell.dataset.name));
        return [wide.length, unnamed.length, named.length]"""
    )
    assert cut[0] == 0 and cut[1] == 0 and cut[2] > 20, cut


# WCAG's contrast of text against the first background behind it that is not transparent.
CONTRAST = """const parts = colour => colour.match(/[\\d.]+/g).map(Number);
const light = colour => { const [r, g, b] = parts(colour).map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const behind = node => { for (; node; node = node.parentElement) { const colour = getComputedStyle(node).backgroundColor, all = parts(colour); if (all.length < 4 || all[3] === 1) return colour; } return 'rgb(255, 255, 255)'; };
const poor = [];
for (const node of document.querySelectorAll(arguments[0])) {
    const words = [...node.childNodes].some(child => child.nodeType === 3 && child.textContent.trim());
    if (!words || !node.getBoundingClientRect().width) continue;
    const [a, b] = [getComputedStyle(node).color, behind(node)].map(light), ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 4.5) poor.push([node.tagName, node.className, node.textContent.slice(0, 30), ratio.toFixed(2)]);
}
return poor;"""


def colours_follow_the_scheme(browser):
    """Light and dark are what the system asks for, and words can be read in both."""
    papers = []
    for scheme in ("dark", "light"):
        browser.devtools("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
        papers.append(browser.run("return getComputedStyle(document.body).backgroundColor"))
        for part in ("#answer .plan", "#view"):
            papers.append(browser.run(f"return getComputedStyle(document.querySelector('{part}')).backgroundColor"))
        poor = browser.run(CONTRAST, "header *, main p, main li, main dt, main dd, main span, main strong, main b, main td, main th, main h2, main h3, main a, main summary")
        assert not poor, (scheme, poor[:5], len(poor))
    assert len(set(papers)) == 2, papers


def the_front_is_drawn(browser):
    """A point for each row of the table, at its cost and score, and from each its bound to the right."""
    rows = browser.run("return [...document.querySelector('#front table').tBodies[0].rows].map(row => [...row.cells].map(cell => cell.textContent))")
    assert len(rows) >= 5, rows
    points = browser.run(
        """return [...document.querySelectorAll('#front circle')].map(point => {
        const { x, y, width, height } = point.getBoundingClientRect();
        return [x + width / 2, y + height / 2, point.className.baseVal, point.textContent]; })"""
    )
    assert len(points) == len(rows), (points, rows)
    # Where all are proven, no column says what else is possible.
    for (x, y, kind, words), (_, cost, score, *possible, _, poses) in zip(points, rows):
        assert kind == ("proven" if possible in ([], ["proven"]) else "open"), (kind, possible)
        assert words.endswith(f" {score}, cost {cost}: {poses}"), (words, score, cost, poses)
    by_cost, by_score = ([points[i][:2] for i in sorted(range(len(rows)), key=lambda i: float(rows[i][column]))] for column in (1, 2))
    assert all(a[0] <= b[0] for a, b in zip(by_cost, by_cost[1:])), by_cost
    assert all(a[1] >= b[1] for a, b in zip(by_score, by_score[1:])), by_score
    bounds = browser.run(
        """return [...document.querySelectorAll('#front .bound')].map(line => {
        const { left, right, top } = line.getBoundingClientRect();
        return [left, right, top, getComputedStyle(line).strokeDasharray]; })"""
    )
    assert len(bounds) == len(points), bounds
    for (left, right, top, dashes), (x, y, kind, _) in zip(bounds, points):
        assert abs(left - x) < 3 and right > x and top <= y + 3, (left, right, top, x, y)
        assert (dashes == "none") == (kind == "proven"), (dashes, kind)


def the_cheapest_sets_are_shown(browser, size):
    """The answer in short and then in a sentence are the first of all, and nothing sticks out; each set opens."""
    box = "const { top, bottom } = document.querySelector('%s').getBoundingClientRect(); return [top, bottom]"
    short, sentence = (browser.run(box % part) for part in (".summary", "main .sentence"))
    assert 0 < short[0] and short[1] < 200, short
    assert short[1] < sentence[0] < size[1] / 3 and sentence[1] < size[1] * 2 / 3, (sentence, size)
    nothing_sticks_out(browser, size[0])
    nothing_is_cut_off(browser, size[0])
    colours_follow_the_scheme(browser)
    a_cheapest_set_opens(browser)
    quiet(browser)


def a_cheapest_set_opens(browser):
    """A click on a point of the chart and on a row of the table selects its set and opens what the page tells of it."""
    links = "[...document.querySelectorAll('#purchase figure .spot, #purchase table .choose')]"
    opened = browser.run(f"return {links}.map(link => link.dataset.opens)")
    # Of several speeds the cheapest set may be the same; without a requirement it is another one.
    has_chart = browser.run("return !!document.querySelector('#purchase figure svg.chart')")
    assert len(opened) >= 3 and (has_chart or len(set(opened)) >= 2), opened
    for number, opens in enumerate(opened):
        browser.run("document.querySelectorAll('#purchase details').forEach(part => { part.open = false; })")
        browser.run(f"{links}[{number}].dispatchEvent(new MouseEvent('click', {{ bubbles: true }}))")
        browser.until("return !document.body.dataset.waits", "the cell")
        [shown, plan, name, selected, view] = browser.run(
            """const all = [...document.querySelectorAll('#purchase details[open]')], sheet = document.querySelector('#sheet caption');
            return [all.map(one => one.id), all[0]?.querySelector('.plan').getBoundingClientRect().height,
                all[0]?.querySelector('summary').textContent, document.querySelector('#selected strong').textContent, sheet.textContent];"""
        )
        assert shown == [opens] and plan > 100, (number, shown, plan)
        poses = name.rsplit(": ", 1)[1]
        assert selected in (poses, poses.split(":")[-1]), (selected, poses)
        assert view.startswith("Mounting sheet ") and view.split(", ")[-1] in poses, (view, poses)


# What the 3D view shows, as a number that changes when it does.
SHOWN = """return JSON.stringify([...document.getElementById('view').stage.parts].map(([name, part]) =>
    [name, part.isShown, part.at.length, ...part.at.slice(0, 9)]))"""


def a_position_changes_the_cell(browser):
    """Clicks on positions of the first map until another one than the chosen is hit."""
    before, was = browser.run(SHOWN), browser.run("return document.getElementById('selected').textContent")
    places = browser.run(
        """const plot = document.querySelector('#maps > div');
        if (!plot) return [];
        plot.scrollIntoView({ block: 'center' });
        return [...plot.querySelectorAll('.spot')].map(spot => spot.getBoundingClientRect()).map(({ x, y, width, height }) => [x + width / 2, y + height / 2])"""
    )
    assert places, "no positions to click on"
    for x, y in (places[0], places[-1], places[len(places) // 2]):
        browser.click(x, y)
        time.sleep(0.3)
        now = browser.run("return document.getElementById('selected').textContent")
        if now != was:
            break
    assert now != was, "a click chooses another pose"
    browser.until(f"return (() => {{ {SHOWN} }})() !== {before!r}", "another 3D view")
    chosen = browser.run("return document.querySelector('#selected strong').textContent")
    note = browser.run("return document.getElementById('cell-note').textContent")
    assert chosen.split(": ")[-1] in note, (chosen, note)
    assert browser.run("return document.querySelectorAll('#sheet table').length"), "a mounting sheet"


def every_score_is_plotted(browser):
    """The selector above the boxes takes all scores; a claimed share is never without its false alarms."""
    select = "document.getElementById('measure-of-distributions')"
    names = browser.run(f"return [...{select}.options].map(option => option.textContent)")
    assert len(names) == 9, names
    for number, name in [*enumerate(names), (0, names[0])]:
        browser.run(f"{select}.value = {number}; {select}.dispatchEvent(new Event('change'))")
        always = ["F1", "κ", "human seen", "parts detected"]
        chosen = [name] + ["false alarm"] * (name == "human claimed")
        for home in ("distributions", "maxima"):
            expected = chosen if home == "maxima" else chosen + [other for other in always if other not in chosen]
            labels = f"return [...(document.getElementById('{home}')?.children ?? [])].filter(plot => plot.querySelector('svg rect, .none')).map(plot => plot.querySelector('.title').textContent.replace('Largest ', '').split(' · region')[0])"
            if home == "maxima" and not browser.run("return !!document.getElementById('maxima')"):
                continue
            browser.until(f"return (() => {{ {labels} }})().join() === {','.join(expected)!r}", f"{home} of {name}")
        assert browser.run("return document.getElementById('measure').value") == str(number)
        if not browser.run("return !!document.getElementById('table')"):
            continue
        sorted_by = browser.run("return document.querySelector('#table [aria-sort=ascending], #table [aria-sort=descending]').textContent")
        assert sorted_by.startswith(name), (sorted_by, name)


def one_region_is_shown(browser):
    """Tables and charts are those of the selected region, whichever selector it is selected by."""
    shown = """return [[...document.querySelectorAll('[data-of-region]')].filter(part => !part.hidden).map(part => part.dataset.ofRegion),
        [...new Set([...document.querySelectorAll('.plots > [data-region]')].map(chart => chart.dataset.region))]]"""
    count = browser.run("return document.getElementById('region').options.length")
    names = ["region", "region-of-best"] if count > 1 else ["region"]
    for name in names:
        for region in [*range(count), 0]:
            browser.run(f"const select = document.getElementById({name!r}); select.value = {region}; select.dispatchEvent(new Event('change'))")
            assert browser.run(shown) == [[str(region)]] * 2, (name, region, browser.run(shown))
            assert all(browser.run(f"return document.getElementById({other!r}).value") == str(region) for other in names)


def headings_stay_visible(browser):
    """A heading that a link leads to is not below the bar that sticks to the top."""
    links = browser.run("return [...document.querySelectorAll('nav a')].map(link => link.getAttribute('href'))")
    for link in links:
        covered = browser.run(
            """document.querySelector(`nav a[href="${arguments[0]}"]`).click();
            const bar = document.getElementById('choice'), { bottom } = bar.getBoundingClientRect();
            const { top } = document.querySelector(`${arguments[0]} h2`).getBoundingClientRect();
            return getComputedStyle(bar).position === 'sticky' && bar.getBoundingClientRect().top <= 0 ? bottom - top : 0""",
            link,
        )
        assert covered <= 0, f"{link}: {covered} px of the heading are covered"
    browser.run("scrollTo(0, 0)")


def labels_of_sketches_do_not_collide(browser):
    """No label of a mounting sheet covers another, in the font that the browser has."""
    colliding = browser.run(
        """document.querySelectorAll('#where details').forEach(part => { part.open = false; });
        return [...document.querySelectorAll('#where svg.sketch')].flatMap(sketch => {
            const words = [...sketch.querySelectorAll('text')].map(text => [text.textContent, text.getBoundingClientRect()]);
            return words.flatMap(([a, one], n) => words.slice(n + 1).filter(([, other]) =>
                Math.min(one.right, other.right) - Math.max(one.left, other.left) > 2 && Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top) > 5
            ).map(([b]) => [a, b]));
        })"""
    )
    assert not colliding, colliding


def a_map_says_why_its_best_is_not_recommended(browser, recommended):
    """A sentence names the recommended place and why it is recommended, if another place of the map is better."""
    name, series = recommended
    browser.run(f"const select = document.getElementById('series'); select.value = {series!r}; select.dispatchEvent(new Event('change'))")
    for measure in range(9):
        browser.run(f"const select = document.getElementById('measure'); select.value = {measure}; select.dispatchEvent(new Event('change'))")
        note, rows = browser.run(
            """const note = document.getElementById('map-note');
            const row = ({ cells }) => [cells[0].textContent, cells[2 + arguments[0]].textContent];
            return [note.hidden ? '' : note.textContent, [...document.querySelectorAll('#table tbody tr')].map(row)]""",
            measure,
        )
        own = dict(rows).get(name)
        if own and own != rows[0][1]:
            assert own in note and rows[0][1] in note and " It is the " in note, (measure, own, rows[0], note)


def the_best_is_shown(browser):
    browser.run("document.querySelector('#instead .choose').click()")
    browser.until("return !document.body.dataset.waits && !document.getElementById('layer-TP').disabled", "labels of the best pose")


def layers_hide_and_show(browser):
    the_best_is_shown(browser)
    hues = "return new Set(document.getElementById('view').stage.parts.get('TP').colours).size"
    people = browser.run("return [...document.querySelectorAll('#answer .tiles dt')].some(term => term.textContent === 'people detected')")
    assert browser.run(hues) >= (2 if people else 1), "people are told from the floor"
    words = browser.run("return [...document.querySelectorAll('#layers strong')].map(word => word.textContent)")
    assert words[:5] == ["blind", "not seen", "missed", "false", "seen"], words
    names = "return document.getElementById('view').stage.parts.get('sensors: names').words"
    assert browser.run(names), "furniture and robots have names"
    names = browser.run("return [...document.querySelectorAll('#layers input[type=checkbox]')].map(box => box.id)")
    voxels = "return ['TP','FN','FP','TN','UO','UF'].reduce((sum, name) => sum + Number(document.getElementById('count-' + name).textContent), 0)"
    assert browser.run(voxels) > 0, "voxels are counted"
    assert names[:4] == ["layer-UF", "layer-UO", "layer-FN", "layer-FP"], "what matters comes first"
    for name in (f"layer-{name}" for name in ("TP", "FN", "FP", "TN", "UO", "UF")):
        of_trace = f"return document.getElementById('view').stage.parts.get({name.removeprefix('layer-')!r}).isShown"
        before = browser.run(of_trace)
        browser.run(f"document.getElementById({name!r}).click()")
        browser.until(f"return (() => {{ {of_trace} }})() === {str(not before).lower()}", f"{name} to change")
        browser.run(f"document.getElementById({name!r}).click()")
        browser.until(f"return (() => {{ {of_trace} }})() === {str(before).lower()}", f"{name} to change back")


def causes_hide_and_show(browser):
    """The causes of the unknown voxels are all of them; each can be taken out of the 3D view, and they have colours."""
    the_best_is_shown(browser)
    of_note = "return [...document.querySelectorAll('#causes .note')].reduce((sum, note) => sum + Number(note.textContent), 0)"
    unknown = "return ['UO', 'UF'].reduce((sum, name) => sum + Number(document.getElementById('count-' + name).textContent), 0)"
    assert browser.run(of_note) == browser.run(unknown) > 0, "every unknown voxel has a cause"
    bars = "return [...document.querySelectorAll('#reasons .bar i')].reduce((sum, bar) => sum + Number(bar.title.match(/: (\\d+) voxels/)[1]), 0)"
    assert browser.run(bars) == browser.run(unknown), "so have the bars"
    faces = "return ['UO', 'UF'].reduce((sum, name) => sum + document.getElementById('view').stage.parts.get(name).faces.length, 0)"
    before = browser.run(faces)
    first = "document.querySelector('#causes input')"
    browser.run(f"{first}.click()")
    browser.until(f"return (() => {{ {faces} }})() < {before}", "a cause to go")
    browser.run(f"{first}.click()")
    browser.until(f"return (() => {{ {faces} }})() === {before}", "a cause to come back")
    colours = "return new Set(['UO', 'UF'].flatMap(name => document.getElementById('view').stage.parts.get(name).colours)).size"
    assert browser.run(colours) <= 2
    swatches = browser.run("return new Set([...document.querySelectorAll('#causes i')].map(swatch => swatch.style.background)).size")
    browser.run("document.getElementById('by-cause').click()")
    browser.until(f"return (() => {{ {colours} }})() === {swatches}", "the colours of the causes")
    browser.run("document.getElementById('by-cause').click()")


def the_table_sorts(browser):
    column = "return [...document.querySelectorAll('#table tbody tr')].map(row => parseFloat(row.cells[{}].textContent)).filter(value => !isNaN(value))"
    for measure in range(5):
        for _ in range(2):
            browser.run(f"document.querySelector('#table [data-measure=\"{measure}\"]').click()")
            values = browser.run(column.format(measure + 2))
            order = browser.run(f"return document.querySelector('#table [data-measure=\"{measure}\"]').parentElement.ariaSort")
            assert values == sorted(values, reverse=order == "descending"), (measure, order, values)
    button = "document.querySelectorAll('#table tbody .choose')[3]"
    if browser.run(f"return !!{button}"):
        name = browser.run(f"const name = {button}.textContent; {button}.click(); return name")
        now = browser.run("return document.querySelector('#selected strong').textContent")
        assert name == now, (name, now)
        marked = browser.run("return document.querySelector('#table tr.chosen .choose').textContent")
        assert marked == name


def the_summary_chooses(browser):
    rows = browser.run("return document.querySelectorAll('#instead .choose').length")
    browser.run(f"document.querySelectorAll('#instead .choose')[{rows - 1}].click()")
    wanted = browser.run(f"return document.querySelectorAll('#instead .choose')[{rows - 1}].dataset.series")
    assert browser.run("return document.getElementById('series').value") == wanted


def haste_breaks_nothing(browser):
    """Selectors are changed faster than plots are drawn."""
    browser.run(
        """for (const id of ['measure', 'region', 'series', 'measure', 'series', 'region']) {
            const select = document.getElementById(id);
            select.value = (Number(select.value) + 1) % select.options.length;
            select.dispatchEvent(new Event('change'));
        }"""
    )
    follows = """const text = document.getElementById('table-note').textContent;
        return ['series', 'region'].every(id => text.includes(document.getElementById(id).selectedOptions[0].textContent))"""
    assert browser.run(follows), "the table follows at once"
    # What stands nowhere, as a cover on the robot, has no map.
    plots = """const home = document.getElementById('maps'), all = [...home.children];
        return home.hidden ? !all.length : all.length > 0 && all.every(plot => plot.querySelector('svg'))"""
    browser.until(plots, "maps to be drawn")


def another_pose_is_shown_where_it_has_labels(browser):
    """A snapshot without labels of the next pose is left for one that has them."""
    the_best_is_shown(browser)
    snapshots = browser.run("return [...document.getElementById('moment').options].map(option => [option.value, option.textContent])")
    empty = [value for value, text in snapshots if "no labels" in text]
    if not empty:
        return
    choose = "const select = document.getElementById('moment'); select.value = {!r}; select.dispatchEvent(new Event('change'));"
    browser.run(choose.format(empty[0]))
    browser.until("return document.getElementById('layer-TP').disabled", "a snapshot without labels")
    browser.run("[...document.querySelectorAll('#instead .choose')].at(-1).click()")
    browser.until("return !document.getElementById('layer-TP').disabled", "labels of another pose")


def keys_are_enough(browser):
    """A layer is switched and a pose chosen without a mouse."""
    browser.run("document.getElementById('layer-sensors').focus()")
    before = browser.run("return document.getElementById('layer-sensors').checked")
    browser.press(SPACE)
    assert browser.run("return document.getElementById('layer-sensors').checked") != before
    browser.press(SPACE)
    browser.run("document.querySelector('#table tbody .choose').focus()")
    name = browser.run("return document.activeElement.textContent")
    browser.press(ENTER)
    assert browser.run("return document.querySelector('#selected strong').textContent") == name
    browser.press(TAB)
    assert browser.run("return document.activeElement !== document.body")


def sections(browser, folder, name):
    """A picture of each section."""
    folder.mkdir(parents=True, exist_ok=True)
    for section in browser.run("return [...document.querySelectorAll('section')].map(section => section.id)"):
        browser.run(f"document.getElementById({section!r}).scrollIntoView()")
        time.sleep(0.5)
        browser.picture(folder / f"{name}-{section}.png")


if __name__ == "__main__":
    main()
