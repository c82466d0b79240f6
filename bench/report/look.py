#!/usr/bin/env python3
"""Opens pages of our programs in headless Chromium and checks each by the rules of rules.js, and the report of an
experiment for whether every figure is drawn.

look.py PAGE.html... [PICTURE.png]  exit status 1 for a message on the browser's console, a rule that is broken, a link
                                    to nothing, or a figure of an experiment that is missing or not drawn; takes a
                                    picture of the first page's first screen
"""
import html
import json
import os
import re
import subprocess
import sys
import tempfile

PAPER_FIGURES = (6, 7, 8, 9, 10, 11, 13, 14, 15, 16, 18, 19)
OTHER_FIGURES = ("figures/spread.svg", "figures/convergence.svg", "figures/coverage.svg")
LEAST_MARKS = 12  # of data: axes and frames do not count
LEAST_SHARE_INSIDE = 0.9
SCREEN = "1100,800"

# Counts the marks of each figure that have a size and those of them that lie in their figure, and lists the words
# that do not.
COUNT_MARKS = """
function marksOfFigures() {
  const inside = (a, b) => a.left >= b.left - 1 && a.right <= b.right + 1 && a.top >= b.top - 1 && a.bottom <= b.bottom + 1;
  return [...document.querySelectorAll("figure")].map(figure => {
    let marks = 0, within = 0, cut = [];
    for (const svg of figure.querySelectorAll("svg")) {
      const frame = svg.getBoundingClientRect();
      const boxes = [...svg.querySelectorAll(".dot,.line,.arrow,.bar,g[shape-rendering] rect")]
        .map(mark => mark.getBoundingClientRect()).filter(box => box.width + box.height > 0);
      marks += boxes.length;
      within += boxes.filter(box => inside(box, frame)).length;
      cut = cut.concat([...svg.querySelectorAll("text")].filter(text => !inside(text.getBoundingClientRect(), frame))
        .map(text => text.textContent));
    }
    return {caption: figure.querySelector("figcaption").textContent, cut, marks, inside: within};
  });
}
"""

LEAVE_NOTE = """
addEventListener("load", () => {
  const note = document.createElement("pre"), found = {figures: marksOfFigures(), faults: faultsOfPage()};
  note.id = "found";
  note.textContent = JSON.stringify(found);
  document.body.append(note);
});
"""


def chromium(*arguments):
    with tempfile.TemporaryDirectory() as profile:
        return subprocess.run(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync",
             "--disable-background-networking", "--disable-component-update", "--hide-scrollbars",
             "--enable-logging=stderr", f"--user-data-dir={profile}", *arguments],
            capture_output=True, text=True, timeout=120, check=True)


def faults_of_figures(figures):
    for figure in figures:
        title = figure["caption"].split(".")[0]
        if figure["marks"] < LEAST_MARKS:
            yield f"{title}: only {figure['marks']} marks are drawn"
        elif figure["inside"] < LEAST_SHARE_INSIDE * figure["marks"]:
            yield f"{title}: only {figure['inside']} of {figure['marks']} marks lie within it"
        for words in figure["cut"]:
            yield f"{title}: '{words}' is cut off"


def is_experiment(text):
    return "<title>The paper&apos;s experiment" in text or "<title>The paper's experiment" in text


def faults_of_links(text, folder):
    links = [link for link in re.findall(r'href="([^"]*)"', text) if not link.startswith(("#", "data:"))]
    promised = [f"figures/figure_{number:02}.svg" for number in PAPER_FIGURES] + list(OTHER_FIGURES)
    for link in links:
        if not os.path.exists(os.path.join(folder, link)):
            yield f"the page links to {link}, which does not exist"
    for link in promised if is_experiment(text) else ():
        if link not in links:
            yield f"the page has no {link}"


def look(page):
    with open(page, encoding="utf-8") as file:
        text = file.read()
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "rules.js"), encoding="utf-8") as file:
        script = f"<script>{file.read()}{COUNT_MARKS}{LEAVE_NOTE}</script>"
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, "page.html")
        with open(copy, "w", encoding="utf-8") as file:
            file.write(text.replace("</head>", script + "</head>"))
        shown = chromium("--dump-dom", f"file://{copy}")
    found = re.search(r'<pre id="found">(.*?)</pre>', shown.stdout, re.DOTALL)
    if not found:
        sys.exit(f"{page}: the browser shows no page\n{shown.stderr}")
    note = json.loads(html.unescape(found.group(1)))
    faults = [line for line in shown.stderr.splitlines() if "CONSOLE" in line] + note["faults"]
    faults += list(faults_of_figures(note["figures"])) + list(faults_of_links(text, os.path.dirname(page)))
    marks = sum(figure["marks"] for figure in note["figures"])
    print(f"{page}: {len(note['figures'])} figures with {marks} marks, {len(faults)} faults")
    return [f"{page}: {fault}" for fault in faults]


def main():
    pictures = [name for name in sys.argv[1:] if name.endswith(".png")]
    pages = [os.path.abspath(name) for name in sys.argv[1:] if name not in pictures]
    if not pages or len(pictures) > 1:
        sys.exit(__doc__)
    faults = [fault for page in pages for fault in look(page)]
    for picture in pictures:
        chromium(f"--screenshot={os.path.abspath(picture)}", f"--window-size={SCREEN}", f"file://{pages[0]}")
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
