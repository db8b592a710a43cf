"""The page of `tissuectl serve` with a model in space, in a real browser that draws WebGL in software:
test_page_space.py TISSUECTL MODEL PLANE_MODEL. MODEL is of a solid block with cases.h5 and eval.json in its folder,
PLANE_MODEL is in the plane.
Prints "ok - sentence" or "not ok - sentence: seen", and measured values after "# "; exits 1 if any failed.

The state of the page is read from window.tissue, its display from the document and from pictures of it."""
import base64
import io
import json
import math
import shutil
import sys
import time
from pathlib import Path
from urllib.request import Request, urlopen

import h5py
import matplotlib
import matplotlib.image
import numpy
from browser import FLAT, SOLID, Browser, Server, check, run

force = "Math.hypot(...tissue.force_N || [0])"
moved = "(tissue.largest_displacement_m || [0])"
depth = "Math.hypot(...(tissue.contact_moved_m || [[0, 0, 0]])[0])"
free = f"tissue.pressed === -1 && {force} === 0"


class Block:
    """Nodes, facets and cases.h5 of the model."""

    def __init__(self, model):
        with h5py.File(model) as f:
            self.nodes, self.facets = f["mesh/nodes"][:len(f["mesh/lattice/corner"])], f["mesh/facets"][:]
        self.shown = numpy.unique(self.facets)
        self.low, self.high = self.nodes.min(0), self.nodes.max(0)
        self.beside = numpy.array([1.5 * (self.high[0] - self.low[0]), 0, 0])   # offset of the second mesh
        self.cases = Path(model).with_name("cases.h5")

    def top(self, x, y, mesh=0):
        """A point of the top at fractions x and y of its size."""
        return [*(self.low[:2] + (self.high - self.low)[:2] * (x, y) + mesh * self.beside[:2]), self.high[2]]


def colour(page, point):
    """RGB of the picture at a point, 0 to 255: the median of 3 x 3 pixels."""
    x, y = page.on_screen(*point)
    data = page.cdp("Page.captureScreenshot", format="png")["data"]
    picture = matplotlib.image.imread(io.BytesIO(base64.b64decode(data)))
    return numpy.median(255 * picture[int(y) - 1:int(y) + 2, int(x) - 1:int(x) + 2, :3].reshape(-1, 3), axis=0)


def wheel(page, x, y, by):
    page.cdp("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=by)


def set_depth(page, mm):
    page.js("(e => { e.value = arguments[0]; e.dispatchEvent(new Event('input')); })(document.getElementById('depth'))", mm)


def beside(page):
    """CSS pixels of a point of the canvas without solid: its lower left corner."""
    return page.js("(b => [b.left + 6, b.bottom - 6])(document.getElementById('space').getBoundingClientRect())")


def opening(page, server, block):
    page.open(server.url)
    check("the page connects to a model in space", page.until("tissue.connected") and page.js("tissue.dimension") == 3)
    check("the solids are drawn and the stage of the plane is hidden", page.until("tissue.solids !== null && tissue.drawn > 2") and page.js(
        "document.getElementById('stage').hidden && !document.getElementById('space_stage').hidden && !document.getElementById('help_space').hidden"),
        page.text("space_fault"))
    check("the page has only the surface of the mesh", page.js("tissue.outline.length") == len(block.shown) and
          page.js("tissue.solids[0].facets") == len(block.facets), page.js("tissue.solids"))
    foreign = page.js("performance.getEntriesByType('resource').filter(e => !e.name.startsWith(location.origin) && "
                      "!e.name.startsWith('data:')).map(e => e.name)")
    check("the page of a solid fetches nothing from other origins", foreign == [], foreign)
    check("at the start the demo displaces the solid", page.until(f"tissue.control.holder === 'demo' && tissue.pressed === 0 && {moved}[0] > 1e-3"),
          [page.js("tissue.control"), page.js(moved)])


def take_over(page, block):
    """Ends the demo and waits until no tool touches the tissue. The mouse button is up afterwards."""
    page.mouse("Pressed", *block.top(0.5, 0.5))
    page.until("tissue.control.holder === 'you'")
    page.mouse("Released", *block.top(0.5, 0.5))
    page.until(free)


def pressing(page, block):
    take_over(page, block)
    page.js("document.getElementById('reset').click()")
    page.until(f"{free} && Math.max(...{moved}) < 2e-4")
    spot = block.top(0.5, 0.4)
    before = colour(page, spot)
    set_depth(page, 3)
    page.mouse("Pressed", *block.top(0.5, 0.5))
    check("a press of the mouse on the learned solid takes hold and moves the tool into contact", page.until("tissue.control.holder === 'you' && tissue.pressed === 0"),
          [page.js("tissue.control"), page.js("tissue.pressed")])
    check("the notice of a solid says that the user holds the tool", "You hold" in page.text("notice"), page.text("notice"))
    page.until("tissue.pressing.depth_m > 0.00299")
    shallow = page.rests(force)
    push = page.js("tissue.contact_moved_m[0]")
    check("the tool moves straight in to the depth of the slider", abs(math.hypot(*push) - 0.0033) < 6e-4 and -push[2] > 0.95 * math.hypot(*push), push)
    deepest = page.js("Number(document.getElementById('depth').max)")
    set_depth(page, deepest)
    page.until(f"tissue.pressing.depth_m > {1e-3 * deepest - 1e-5}")
    deep = page.rests(force)
    check("the force on the solids increases with depth", deep > 1.3 * shallow > 0, [shallow, deep])
    check("the band below the fixed facets moves by less than 0.05 mm", page.js("Math.max(...tissue.solids.map(s => s.band_moved_m))") < 5e-5, page.js("tissue.solids"))
    check("both solids are displaced", page.js(f"Math.min(...{moved})") > 1e-3, page.js(moved))
    x, y = page.on_screen(*block.top(0.5, 0.5))
    wheel(page, x, y, 100)
    check("the wheel reduces the depth by 0.5 mm", page.until(f"Number(document.getElementById('depth').value) === {deepest - 0.5}"), page.js("document.getElementById('depth').value"))
    check("numbers of a solid are shown with their units", all(page.text(name).endswith(unit) for name, unit in
          (("force", "N"), ("learned_depth", "\xa0mm"), ("heuristic_depth", "\xa0mm"), ("tick_rate", " Hz"), ("depth_now", "\xa0mm"))))
    page.after(20)
    after = colour(page, spot)
    check("the solid is purple at rest and has another colour beside the tool",
          before[2] > before[1] + 30 and after[1] > before[1] + 25, [before, after])
    aside = page.js("tissue.pressing.direction")
    for k in range(1, 9):
        page.mouse_at("Moved", x + 8 * k, y)
    page.after(30)
    tilted, push = page.js("tissue.pressing.direction"), page.js("tissue.contact_moved_m[0]")
    angle = math.degrees(math.acos(max(-1, min(1, sum(a * b for a, b in zip(aside, tilted))))))
    check("a drag tilts the displacement to the side of the drag", 10 < angle < 40 and tilted[0] > 0.1 and push[0] > 1e-3, [angle, tilted, push])
    page.mouse_at("Released", x + 64, y)
    check("release of the mouse ends contact and force in space", page.until(free), page.js(force))
    page.mouse("Pressed", *block.top(0.5, 0.5, 1))
    check("an indentation of the heuristic solid displaces both", page.until(f"tissue.pressed === 1 && {force} > 0 && Math.min(...{moved}) > 5e-4"), page.js(moved))
    page.mouse("Released", *block.top(0.5, 0.5, 1))
    page.until(free)


def turning(page, block):
    first = page.js("tissue.view")
    x, y = beside(page)
    page.mouse_at("Pressed", x, y)
    page.mouse_at("Moved", x + 50, y - 20)
    page.mouse_at("Released", x + 50, y - 20)
    page.until(f"tissue.view.azimuth !== {first['azimuth']}")
    second = page.js("tissue.view")
    check("a drag beside the solids turns them and does not take hold", abs(first["azimuth"] - second["azimuth"] - 20) < 1 and
          abs(first["elevation"] - second["elevation"] - 8) < 1 and page.js("tissue.control.holder") != "you", [first, second])
    wheel(page, x, y, -100)
    check("the wheel zooms", page.until("tissue.view.zoom > 1.1"), page.js("tissue.view"))
    page.mouse("Pressed", *block.top(0.4, 0.5))
    check("after turning and zooming the indentation is at the pointer", page.until("tissue.pressing !== null") and
          numpy.abs(numpy.array(page.js("tissue.pressing.contact_m")) - block.top(0.4, 0.5)).max() < 0.004, page.js("tissue.pressing"))
    page.mouse("Released", *block.top(0.4, 0.5))
    page.until(free)
    page.js("document.getElementById('space').focus()")
    page.key("Home")
    check("Home restores the view", page.until("tissue.view.azimuth === -62 && tissue.view.elevation === 30 && tissue.view.zoom === 1"), page.js("tissue.view"))
    page.mouse_at("Pressed", x, y)
    page.mouse_at("Moved", x, y + 200)
    page.mouse_at("Released", x, y + 200)
    page.until("tissue.view.elevation > 31")
    check("the elevation of the view is 89 degrees at most", page.js("tissue.view.elevation") == 89, page.js("tissue.view"))
    page.key("Home")


def keyboard(page, block):
    page.js("document.activeElement.blur()")
    page.js("document.getElementById('reset').focus()")
    page.key("Tab")
    check("Tab reaches the solids and the focus is visible", page.js("document.activeElement.id") == "space" and
          page.js("getComputedStyle(document.activeElement).outlineStyle") == "solid", page.js("document.activeElement.id"))
    page.key("ArrowLeft")
    page.key("+")
    check("arrow keys turn, + zooms", page.until("tissue.view.azimuth === -57 && tissue.view.zoom > 1.1"), page.js("tissue.view"))
    page.key("Home")
    set_depth(page, 5)
    page.choose("contact", 0)
    page.until("tissue.control.holder === 'demo' && tissue.control.place >= 0")
    place = page.js("tissue.place(Number(document.getElementById('way').value))")
    page.js("document.getElementById('space').focus()")
    page.key("Space")
    check("Space starts an indentation at the chosen contact", page.until("tissue.control.holder === 'you' && tissue.pressed === 0") and
          numpy.abs(numpy.array(page.js("tissue.pressing.contact_m")) - place["contact_m"]).max() < 1e-9, page.js("tissue.pressing"))
    page.key("PageDown", 2)
    check("Page Down increases the depth by 0.5 mm", page.js("document.getElementById('depth').value") == "6", page.js("document.getElementById('depth').value"))
    page.until("tissue.pressing.depth_m > 0.00599")
    before = page.js("tissue.pressing.direction")
    page.key("ArrowRight", 2, shift=True)
    after = page.js("tissue.pressing.direction")
    angle = math.degrees(math.acos(min(1, sum(a * b for a, b in zip(before, after)))))
    check("Shift with arrow keys tilts the displacement", 8 < angle < 12, [angle, before, after])
    page.key("Escape")
    check("Escape releases the tissue", page.until(f"tissue.control.holder !== 'you' && {force} === 0"), page.js("tissue.control"))
    names = page.js("""[...document.querySelectorAll('select, button, canvas, input')].filter(e => !(e.getAttribute('aria-label')
        || e.textContent.trim() && e.tagName === 'BUTTON' || e.closest('label'))).map(e => e.id)""")
    check("every control and canvas of a solid has a name", names == [], names)


def finite_elements(page, block):
    """Indents a contact with an FE reference straight in until the tissue is at rest."""
    for k in page.js("[...document.querySelectorAll('#contact option')].map(o => o.value).filter(v => v >= 0)"):
        page.choose("contact", k)
        if page.js("document.querySelector('#way option:checked').textContent === 'straight in'"):
            break
    place_k = page.js("Number(document.getElementById('way').value)")
    place = page.js("tissue.place(arguments[0])", place_k)
    set_depth(page, 0.75e3 * place["depth_m"])
    page.js("document.getElementById('space').focus()")
    # The choice of a contact has started the demo there. The tissue must rest first, or the tool touches another point.
    page.key("Space")
    page.until("tissue.control.holder === 'you'")
    page.key("Escape")
    page.until(f"{free} && Math.max(...{moved}) < 2e-4")
    page.key("Space")
    page.until("tissue.pressing && tissue.pressed === 0")
    page.after(60)
    page.rests(force)
    known = page.until("tissue.off_FE !== null && tissue.fe_shown_m !== null")
    check("at a contact with an FE reference the page compares and draws the FE surface", known, [page.text("verdict"), page.text("basis")])
    page.click("pause")
    page.until("tissue.control.paused")
    page.after(10)
    drawn, outline, push = page.js("[tissue.fe_outline_m, tissue.outline, tissue.contact_moved_m[0]]")
    along = sum(a * b for a, b in zip(push, place["direction"]))
    with h5py.File(block.cases) as f:
        path = f[f"paths/{place['name']}"]
        known = {0.0: 0 * block.nodes} | {d: path["displacement"][abs(path["magnitude"][:] - d).argmin()] for d, _ in place["curve"][1:]}
    depths = sorted(known)
    at = next((i for i in range(1, len(depths)) if along <= depths[i]), len(depths) - 1)
    w = (along - depths[at - 1]) / (depths[at] - depths[at - 1])
    fe = (block.nodes + known[depths[at - 1]] + w * (known[depths[at]] - known[depths[at - 1]]))[block.shown]
    off = numpy.abs(fe[outline] - drawn).max() if drawn is not None else math.inf
    check("every node of the FE surface is at its position in cases.h5 for the depth of the learned mesh", off < 2e-7, [off, along])
    a, b = place["curve"][at - 1], place["curve"][at]
    fe_N = a[1] + (b[1] - a[1]) * w
    ours = page.js(force)
    check("the FE force is that of the place's curve at this depth and is shown", abs(page.js("tissue.fe_N") - fe_N) < 1e-3 * fe_N and page.text("fe_force") != "–",
          [page.js("tissue.fe_N"), fe_N, page.text("fe_force")])
    print(f"# at {1e3 * along:.2f} mm: learned {ours:.4f} N, FE {fe_N:.4f} N; off {page.js('tissue.off_FE')}")
    page.click("fe_wanted")
    page.after(5)
    check("the FE surface can be switched off", page.until("tissue.fe_shown_m === null"))
    page.click("fe_wanted")
    page.click("pause")
    page.until("!tissue.control.paused")
    page.key("Escape")
    page.until(free)


def standing_still(page, block):
    set_depth(page, 5)
    page.mouse("Pressed", *block.top(0.5, 0.5))
    page.until(f"tissue.pressed === 0 && {moved}[0] > 1e-3")
    page.js("document.getElementById('pause').click()")
    page.until("tissue.control.paused")
    page.after(10)
    first = page.js("[tissue.time_s, tissue.work.nodes]")
    page.after(30)
    second = page.js("[tissue.time_s, tissue.work.nodes]")
    check("during a pause time stops and no node is sent", first == second and page.js(f"{moved}[0]") > 1e-3, [first, second])
    page.js("document.getElementById('pause').click()")
    check("the time of a solid continues after a pause", page.until(f"tissue.time_s > {first[0]} && !tissue.control.paused"))
    page.js("document.getElementById('reset').click()")
    check("reset puts both solids to rest", page.until(f"Math.max(...{moved}) < 2e-4"), page.js(moved))
    page.mouse("Released", *block.top(0.5, 0.5))
    page.until(free)


def budget(page, block):
    """Time that the page needs per state before drawing, while all of the tissue moves."""
    page.choose("contact", -1)
    page.until(f"tissue.control.holder === 'demo' && {moved}[0] > 1e-3")
    before = page.js("[tissue.work.nodes, tissue.states]")
    seen = page.watch("({decode: tissue.work.decode_ms, update: tissue.work.update_ms})", 6)
    after = page.js("[tissue.work.nodes, tissue.states]")
    nodes, states = after[0] - before[0], after[1] - before[1]
    each = nodes / max(1, states)
    check("a state has at most the surface nodes of both meshes", 0 < each <= 2 * len(block.shown), [nodes, states])
    total = sorted(s["decode"] + s["update"] for s in seen)
    print(f"# {states} states of {each:.0f} nodes of {2 * len(block.shown)}; decoding and update: median {total[len(total) // 2]:.2f} ms, "
          f"p99 {total[int(0.99 * (len(total) - 1))]:.2f} ms of 4")


def touching(page, block):
    page.resize(360, 780, 2, True)
    page.cdp("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    page.until("innerWidth === 360")
    page.until("(c => c.width === 2 * c.clientWidth)(document.getElementById('space'))")
    wide = page.js("[document.documentElement.scrollWidth, ...[...document.querySelectorAll('body *')].filter(e => !e.classList.contains('unseen'))"
                   ".map(e => Math.ceil(e.getBoundingClientRect().right))]")
    check("360 px: nothing is wider than the screen", max(wide) <= 360, max(wide))
    a, b = page.on_screen(*block.top(0.5, 0.5)), page.on_screen(*block.top(0.5, 0.5, 1))
    a = page.on_screen(*block.top(0.5, 0.5))
    check("360 px: one solid below the other", b[1] - a[1] > 100 and abs(a[0] - b[0]) < 40, [a, b])
    place = "[scrollY, document.getElementById('space').getBoundingClientRect().top]"
    before = page.js(place)
    page.touch("Start", *block.top(0.5, 0.5))
    check("a finger indents the solid", page.until(f"tissue.pressed === 0 && {force} > 0"), page.js("tissue.control"))
    for k in range(1, 7):
        # a scroll gesture
        page.cdp("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{"x": a[0], "y": a[1] - 12 * k}])
    check("a dragged finger tilts the displacement", page.until("tissue.pressing && tissue.pressing.direction[2] > -0.98"), page.js("tissue.pressing"))
    page.touch("End")
    check("lifting the finger releases the solid", page.until(free), page.js("tissue.control"))
    zoom = page.js("tissue.view.zoom")
    x, y = page.on_screen(*block.top(0.5, 0.5))
    fingers = [[{"x": x - s, "y": y, "id": 0}, {"x": x + s, "y": y, "id": 1}] for s in (30, 45, 60)]
    page.cdp("Input.dispatchTouchEvent", type="touchStart", touchPoints=fingers[0])
    for points in fingers[1:]:
        page.cdp("Input.dispatchTouchEvent", type="touchMove", touchPoints=points)
    page.cdp("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    check("two fingers zoom and do not take hold", page.until(f"tissue.view.zoom > 1.5 * {zoom}") and page.until("tissue.control.holder !== 'you'"),
          page.js("[tissue.view, tissue.control]"))
    check("the page does not scroll or shift under two fingers", page.js(place) == before, [before, page.js(place)])
    page.cdp("Emulation.setTouchEmulationEnabled", enabled=False)
    page.resize(1360, 900)
    page.until("innerWidth === 1360")


def media(page):
    name = "getComputedStyle(document.documentElement).getPropertyValue('--soft').trim()"
    soft = page.js(name)
    page.media(prefers_contrast="more")
    check("with increased contrast the page has another colour", page.until(f"{name} !== '{soft}'"), page.js(name))
    page.media(prefers_reduced_motion="reduce")
    page.open(page.js("location.href"))
    page.until("tissue.connected && tissue.solids !== null && tissue.control.holder === 'demo' && tissue.states > 0")
    begun = "[tissue.drawn, tissue.states, performance.now() / 1000]"
    first = page.js(begun)
    page.after(120)
    drawn, _, seconds = (b - a for a, b in zip(first, page.js(begun)))
    check("with reduced motion the demo of a solid is drawn once a second", 0 < drawn <= 2 + seconds, [drawn, seconds])
    page.media()
    page.open(page.js("location.href"))
    check("the solids are drawn after a reload", page.until("tissue.connected && tissue.solids !== null && tissue.states > 2"))


def switching(page):
    page.choose("model", 1)
    check("after a solid a plane model is drawn on its own stage", page.until("tissue.dimension === 2 && tissue.states > 5") and page.js(
        "!document.getElementById('stage').hidden && document.getElementById('space_stage').hidden") and
        page.until(f"tissue.pressed === 0 && Math.min(...{moved}) > 1e-3"), page.js("tissue.dimension"))
    page.choose("model", 0)
    check("after a plane model the solids are drawn again", page.until("tissue.dimension === 3 && tissue.solids !== null") and
          page.until(f"tissue.pressed === 0 && {moved}[0] > 1e-3"), page.js(moved))


def without_webgl(server):
    other = Browser(900, 700, flags=[*FLAT, "--disable-3d-apis"])
    try:
        other.open(server.url)
        check("a browser that cannot draw solids reports it and still shows numbers", other.until(
            "document.getElementById('space_fault').textContent.startsWith('This browser cannot draw solids: ')") and
            other.until("tissue.states > 10 && document.getElementById('tick_rate').textContent.endsWith('Hz')"), other.text("space_fault"))
        other.choose("model", 1)
        check("a browser that cannot draw solids accepts a plane model", other.until("tissue.dimension === 2 && document.getElementById('space_fault').textContent === ''"))
        other.choose("model", 0)
        check("a second change of model directly after the first is done too", other.until("tissue.dimension === 3"), other.js("tissue.dimension"))
    finally:
        other.end()


def relaxes(page, program, model, folder):
    """The same block with Maxwell branches. The FE force through them is recomputed from the states of the page."""
    tau, share = numpy.array([0.1, 1, 5]), numpy.array([0.30, 0.25, 0.20])
    with h5py.File(shutil.copy(model, Path(folder) / "relaxes.h5"), "r+") as f:
        f["law/relaxation_time"], f["law/contact_share"] = tau, share
        f["law/share"] = numpy.tile(share, (len(f["law/constants"]), 1))
        f.attrs["format_version"] = 5.0
    server = Server(program, [Path(folder) / "relaxes.h5"], folder)
    try:
        page.open(server.url)
        page.until("tissue.solids !== null && tissue.states > 0")
        check("the page gives the relative moduli and times of a relaxing model", "The tissue relaxes: 30\xa0% of the force with a relaxation time of 0.1\xa0s, 25\xa0% with 1\xa0s" in
              page.text("about"), page.text("about"))
        deepest = page.js("tissue.place(0).depth_m")
        set_depth(page, 900 * deepest)
        page.js("document.getElementById('space').focus()")
        page.key("Space")
        page.until("tissue.pressed === 0")
        began = page.js("tissue.time_s")
        # long enough for the force to persist although a busy browser releases and indents late
        page.until(f"tissue.time_s > {began} + 3")
        remembered = "tissue.pressed === 0 && tissue.off_FE === null && document.getElementById('verdict').textContent.startsWith('Force of an earlier indentation remains')"
        page.key("Space")
        page.until(free)
        page.key("Space")
        check("an indentation before an earlier one has decayed is not compared, and the page says what to do", page.until(remembered) and
              page.text("verdict").endswith("wait, or press Reset.") and page.js("Number.isNaN(tissue.fe_felt_N[0])"),
              [page.text("verdict"), page.js("tissue.fe_felt_N")])
        page.key("Space")
        page.until(free)
        page.js("document.getElementById('reset').click()")
        page.until(f"{free} && Math.max(...{moved}) < 1e-6")
        page.js("""window.seen = [], (function look(before) {
            if (tissue.states !== before) window.seen.push([tissue.time_s, tissue.pressed, tissue.contact_moved_m[0], tissue.fe_felt_N[0], tissue.nearest]);
            setTimeout(look, 2, tissue.states);
        })()""")
        page.key("Space")
        page.until("tissue.pressed === 0 && tissue.off_FE !== null && document.getElementById('verdict').textContent.startsWith('Force error')")
        check("after Reset the page compares with the FE force through the Maxwell branches", "the FE force without relaxation, passed through the Maxwell branches"
              in page.text("basis"), page.text("basis"))
        first = page.js("tissue.off_FE[0]")
        page.until("Math.abs(tissue.fe_felt_N[0]) < 0.75 * tissue.fe_N")
        page.after(60)
        later = page.js("tissue.off_FE[0]")
        check("the error changes by less than 0.02 while both forces relax", None not in (first, later) and abs(later - first) < 0.02, [first, later])
        seen = page.js("window.seen")
        curve = numpy.array(page.js("tissue.place(arguments[0])", seen[-1][4])["curve"])
        q, now, before, off = numpy.zeros(3), 0, seen[0][0], []
        for time_s, pressed, push, felt, _ in seen[1:]:
            dt, at_once = time_s - before, numpy.interp(math.hypot(*push), *curve.T) if pressed == 0 else 0
            before = time_s
            if dt == 0:
                continue
            left = numpy.exp(-dt / tau)
            q = left * q + share * (1 - left) * tau / dt * (at_once - now)
            now = at_once
            off.append(abs(felt - (1 - sum(share)) * now - sum(q)))
        check("the FE force is the curve at the learned depth through the Maxwell branches since the start of the indentation",
              len(off) > 60 and max(off) < 0.02 * curve[-1, 1], [len(off), max(off), curve.tolist()])
        page.key("Space")
    finally:
        server.end()


def ending(page, program, models, folder, server, block):
    check("the console has no warnings or errors", (seen := [c for c in dict.fromkeys(page.complaints())
          if "GPU stall" not in c]) == [], seen[:5])   # from pictures with WebGL in software
    page.mouse("Pressed", *block.top(0.5, 0.5))
    page.until(f"tissue.control.holder === 'you' && {force} > 0")
    server.end()
    check("the page of a solid reports the end of the server and stops the indentation", page.until("document.getElementById('connection').dataset.state !== 'open'") and
          page.until("document.getElementById('notice').textContent === 'Server: the program ends. Trying again.'") and
          page.until("tissue.pressing === null"), [page.text("connection"), page.text("notice")])
    page.mouse("Released", *block.top(0.5, 0.5))
    again = Server(program, models, folder, port=server.port)
    try:
        states = page.js("tissue.states")
        check("the page of a solid reconnects by itself", page.until(f"tissue.connected && tissue.states > {states + 3}") and
              page.until(f"tissue.pressed === 0 && {moved}[0] > 1e-3"), page.text("connection"))
    finally:
        again.end()


def carried(page, program, models, folder, block):
    """The block's surface with each facet divided into four: finer than the model's, and in millimetres, as that of a
    segmentation."""
    corners = 1e3 * block.nodes[block.facets]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    triangles = numpy.concatenate([numpy.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    file = Path(folder) / "organ.stl"
    file.write_text("solid organ\n" + "".join("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in t) + "endloop\nendfacet\n"
                                              for t in triangles) + "endsolid organ\n")
    server = Server(program, models, folder, "--surface", str(file), "--unit", "mm")
    try:
        page.open(server.url)
        drawn = "(tissue.solids || [{facets: 0}])"
        check("the organ's own surface is drawn on both meshes", page.until(f"{drawn}.every(s => s.facets === {len(triangles)})"), page.js("tissue.solids"))
        answers = [urlopen(Request(server.url + "surface", method=method)) for method in ("GET", "HEAD")]
        sent, long = answers[0].read(), 8 + 36 * len(numpy.unique(triangles.reshape(-1, 3), axis=0)) + 12 * len(triangles)
        check("the organ's surface has the length of PROTOCOL.md, for GET and HEAD", len(sent) == long and [int(a.headers["Content-Length"]) for a in answers] == [long] * 2, [len(sent), long])
        page.until(f"tissue.pressed === 0 && Math.min(...{drawn}.map(s => s.farthest_m)) > 1e-3")
        page.js("document.getElementById('pause').click()")
        page.until("tissue.control.paused")
        # its vertices are nodes of the mesh or lie between them
        both = f"[{drawn}.map(s => s.farthest_m), tissue.largest_displacement_m]"
        check("the organ's own surface moves with the meshes", page.until(f"(([own, mesh]) => own.every((x, m) => Math.abs(x / mesh[m] - 1) < 1e-3))({both})"), page.js(both))
        page.js("document.getElementById('pause').click()")
        page.js("document.getElementById('carried_wanted').click()")
        check("the model's own surface can be drawn instead", page.until(f"{drawn}[0].facets === {len(block.facets)}"), page.js("tissue.solids"))
        page.js("document.getElementById('carried_wanted').click()")
        page.until(f"{drawn}[0].facets === {len(triangles)}")
        page.mouse("Pressed", *block.top(0.5, 0.5))
        check("the organ's own surface can be indented", page.until(f"tissue.control.holder === 'you' && tissue.pressed === 0 && {force} > 0"), page.js("tissue.control"))
        page.mouse("Released", *block.top(0.5, 0.5))
        page.choose("model", 1)
        page.until("tissue.dimension === 2")
        page.choose("model", 0)
        check("the organ's own surface is drawn again after another model", page.until(f"tissue.dimension === 3 && {drawn}[0].facets === {len(triangles)}"), page.js("tissue.solids"))
    finally:
        server.end()


def tumour(page, program, model, folder, block):
    """The same block with an octahedral nodule in its middle, as training writes it. Its eval.json is that of the block
    without nodule."""
    place, middle, radius = Path(folder) / "nodule", (block.low + block.high) / 2, 0.3 * (block.high - block.low).min()
    place.mkdir()
    shutil.copy(Path(model).with_name("eval.json"), place)
    with h5py.File(shutil.copy(model, place), "r+") as f:
        f["nodule/points"] = middle + radius * numpy.concatenate([numpy.eye(3), -numpy.eye(3)])
        f["nodule/triangles"] = numpy.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]], dtype="int32")
    server = Server(program, [place / Path(model).name], folder)
    shown = "(tissue.solids || [{}])[0].nodule"
    try:
        page.open(server.url)
        page.until(f"{shown} && tissue.states > 0")
        check("a model with a nodule offers to show it and hides it at first", page.js(f"!document.getElementById('nodule_row').hidden && !{shown}.shown"), page.js("tissue.solids"))
        check("an evaluation of another model gives no error map, and the server gives the reason", page.js("document.getElementById('errors_row').hidden") and
              "eval.json is not used: it is of another model" in server.log.read_text(), server.log.read_text())
        take_over(page, block)
        page.js("document.getElementById('reset').click()")
        page.until(f"{free} && Math.max(...{moved}) < 1e-5")
        page.click("pause")   # otherwise the demo indents
        page.until("tissue.control.paused")
        view = page.js("tissue.view")
        turned, down = math.radians(view["azimuth"]), (block.high[2] - middle[2]) / math.tan(math.radians(view["elevation"]))
        # the nodule lies behind the first
        spots = [[middle[0] + down * math.cos(turned), middle[1] + down * math.sin(turned), block.high[2]], block.top(0.1, 0.9)]
        before = [colour(page, spot) for spot in spots]
        page.click("nodule_wanted")
        page.until(f"{shown}.shown")
        page.after(5)
        after = [colour(page, spot) for spot in spots]
        check("a shown nodule is red through the organ, and the organ beside it is lighter and not red", after[0][0] > after[0][1:].max() + 25 and
              after[1][1] > before[1][1] + 40 and after[1][0] < after[1][2] + 10, [before, after])
        check("at rest the nodule has no displacement", page.js(f"{shown}.farthest_m") < 1e-5, page.js(shown))
        page.click("pause")
        page.until("!tissue.control.paused")
        set_depth(page, 5)
        page.mouse("Pressed", *block.top(0.5, 0.5))
        page.until("tissue.pressing && tissue.pressing.depth_m > 0.0049")
        page.after(30)
        told = page.js(f"[{shown}.farthest_m, tissue.largest_displacement_m[0]]")
        check("under an indentation the nodule moves by 3 to 80 per cent of the largest displacement", 0.03 * told[1] < told[0] < 0.8 * told[1], told)
        page.mouse("Released", *block.top(0.5, 0.5))
        page.until(free)
        page.click("nodule_wanted")
        page.until(f"!{shown}.shown")
    finally:
        server.end()


def set_of(role):
    """The text of the page for a role of eval.json."""
    return {"validation": "validation set", "held_out": "test set"}.get(role) or role.replace("held_out_", "test set, ").replace("_", " ")


def error_map(page, program, model, folder, block):
    """The model with its evaluation, in which one drawn contact has no answer."""
    place = Path(folder) / "evaluated"
    place.mkdir()
    shutil.copy(model, place)
    evaluation = json.loads(Path(model).with_name("eval.json").read_text())
    gone = evaluation["drawn"]["held_out"][0]
    gone["error"]["learned"] = None
    (place / "eval.json").write_text(json.dumps(evaluation))
    drawn = [(row["contact_m"], row["error"]["learned"], role) for role, rows in evaluation["drawn"].items() for row in rows]
    server = Server(program, [place / Path(model).name], folder)
    try:
        page.open(server.url)
        page.until("tissue.solids !== null && tissue.states > 0")
        check("a model with an evaluation and no nodule offers only an error map", page.js(
            "!document.getElementById('errors_row').hidden && document.getElementById('nodule_row').hidden && tissue.error_map === null"))
        take_over(page, block)
        page.click("errors_wanted")
        page.until("tissue.error_map !== null")
        page.after(5)
        check("the legend's text for screen readers names the error of contact force", "error of contact force" in page.js("document.getElementById('space_legend').getAttribute('aria-label')"))
        seen = page.js("tissue.error_map")
        by_contact = {tuple(numpy.round(spot["contact_m"], 9)): spot for spot in seen["spots"]}
        trained = {row["name"]: row["error"] for row in evaluation["trained_errors"]}
        told = [error for spot in seen["spots"] for error in spot["errors"]]
        check("the error map has every trained and drawn contact with the error of the evaluation", len(told) == len(drawn) + len(trained) and
              all(by_contact[tuple(numpy.round(at, 9))]["errors"] == [error] for at, error, _ in drawn) and
              sorted(e for e in told if e is not None) == sorted([*trained.values(), *(e for _, e, _ in drawn if e is not None)]), [seen, drawn])
        size = numpy.linalg.norm(block.high - block.low) / 2
        off = lambda spot: list(numpy.array(spot["contact_m"]) - 0.012 * size * numpy.array(spot["inward"]))
        at, error, role = max((d for d in drawn if d[1] is not None), key=lambda d: abs(d[0][0] - 0.5 * (block.low + block.high)[0]))
        spot, wanted = by_contact[tuple(numpy.round(at, 9))], numpy.array(matplotlib.colormaps["viridis"](error / seen["worst"])[:3]) * 255
        check("a dot has the colour of its error on the legend's scale", numpy.abs(colour(page, off(spot)) - wanted).max() < 14, [colour(page, off(spot)), wanted])
        page.mouse("Moved", *off(spot))
        number = f"{100 * error:.1f}" if 100 * error < 9.95 else f"{100 * error:.0f}"
        check("the pointer on a dot shows the error and its role", page.until("!document.getElementById('error_tip').hidden") and
              page.text("error_tip").startswith(f"error {number}\xa0%: {set_of(role)}"), page.text("error_tip"))
        near = min((d for d in drawn if d[1] is not None), key=lambda d: numpy.linalg.norm(d[0] - numpy.array(block.top(0.5, 0.5))))
        page.js("document.querySelector('#space_stage canvas[tabindex]').focus()")
        page.key("+", times=5)
        check("zooming hides the number beside a dot", page.until("document.getElementById('error_tip').hidden"))
        page.mouse("Moved", *off(by_contact[tuple(numpy.round(near[0], 9))]))
        check("after zooming the pointer on a dot shows its role", page.until("!document.getElementById('error_tip').hidden") and
              page.text("error_tip").endswith("° from straight in") and set_of(near[2]) in page.text("error_tip"), [near, page.text("error_tip")])
        page.key("Home")
        lost = by_contact[tuple(numpy.round(gone["contact_m"], 9))]
        page.mouse("Moved", *off(lost))
        check("a contact without an answer is a white cross with a text", page.until("document.getElementById('error_tip').textContent.startsWith('no answer: test set')") and
              colour(page, off(lost)).min() > 225, [page.text("error_tip"), colour(page, off(lost))])
        page.click("errors_wanted")
        check("the error map can be switched off", page.until("tissue.error_map === null && document.getElementById('error_tip').hidden"))
    finally:
        server.end()


def two_tools(page, program, model, folder, block):
    """A session of two tools: left in the tissue one after the other, led by two fingers, held by two pages."""
    server = Server(program, [model], folder, "--tools", "2", "--no-realtime")
    second = "(tissue.second && tissue.second.pressed === 0 ? Math.hypot(...tissue.second.force_N) : 0)"
    left, right = block.top(0.3, 0.5), block.top(0.7, 0.5)
    try:
        page.resize(1360, 900)
        page.open(server.url)
        page.until("tissue.connected && tissue.solids !== null && tissue.states > 0")
        page.complaints()  # discards those about servers that have ended
        check("a session of two tools has its own title and one solid", page.js("tissue.tools") == 2 and page.text("title") == "Two tools on one tissue" and page.js("tissue.solids.length") == 1)
        page.click("stays")
        for k, (at, mm) in enumerate(((left, 4), (right, 2.5))):
            set_depth(page, mm)
            page.mouse("Pressed", *at)
            page.until(f"tissue.control.holders[{k}] === 'you'")
            page.mouse("Released", *at)
            check("a tool stays in the tissue after release of the mouse", page.until(f"tissue.control.holders[{k}] === 'you' && {[force, second][k]} > 0.03", 20), page.js(f"[{force}, {second}]"))
        check("the page holds both tools, both have a force, and the first keeps its depth", page.until(
            f"{force} > 1.3 * {second} && {second} > 0.03 && tissue.control.holders.join() === 'you,you' && Math.abs({depth} - 0.004) < 5e-4", 20), page.js(f"[{force}, {second}, {depth}, tissue.control]"))
        check("the force of the second tool is shown", page.until(f"Math.abs(parseFloat(document.getElementById('second_force').textContent) - {second}) < 0.02 && {second} > 0"), [page.text("second_force"), page.js(second)])
        check("under two tools nothing is compared", page.until("tissue.off_FE === null") and page.text("verdict").startswith("Two tools indent"), page.text("verdict"))
        check("each tool is within 3 mm of its chosen x", abs(page.js("tissue.second.tool_m[0]") - right[0]) < 3e-3 and abs(page.js("tissue.hand_m[0]") - left[0]) < 3e-3, [page.js("tissue.second.tool_m"), right])
        for k, at in enumerate((block.top(0.25, 0.5), block.top(0.75, 0.5))):
            page.mouse("Pressed", *at)
            page.after(5)
            page.mouse("Released", *at)
            where = ["tissue.hand_m[0]", "tissue.second.tool_m[0]"][k]
            check("a further indentation moves the tool that has stayed longest", page.until(f"Math.abs({where} - {at[0]}) < 3e-3", 20), page.js(where))
        page.key("Escape")
        check("Escape releases both tools", page.until(f"tissue.control.holders.every(holder => holder !== 'you') && {second} === 0", 20), page.js("tissue.control"))
        page.click("stays")

        fingers = [dict(zip("xy", page.on_screen(*p)), id=k) for k, p in enumerate((left, right))]
        page.cdp("Input.dispatchTouchEvent", type="touchStart", touchPoints=fingers[:1])
        page.after(5)
        page.cdp("Input.dispatchTouchEvent", type="touchStart", touchPoints=fingers[1:])
        check("two fingers on the solid indent with both tools", page.until(f"{force} > 0.03 && {second} > 0.03", 20), page.js(f"[{force}, {second}, tissue.view.zoom]"))
        page.cdp("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{**finger, "x": finger["x"] + (40 if k else -40)} for k, finger in enumerate(fingers)])
        page.after(10)
        check("two dragged fingers tilt the first tool's displacement and do not zoom", page.js("tissue.view.zoom") == 1 and page.js("tissue.pressing.direction[0]") < -0.02, page.js("[tissue.view.zoom, tissue.pressing]"))
        page.cdp("Input.dispatchTouchEvent", type="touchEnd", touchPoints=fingers[:1])
        check("the first of two fingers releases the first tool alone", page.until(f"{force} === 0 && {second} > 0.05", 20), page.js(f"[{force}, {second}]"))
        page.cdp("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        page.until(f"{free} && tissue.second.pressed === -1", 20)

        other = Browser(flags=SOLID)
        try:
            other.open(server.url)
            other.until("tissue.connected && tissue.solids !== null && tissue.states > 0")
            page.mouse("Pressed", *left)
            page.until(f"tissue.control.holder === 'you' && {force} > 0.05", 20)
            check("another page is offered the free tool", other.until("tissue.control.holder === 'other'") and other.until(
                "document.getElementById('notice').textContent.includes('You can indent with the other one')"), other.text("notice"))
            other.mouse("Pressed", *right)
            check("another page indents with the second tool", other.until(f"tissue.control.holders.join() === 'other,you' && {force} > 0.03 && {second} > 0.03", 20), other.js("tissue.control"))
            check("the Pause button is disabled while each page holds one tool", page.until("document.getElementById('pause').disabled") and page.text("notice").startswith("You hold one tool"), page.text("notice"))
            page.mouse("Released", *left)
            check("the second tool keeps its force after release of the first", other.until(f"{force} === 0 && {second} > 0.03", 20), other.js(f"[{force}, {second}]"))
            other.mouse("Released", *right)
            complaints = page.complaints() + other.complaints()
            check("the consoles of both pages have no warnings or errors", complaints == [], complaints[:2])
        finally:
            other.end()
    finally:
        server.end()


def grasping(page, program, model, folder, block):
    """A model whose contact may be pulled, with the box Grasp: the solid is lifted, and falls back after the release."""
    pulled = Path(folder) / "pulled.h5"
    shutil.copy(model, pulled)
    with h5py.File(pulled, "r+") as f:
        old = f["law/terms"]
        terms = [term.replace(b"contact.hardening", b"contact.compression") for term in old[:]]
        attributes, checked = dict(old.attrs), dict(fletcher32=old.fletcher32, chunks=old.chunks)
        del f["law/terms"]
        f.create_dataset("law/terms", data=numpy.array(terms, "S"), **checked).attrs.update(attributes)
    server = Server(program, [str(pulled)], folder)
    try:
        page.open(server.url)
        page.until("tissue.connected && tissue.solids !== null && tissue.states > 0")
        page.complaints()  # discards those about servers that have ended
        check("a model that may be pulled has the box Grasp", page.js("!document.getElementById('grasp_row').hidden && document.getElementById('depth').min === '0'"))
        page.click("grasp")
        set_depth(page, -4)
        page.mouse("Pressed", *block.top(0.5, 0.5))
        lifted = "tissue.pressed === 0 && tissue.contact_moved_m[0][2] > 3.5e-3 && tissue.force_N[2] > 0"
        check("a tool that grasps lifts the solid to the depth below zero", page.until(lifted), page.js("[tissue.pressed, tissue.contact_moved_m, tissue.force_N]"))
        page.mouse("Released", *block.top(0.5, 0.5))
        check("after the release the solid returns", page.until(f"tissue.pressing === null && {force} === 0 && {moved}[0] < 2e-3"), page.js("tissue.largest_displacement_m"))
        page.click("grasp")
        check("without the box the depth is not below zero", page.js("document.getElementById('depth').min === '0' && document.getElementById('depth').value >= 0"))
    finally:
        server.end()


def main(page, folder):
    program, *models = sys.argv[1:]
    block = Block(models[0])
    server = Server(program, models, folder)
    opening(page, server, block)
    pressing(page, block)
    turning(page, block)
    keyboard(page, block)
    finite_elements(page, block)
    standing_still(page, block)
    budget(page, block)
    touching(page, block)
    media(page)
    switching(page)
    without_webgl(server)
    ending(page, program, models, folder, server, block)
    relaxes(page, program, models[0], folder)
    carried(page, program, models, folder, block)
    tumour(page, program, models[0], folder, block)
    error_map(page, program, models[0], folder, block)
    two_tools(page, program, models[0], folder, block)
    grasping(page, program, models[0], folder, block)


if __name__ == "__main__":
    sys.exit(run(main, flags=SOLID))
