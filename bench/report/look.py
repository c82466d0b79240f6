#!/usr/bin/env python3
"""Opens the report of an experiment in headless Chromium and looks whether everything is drawn.

look.py REPORT.html [PICTURE.png]   exit status 1 for a message on the browser's console, a figure that
                                    is missing or not drawn, or a link to nothing; takes a picture of
                                    the first screen
"""
import html
import json
import os
import re
import subprocess
import sys
import tempfile

PAPER_FIGURES = (6, 7, 8, 9, 10, 11, 13, 14, 15, 16, 18, 19)
OTHER_FIGURES = ("figures/spread.svg", "figures/convergence.svg")
LEAST_MARKS = 12  # of data: axes and frames do not count
LEAST_SHARE_INSIDE = 0.9
SCREEN = "1100,800"

# Counts the marks of each figure that have a size and those of them that lie in their figure, and lists the words
# that do not.
COUNT_MARKS = """<script>
addEventListener("load", () => {
  const inside = (a, b) => a.left >= b.left - 1 && a.right <= b.right + 1 && a.top >= b.top - 1 && a.bottom <= b.bottom + 1;
  const found = [...document.querySelectorAll("figure")].map(figure => {
    const svg = figure.querySelector("svg");
    const boxes = svg ? [...svg.querySelectorAll(".dot,.line,.arrow,.bar,g[shape-rendering] rect")]
      .map(mark => mark.getBoundingClientRect()).filter(box => box.width + box.height > 0) : [];
    const frame = svg ? svg.getBoundingClientRect() : null;
    const words = svg ? [...svg.querySelectorAll("text")].filter(text => !inside(text.getBoundingClientRect(), frame)) : [];
    return {caption: figure.querySelector("figcaption").textContent, cut: words.map(text => text.textContent),
            marks: boxes.length, inside: boxes.filter(box => inside(box, frame)).length};
  });
  const note = document.createElement("pre");
  note.id = "found";
  note.textContent = JSON.stringify(found);
  document.body.append(note);
});
</script>
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


def faults_of_links(text, folder):
    links = re.findall(r'href="([^"]*)"', text)
    promised = [f"figures/figure_{number:02}.svg" for number in PAPER_FIGURES] + list(OTHER_FIGURES)
    for link in links:
        if not os.path.exists(os.path.join(folder, link)):
            yield f"the page links to {link}, which does not exist"
    for link in promised:
        if link not in links:
            yield f"the page has no {link}"


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    report = os.path.abspath(sys.argv[1])
    with open(report, encoding="utf-8") as file:
        text = file.read()
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, "report.html")
        with open(copy, "w", encoding="utf-8") as file:
            file.write(text.replace("</head>", COUNT_MARKS + "</head>"))
        shown = chromium("--dump-dom", f"file://{copy}")
    found = re.search(r'<pre id="found">(.*?)</pre>', shown.stdout, re.DOTALL)
    if not found:
        sys.exit(f"{report}: the browser shows no page\n{shown.stderr}")
    figures = json.loads(html.unescape(found.group(1)))
    faults = [line for line in shown.stderr.splitlines() if "CONSOLE" in line]
    faults += list(faults_of_figures(figures)) + list(faults_of_links(text, os.path.dirname(report)))
    if len(sys.argv) == 3:
        chromium(f"--screenshot={os.path.abspath(sys.argv[2])}", f"--window-size={SCREEN}", f"file://{report}")
    print(f"{len(figures)} figures with {sum(figure['marks'] for figure in figures)} marks, {len(faults)} faults")
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
