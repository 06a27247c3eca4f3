"""Usage: python3 examples/site/test.py SITE FOLDER

Opens the pages of the site in a headless Chromium, 1440 and 390 pixels wide. Checks that no page is wider than
the window, reports an error or sends a network request, and that all pictures load. Then searches, opens the menu on a
phone, and saves pictures of some pages to FOLDER (site_*.png).
"""
import os
import re
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'page'))
from browser import Browser  # noqa: E402

DESKTOP, PHONE = (1440, 900), (390, 844)
SHOWN = ['index', 'coordinates', 'harmonic', 'classcageform_1_1HarmonicCoordinates', 'group__room__binding',
         'gallery', 'lesson_12', 'play', 'engines', 'changes']

WIDE = '''(() => {
  const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  const lacking = [...document.images].filter(image => image.complete && image.naturalWidth === 0);
  return [wide, lacking.map(image => image.src)];
})()'''


def results(browser):
    """Returns the results of the search, a page in a frame. For local files this page has another origin."""
    for frame in browser.call('Page.getFrameTree')['frameTree'].get('childFrames', []):
        world = browser.call('Page.createIsolatedWorld', {'frameId': frame['frame']['id']})
        return browser.call('Runtime.evaluate', {
            'contextId': world['executionContextId'], 'returnByValue': True, 'expression':
            "[...document.querySelectorAll('.SRResult')].filter(result => result.offsetHeight > 0)"
            ".map(result => result.innerHTML).join(' ')"})['result'].get('value') or ''
    return ''


def main(site, out):
    browser = Browser(DESKTOP)
    failures = []
    pages = sorted(name for name in os.listdir(site) if name.endswith('.html') and name != 'cageform.html')

    def show(page, dark=False):
        browser.call('Emulation.setEmulatedMedia', {'features': [
            {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}]})
        browser.call('Page.navigate', {'url': 'about:blank'})
        browser.call('Page.navigate', {'url': 'file://' + os.path.abspath(os.path.join(site, page))})
        browser.wait("document.readyState === 'complete' && location.href.includes('%s')" % page)

    # Many pages of Doxygen are similar: opens every fifth.
    alike = [page for page in pages if re.match(r'class|struct|concept|\w+_8hpp', page)]
    for page in [page for page in pages if page not in alike] + alike[::5]:
        browser.resize(*DESKTOP)
        show(page)
        for size in (DESKTOP, PHONE):
            browser.resize(*size, phone=False)  # a phone would zoom out on a page that is too wide
            wide, lacking = browser.run(WIDE)
            if wide > 0:
                failures.append('%s is %d pixels wider than %d' % (page, wide, size[0]))
            failures += ['%s lacks %s' % (page, picture) for picture in lacking]
    browser.resize(*DESKTOP)
    failures += ['asks for ' + event['params']['request']['url'] for event in browser.events
                 if event.get('method') == 'Network.requestWillBeSent' and
                 event['params']['request']['url'].startswith(('http:', 'https:'))]
    failures += browser.faults()

    for words, expected in (('harmonic', 'harmonic.html'), ('bind', 'bind'), ('status', 'Status'),
                            ('lesson', 'lesson_')):
        show('index.html')
        browser.run("document.getElementById('MSearchField').focus()")
        for letter in words:
            browser.key(letter, text=letter)
        found = ''
        limit = time.time() + 10
        while expected.lower() not in found.lower() and time.time() < limit:
            time.sleep(0.1)
            found = results(browser)
        if expected.lower() not in found.lower():
            failures.append('the search for %s does not find %s' % (words, expected))
        if words == 'harmonic':
            browser.picture(os.path.join(out, 'site_search.png'))

    browser.resize(*PHONE, phone=True)
    show('index.html')
    browser.click('.main-menu-btn')
    time.sleep(0.5)
    if not browser.run("document.querySelector('#main-menu').offsetHeight > 200"):
        failures.append('the menu on a phone does not open')
    browser.picture(os.path.join(out, 'site_menu.png'))

    for name, size in (('desktop', DESKTOP), ('phone', PHONE)):
        browser.resize(*size, phone=size == PHONE)
        for page in SHOWN:
            show(page + '.html', dark=page == 'harmonic')
            time.sleep(2 if page == 'play' else 0.2)
            browser.picture(os.path.join(out, 'site_%s_%s.png' % (page.split('_1_1')[-1], name)))
    browser.close()
    for failure in failures:
        print(failure, file=sys.stderr)
    print('the site in a browser: %d failures' % len(failures))
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
