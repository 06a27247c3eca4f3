#!/usr/bin/env python3
"""Usage: moving_frames.py PROGRAMS SEED COUNT

What animate_svg writes, played by Chromium and paused at three times, against what deform_svg draws of the pose at these
times. The drawings and the poses are random; their seeds are printed. Exit status 77: no Chromium here.
"""
import os
import random
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../examples/page"))
from browser import Browser  # noqa: E402

PROGRAMS, SEED, COUNT = os.path.abspath(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
SECONDS = 1.6
MOST = 10  # pixels that differ visibly, of 400 x 400
COMPARE = """(async shots => {
  const [a, b] = await Promise.all(shots.map(async shot => {
    const bitmap = await createImageBitmap(await (await fetch('data:image/png;base64,' + shot)).blob());
    const context = new OffscreenCanvas(400, 400).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return context.getImageData(0, 0, 400, 400).data;
  }));
  const far = Array.from({length: 160000}, (_, n) => [0, 1, 2].some(c => Math.abs(a[4 * n + c] - b[4 * n + c]) > 40));
  return far.filter((is, n) => is && far[n + 1] && far[n + 400] && far[n + 401]).length; // fine edges do not count
})(%r)"""


def drawing(r):
    """All that follows its shapes: gradients and patterns of both units, taken from others or not, text, clip paths."""
    def n(least, most):
        return "%.1f" % r.uniform(least, most)

    def paint():
        return 'fill="url(#%s)"' % r.choice(["across", "round", "tiles", "grid", "other"])

    def shape():
        x, y = r.uniform(15, 70), r.uniform(15, 70)
        return r.choice([
            '<rect x="%.1f" y="%.1f" width="%s" height="%s" %s stroke="#333" stroke-width="%s"/>' % (x, y, n(8, 30), n(8, 30), paint(), n(.2, 2)),
            '<ellipse cx="%.1f" cy="%.1f" rx="%s" ry="%s" %s/>' % (x, y, n(4, 15), n(4, 15), paint()),
            '<path d="M%.1f %.1fc%s 0 9 %s 12 12s-%s 9 -9 9z" %s/>' % (x, y, n(3, 9), n(2, 9), n(2, 9), paint()),
            '<g transform="rotate(%s 50 50)"><circle cx="%.1f" cy="%.1f" r="%s" %s/><path d="M%.1f %.1fh6v6h-6z" fill="#%03x"/></g>'
            % (n(-20, 20), x, y, n(1, 4), paint(), x, y, r.randrange(0xeee))])
    return """<svg xmlns="http://www.w3.org/2000/svg" width="400" height="400" viewBox="0 0 100 100">
<linearGradient id="stops"><stop offset="0" stop-color="#%03x"/><stop offset="1" stop-color="#%03x"/></linearGradient>
<linearGradient id="across" href="#stops" gradientUnits="userSpaceOnUse" x1="%s" x2="%s"/>
<radialGradient id="round" cx=".3" fy=".6"><stop stop-color="gold"/><stop offset="1" stop-color="#%03x"/></radialGradient>
<radialGradient id="other" href="#round" gradientTransform="rotate(%s .5 .5)"/>
<pattern id="tiles" patternUnits="userSpaceOnUse" width="7" height="6"><rect width="7" height="6" fill="#cde"/><circle cx="3" cy="3" r="%s" fill="#%03x"/></pattern>
<pattern id="grid" href="#lines" width=".25"/>
<pattern id="lines" width=".5" height=".25" patternContentUnits="objectBoundingBox"><path d="M0 0H.2V.1H0z" fill="#063"/></pattern>
<clipPath id="hole"><circle cx="50" cy="50" r="%s"/></clipPath>
%s<g clip-path="url(#hole)">%s</g><path d="M%s 20L80 %s" stroke="#%03x" stroke-width="2"/>
</svg>""" % (r.randrange(0x1000), r.randrange(0x1000), n(0, 40), n(60, 100), r.randrange(0x1000), n(-40, 40), n(1, 3), r.randrange(0x1000),
             n(20, 40), "\n".join(shape() for _ in range(6)), shape(), n(10, 30), n(60, 80), r.randrange(0x1000))


def main():
    if not any(map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))):
        print("skipped: no chromium")
        return 77
    browser, faults = Browser((400, 400)), 0
    with tempfile.TemporaryDirectory() as folder:
        def shown(name, time=None):
            browser.call("Page.navigate", {"url": "file://%s/%s" % (folder, name)})
            browser.wait("document.documentElement.localName === 'svg' && document.readyState === 'complete' && document.URL.endsWith(%r)" % name)
            if time is not None:
                browser.run("document.documentElement.pauseAnimations(), document.documentElement.setCurrentTime(%r)" % time)
            browser.frames()
            return browser.call("Page.captureScreenshot", {"format": "png"})["data"]

        def run(program, *words):
            subprocess.run([os.path.join(PROGRAMS, program), "rest.svg", "--cage", "box", *words], cwd=folder, check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        for seed in range(SEED, SEED + COUNT):
            r = random.Random(seed)
            with open(os.path.join(folder, "rest.svg"), "w") as file:
                file.write(drawing(r))
            moves = [(v, r.uniform(-25, 25), r.uniform(-25, 25)) for v in r.choice([["all"], [r.randrange(4)], [0, 2]])]

            def pose(share):
                return [word for v, x, y in moves for word in ("--move", "%s:%r,%r" % (v, share * x, share * y))]
            run("animate_svg", *pose(1), "--seconds", str(SECONDS), "-o", "played.svg")
            frames = []
            for time, share in ((0.25, 0.5), (0.5, 1), (0.75, 0.5)):  # there and back, alike before and after half the way
                run("deform_svg", *pose(share), "-o", "still.svg")
                still, played = shown("still.svg"), shown("played.svg", time * SECONDS)
                frames.append(played)
                browser.call("Page.navigate", {"url": "about:blank"})
                far = browser.run(COMPARE % [still, played])
                if far > MOST:
                    faults += 1
                    print("FAILED: seed %d at %g of the time: %d pixels differ from the still" % (seed, time, far))
            rest = shown("rest.svg")
            browser.call("Page.navigate", {"url": "about:blank"})
            if browser.run(COMPARE % [rest, frames[1]]) < 100 or browser.run(COMPARE % [frames[0], frames[1]]) < 100:
                faults += 1
                print("FAILED: seed %d: it does not move" % seed)
    browser.close()
    print("seeds %d to %d: %d faults" % (SEED, SEED + COUNT - 1, faults))
    return faults > 0


sys.exit(main())
