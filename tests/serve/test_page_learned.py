"""The page of `tissuectl serve` for a model that was adapted from measurements, and for one that adapts during the
session: test_page_learned.py TISSUECTL LEARNED MODEL. LEARNED is also the target tissue that MODEL learns from. Prints
"ok - sentence" or "not ok - sentence: seen"; exits 1 if any failed."""
import math
import re
import sys
from pathlib import Path

import h5py
from browser import Server, check, run

WARM = """(() => { const c = document.getElementById('stage'), above = c.height - Math.ceil(54 * c.width / c.clientWidth),   // without the legend, in which the arrow of the heuristic mesh is red
        d = c.getContext('2d').getImageData(0, 0, c.width / 2, above).data;
    let red = 0; for (let k = 0; k < d.length; k += 4) red += d[k] > d[k + 2] + 60 && d[k] > d[k + 1] + 40; return red; })()"""


def main(page, folder):
    program, model, nominal = sys.argv[1:]
    with h5py.File(model) as file:
        pokes, x = int(file["adaptation"].attrs["learned"]), file["adaptation/x"][:]
    server = Server(program, [model], folder)
    page.open(server.url)
    page.until("tissue.connected && tissue.states > 0")
    check("the page gives the number of measurements of an adapted model", page.until("!document.getElementById('learned_row').hidden") and
          page.text("learned_text").startswith(f"{pokes} measurement{'s' * (pokes != 1)}: "), page.text("learned_text"))
    seen = [float(v) for v in re.findall(r"([0-9.]+) to ([0-9.]+) times", page.text("learned_text"))[0]]
    check("the page gives the range of the stiffness factors in the file", all(abs(a - math.exp(b)) < 0.006 for a, b in zip(seen, (x.min(), x.max()))), (seen, x.min(), x.max()))
    check("stiffer places are red", page.until(f"{WARM} > 500"), page.js(WARM))
    page.click("learned_wanted")
    check("the colours of stiffness can be switched off", page.until(f"{WARM} < 50"), page.js(WARM))
    check("no FE force is shown for an adapted model: the FE reference is of another tissue",
          page.until("tissue.pressed === 0") and page.text("fe_force") == "–", page.text("fe_force"))
    page.open("about:blank")
    server.end()

    learnt = Path(folder) / "learnt.h5"
    server = Server(program, [nominal], folder, "--hidden", model, "--learn", str(learnt))
    page.open(server.url)
    check("the page of an adapting model reports that there is no measurement yet", page.until("tissue.connected && tissue.states > 0") and
          page.until("document.getElementById('learned_text').innerText.startsWith('no measurement yet')"), page.text("learned_text"))
    check("the page asks the user to hold still for a second", "hold still for a second" in page.text("reading_text"), page.text("reading_text"))
    check("the page has the most informative next indentation", page.until("tissue.next !== null") and page.js("tissue.next.push_m.length") == 2, page.js("tissue.next"))
    check("indentations of the demo are measurements", page.until("/^[3-9] measurements: /.test(document.getElementById('learned_text').innerText)", 60),
          page.text("learned_text"))
    check("the page gives the result of the last measurement", page.text("reading_text").startswith("The last measurement was "), page.text("reading_text"))
    page.open(server.url)
    check("a page that is opened later gives the number of measurements too", page.until("tissue.connected && /^[0-9]+ measurements: /.test(document.getElementById('learned_text').innerText)"),
          page.text("learned_text"))
    page.open("about:blank")
    server.end()
    with h5py.File(learnt) as file:
        learned = int(file["adaptation"].attrs["learned"])
    check("the adapted model is written at the end", learned >= 3, learned)
    seen = [line for line in page.complaints() if "getImageData" not in line]  # caused by WARM
    check("the console has no warnings or errors", seen == [], seen)


if __name__ == "__main__":
    sys.exit(run(main))
