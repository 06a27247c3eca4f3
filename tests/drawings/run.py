#!/usr/bin/env python3
"""Usage: run.py PROGRAMS [--inkscape] [--mark] [--keep FOLDER] [NAME…]

Poses each drawing of corpus.txt, or those named, by affine maps of its cage. Chromium must draw it as it draws the
input under that map: at rest, posed by deform_svg, and played by animate_svg at three times. At least 99.5 % of the
pixels must be within 8/255. With --inkscape rest and pose are also drawn by Inkscape. --keep writes all files and
pictures to a new folder.

"## NAME" begins a drawing. "## NAME rigid" poses it without scale, as strokes keep their width, and letters their
shape. Between that line and the drawing can stand:

    warns: WORDS                 each warning of the programs has these words; without this line there is none
    differs: COLUMN…: REASON     these columns are wrong; another column that is wrong fails, and one of these that is right

--mark takes the columns that are now right out of these lines. Columns that are newly wrong get a line without a reason.
"""
import base64
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "examples", "page"))
from browser import Browser  # noqa: E402

SIDE, ACROSS = 200, 10  # pixels of a drawing, drawings in a row of a sheet
LIMIT = 0.005  # the share of pixels that may differ
SVG = "http://www.w3.org/2000/svg"
FRAME = '<svg xmlns="%s" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 200 200">\n%%s</svg>\n' % SVG
PICTURE = ("data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAMAAAACCAIAAAASFvFNAAAAGUlEQVR42mM4YGBgAMYMDw4oKCxYkKDQ"
           "AABJtAeBbqYPLAAAAABJRU5ErkJggg==")
CAGE = [(-20, -20), (220, -20), (220, 220), (-20, 220)]
POSES = {0.5: (6, -4, 25, 1.1, 0.75), 1: (-5, 7, -16, 0.8, 1.2), 1.5: (2, 5, 130, 1, 0.9)}  # by time; see matrix()
SHEET = """<!DOCTYPE html><html data-ready="yes"><style>body { margin: 0 }
body > * { float: left; overflow: hidden; width: SIDEpx; height: SIDEpx }</style><script>
const stills = urls => Promise.all(urls.map(url => {
  const picture = document.body.appendChild(new Image())
  picture.src = url
  return picture.decode().catch(() => 0)
})).then(() => 0)
const films = (texts, time) => texts.forEach(text => {
  const root = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement
  const cell = document.body.appendChild(document.createElement('div')).attachShadow({ mode: 'open' })
  cell.innerHTML = '<style>:host > svg { width: 100%; height: 100% }</style>'
  cell.append(root)
  for (const svg of [root, ...root.querySelectorAll('svg')]) { // each has its own clock
    svg.pauseAnimations?.()
    svg.setCurrentTime?.(time)
  }
  for (const animation of root.getAnimations({ subtree: true })) {
    animation.pause()
    animation.currentTime = 1000 * time
  }
})
const sheets = {}
const read = (name, url) => stills([url]).then(() => {
  const picture = document.body.lastChild, { naturalWidth: width, naturalHeight: height } = picture
  const context = new OffscreenCanvas(width, height).getContext('2d')
  context.drawImage(picture, 0, 0)
  sheets[name] = context.getImageData(0, 0, width, height)
})
const shares = (count, a, b) => Array.from({ length: count }, (_, cell) => {
  let far = 0
  for (let y = 0; y < SIDE; ++y) for (let x = 0; x < SIDE; ++x) {
    const k = 4 * ((Math.floor(cell / ACROSS) * SIDE + y) * a.width + cell % ACROSS * SIDE + x)
    far += [0, 1, 2].some(c => Math.abs(a.data[k + c] - b.data[k + c]) > 8)
  }
  return far / SIDE ** 2
})
</script>""".replace("SIDE", str(SIDE)).replace("ACROSS", str(ACROSS))


def matrix(rigid, x, y, degrees, p, q):
    """A turn and a scale about the middle, and a move."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    p, q = (1, 1) if rigid else (p, q)
    a, b, c, d = p * cosine, q * sine, -p * sine, q * cosine
    return a, b, c, d, SIDE / 2 * (1 - a - c) + x, SIDE / 2 * (1 - b - d) + y


def posed(m, x, y):
    return m[0] * x + m[2] * y + m[4], m[1] * x + m[3] * y + m[5]


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def read(path):
    """The text of a file, or nothing where a program refused to write it."""
    if not os.path.exists(path):
        return ""
    with open(path, encoding="utf-8") as file:
        return file.read()


def write_motions():
    """The cage, a pose and a motion, both rigid and not."""
    write("cage.csv", "".join("%g,%g\n" % p for p in CAGE))
    for kind in ("any", "rigid"):
        maps = {t: matrix(kind == "rigid", *pose) for t, pose in POSES.items()}
        write(kind + ".pose.csv", "".join("%.17g,%.17g\n" % posed(maps[0.5], *p) for p in CAGE))
        text = "length,2\n"
        for k, (x, y) in enumerate(CAGE):
            text += "\ncontrol,%d\nvertices,%d\npivot,0,0\ntime,x,y,turn,kind\n0,0,0,0,linear\n" % (k, k)
            for t, m in maps.items():
                u, v = posed(m, x, y)
                text += "%g,%.17g,%.17g,0,linear\n" % (t, u - x, v - y)
            text += "2,0,0,0,linear\n"
        write(kind + ".clip.csv", text)


class Drawing:
    def __init__(self, text):
        head, body = re.match(r"(.*?)^(?=<)(.*)", text, re.S | re.M).groups()
        self.name, *marks = head.split("\n")[0].split()
        self.is_rigid = "rigid" in marks
        self.warns = "".join(re.findall(r"^warns: (.*)", head, re.M))
        self.differs = " ".join(re.findall(r"^differs: (.*?):", head, re.M)).split()
        body = body.replace("PICTURE", PICTURE)
        self.text = body if re.search(r"<(\w+:)?svg[^>]* xmlns", body) else FRAME % body
        self.off, self.said = {}, []

    def under(self, m):
        """The input under a map."""
        group = '<g xmlns="%s" transform="matrix(%s)">' % (SVG, " ".join("%.9g" % x for x in m))
        opened = re.sub(r"<(\w+:)?svg\b[^>]*>", lambda root: root[0] + group, self.text, count=1)
        return re.sub(r"(</(\w+:)?svg>\s*)$", r"</g>\1", opened)

    def run(self, program, ending, *words):
        command = [os.path.join(PROGRAMS, program), self.name + ".svg", "--cage", "cage.csv", *words]
        done = subprocess.run(command + ["-o", self.name + ending], capture_output=True, text=True)
        for line in done.stderr.splitlines():
            said = line.partition(": ")[2] if done.returncode else line.partition(": warning: ")[2]
            if said and said not in self.said:
                self.said.append(said)

    def write(self):
        kind = "rigid" if self.is_rigid else "any"
        write(self.name + ".svg", self.text)
        for t, pose in POSES.items():
            write("%s.at_%g.svg" % (self.name, t), self.under(matrix(self.is_rigid, *pose)))
        self.run("deform_svg", ".rest.svg", "--pose", "cage.csv")
        self.run("deform_svg", ".affine.svg", "--pose", kind + ".pose.csv")
        self.run("animate_svg", ".animated.svg", "--clip", kind + ".clip.csv", "--rate", "4")
        others = [said for said in self.said if self.warns not in said]
        self.off["warnings"] = bool(others) or bool(self.said) != bool(self.warns)


def mark(corpus, drawing):
    """The corpus with the columns of a drawing that are wrong now."""
    def remaining(line):
        kept = [c for c in line[1].split() if drawing.off.get(c, 1) > LIMIT]
        return "differs: %s: %s\n" % (" ".join(kept), line[2]) if kept else ""

    head = re.search(r"^## %s( .*)?\n([a-z].*\n)*" % drawing.name, corpus, re.M)
    marked = re.sub(r"^differs: (.*?): (.*)\n", remaining, head[0], flags=re.M)
    new = [c for c, off in drawing.off.items() if off > LIMIT and c not in drawing.differs]
    return corpus.replace(head[0], marked + ("differs: %s: ?\n" % " ".join(new) if new else ""))


def compare(browser, drawings, inkscape):
    """Draws sheets of all drawings, and enters which share of the pixels is off."""
    def sheet(ending, seconds=None):
        paths = [drawing.name + ending for drawing in drawings]
        browser.run("document.body.replaceChildren()")
        if seconds is None:
            browser.run("stills(%s)" % json.dumps(["file://%s/%s" % (os.getcwd(), path) for path in paths]))
        else:
            browser.run("films(%s, %g)" % (json.dumps([read(path) for path in paths]), seconds))
        browser.frames()
        shot = browser.call("Page.captureScreenshot", {"format": "png"})["data"]
        browser.run("read('%s', 'data:image/png;base64,%s')" % (ending, shot))
        with open("sheet%s.png" % (ending if seconds is None else "%s.at_%g" % (ending, seconds)), "wb") as file:
            file.write(base64.b64decode(shot))

    def shares(a, b):
        return zip(drawings, browser.run("shares(%d, sheets['%s'], sheets['%s'])" % (len(drawings), a, b)))

    def enter(column, a, b):
        for drawing, share in shares(a, b):
            drawing.off[column] = max(share, drawing.off.get(column, 0))

    browser.resize(SIDE * ACROSS, SIDE * -(-len(drawings) // ACROSS))
    write("sheet.html", SHEET)
    browser.open("sheet.html")
    for ending in (".svg", ".rest.svg", ".affine.svg"):
        sheet(ending)
    enter("rest", ".svg", ".rest.svg")
    for t in POSES:
        sheet(".at_%g.svg" % t)
        sheet(".animated.svg", t)
        enter("animated", ".at_%g.svg" % t, ".animated.svg")
    enter("affine", ".at_0.5.svg", ".affine.svg")
    for drawing, share in shares(".svg", ".at_0.5.svg"):
        if share < 4 * LIMIT:
            sys.exit("%s: the pose changes only %g of the pixels" % (drawing.name, share))
    if inkscape:
        columns = {"inkscape-rest": ("", ".rest"), "inkscape-affine": (".at_0.5", ".affine")}
        left = [path for drawing in drawings for pair in columns.values() for ending in pair
                for path in [drawing.name + ending] if os.path.exists(path + ".svg")]
        while left:  # Inkscape ends at a drawing that crashes it
            subprocess.run(["inkscape", "--export-type=png", "--export-width=%d" % SIDE, "--export-height=%d" % SIDE,
                            "--export-background=white", "--export-background-opacity=1",
                            *(path + ".svg" for path in left)], capture_output=True)
            left = [path for path in left if not os.path.exists(path + ".png")][1:]
        for column, pair in columns.items():
            for ending in pair:
                sheet(ending + ".png")
            enter(column, *(ending + ".png" for ending in pair))


def main(words):
    """Returns the number of faults and of marks that are out of date."""
    named = [word for word in words if word not in ("--inkscape", "--mark")]
    inkscape = "--inkscape" in words
    for program in ["chromium"] + inkscape * ["inkscape"]:
        if not shutil.which(program):
            print("skipped: no", program)
            sys.exit(77)
    path = os.path.join(HERE, "corpus.txt")
    corpus = read(path)
    drawings = [Drawing(text) for text in re.split(r"^## ", corpus, flags=re.M)[1:]]
    drawings = [drawing for drawing in drawings if not named or drawing.name in named]
    if not drawings:
        sys.exit("no drawing has such a name")
    write_motions()
    for drawing in drawings:
        drawing.write()
    browser = Browser()
    try:
        compare(browser, drawings, inkscape)
    finally:
        browser.close()
    faults = 0
    for drawing in drawings:
        print("%-30s" % drawing.name, *("%s %.4f " % pair for pair in drawing.off.items()))
        for column, off in drawing.off.items():
            if (off > LIMIT) != (column in drawing.differs):
                why = "is wrong" if off > LIMIT else "is right, and corpus.txt says that it differs"
                print("FAILED: %s: %s %s" % (drawing.name, column, why), *drawing.said, sep="\n    ")
                faults += 1
        if "--mark" in words:
            corpus = mark(corpus, drawing)
    if "--mark" in words:
        write(path, corpus)
    print("%d drawings, %d faults" % (len(drawings), faults))
    return faults


if __name__ == "__main__":
    words = sys.argv[1:]
    PROGRAMS = os.path.abspath(words.pop(0))
    with tempfile.TemporaryDirectory() as folder:
        if "--keep" in words:
            at = words.index("--keep")
            folder = words[at + 1]
            os.makedirs(folder)
            del words[at:at + 2]
        os.chdir(folder)
        sys.exit(main(words) > 0)
