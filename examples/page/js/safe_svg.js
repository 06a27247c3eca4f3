// Makes an untrusted document safe to show: copies only parts that are known to be harmless, before any part is in the
// page. The copy contains no script, loads nothing, and does not expand to more than a browser can draw.

const SVG_NS = 'http://www.w3.org/2000/svg', XLINK_NS = 'http://www.w3.org/1999/xlink';
const INKSCAPE_NS = 'http://www.inkscape.org/namespaces/inkscape', XML_NS = 'http://www.w3.org/XML/1998/namespace';
const MOST_INSTANCES = 8000, DEEPEST = 200, MOST_PIXELS = 1e8; // MOST_INSTANCES: limit of instances in addition to the elements of the text

const SHAPES = 'path,rect,circle,ellipse,line,polyline,polygon';
const words = text => new Set(text.trim().split(/\s+/));
const FILTER_PRIMITIVES = `feBlend feColorMatrix feComponentTransfer feComposite feConvolveMatrix feDiffuseLighting feDisplacementMap
  feDistantLight feDropShadow feFlood feFuncA feFuncB feFuncG feFuncR feGaussianBlur feImage feMerge feMergeNode feMorphology feOffset
  fePointLight feSpecularLighting feSpotLight feTile feTurbulence`;
const SAFE_ELEMENTS = words(`svg g defs symbol use switch a text tspan textPath image linearGradient radialGradient stop clipPath mask
  pattern marker filter title desc metadata style ${SHAPES.replaceAll(',', ' ')} ${FILTER_PRIMITIVES}`);
const PLAIN_TEXT = words('id class label groupmode role aria-label data-name lang space'); // browsers do not interpret their values
const SAFE_ATTRIBUTES = words(`viewBox preserveAspectRatio x y width height rx ry cx cy r fx fy fr x1 y1 x2 y2 dx dy d points pathLength
  offset gradientUnits gradientTransform spreadMethod patternUnits patternContentUnits patternTransform clipPathUnits maskUnits
  maskContentUnits mask-type markerUnits markerWidth markerHeight refX refY orient filterUnits primitiveUnits in in2 result mode type
  values tableValues slope intercept amplitude exponent operator k1 k2 k3 k4 order kernelMatrix divisor bias targetX targetY edgeMode
  kernelUnitLength preserveAlpha surfaceScale diffuseConstant specularConstant specularExponent azimuth elevation z pointsAtX pointsAtY
  pointsAtZ limitingConeAngle scale xChannelSelector yChannelSelector stdDeviation radius baseFrequency numOctaves seed stitchTiles
  startOffset method spacing textLength lengthAdjust rotate systemLanguage requiredFeatures version`);
// The properties of styles; most of them are also attributes.
const SAFE_PROPERTY = new RegExp(`^(--[\\w-]+|(fill|stroke|marker|mask|clip|flood|stop|color|font|text|transform|overflow)(-[a-z-]+)?|
  filter|lighting-color|opacity|visibility|display|letter-spacing|word-spacing|white-space(-collapse)?|line-height|direction|
  unicode-bidi|writing-mode|dominant-baseline|alignment-baseline|baseline-shift|rotate|scale|translate|shape-rendering|
  image-rendering|vector-effect|paint-order|mix-blend-mode|isolation|enable-background|[dxyr]|cx|cy|rx|ry|width|height)$`.replace(/\s/g, ''));
const SAFE_FUNCTIONS = words(`url rgb rgba hsl hsla hwb lab lch oklab oklch color color-mix icc-color calc min max clamp var matrix
  translate translatex translatey scale scalex scaley rotate skew skewx skewy blur brightness contrast drop-shadow grayscale hue-rotate
  invert opacity saturate sepia circle ellipse inset polygon path rect`);

/** Tests whether the value of a style or an attribute uses only known functions and references into this document. */
function isSafeValue(text) {
  if (/[\\{}@]/.test(text)) return false;
  for (const [, name] of text.matchAll(/([\w-]*)\s*\(/g)) if (name && !SAFE_FUNCTIONS.has(name.toLowerCase())) return false;
  return !/url\s*\(/i.test(text.replace(/url\(\s*(["']?)#[^"'()\s]+\1\s*\)/gi, ''));
}

/** Returns the safe declarations of a style: [name, value, priority]. Variables with references are omitted: any property may use them. */
function safeDeclarations(style) {
  return Array.from(style, name => [name, style.getPropertyValue(name).trim(), style.getPropertyPriority(name)])
    .filter(([name, value]) => SAFE_PROPERTY.test(name) && isSafeValue(value) && !(name.startsWith('--') && /url\s*\(/i.test(value)));
}
/** Returns the safe parts of style rules as { media, selector, declarations }. Omits fonts, imports and animations. */
function safeRules(rules, media = []) {
  return Array.from(rules).flatMap(rule => {
    if (rule instanceof CSSMediaRule) return safeRules(rule.cssRules, [...media, rule.conditionText]);
    if (!(rule instanceof CSSStyleRule) || /:has\(|:host/i.test(rule.selectorText)) return [];
    const declarations = safeDeclarations(rule.style).map(([name, value, priority]) => `${name}: ${value}${priority && ' !' + priority};`).join(' ');
    return selectorsIn(rule.selectorText).map(selector => ({ media, selector, declarations }));
  });
}
const textOfRule = ({ media, selector, declarations }) => media.reduceRight((text, query) => `@media ${query} {\n${text}\n}`, `${selector} { ${declarations} }`);

/** Splits a list of selectors at commas outside of brackets and strings. */
function selectorsIn(list) {
  const all = [''];
  let depth = 0;
  for (const [token] of list.matchAll(/"(?:[^"\\]|\\.)*"|\\.|[^"\\]/gs)) {
    depth += '(['.includes(token) ? 1 : ')]'.includes(token) ? -1 : 0;
    if (token === ',' && depth === 0) all.push(''); else all[all.length - 1] += token;
  }
  return all.map(selector => selector.trim());
}

/** Returns the specificity of a selector as one number: ids first, then classes, then element names. */
function specificityOf(selector) {
  let text = selector.replace(/\\([0-9a-f]{1,6}\s?|.)/gi, 'x').replace(/\[("[^"]*"|[^"\]])*\]/g, '.x').replace(/[\w-*]*\|/g, '');
  for (let before = ''; text !== before;) { // functions, innermost first
    before = text;
    text = text.replace(/:([\w-]+)\(([^()]*)\)/, (all, name, inside) => {
      const list = /^(is|not)$/.test(name) ? inside : /^nth-(last-)?child$/.test(name) ? /\sof\s(.*)/.exec(inside)?.[1] ?? '' : '';
      const most = Math.max(0, ...list.split(',').map(specificityOf)), own = /^(is|not|where)$/.test(name) ? '' : '.x';
      return own + '#x'.repeat(most / 1e6) + '.x'.repeat(most / 1e3 % 1e3) + '::x'.repeat(most % 1e3);
    });
  }
  const count = pattern => (text.match(pattern) ?? []).length;
  return 1e6 * count(/#/g) + 1e3 * (count(/\./g) + count(/(?<!:):(?!:)/g)) + count(/::/g) + count(/(?<=^|[\s>+~])[^\s.#:>+~*]/g);
}

/** Makes a style sheet from a text by script, which content security policies allow. */
function sheetOf(text) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  return sheet;
}

/** Returns copies of the targets of `use` by their ids, each in a separate tree, in which rules are matched. */
function useTrees(root) {
  const trees = new Map();
  for (const use of root.querySelectorAll('use')) {
    const id = use.getAttribute('href')?.slice(1), target = id && !trees.has(id) && root.querySelector('#' + CSS.escape(id));
    if (!target) continue;
    trees.set(id, new DocumentFragment());
    trees.get(id).append(target.cloneNode(true));
  }
  return trees;
}
/** Converts rules so that each has its own class, and adds the classes to the matching elements of some trees. Returns the rules' text in
 *  order of precedence. Rules then still apply to copies and to elements of another kind. Rules with only classes and ids do so anyway. */
function textOfRules(trees, rules) {
  if (rules.every(({ selector }) => /^([.#][\w-]+)+$/.test(selector))) return rules.map(textOfRule).join('\n');
  const find = selector => trees.flatMap(tree => [...tree.querySelectorAll(selector)]);
  const given = new Map(find('*').map(element => [element, [element.getAttribute('class') ?? '']])), taken = [...given.values()].join(' ');
  let prefix = 'rule-';
  while (taken.includes(prefix)) prefix = '_' + prefix;
  const ordered = rules.map(rule => [specificityOf(rule.selector), rule]).sort(([a], [b]) => a - b).flatMap(([, rule], n) => {
    const found = find(rule.selector), name = prefix + n;
    for (const element of found) given.get(element).push(name);
    return found.length > 0 ? { ...rule, selector: '.' + name } : /:(:|hover|active|focus)/.test(rule.selector) ? rule : [];
  });
  for (const [element, names] of given) if (names.length > 1) element.setAttribute('class', names.join(' ').trim());
  return ordered.map(textOfRule).join('\n');
}

/** Returns a data URI of a picture with the type given by its first bytes; null for an unknown type or a picture that is too large. */
function pictureUri(text) {
  const found = /^\s*data:[^,]*?base64\s*,/i.exec(text);
  if (!found) return null;
  let head = '';
  try {
    head = atob(decodeURIComponent(text.slice(found[0].length, found[0].length + 400)).replace(/\s/g, '').slice(0, 64));
  } catch {
    return null; // not base64
  }
  const byte = k => head.charCodeAt(k), type = head.startsWith('\x89PNG') ? 'png' : head.startsWith('\xff\xd8\xff') ? 'jpeg'
    : head.startsWith('GIF8') ? 'gif' : head.startsWith('RIFF') && head.slice(8, 12) === 'WEBP' ? 'webp' : null;
  const four = k => ((byte(k) * 256 + byte(k + 1)) * 256 + byte(k + 2)) * 256 + byte(k + 3), two = k => byte(k) + 256 * byte(k + 1);
  const pixels = type === 'png' ? four(16) * four(20) : type === 'gif' ? two(6) * two(8) : 0;
  return type && pixels <= MOST_PIXELS ? `data:image/${type};base64,` + text.slice(found[0].length) : null;
}

/** Returns the target of an element's href: "#id" or the data URI of a picture; null for anything else. */
function safeReference(kind, text) {
  if (kind === 'a') return null;
  if (/^\s*#/.test(text)) return text.trim();
  return kind === 'image' || kind === 'feImage' ? pictureUri(text) : null;
}

const LARGEST = { radius: 200, numOctaves: 10, order: 30 }; // limits of filter parameters that determine the cost per pixel
/** Tests whether a filter has an acceptable number of pixels; its region may be relative to the filtered element's size. */
function isSmallEnough(element, name, value) {
  const most = LARGEST[name] ?? (element.localName === 'filter' && /^(x|y|width|height)$/.test(name) ?
    element.getAttribute('filterUnits') === 'userSpaceOnUse' ? 1e5 : /%/.test(value) ? 2000 : 20 : Infinity);
  return most === Infinity || numbersIn(value).every(number => Math.abs(number) <= most);
}

function copyAttributes(from, to) {
  for (const { localName: name, namespaceURI: space, value } of from.attributes) {
    if (name === 'href' && (space === null || space === XLINK_NS)) {
      const reference = safeReference(from.localName, value);
      if (reference !== null) to.setAttribute('href', reference);
    } else if (space === XML_NS && (name === 'space' || name === 'lang')) {
      to.setAttributeNS(space, 'xml:' + name, value);
    } else if (space === INKSCAPE_NS && (name === 'label' || name === 'groupmode')) {
      to.setAttributeNS(space, 'inkscape:' + name, value); // names of layers
    } else if (space === null && (PLAIN_TEXT.has(name) || (SAFE_ATTRIBUTES.has(name) || SAFE_PROPERTY.test(name)) &&
               isSafeValue(value) && isSmallEnough(from, name, value))) {
      to.setAttribute(name, value);
    }
  }
  const style = from.getAttribute('cageform-style');
  if (!style) return;
  const scratch = document.createElement('span').style; // parses declarations; belongs to no element
  scratch.cssText = style;
  for (const declaration of safeDeclarations(scratch)) to.style.setProperty(...declaration);
}

// A parser applies the page's policy even to styles and handlers of an inert document, and reports violations. It therefore reads them
// under other names.
const aside = text => text.replace(/(\s)(style|on\w+)(\s*=\s*["'])/gi, '$1cageform-$2$3').replace(/(<\/?(?:[\w-]+:)?)(style|base)(?=[\s>\/])/gi, '$1cageform-$2');
const notAside = text => text.replaceAll('cageform-', '');

/** Copies a safe element with its children; style rules are collected in `rules`. */
function copySafe(from, parent, rules, depth) {
  if (depth > DEEPEST) throw new Error('elements are nested too deeply');
  const kind = notAside(from.localName);
  if (from.namespaceURI !== SVG_NS || !SAFE_ELEMENTS.has(kind)) return null;
  const isStyle = kind === 'style', to = (parent.ownerDocument ?? parent).createElementNS(SVG_NS, isStyle ? 'metadata' : kind);
  parent.append(to);
  if (isStyle) { // an empty element keeps its position for selectors that count
    const media = from.getAttribute('media'), type = from.getAttribute('type');
    if (type && type !== 'text/css') return to;
    rules.push(...safeRules(sheetOf(media && isSafeValue(media) ? `@media ${media} {${from.textContent}}` : from.textContent).cssRules));
    return to;
  }
  copyAttributes(from, to);
  for (const child of kind === 'metadata' ? [] : from.childNodes) {
    if (child.nodeType === Node.ELEMENT_NODE) copySafe(child, to, rules, depth + 1);
    else if (child.nodeType === Node.TEXT_NODE || child.nodeType === Node.CDATA_SECTION_NODE) to.append(notAside(child.data));
  }
  return to;
}

// ---- how much a document draws ----

const referenced = text => [...text.matchAll(/url\(\s*["']?#([^"')]+)/gi)].map(([, id]) => id);
/** How often the target of a property is drawn: with every shape, at every vertex, or once. */
const multiplier = name => /^(fill|stroke)/.test(name) ? 'shapes' : name.startsWith('marker') ? 'vertices' : null;
/** The cost of drawing an element, in shapes. The cost of filters depends on their pixels. */
const ownCost = kind => /^fe(Turbulence|Morphology|ConvolveMatrix)$/.test(kind) ? 300 : kind === 'feGaussianBlur' || /Lighting$/.test(kind) ? 60
  : kind.startsWith('fe') || kind === 'mask' || kind === 'clipPath' || kind === 'pattern' ? 15 : 1;

/** Counts the instances of elements that a document draws after all references are expanded. */
class InstanceCount {
  constructor(root, css) {
    this.ids = new Map();
    this.most = MOST_INSTANCES + 2 * root.querySelectorAll('*').length;
    for (const element of root.querySelectorAll('[id]')) if (!this.ids.has(element.id)) this.ids.set(element.id, element);
    this.ruled = new Map(); // targets referenced by style rules, by element
    const visit = rules => {
      for (const rule of rules) {
        if (rule instanceof CSSMediaRule) { visit(rule.cssRules); continue; }
        const references = referencesOf(rule.style);
        if (references.length === 0) continue;
        for (const element of [root, ...root.querySelectorAll('*')])
          if (element.matches(rule.selectorText)) this.ruled.set(element, [...this.ruled.get(element) ?? [], ...references]);
      }
    };
    visit(sheetOf(css).cssRules);
    this.known = new Map();
    this.active = new Set();
  }

  /** Returns { all, shapes, vertices, height } of an element, including its children and targets. */
  of(element, depth = 0) {
    const known = this.known.get(element);
    if (known && depth + known.height <= DEEPEST) return known;
    if (depth > DEEPEST) throw new Error('elements are nested too deeply');
    this.active.add(element);
    const kind = element.localName, sum = { all: ownCost(kind), shapes: 0, vertices: 0, height: 0 };
    const add = (part, times, isDrawn) => {
      sum.all += times * part.all;
      sum.height = Math.max(sum.height, part.height + 1);
      if (isDrawn) { sum.shapes += part.shapes; sum.vertices += part.vertices; }
    };
    if (kind === 'text' || kind === 'tspan' || kind === 'image' || element.matches(SHAPES)) {
      sum.shapes = 1;
      sum.vertices = numbersIn(element.getAttribute('d') ?? element.getAttribute('points') ?? '').length / 2 + 4;
    }
    for (const child of element.children) add(this.of(child, depth + 1), 1, true);
    for (const [name, id] of this.referencesFrom(element)) {
      const target = this.ids.get(id);
      if (!target) continue;
      if (this.active.has(target)) throw new Error(`"#${id}" refers to itself through <${kind}>`);
      const part = this.of(target, depth + 1), by = multiplier(name);
      add(part, by ? sum[by] : 1, name === 'href');
    }
    this.active.delete(element);
    if (sum.all > this.most) throw new Error(`${element.id ? `"#${element.id}"` : `<${kind}>`} expands to more than a browser can draw`);
    this.known.set(element, sum);
    return sum;
  }
  referencesFrom(element) {
    const href = element.getAttribute('href'), isCopied = /^(use|pattern|feImage)$/.test(element.localName);
    const own = Array.from(element.attributes, ({ name, value }) => name === 'style' ? [] : referenced(value).map(id => [name, id])).flat();
    return [...(isCopied && href?.startsWith('#') ? [['href', href.slice(1)]] : []), ...own, ...referencesOf(element.style), ...this.ruled.get(element) ?? []];
  }
}
const referencesOf = style => Array.from(style, name => referenced(style.getPropertyValue(name)).map(id => [name, id])).flat();

// ---- reading ----

/** Returns the text with missing namespaces added. */
function withNamespaces(text) {
  return text.replace(/<svg(?=[\s>])[^>]*>/, tag => [['xmlns', SVG_NS], ['xmlns:xlink', XLINK_NS], ['xmlns:inkscape', INKSCAPE_NS]]
    .reduce((all, [name, space]) => new RegExp(`\\s${name}\\s*=`).test(all) ? all : all.replace('<svg', `<svg ${name}="${space}"`), tag));
}
/** Returns the root of an inert document; null if the text is not SVG. */
function parseSvg(text) {
  if (!/<([\w-]+:)?svg[\s>]/.test(text)) return null;
  const root = new DOMParser().parseFromString(aside(text), 'image/svg+xml').documentElement;
  return root.localName === 'svg' && root.namespaceURI === SVG_NS && !root.querySelector('parsererror') ? root : null;
}

/** Returns the safe part of an SVG document: { root, css, trees }; `trees` are the targets of `use`. Throws if it is not SVG or too costly. */
function readSafeSvg(text, name) {
  const parsed = parseSvg(withNamespaces(text)) ?? parseSvg(text);
  if (!parsed) throw new Error(name + ' is not an SVG document');
  const inert = document.implementation.createDocument(null, null), rules = [];
  try {
    const root = copySafe(parsed, inert, rules, 0);
    new InstanceCount(root, '').of(root); // before targets of `use` are copied
    const trees = useTrees(root), css = textOfRules([inert, ...trees.values()], rules);
    new InstanceCount(root, css).of(root);
    return { root, css, trees };
  } catch (error) {
    throw new Error(`${name} cannot be shown: ${error.message}`);
  }
}
