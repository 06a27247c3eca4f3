"""Runs the tests of the npm package in a headless Chromium: python3 chromium.py FOLDER

FOLDER has the installed package, the tests, and data/. A server for this host only serves the files.
"""

import functools
import http.server
import pathlib
import sys
import threading

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parents[3] / 'page'))
from browser import Browser  # noqa: E402


class Quiet(http.server.SimpleHTTPRequestHandler):
    extensions_map = {'.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm', '': 'application/octet-stream'}

    def log_message(self, *args):
        pass


def serve(folder):
    """Serves a folder and returns the address."""
    server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return 'http://127.0.0.1:%d' % server.server_port


def main():
    browser = Browser()
    try:
        browser.call('Page.navigate', {'url': serve(sys.argv[1]) + '/browser.html'})
        browser.wait('window.results !== undefined', seconds=600)
        results = browser.run('window.results')
        faults = browser.faults()
    finally:
        browser.close()
    for result in results:
        print('%s  %s' % ('passed' if result['fault'] is None else 'FAILED', result['name']))
        if result['fault'] is not None:
            print(result['fault'])
    for fault in faults:
        print('browser error: ' + fault)
    failed = sum(result['fault'] is not None for result in results) + len(faults)
    print('in Chromium: %d passed, %d failed' % (len(results) - failed, failed))
    return 1 if failed or len(results) < 20 else 0


if __name__ == '__main__':
    sys.exit(main())
