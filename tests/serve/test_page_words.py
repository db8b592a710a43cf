"""Texts of the page of `tissuectl serve` in states that real tissue seldom reaches: test_page_words.py TISSUECTL MODEL
[PART...]. The server provides only the files of the page. Models and states are made here and reach the page through a
replaced WebSocket. Prints "ok - sentence" or "not ok - sentence: seen"; exits 1 if any failed."""
import math
import re
import sys
import time

from browser import Server, check, run

SIZE, CELLS, APART = 0.1, 10, 0.15
CURVE = [[0, 0], [0.005, 1], [0.010, 2.5], [0.015, 4.5]]
SOCKET = """
    window.sent = [];
    window.sockets = 0;
    window.WebSocket = class {
        static OPEN = 1;
        constructor() {
            Object.assign(this, { readyState: 0 });
            window.sockets++;
            if (window.refuse) return void setTimeout(() => this.lose(""), 50);
            window.socket = this;
            setTimeout(() => { this.readyState = 1; this.onopen && this.onopen(); });
            // keeps the connection when this test is slow
            setInterval(() => { if (this.readyState === 1 && !window.silent) this.text({ type: "beat" }); }, 500);
        }
        send(text) { window.sent.push(JSON.parse(text)); }
        close() { this.readyState = 3; }
        lose(reason) { this.readyState = 3; this.onclose({ reason }); }
        text(message) { this.onmessage({ data: JSON.stringify(message) }); }
        states(count, gap, head, nodes) {   // each state is `gap` seconds after the previous one
            for (let k = 0; k < count; k++) {
                const buffer = new ArrayBuffer(8 * head.length + 4 * nodes.length), numbers = new Float64Array(buffer, 0, head.length);
                numbers.set(head.map(x => x === null ? NaN : x));
                numbers[0] += k * gap;
                new Float32Array(buffer, 8 * head.length).set(nodes);
                this.onmessage({ data: buffer });
            }
        }
    };"""


def rotated(angle):
    return [math.cos(math.radians(angle)), math.sin(math.radians(angle))]


def nodes_of(mesh):
    return [[mesh * APART + SIZE * i / CELLS, SIZE * j / CELLS] for j in range(CELLS + 1) for i in range(CELLS + 1)]


def place(name, contact, direction, curve=CURVE):
    return {"name": name, "contact_m": contact, "direction": direction, "depth_m": curve[-1][0], "curve": curve}


LEFT = [place("left", [0, 0.05], [1, 0])]


def model_of(places, **more):
    n = CELLS + 1
    springs = [[j * n + i, j * n + i + 1] for j in range(n) for i in range(CELLS)] + [[j * n + i, j * n + n + i] for j in range(CELLS) for i in range(n)]
    rim = [i for i in range(n)] + [j * n + CELLS for j in range(1, n)] + [CELLS * n + i for i in range(CELLS - 1, -1, -1)] + [j * n for j in range(CELLS - 1, 0, -1)]
    meshes = [{"name": name, "nodes_m": nodes_of(m), "fixed": list(range(n)), "springs": springs, "stiffness_N_m": [1] * len(springs), "outline": rim}
              for m, name in enumerate(("learned", "heuristic"))]
    return {"type": "model", "study": "made", "models": ["made"], "model": 0, "dimension": 2, "law": True, "tools": 1, "dt_s": 0.001, "force_max_N": 3, "force_scale": 1,
            "dynamics": {"learned": "implicit", "heuristic": "implicit"}, "node_count": n * n, "spring_count": len(springs), "low_m": [0, 0],
            "high_m": [APART + SIZE, SIZE], "meshes": meshes, "places": places, "demo": 0, **more}


class Page:
    """The page with the clock and the tissue of this test."""

    def __init__(self, browser, url):
        self.browser, self.url, self.time = browser, url, 0

    def open(self, model, control=None):
        self.browser.open(self.url)
        self.browser.until("Boolean(window.socket && socket.readyState === 1 && socket.onmessage)")
        self.time = 0
        self.come(model, control)

    def come(self, model, control=None):
        self.say(model)
        self.say({"type": "near", "place": -1, "distance_m": 0, "outline": []})
        self.control(**(control or {}))

    def say(self, message):
        self.browser.js("socket.text(arguments[0])", message)

    def control(self, holder="nobody", paused=False, place=-1):
        self.say({"type": "control", "holder": holder, "holders": [holder], "paused": paused, "place": place})

    def states(self, count, moved=((0, 0), (0, 0)), force=(0, 0), pressed=0, where=0, contact=(0, 0.05), shift=None, gap=1 / 60, tool=(-0.03, 0.05), status=0, behind=0):
        """Sends `count` states of a tool at rest, without contact at `tool`. behind: distance of the tool behind the
        hand [m]; shift: displacement by node of the heuristic mesh [m]."""
        nodes = [x for m in (0, 1) for k, p in enumerate(nodes_of(m)) for x in (p if m == 0 or not shift or k not in shift else [a + b for a, b in zip(p, shift[k])])]
        head = [0.0] * 32
        head[0], head[6], head[13], head[22], head[23], head[24], head[26] = self.time + gap, 1000, pressed, where if pressed >= 0 else -1, 1, -1, 1
        head[9:13] = [contact[0] + moved[0][0], contact[1] + moved[0][1]] * 2 if pressed >= 0 else [*tool] * 2
        head[9] += behind
        head[14:20] = [*moved[0], *moved[1], *force]
        head[28:31] = [status, *contact]
        self.browser.js("socket.states(...arguments)", count, gap, [None if math.isnan(x) else x for x in head], nodes)
        self.time += count * gap

    def verdict(self):
        """The verdict after the page has evaluated the newest state, which it does five times a second."""
        self.browser.driver.execute_async_script("setTimeout(arguments[0], 450)")
        return self.browser.text("verdict").replace("\xa0", " ")

    def press(self, learned, heuristic, force, count=40, **more):
        """Indents and returns the verdict. learned, heuristic: depth [mm] and angle from straight in [degrees]."""
        self.states(5, pressed=-1)
        self.states(count, [[1e-3 * d * x for x in rotated(a)] for d, a in (learned, heuristic)], force, **more)
        return self.verdict()


def central_sentence(page):
    page.open(model_of(LEFT))
    said = page.press((5, 0), (7.5, 0), (1.1, 0))
    check("each mesh is compared with FE at its own depth", said == "Force error against the FE reference: learned mesh +10 %, heuristic mesh −37 %.", said)
    wrong = []
    for depth in (1.5, 3, 5, 8, 12, 14):
        for angles in ((0, 0), (0, 8), (0, -20), (4, 12), (3, 3), (-2, 40), (9, 0), (15, 15), (30, -30), (0, 90)):
            said = page.press((depth, angles[0]), (1.1 * depth, angles[1]), (1, 0))
            if "deeper" in said or "beyond" in said:
                wrong.append([depth, angles, said])
    check("in 60 states up to 1.03 times the deepest FE depth the page never says deeper", wrong == [], [len(wrong), wrong[:2]])
    said = page.press((5, 0), (5, 12), (1, 0))
    check("the verdict names a heuristic mesh that moves in another direction", said.endswith("; the heuristic mesh is displaced in another direction than the FE reference."), said)
    said = page.press((5, 0), (0.4, 0), (1, 0))
    check("the verdict names a heuristic mesh that is indented less than 1 mm", said.endswith("; the heuristic mesh is indented less than 1 mm."), said)
    said = page.press((10, 0), (17, 0), (2.5, 0))
    check("the verdict names the one mesh that is deeper than the FE reference", said == "Force error against the FE reference: learned mesh 0.0 %; the heuristic mesh is indented deeper than the FE reference.", said)
    said = page.press((16.5, 0), (17, 0), (5, 0))
    check("the verdict names both meshes if both are deeper than the FE reference", said == "No comparison: each mesh is indented deeper than the FE reference.", said)
    page.states(5, pressed=-1)
    for k in range(30):
        page.states(1, [[0.0002 * k + 0.002, 0]] * 2, (1, 0))
    said = page.verdict()
    check("the verdict has no percentage for a mesh in motion", said.startswith("In motion: ") and "%" not in said, said)
    said = page.press((5, 0), (5, 0), (1, 0), contact=(0, 0.057))
    check("7 mm from a known contact the verdict has both forces and no percentage", said ==
          "No FE reference here: at the nearest known contact, 7.0 mm away, the FE force is 1.00 N; the learned mesh here has 1.00 N.", said)
    said = page.press((5, 0), (5, 0), (1, 0), contact=(0, 0.08))
    check("30 mm from a known contact nothing is compared", said == "The nearest known contact is 30.0 mm away: too far to compare.", said)


def not_a_number(page):
    page.open(model_of(LEFT))
    page.states(5, pressed=-1)
    page.states(20, [[0.005, 0]] * 2, (1.1, 0))
    page.verdict()
    ink = """(c => [...c.getContext('2d').getImageData(0, 0, 44, c.height).data].filter((v, k) => k % 4 === 3 && v > 0).length)(document.getElementById('depth_plot'))"""
    labels = page.browser.js(ink)   # painted pixels of the force axis
    page.states(1, [[0.005, 0], [math.nan, 0]], (math.nan, 0))
    page.states(9, [[0.005, 0]] * 2, (1.1, 0))
    said = page.verdict()
    check("a state with NaN does not hide the other states", said == "Force error against the FE reference: learned mesh +10 %, heuristic mesh +10 %.", said)
    check("a state with NaN does not erase the labels of the force axis", page.browser.js(ink) == labels > 100, [labels, page.browser.js(ink)])
    page.open(model_of(LEFT, relaxation={"tau_s": [0.05, 0.5], "share": [0.3, 0.3]}))
    page.states(60, pressed=-1)
    page.states(20, [[0.005, 0]] * 2, (0.5, 0))
    page.states(1, [[math.nan, 0]] * 2, (math.nan, 0))
    page.states(1, [[0, 0]] * 2, (math.nan, 0), pressed=-1)
    page.states(600, pressed=-1)
    page.states(40, [[0.005, 0]] * 2, (0.5, 0))
    said = page.verdict()
    check("relaxing tissue is compared again once earlier forces have decayed", said.startswith("Force error against the FE reference: learned mesh "), said)
    said = page.press((5, 0), (5, 0), (0.5, 0))
    check("the verdict still reports an earlier indentation whose force has not decayed", said.startswith("Force of an earlier indentation remains"), said)


def many(page):
    contacts = [place(f"p{k}", [0, 0.1 * (k + 1) / 601], [1, 0]) for k in range(600)]
    page.open(model_of(contacts))
    page.states(5, pressed=-1)
    listed = page.browser.js("document.querySelectorAll('#contact option').length")
    check("600 contacts are listed and the page continues", listed == 601 and page.verdict().startswith("Nothing touches the tissue."),
          [listed, page.verdict(), page.browser.complaints()[:2]])
    long = page.browser.driver.execute_async_script("""
        const [contact, done] = arguments;
        import("./vectors.js").then(v => done([v.largest(new Float64Array(1e6).fill(1), 0), v.smallest(Array(1e6).fill(2)), v.largest([NaN, 1, Infinity])]), error => done(String(error)));""", 0)
    check("largest and smallest accept a million numbers, and largest skips numbers that are not finite", long == [1, 2, 1], long)


def left_behind(page):
    page.open(model_of(LEFT))
    page.states(5, pressed=-1)
    said = page.verdict()
    check("at rest the page invites the user to drag", said == "Nothing touches the tissue. Drag into a mesh, or play the demo.", said)
    fold = {60: [0.016, 0]}   # a node in the middle, displaced past the next one
    for _ in range(5):
        page.states(3, pressed=-1, shift=fold)
        said = page.verdict()
    check("the page reports a mesh that stays inverted", said == "Nothing touches the tissue, but the heuristic mesh is inverted, 16.0 mm from rest. Reset puts it to rest.", said)
    page.states(3, pressed=-1, shift={60: [0.0161, 0]})
    said = page.verdict()
    check("the page reports an inverted mesh after a further small displacement", "the heuristic mesh is inverted" in said, said)
    page.states(3, pressed=-1, shift={60: [0.004, 0]})
    said = page.verdict()
    check("the page reports an oscillating mesh as returning to rest", said == "Nothing touches the tissue; it returns to rest.", said)
    for _ in range(5):
        page.states(3, pressed=-1, shift={60: [0.003, 0]})
        said = page.verdict()
    check("the page reports a mesh that stays away from rest", said == "Nothing touches the tissue, but the heuristic mesh is in equilibrium 3.0 mm from rest. Reset puts it to rest.", said)
    said = page.press((5, 0), (5, 0), (1.1, 0), shift=fold)
    check("an inverted mesh is not compared", said == "Force error against the FE reference: learned mesh +10 %; the heuristic mesh is inverted.", said)


def without_force(page):
    page.open(model_of(LEFT), {"holder": "you"})
    for status, words in ((1, "position was refused"), (2, "has left the tissue"), (3, "is self-intersecting"), (4, "diverged and was reset")):
        page.states(5, pressed=-1, status=status, tool=(0.01, 0.05))
        said = page.verdict()
        check(f"without force the page states the cause ({words}) and does not invite", said.startswith("No force") and words in said and not re.search("[Pp]ress|[Dd]rag|[Pp]lay", said), said)
    page.states(5, pressed=-1)
    said = page.verdict()
    check("the page invites again after the cause has ended", said.startswith("Nothing touches the tissue. Drag"), said)


def limit(page):
    page.open(model_of(LEFT))
    page.states(5, pressed=-1)
    page.states(40, [[0.005, 0]] * 2, (1.1, 0), behind=0.01)
    said = page.verdict()
    check("a tool behind the hand is compared at the point where it touches the tissue", said == "Force error against the FE reference: learned mesh +10 %, heuristic mesh +10 %." and
          page.browser.js("tissue.distance_m") < 1e-9, [said, page.browser.js("tissue.distance_m")])


def relaxing(page):
    relaxation = {"tau_s": [0.05, 10], "share": [0.3, 0.3]}
    page.open(model_of(LEFT, relaxation=relaxation))
    page.states(60, pressed=-1)
    for k in range(8):
        page.states(3, pressed=-1, shift={60: [0.004 - 0.00006 * k, 0]})
        said = page.verdict()
    check("the page does not report slowly relaxing tissue as still", said.startswith("Nothing touches the tissue, which relaxes: the heuristic mesh is still 3."), said)
    page.open(model_of(LEFT, relaxation=relaxation))
    page.states(60, pressed=-1)
    page.states(10, [[1e-3 * 5 * x for x in rotated(8)]] * 2, (0.5, 0))
    page.states(40, [[0.005, 0]] * 2, (0.5, 0))
    said = page.verdict()
    check("an indentation that left the FE directions is not reported as an earlier indentation", said.startswith("Part of this indentation had no FE reference"), said)


def headings(page):
    first = lambda model: (page.open(model), page.browser.text("title"), page.browser.text("lead").replace("\xa0", " "))[1:]  # noqa: E731
    title, lead = first(model_of(LEFT))
    check("the heading of a model with two meshes names both and the curve", title == "The same force on two meshes" and "thick curve" in lead, [title, lead])
    title, lead = first(model_of([{**LEFT[0], "curve": []}]))
    check("the heading of a model without curves does not mention a curve", title == "The same force on two meshes" and "curve" not in lead, [title, lead])
    alone = model_of(LEFT)
    alone["meshes"] = alone["meshes"][:1]
    title, lead = first(alone)
    check("the heading of a model with one mesh does not mention a second mesh", title == "Force on a trained mesh" and not re.search("two|either|both|heuristic", lead), [title, lead])
    page.open(model_of(LEFT, learns=True))
    said = page.browser.text("reading_text").replace("\xa0", " ")
    check("the page of an adapting model explains a measurement and its force limit", "hold still for a second" in said and "at its limit of 3.00 N" in said, said)
    page.say({"type": "learned", "reading": {"contact_m": [0, 0.05], "push_m": [0.005, 0], "status": "learned", "why": "", "warning": ""}})
    page.say({"type": "learned", "ended": "there is no room left"})
    said = page.browser.text("reading_text")
    check("the page reports the end of adaptation and its cause", said == "Adaptation has ended: there is no room left. The model stays as adapted.", said)


def standing(page):
    """Texts that change while a pointer is on the tissue do not move the stage."""
    box = """(() => { const b = document.getElementById('stage').getBoundingClientRect();
        return [b.left, b.top, b.width, b.height, document.documentElement.scrollHeight]; })()"""
    for width, height in ((1360, 900), (1024, 700), (880, 700), (700, 900), (390, 844)):
        page.browser.resize(width, height)
        page.open(model_of(LEFT))
        page.states(5, pressed=-1)
        seen = {}
        for holder, paused, k in (("nobody", False, -1), ("you", False, -1), ("demo", False, 0), ("nobody", True, -1), ("other", False, -1)):
            page.control(holder, paused, k)
            page.states(3, pressed=-1)
            page.verdict()
            seen[holder, paused] = page.browser.js(box)
        for name, press in (("compared", [(5, 0), (7, 0), (1, 0)]), ("another way", [(5, 0), (5, 12), (1, 0)]), ("deep", [(16.5, 0), (17, 0), (5, 0)])):
            page.press(*press)
            seen[name] = page.browser.js(box)
        first = seen["nobody", False]
        moved = {key: [b - a for a, b in zip(first, value)] for key, value in seen.items() if any(abs(b - a) > 0.01 for a, b in zip(first, value))}
        check(f"{width} x {height}: changes of holder and verdict do not move the stage", moved == {}, moved)
    page.browser.resize(1360, 900)


def lost(page):
    page.open(model_of(LEFT), {"holder": "demo", "place": 0})
    page.states(5, pressed=-1)
    page.verdict()
    page.browser.js("(window.refuse = true, socket.lose('the program ends'))")
    said = page.verdict()
    check("a page without connection reports it in the verdict and does not invite", said == "No connection: the picture is the last one received." and
          not re.search("[Pp]ress|[Dd]rag|[Pp]lay", said + page.browser.text("notice")), [said, page.browser.text("notice")])
    check("without connection the stage is faint and its cursor is not-allowed", page.browser.js("""(s => [Number(s.opacity) < 0.5, s.cursor])
        (getComputedStyle(document.getElementById('stage')))""") == [True, "not-allowed"])
    check("without connection force and tick rate are blank", page.browser.text("force") == "–" and page.browser.text("tick_rate") == "–", page.browser.text("force"))
    page.browser.js("window.sent.length = 0")
    x, y = page.browser.on_screen(-0.01, 0.05)
    page.browser.mouse_at("Pressed", x, y)
    check("without connection a press of the mouse sends no pointer message", page.browser.js("window.sent.filter(m => m.type === 'pointer').length") == 0, page.browser.js("window.sent"))
    page.browser.mouse_at("Released", x, y)
    tried = page.browser.js("window.sockets")
    check("the page opens another connection by itself", page.browser.until(f"window.sockets > {tried}", 20), tried)
    page.browser.js("window.refuse = false")
    check("the page is connected once the server accepts", page.browser.until("document.getElementById('connection').textContent === 'connected'", 20), page.browser.text("connection"))
    page.come(model_of(LEFT))
    page.states(5, pressed=-1)
    said = page.verdict()
    check("after reconnection the page invites and shows the tick rate", said.startswith("Nothing touches the tissue. Drag") and page.browser.text("tick_rate") == "1000 Hz", said)
    # prevents a new connection before the verdict is read
    page.browser.js("(window.silent = true, window.refuse = true)")
    began = time.monotonic()
    silent = page.browser.until("document.getElementById('connection').textContent !== 'connected'", 60)
    check("a silent server counts as disconnected, but not before 4 s", silent and time.monotonic() - began > 4 and page.verdict().startswith("No connection"), time.monotonic() - began)


def arrows(page):
    colours = """(() => { const s = document.getElementById('stage'), w = 64, h = 22, top = s.clientHeight - 40,
        d = s.getContext('2d').getImageData(18, top, w, h).data, count = { learned: 0, heuristic: 0, black: 0 };
        for (let k = 0; k < d.length; k += 4) {
            const [r, g, b, a] = d.slice(k, k + 4);
            if (a < 250) continue;
            count.learned += b > r + 120 && b > g + 30; count.heuristic += r > b + 150 && r > g + 80; count.black += r + g + b < 120;
        }
        return count; })()"""
    page.open(model_of(LEFT))
    page.press((5, 0), (7, 0), (2, 0))
    seen = page.browser.js(colours)
    check("the legend's arrow of the tool's force has the colours of both meshes and no black",
          seen["learned"] > 30 and seen["heuristic"] > 30 and seen["black"] == 0, seen)


def snapping(page):
    page.open(model_of([place("left", [0, 0.05], [1, 0]), place("left-20", [0, 0.05], rotated(20))]))
    page.states(5, pressed=-1)

    def pressed_at(down, x, y):
        page.browser.js("window.sent.length = 0")
        page.browser.mouse("Pressed", *down)
        page.browser.mouse("Moved", -0.0005, down[1])
        page.browser.driver.execute_async_script("setTimeout(arguments[0], 300)")
        page.browser.mouse("Moved", x, y)
        # longer than the page waits for the tool, which never arrives here, and then moves in
        page.browser.until("false", 3.2)
        at = page.browser.js("window.sent.filter(m => m.type === 'pointer' && m.down).map(m => [m.x, m.y])")
        page.browser.mouse("Released", x, y)
        return at

    at = pressed_at((-0.02, 0.0525), 0.006, 0.0525)
    check("an indentation that enters 2.5 mm from a known contact moves to it", math.dist(at[-1], [0.006, 0.05]) < 2e-4, at[-1])
    check("the tool moves to the known contact before it enters", any(math.dist(p, [-0.001, 0.05]) < 1e-5 for p in at) and
          all(abs(p[1] - 0.05) < 2e-4 for p in at if p[0] > 0), at)
    at = pressed_at((-0.02, 0.054), 0.006, 0.054)
    check("an indentation 4 mm from a known contact follows the pointer", math.dist(at[-1], [0.006, 0.054]) < 2e-4, at[-1])
    tilted = [0.006 * x for x in rotated(17)]
    at = pressed_at((-0.02, 0.05), tilted[0], 0.05 + tilted[1])
    check("a displacement 3 degrees from a known direction follows that direction", math.dist(at[-1], [0.006 * rotated(20)[0], 0.05 + 0.006 * rotated(20)[1]]) < 3e-4, at[-1])
    tilted = [0.006 * x for x in rotated(-20)]
    at = pressed_at((-0.02, 0.05), tilted[0], 0.05 + tilted[1])
    check("a displacement 20 degrees outside the known directions follows the nearest one", math.dist(at[-1], [0.006, 0.05]) < 3e-4, at[-1])
    tilted = [0.006 * x for x in rotated(-55)]
    at = pressed_at((-0.02, 0.05), tilted[0], 0.05 + tilted[1])
    # from the entry point, which is 0.6 mm lower
    check("a displacement 55 degrees outside the known directions follows the pointer", math.dist(at[-1], [tilted[0], 0.05 + tilted[1]]) < 8e-4, at[-1])
    tilted = [0.006 * x for x in rotated(10)]
    at = pressed_at((-0.02, 0.05), tilted[0], 0.05 + tilted[1])
    check("a displacement midway between two known directions follows the pointer", math.dist(at[-1], [tilted[0], 0.05 + tilted[1]]) < 3e-4, at[-1])
    steps = [math.dist(a, b) for a, b in zip(at, at[1:]) if a[0] > 0]
    check("the tool enters in small steps after a jump of the pointer", len(steps) > 5 and max(steps) < 0.0011, steps)


def clicking(page):
    """A click inside the tissue near its corner: the side is nearer than the top, which has the known contact."""
    page.open(model_of([place("top", [0.0025, 0.1], [0, -1])]))
    page.states(5, pressed=-1)
    page.browser.js("window.sent.length = 0")
    page.browser.mouse("Pressed", 0.0035, 0.093)
    page.browser.until("false", 3.2)
    at = page.browser.js("window.sent.filter(m => m.type === 'pointer' && m.down).map(m => [m.x, m.y])")
    check("after a click inside, the tool enters along the known direction, not through the nearest side", math.dist(at[0], [0.0025, 0.101]) < 2e-4 and
          math.dist(at[-1], [0.0025, 0.093]) < 2e-4, [at[0], at[-1]])
    page.browser.js("window.sent.length = 0")
    page.control("you")
    # a frame in which this page holds the tool without contact: it has left the demo's indentation
    page.browser.until("false", 0.2)
    page.states(2, [[0.001, -0.007]] * 2, (0, -1), contact=(0.0015, 0.1))
    page.browser.until("window.sent.some(m => m.type === 'pointer' && m.down && Math.hypot(m.x - 0.0015, m.y - 0.093) < 2e-4)", 5)
    page.browser.mouse("Released", 0.0035, 0.093)
    at = page.browser.js("window.sent.filter(m => m.type === 'pointer' && m.down).map(m => [m.x, m.y])")
    check("a tool that touches the tissue 1 mm from the contact moves in the known direction from there", len(at) > 0 and
          math.dist(at[-1], [0.0015, 0.093]) < 2e-4, at[-1:])


def taking_over(page):
    """A user takes over while the demo indents. The user's indentation starts after the tool has left the tissue and
    waited before the contact."""
    page.open(model_of(LEFT), {"holder": "demo", "place": 0})
    page.states(5, [[0.005, 0]] * 2, (1, 0))
    page.browser.js("window.sent.length = 0")
    page.browser.mouse("Pressed", 0.006, 0.05)
    page.control("you")
    sent = "window.sent.filter(m => m.type === 'pointer' && m.down).map(m => [m.x, m.y])"
    for _ in range(8):
        page.states(2, [[0.004, 0]] * 2, (1, 0))
        page.browser.until("false", 0.05)
    at = page.browser.js(sent)
    check("a takeover waits outside while the demo's tool is in the tissue", len(at) > 0 and all(p[0] < 0 for p in at), at)
    page.states(1, pressed=-1, tool=(-0.001, 0.05))   # on its way out
    page.browser.until("false", 0.1)
    page.states(1, pressed=-1, tool=(-0.006, 0.05))
    page.browser.until("false", 0.1)
    at = page.browser.js(sent)
    check("a tool that passes the waiting point on its way out does not start the indentation", all(p[0] < 0 for p in at), at)
    page.states(10, pressed=-1, tool=(-0.001, 0.05))
    page.browser.until("false", 0.1)
    page.states(10, pressed=-1, tool=(-0.001, 0.05))
    went = page.browser.until(f"{sent}.some(p => p[0] > 0)", 1)
    check("the indentation starts once the tool rests at the waiting point", went, page.browser.js(sent)[-1:])
    page.browser.mouse("Released", 0.006, 0.05)


def main(browser, folder):
    program, model, *only = sys.argv[1:]
    server = Server(program, [model], folder)
    browser.cdp("Page.addScriptToEvaluateOnNewDocument", source=SOCKET)
    page = Page(browser, server.url)
    for part in (central_sentence, not_a_number, many, left_behind, without_force, limit, relaxing, headings, standing, lost, arrows, snapping, clicking, taking_over):
        if not only or part.__name__ in only:
            part(page)
    seen = [line for line in browser.complaints() if "getImageData" not in line]
    check("the console has no warnings or errors", seen == [], seen[:3])


if __name__ == "__main__":
    sys.exit(run(main))
