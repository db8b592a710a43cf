"""Takes results/reference/serve.png and serve-space.png: screenshot.py TISSUECTL MODEL OUT.png [dark]. MODEL is that of
the study `surface`, or one in space. Indents the learned mesh: in the plane with the mouse, straight in at its left
side between two nodes; in space with the keyboard where the demo starts. Waits until the tissue is at rest, and saves a
picture of the page."""
import sys
import tempfile

from browser import SOLID, Browser, Server

Y = 0.0665       # m above the fixed edge
DEPTH = 0.0095   # m, of the hand


def press(page, solid):
    if solid:
        page.until("tissue.solids !== null")
        page.js("document.getElementById('space').focus()")
        page.js("(e => { e.value = 7; e.dispatchEvent(new Event('input')); })(document.getElementById('depth'))")
        page.key("Space")
        page.until("tissue.pressing !== null && tissue.pressing.depth_m > 0.00699")
        return
    page.drag([-0.02, Y], [-0.015, Y])
    page.until("tissue.control.holder === 'you' && Math.max(...tissue.largest_displacement_m) < 1e-5", 20)
    page.drag([-0.015, Y], [DEPTH, Y], steps=120)


def main():
    program, model, out, *night = sys.argv[1:]
    page = Browser(1280, 700, 1, flags=SOLID, prefers_color_scheme="dark" if night else "light")
    with tempfile.TemporaryDirectory() as folder:
        server = Server(program, [model], folder)
        try:
            page.open(server.url)
            page.until("tissue.connected && tissue.states > 0")
            press(page, page.js("tissue.dimension === 3"))
            page.until("tissue.pressed === 0")
            for _ in range(30):
                moved = page.watch("Math.hypot(...tissue.contact_moved_m[1])", 0.5)
                if max(moved) - min(moved) < 0.002 * max(moved):
                    break
            for _ in range(3):  # the height of the whole page; the drawing grows with the window, hence three times
                page.resize(1280, page.js("document.documentElement.scrollHeight"))
                page.after(5)
            page.driver.save_screenshot(out)
            print(page.text("verdict"), page.text("basis"), sep="\n")
        finally:
            page.end()
            server.end()


if __name__ == "__main__":
    main()
