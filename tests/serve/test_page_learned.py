"""What the page of `tissuectl serve` shows of a model that has learned from pokes, and of one that
learns while it plays: test_page_learned.py TISSUECTL LEARNED MODEL, LEARNED also being the tissue that MODEL learns from. Prints "ok - sentence" or
"not ok - sentence: seen"; exits 1 if any failed."""
import math
import re
import sys
import tempfile
from pathlib import Path

import h5py
from browser import Browser, Missing, Server

failed = 0


def check(sentence, holds, seen=""):
    global failed
    failed += not holds
    print(f"ok - {sentence}" if holds else f"not ok - {sentence}: {seen}", flush=True)


WARM = """(() => { const c = document.getElementById('stage'), above = c.height - Math.ceil(54 * c.width / c.clientWidth),   // the legend has an arrow of the heuristic mesh, which is red
        d = c.getContext('2d').getImageData(0, 0, c.width / 2, above).data;
    let red = 0; for (let k = 0; k < d.length; k += 4) red += d[k] > d[k + 2] + 60 && d[k] > d[k + 1] + 40; return red; })()"""


def main():
    program, model, nominal = sys.argv[1:]
    with h5py.File(model) as file:
        pokes, x = int(file["adaptation"].attrs["learned"]), file["adaptation/x"][:]
    try:
        page = Browser()
    except Missing as package:
        check("a browser can be driven", False, f"missing package {package}; scripts/install_deps names it")
        return 1
    with tempfile.TemporaryDirectory() as folder:
        server = None
        try:
            server = Server(program, [model], folder)
            page.open(server.url)
            page.until("tissue.connected && tissue.states > 0")
            check("it says from how many pokes it has learned", page.until("!document.getElementById('learned_row').hidden") and
                  page.text("learned_text").startswith(f"what {pokes} pokes have found"), page.text("learned_text"))
            seen = [float(v) for v in re.findall(r"([0-9.]+) to ([0-9.]+) times", page.text("learned_text"))[0]]
            check("and how stiff it is, as the file has it", all(abs(a - math.exp(b)) < 0.006 for a, b in zip(seen, (x.min(), x.max()))), (seen, x.min(), x.max()))
            check("places that are stiffer are red", page.until(f"{WARM} > 500"), page.js(WARM))
            page.click("learned_wanted")
            check("while that is wanted", page.until(f"{WARM} < 50"), page.js(WARM))
            check("no finite elements stand beside it: they are of another tissue",
                  page.until("tissue.pressed === 0") and page.text("fe_force") == "–", page.text("fe_force"))
            page.open("about:blank")
            server.end()

            learnt = Path(folder) / "learnt.h5"
            server = Server(program, [nominal], folder, "--hidden", model, "--learn", str(learnt))
            page.open(server.url)
            check("a model that learns says so, and that it has found nothing yet", page.until("tissue.connected && tissue.states > 0") and
                  page.until("document.getElementById('learned_text').innerText.startsWith('nothing found out yet')"), page.text("learned_text"))
            check("what to do", "hold still for a second" in page.text("reading_text"), page.text("reading_text"))
            check("and where a push would tell most", page.until("tissue.next !== null") and page.js("tissue.next.push_m.length") == 2, page.js("tissue.next"))
            check("the demo's presses are readings, and the map appears", page.until("/^what [3-9] pokes have/.test(document.getElementById('learned_text').innerText)", 60),
                  page.text("learned_text"))
            check("with what became of the last", page.text("reading_text").startswith("The last reading was "), page.text("reading_text"))
            page.open(server.url)
            check("a page that comes later sees it too", page.until("tissue.connected && /^what [0-9]+ pokes have/.test(document.getElementById('learned_text').innerText)"),
                  page.text("learned_text"))
            page.open("about:blank")
            server.end()
            with h5py.File(learnt) as file:
                learned = int(file["adaptation"].attrs["learned"])
            check("the model that it has become is written at the end", learned >= 3, learned)
            seen = [line for line in page.complaints() if "getImageData" not in line]  # that is what WARM does
            check("no complaint in the console", seen == [], seen)
        finally:
            page.end()
            if server:
                server.end()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
