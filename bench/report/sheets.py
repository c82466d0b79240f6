#!/usr/bin/env python3
"""Prints a certificate in headless Chromium and says on how many sheets.

sheets.py CERTIFICATE.html   exit status 1 when it, or the same with every fault at once, needs more than one sheet
"""
import os
import re
import sys
import tempfile

from look import chromium

# As certificate_report.cpp words them, with long reasons in place of what a run and a file say.
EVERY_FAULT = (
    ("the run was ended at c12.P4: held: the tool is seen at (147.8, -110.1) mm, 0.812 mm from where it was commanded, "
     "more than the 0.350 mm that it was ever seen from there at its calibration; a motor has lost steps, the camera has "
     "moved or the arm is bent; look at the cell and calibrate it anew",
     "mend the cell (planar-check-cell), then give the same command to continue"),
    ("17 of 610 moves did not reach their targets and are in no figure",
     "see the column status of cycles.csv, mend the cell, and certify it into another folder"),
    ("23 moves were not judged and are in no figure",
     "clear the tracker's view and certify the cell into another folder"),
    ("files that do not belong together were accepted, 3 in all: /home/somebody/cells/workshop/2026-11-23/workplane.yaml: "
     "was made with camera.yaml 1234567890abcdef, but the cell's camera.yaml is fedcba0987654321 now; make workplane.yaml "
     "anew with planar-pair-tracker, or put the file back that it was made with",
     "make the cell's files anew from one another; certificate.json lists them all"))


def with_every_fault(page):
    verdict = "".join(['<div class="verdict bad"><p><b>To be mended:</b> ', "; ".join(what for what, _ in EVERY_FAULT),
                       ".</p><ul>", "".join(f"<li>{remedy}.</li>" for _, remedy in EVERY_FAULT), "</ul></div>"])
    changed, count = re.subn(r'<div class="verdict.*?</div>', lambda _: verdict, page, count=1, flags=re.DOTALL)
    if count == 0:
        sys.exit("the page has no verdict; a certificate of planar-certify is needed")
    return changed


def sheets(page):
    with tempfile.TemporaryDirectory() as folder:
        html, pdf = os.path.join(folder, "page.html"), os.path.join(folder, "page.pdf")
        with open(html, "w", encoding="utf-8") as file:
            file.write(page)
        chromium(f"--print-to-pdf={pdf}", "--no-pdf-header-footer", f"file://{html}")
        with open(pdf, "rb") as file:
            return len(re.findall(rb"/Type\s*/Page\b", file.read()))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        page = file.read()
    own, worst = sheets(page), sheets(with_every_fault(page))
    print(f"{own} sheets; with every fault at once {worst}")
    sys.exit(0 if own == worst == 1 else 1)


if __name__ == "__main__":
    main()
