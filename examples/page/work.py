"""Tests of files and storage: encodings, isolated styles, several open files, reloads."""

import gzip
import json
import os
import random
import time

from support import Page, check, compare_pictures

SVG = 'http://www.w3.org/2000/svg'
TOWER = '<svg xmlns="%s" viewBox="0 0 120 160"><path fill="#47a" d="M40 150V60l20-40l20 40v90z"/><circle cx="60" cy="80" r="9" fill="#fd6"/></svg>' % SVG
BOAT = '<svg xmlns="%s" viewBox="0 0 160 100"><path fill="#a53" d="M10 60h140l-25 30h-90z"/><path fill="#999" d="M75 10v45h-45z"/></svg>' % SVG


def drop(page, folder, name, data):
    """Drops a file, waits until it is processed, and returns the message of the page."""
    path = os.path.join(folder, name)
    with open(path, 'wb') as file:
        file.write(data if isinstance(data, bytes) else data.encode())
    page.run("window.shownBefore = page.current; byId('status').textContent = ''; byId('status').classList.remove('fault'); 0")
    page.drop([path])
    page.wait("page.current !== shownBefore || byId('status').classList.contains('fault')")
    return page.run("byId('status').textContent")


def test_encodings(page, folder):
    def document(encoding, words):
        declared = '<?xml version="1.0" encoding="%s"?>\n' % encoding if encoding else ''
        return '%s<svg xmlns="%s" viewBox="0 0 90 60"><title>%s</title><rect width="80" height="50"/></svg>' % (declared, SVG, words)
    wrong = []
    for declared, codec, words, mark in (
            ('iso-8859-1', 'latin-1', 'Åre, señor', b''), ('ISO-8859-2', 'iso8859-2', 'Łódź', b''), ('windows-1253', 'cp1253', 'Ωμέγα', b''),
            ('koi8-r', 'koi8-r', 'Якорь', b''), ('EUC-KR', 'euc-kr', '한글', b''), ('gb18030', 'gb18030', '汉字', b''), ('EUC-JP', 'euc-jp', '漢字', b''),
            ('', 'utf-8', 'Łódź 漢字', b''), ('utf-8', 'utf-8', 'Ωμέγα', b'\xef\xbb\xbf'), ('koi8-r', 'utf-8', 'Ωμέγα', b'\xef\xbb\xbf'),
            ('utf-16', 'utf-16-le', '漢字', b'\xff\xfe'), ('utf-16', 'utf-16-be', 'Łódź', b'\xfe\xff'), ('utf-16', 'utf-16-be', '漢字', b''),
            ('UTF-16', 'utf-8', 'Łódź', b'')):  # a wrong declaration, left by a program that changed the encoding
        for pack in (bytes, gzip.compress):
            drop(page, folder, 'words.' + ('svg' if pack is bytes else 'svgz'), pack(mark + document(declared, words).encode(codec)))
            saved = open(page.saved('#save-svg', 'words_posed.svg'), encoding='utf-8').read()
            wrong += [] if '<title>%s</title>' % words in saved else [(declared, codec, mark)]
            page.click('#close')
    check(not wrong, 'letters of 14 encodings are read and saved, compressed or not' if not wrong else 'letters are lost: %s' % wrong)
    said = drop(page, folder, 'lost.svg', document('', 'Åre').encode('latin-1'))
    check('utf-8' in said and 'lost' in said, 'unreadable letters give a message: ' + said)
    for name, data, words in (('odd.svg', document('x-none', 'a'), 'x-none'), ('broken.svgz', gzip.compress(BOAT.encode())[:-9], 'damaged'),
                              ('bomb.svgz', gzip.compress(BOAT.encode() + bytes(101 * 10 ** 6)), '100 MB')):
        said = drop(page, folder, name, data)
        check(said.startswith(name) and words in said, 'error with the file name: ' + said)


def random_sheet(rng):
    """Returns a drawing with style rules of all kinds of selectors."""
    def pick(*choices):
        return rng.choice(choices)

    def colour():
        return '#%03x' % rng.randrange(4096)

    def simple():
        return pick('rect', 'circle', 'path', 'g', 'use', 'polygon', '*', '.a', '.b', '#one', '#two', 'rect.a', 'use.b', 'rect[width="24"]', '[class]', 'svg', ':root')

    def compound():
        return simple() + pick('', '', '', ':not(.b)', ':is(.a, #two, circle)', ':nth-of-type(2)', ':first-child', ':nth-child(2n+1 of .a)', ':where(#one)', ':not(:is(g, .a))')

    def selector():
        return compound() + ''.join(pick(' ', ' > ', ' + ', ' ~ ') + compound() for _ in range(rng.randrange(3)))

    def look():
        return pick('', '', ' fill="%s"' % colour(), ' style="fill: %s"' % colour(), ' stroke="%s"' % colour(), ' color="%s"' % colour())

    def named():
        return pick('', '', ' class="a"', ' class="b"', ' class="a b"')
    shapes = ['<rect x="%d" y="%d" width="24" height="20"%s%s/>', '<circle cx="%d" cy="%d" r="12"%s%s/>', '<path d="M%d %dh22v18h-22z"%s%s/>',
              '<polygon transform="translate(%d %d)" points="0,0 25,4 9,21"%s%s/>', '<use href="#one" x="%d" y="%d"%s%s/>', '<use href="#two" x="%d" y="%d"%s%s/>']
    drawn = [pick(*shapes) % (rng.randrange(20, 130), rng.randrange(20, 100), named(), look()) for _ in range(rng.randrange(4, 10))]
    at = rng.randrange(len(drawn))
    drawn[at:at + 3] = ['<g%s%s>%s</g>' % (named(), look(), ''.join(drawn[at:at + 3]))]
    rules = ['%s { %s: %s%s }' % (', '.join(selector() for _ in range(rng.randrange(1, 3))), pick('fill', 'fill', 'stroke', 'color'), pick(colour(), colour(), 'currentColor'),
                                  pick('', '', '', ' !important')) for _ in range(rng.randrange(2, 9))]
    rules += ['@media screen { %s { stroke: %s; stroke-width: 4 } }' % (selector(), colour())]
    return '<svg xmlns="%s" viewBox="0 0 160 130"><style>%s</style><defs><rect id="one" width="18" height="18"/><g id="two" class="a"><circle r="7"/>' \
        '<path class="b" d="M5 5h14v14z"/></g></defs>%s</svg>' % (SVG, '\n'.join(rules).replace('>', '&gt;'), ''.join(drawn))


def test_rules(page, first, count=80):
    """At rest a drawing looks like its file, for all kinds of selectors."""
    wrong, worst = [], 0
    for seed in range(first, first + count):
        text = random_sheet(random.Random(seed))
        saved = page.run("""(text => { const figure = new Figure(text, 'rules');
          return posedSvg({ figure, types: [0], pose: null, ensureBound() {}, cloneFigure: () => figure.points }).text; })(%s)""" % json.dumps(text))
        difference = compare_pictures(page, saved, text, same_view=True)
        worst = max(worst, difference)
        wrong += [seed] if difference > 0.001 else []
    check(not wrong, '%d drawings with random rules, from seed %d, look like their files: colour difference %.5f' % (count, first, worst) if not wrong else 'rules of seeds %s' % wrong)


def test_closed(page, folder):
    """Styles of the page do not affect a drawing, and styles of a drawing do not affect the page."""
    words = '<svg xmlns="%s" viewBox="0 0 100 80"><style>* { letter-spacing: 7px } :root, :host { opacity: 0.5; transform: scale(3) !important } svg { width: 20px }' \
        ' #own { fill: var(--ink, #0a0); stroke: var(--accent, none) } button { color: #f00 !important }</style><g stroke="currentColor" fill="none">' \
        '<rect x="9" y="9" width="60" height="50"/></g><text id="own" x="20" y="40">ink</text></svg>' % SVG
    for scheme in ('light', 'dark'):
        page.call('Emulation.setEmulatedMedia', {'features': [{'name': 'prefers-color-scheme', 'value': scheme}, {'name': 'prefers-reduced-motion', 'value': 'reduce'}]})
        look = "(e => { const s = getComputedStyle(e); return [s.letterSpacing, s.opacity, s.transform, s.color]; })(%s)"
        page.click('[data-figure=cat]')
        parts = ["document.getElementById('rest')", 'page.views[0].div', 'page.views[0].shadow.host']
        before = [page.run(look % part) for part in parts]
        drop(page, folder, 'ink.svg', words)
        check([page.run(look % part) for part in parts] == before, "a drawing's rules change nothing of the page (%s)" % scheme)
        shown = page.run("""(() => { const { shadow } = page.views[0], text = shadow.querySelector('#own'), style = getComputedStyle(text);
          return [style.fill, style.stroke, style.fontSize, getComputedStyle(shadow.querySelector('g')).stroke, shadow.querySelector('svg').clientWidth > 300]; })()""")
        check(shown == ['rgb(0, 170, 0)', 'none', '16px', 'rgb(0, 0, 0)', True], "and it is shown without the page's colours, variables and font: %s" % shown)
        saved = open(page.saved('#save-svg', 'ink_posed.svg')).read()
        check('currentColor' in saved and 'rgb' not in saved, 'the saved file has its currentColor')
    page.still()


def state(page):
    return page.run("""JSON.stringify([shownOwner(page).history.earlier.length, shownOwner(page).history.later.length, Array.from(shownOwner(page).pose),
      Array.from(shownOwner(page).cage.rest ?? shownOwner(page).cage.vertices), page.clip.keyTimes, shownOwner(page).pins?.points.length])""")


def reload(page):
    """Reloads the page; returns whether the page asked for confirmation."""
    page.events.clear()
    page.call('Page.reload')
    asked, limit = False, time.time() + 60
    while time.time() < limit:
        try:
            page.call('Page.getLayoutMetrics', seconds=0.3)
        except TimeoutError:  # a page that asks does not respond
            pass
        methods = [event.get('method') for event in page.events]
        if 'Page.javascriptDialogOpening' in methods and not asked:
            asked = True
            page.call('Page.handleJavaScriptDialog', {'accept': True})
        if 'Page.loadEventFired' in methods:
            page.wait("document.documentElement?.dataset.ready === 'yes'")
            return asked
    raise TimeoutError('the page was not reloaded')


def test_work(path, folder, out):
    """Open, pin, animate, undo, a second file, reload, save, open the saved file, close."""
    page = Page(path, mode='figure')
    titles = "[...document.querySelectorAll('#files button')].map(b => b.textContent).join()"

    def choose(title):
        page.run("[...document.querySelectorAll('#figures button')].find(b => b.textContent === %r).scrollIntoView(); 0" % title)
        x, y = page.run("(() => { const b = [...document.querySelectorAll('#figures button')].find(b => b.textContent === %r).getBoundingClientRect();"
                        "return [b.x + b.width / 2, b.y + b.height / 2]; })()" % title)
        page.mouse('mousePressed', x, y)
        page.mouse('mouseReleased', x, y)
        page.frames(4)
    try:
        check(not reload(page), 'a page without work reloads without confirmation')
        kept = page.run('''page.keeper.put([['state', 'plain'], 1], [['state', 'unkept'], () => {}]).then(() => 'kept', error => error.name)
          .then(async said => said + ' ' + await answerOf(page.keeper.store.transaction('work').objectStore('work').count(['state', 'plain'])))''')
        check(kept == 'DataCloneError 0', 'values written together are stored all or none: ' + kept)
        drop(page, folder, 'tower.svg', TOWER)
        page.frames(6)
        page.wait('page.pinDrag.isPrepared')
        place = page.run("""(() => { const v = page.views[0], f = v.frame(), r = v.div.getBoundingClientRect();
          return [r.left + 1 + f.x + f.scale * 60, r.top + 1 + f.y + f.scale * 40]; })()""")
        pins = page.run('page.pins.points.length')
        page.click('#key')
        page.run('page.timeline.setTime(1.2)')
        page.drag(place, (place[0] + 60, place[1] + 10))
        page.wait('!page.pinDrag.running')
        check(page.run('page.pins.points.length') == pins + 1 and page.run('page.pose.some((x, i) => x !== page.cage.rest[i])'), 'a pin is set and pulls the tower')
        page.click('#key')
        posed = state(page)
        page.drag(place, (place[0] - 50, place[1] + 30))
        page.wait('!page.pinDrag.running')
        while json.loads(state(page))[0] > json.loads(posed)[0]:
            page.key('z', 'KeyZ', modifiers=2)
        check(json.loads(state(page))[2] == json.loads(posed)[2], 'undo removes a second pin')
        tower = state(page)
        page.picture(os.path.join(out, 'page_work.png'))
        drop(page, folder, 'boat.svg', BOAT)
        check(page.run(titles) == 'tower,boat', 'a second file opens in addition to the first')
        page.run("setMode(page, 'cage')")
        page.wait('page.keeper.isSaved')
        page.run('page.keeper.timer = -1; 0')  # prevents writing
        page.drag_vertex(3, 40, -20)
        asked = reload(page)
        check(asked, 'the page asks for confirmation if changes are not stored')
        page.run("setMode(page, 'cage')")
        check(page.run('page.figure.name') == 'boat' and page.run('page.pose.some((x, i) => x !== page.cage.rest[i])'), 'and the changes are restored after the reload')
        page.picture(os.path.join(out, 'page_work_again.png'))
        page.click('#undo')
        check(page.run('page.pose.every((x, i) => x === page.cage.rest[i])'), 'with their undo history')
        choose('tower')
        again = [json.loads(text) for text in (tower, state(page))]
        check(page.run(titles) == 'tower,boat' and again[0] == again[1], 'the tower, its pose, pins, key frames and undo are restored, too')
        page.click('#undo')
        check(json.loads(state(page))[2] != again[0][2] or json.loads(state(page))[4] != again[0][4], 'and undo works')
        page.click('#redo')
        check(json.loads(state(page))[:5] == again[0][:5], 'and forth')
        page.wait('page.keeper.isSaved')
        check(not reload(page), 'stored work reloads without confirmation')
        page.click('#play')
        page.frames(8)
        check(page.run('page.figure.name === "tower" && page.timeline.playing > 0 && page.pose.some((x, i) => x !== page.cage.rest[i])'), 'the motion plays after a reload')
        page.click('#play')
        saved = page.saved('#save-svg', 'tower_posed.svg')
        shown = open(saved).read()
        drop(page, folder, 'tower.svg', shown)
        difference = compare_pictures(page, open(page.saved('#save-svg', 'tower_posed.svg')).read(), shown, same_view=True)
        check(page.run(titles) == 'tower,boat,tower (2)' and difference < 0.001, 'the saved file opens as a third, and looks as saved: colour difference %.5f' % difference)
        page.picture(os.path.join(out, 'page_work_three.png'))
        page.click('#close')
        check(page.run(titles) == 'tower,boat' and page.run('page.current') == 'cat', 'a file is closed')
        choose('tower')
        page.run('window.confirm = () => false; 0')
        page.click('#close')
        check(page.run('page.figure.name') == 'tower', 'a changed file is closed only after confirmation')
        page.run('window.confirm = () => true; 0')
        page.click('#close')
        choose('boat')
        for kind in ('lattice', 'curved'):
            page.click('[data-cage=%s]' % kind)
            page.run("setMode(page, 'cage')")
            page.drag_vertex(3, -20, 25)
            kept = state(page)
            page.wait('page.keeper.isSaved')
            reload(page)
            check(page.run('page.cage.kind') == kind and state(page) == kept, 'a cage of kind %s is stored' % kind)
        while not page.run("document.getElementById('undo').disabled"):
            page.click('#undo')
        check(page.run('!page.cage.kind && page.pose.every((x, i) => x === page.cage.rest[i])'), 'and undo leads back to the polygon at rest')
        paths = [os.path.join(folder, name + '.svg') for name in ('mast', 'oar')]
        for each in paths:
            with open(each, 'w') as file:
                file.write(BOAT)
        page.drop(paths)
        page.drop([os.path.join(folder, 'tower.svg')])
        page.wait("page.figure.name === 'tower'")
        check(page.run(titles) == 'boat,mast,oar,tower', 'files dropped together, or while another is being opened, all open')
        for _ in range(3):
            page.click('#close')
            page.run("document.querySelector('#files button:last-child').click()")
            page.frames()
        page.click('[data-figure=character]')
        page.wait('page.mesh.current === "character"')
        page.click('#mesh-pose')
        page.wait('page.keeper.isSaved')
        mesh = page.run('JSON.stringify(Array.from(page.mesh.pose))')
        reload(page)
        check(page.run(titles) == 'boat' and page.run('isInSpace() && JSON.stringify(Array.from(page.mesh.pose))') == mesh, 'a 3D pose is stored; a closed file is not')
        check(not page.faults(), 'without a complaint')
    finally:
        page.close()


def test_without_store(path, folder):
    """If the browser has no storage, the page asks for confirmation."""
    page = Page(path)
    try:
        page.call('Page.addScriptToEvaluateOnNewDocument', {'source': "indexedDB.open = () => { throw new Error('no store'); };"})
        reload(page)
        page.run("setMode(page, 'cage')")
        drop(page, folder, 'boat.svg', BOAT)
        page.drag_vertex(3, 40, -20)
        check(reload(page), 'without storage, the page asks before work is lost')
        check(page.run('page.figure.name') == 'cat' and not page.faults(), 'and the page starts anew')
    finally:
        page.close()
