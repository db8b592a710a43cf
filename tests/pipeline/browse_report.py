"""browse_report.py PAGE.html PROFILE: opens a report in headless Chromium and operates it; one "ok - sentence" per
check.

PROFILE is a folder that does not exist yet. The page's security policy forbids network access. Chromium would log a
violation in its console.
"""
import sys

from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--no-first-run", "--window-size=1280,1000"]
failed = 0


def check(sentence, seen, wanted=True):
    global failed
    failed += seen != wanted
    print(f"ok - {sentence}" if seen == wanted else f"not ok - {sentence}\n#   seen {seen!r}, wanted {wanted!r}")


def first_number(text):
    return float(text.replace("\u00a0", " ").split()[0])


options = webdriver.ChromeOptions()
for flag in FLAGS + [f"--user-data-dir={sys.argv[2]}"]:
    options.add_argument(flag)
options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
browser = webdriver.Chrome(service=webdriver.chrome.service.Service("/usr/bin/chromedriver"), options=options)
try:
    browser.get("file://" + sys.argv[1])
    check("in a browser: all figures are displayed, at least 5", browser.execute_script(
        "const all = [...document.images];"
        "return all.length >= 5 && all.every(i => i.complete && i.naturalWidth > 100)"))
    check("in a browser: the main number is visible without scrolling", browser.execute_script(
        "const b = document.querySelector('.number').getBoundingClientRect();"
        "return b.top >= 0 && b.bottom < innerHeight"))

    table = browser.find_element(By.CSS_SELECTOR, "table:has(th[scope=colgroup])")
    heading = table.find_element(By.CSS_SELECTOR, "tr + tr th[data-column]")  # the first column of a group
    column = int(heading.get_attribute("data-column"))
    button = heading.find_element(By.TAG_NAME, "button")

    def shown(at=column):
        rows = table.find_elements(By.CSS_SELECTOR, "tbody tr")
        return [row.find_elements(By.TAG_NAME, "td")[at].text for row in rows]

    def numbers():
        return [first_number(text) for text in shown()]

    before = numbers()
    names = dict(zip(shown(0), shown()))
    check("in a browser: the column is not sorted at first", before != sorted(before) != before[::-1])
    browser.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", button)
    button.click()
    check("in a browser: a click on a heading sorts the column in ascending order", numbers(), sorted(before))
    check("in a browser: sorting moves whole rows", dict(zip(shown(0), shown())), names)
    check("in a browser: aria-sort is ascending", heading.get_attribute("aria-sort"), "ascending")
    button.click()
    check("in a browser: a second click sorts in descending order", numbers(), sorted(before, reverse=True))
    check("in a browser: aria-sort is descending", heading.get_attribute("aria-sort"), "descending")
    name = table.find_element(By.CSS_SELECTOR, "th.row")
    name.find_element(By.TAG_NAME, "button").send_keys(Keys.ENTER)
    check("in a browser: Enter on a heading sorts names alphabetically", shown(0), sorted(names))
    check("in a browser: a column that is no longer sorted has no aria-sort", heading.get_attribute("aria-sort"), None)
    button.send_keys(Keys.SPACE)
    check("in a browser: Space on a heading sorts the column", numbers(), sorted(before))

    figure = browser.find_elements(By.CSS_SELECTOR, "figure button")[0]
    browser.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", figure)
    width = figure.size["width"]
    figure.click()
    check("in a browser: a click on a figure enlarges it", figure.size["width"] > 1.5 * width)

    light = browser.execute_script("return getComputedStyle(document.body).backgroundColor")
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia",
                            {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
    dark = browser.execute_script("return getComputedStyle(document.body).backgroundColor")
    check("in a browser: the page is dark if the system's colour scheme is dark", (light, dark),
          ("rgb(255, 255, 255)", "rgb(20, 23, 27)"))
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                            {"width": 360, "height": 700, "deviceScaleFactor": 1, "mobile": True})
    check("in a browser: a width of 360 px needs no horizontal scrolling",
          browser.execute_script("return document.documentElement.scrollWidth"), 360)
    check("in a browser: no resource is loaded from a network", browser.execute_script(
        "return performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith('data:'))"), [])
    check("in a browser: the console has no message", [entry["message"] for entry in browser.get_log("browser")], [])
finally:
    browser.quit()
sys.exit(failed > 0)
