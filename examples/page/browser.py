"""Control of a headless Chromium over a pipe with the DevTools protocol. Uses only the standard library."""

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time


class Browser:
    def __init__(self, size=(1280, 900)):
        program = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
        if not program:
            raise SystemExit('chromium is not installed')
        self.folder = tempfile.mkdtemp()
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        def take_pipes():  # the browser reads file descriptor 3 and writes 4
            low, high = os.dup(to_browser), os.dup(from_browser)
            while low in (3, 4):
                low = os.dup(low)
            while high in (3, 4):
                high = os.dup(high)
            os.dup2(low, 3)
            os.dup2(high, 4)

        flags = ['--headless=new', '--no-sandbox', '--remote-debugging-pipe', '--user-data-dir=' + self.folder,
                 '--no-first-run', '--disable-gpu-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-rasterization',
                 '--hide-scrollbars', '--force-color-profile=srgb', '--js-flags=--expose-gc', 'about:blank']
        self.process = subprocess.Popen([program] + flags, preexec_fn=take_pipes, close_fds=False,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.buffer, self.number, self.events = b'', 0, []
        target = self.call('Target.createTarget', {'url': 'about:blank'}, session=None)['targetId']
        self.session = self.call('Target.attachToTarget', {'targetId': target, 'flatten': True}, session=None)['sessionId']
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(domain + '.enable')
        self.resize(*size)

    def close(self):
        try:
            self.call('Browser.close', session=None)
            self.process.wait(10)
        except Exception:  # it has ended already
            self.process.kill()
        shutil.rmtree(self.folder, ignore_errors=True)

    def receive(self, limit):
        while b'\0' not in self.buffer:
            if not select.select([self.read_end], [], [], max(0, limit - time.time()))[0]:
                raise TimeoutError('the browser does not answer')
            part = os.read(self.read_end, 1 << 20)
            if not part:
                raise EOFError('the browser has ended')
            self.buffer += part
        message, self.buffer = self.buffer.split(b'\0', 1)
        return json.loads(message)

    def call(self, method, parameters=None, session='own', seconds=120):
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters or {}}
        if session == 'own':
            message['sessionId'] = self.session
        os.write(self.write_end, json.dumps(message).encode() + b'\0')
        limit = time.time() + seconds
        while True:
            answer = self.receive(limit)
            if answer.get('id') == self.number:
                if 'error' in answer:
                    raise RuntimeError(method + ': ' + answer['error']['message'])
                return answer['result']
            self.events.append(answer)

    def run(self, script):
        """Returns the value of an expression in the page; awaits promises."""
        result = self.call('Runtime.evaluate', {'expression': script, 'awaitPromise': True, 'returnByValue': True,
                                                'userGesture': True})
        if 'exceptionDetails' in result:
            details = result['exceptionDetails']
            raise RuntimeError(details.get('exception', {}).get('description') or details['text'])
        return result['result'].get('value')

    def wait(self, condition, seconds=60):
        limit = time.time() + seconds
        while not self.run(condition):
            if time.time() > limit:
                raise TimeoutError('waited for ' + condition)
            time.sleep(0.03)

    def frames(self, count=2):
        """Waits until the page has drawn."""
        self.run('new Promise(done => { let n = %d; const f = () => --n < 0 ? done() : requestAnimationFrame(f); f(); })' % count)

    def open(self, path):
        self.call('Page.navigate', {'url': 'file://' + os.path.abspath(path)})
        self.wait("document.documentElement?.dataset.ready === 'yes'")

    def resize(self, width, height, scale=1, phone=False):
        self.call('Emulation.setDeviceMetricsOverride',
                  {'width': width, 'height': height, 'deviceScaleFactor': scale, 'mobile': phone})
        self.call('Emulation.setTouchEmulationEnabled', {'enabled': phone})

    def still(self):
        """Emulates the preference for reduced motion."""
        self.call('Emulation.setEmulatedMedia', {'features': [{'name': 'prefers-reduced-motion', 'value': 'reduce'}]})

    def mouse(self, kind, x, y, held=True, **more):
        button = 'left' if held else 'none'
        self.call('Input.dispatchMouseEvent', {'type': kind, 'x': x, 'y': y, 'button': button, 'buttons': int(held),
                                               'clickCount': 1, **more})

    def drag(self, start, end, steps=6, **more):
        self.mouse('mouseMoved', *start, held=False)
        self.mouse('mousePressed', *start, **more)
        for k in range(1, steps + 1):
            self.mouse('mouseMoved', *(a + (b - a) * k / steps for a, b in zip(start, end)), **more)
        self.mouse('mouseReleased', *end, **more)
        self.frames()

    def touch(self, kind, points):
        self.call('Input.dispatchTouchEvent', {'type': kind, 'touchPoints': [
            {'x': x, 'y': y, 'id': k} for k, (x, y) in enumerate(points)]})

    def key(self, key, code=None, modifiers=0, text=None):
        for kind in ('keyDown', 'keyUp'):
            parameters = {'type': kind, 'key': key, 'code': code or key, 'modifiers': modifiers}
            if kind == 'keyDown' and text:
                parameters['text'] = text
            self.call('Input.dispatchKeyEvent', parameters)
        self.frames()

    def click(self, selector):
        self.run('document.querySelector(%r).scrollIntoView({ block: "center" })' % selector)
        x, y = self.run('(() => { const b = document.querySelector(%r).getBoundingClientRect();'
                        'return [b.x + b.width / 2, b.y + b.height / 2]; })()' % selector)
        self.mouse('mousePressed', x, y)
        self.mouse('mouseReleased', x, y)
        self.frames()

    def drop(self, paths, x=600, y=400):
        data = {'items': [], 'files': [os.path.abspath(p) for p in paths], 'dragOperationsMask': 1}
        for kind in ('dragEnter', 'dragOver', 'drop'):
            self.call('Input.dispatchDragEvent', {'type': kind, 'x': x, 'y': y, 'data': data})
        self.frames()

    def picture(self, path, full=False):
        shot = self.call('Page.captureScreenshot', {'format': 'png', 'captureBeyondViewport': full})
        with open(path, 'wb') as file:
            file.write(base64.b64decode(shot['data']))

    def heap(self):
        """Returns the bytes of the JavaScript heap after garbage collection."""
        self.call('HeapProfiler.enable')
        self.call('HeapProfiler.collectGarbage')
        return self.call('Runtime.getHeapUsage')['usedSize']

    def faults(self):
        """Returns the errors of the page."""
        texts = []
        for event in self.events:
            parameters = event.get('params', {})
            if event.get('method') == 'Runtime.exceptionThrown':
                details = parameters['exceptionDetails']
                texts.append(details.get('exception', {}).get('description') or details['text'])
            if event.get('method') == 'Log.entryAdded' and parameters['entry']['level'] == 'error':
                texts.append(parameters['entry']['text'])
            if event.get('method') == 'Runtime.consoleAPICalled' and parameters['type'] == 'error':
                texts.append(str(parameters['args']))
        return texts
