// Reads files as text: also compressed files, in the encoding that they declare.

const MOST_UNPACKED = 1e8; // bytes; a compressed file can expand a thousandfold

/** Returns the bytes of a file; unpacks gzip, such as .svgz. */
async function bytesOf(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  const parts = await unpacked(bytes, MOST_UNPACKED).catch(() => { throw new Error(`${file.name} is damaged and cannot be unpacked`); });
  if (!parts) throw new Error(`${file.name} unpacks to more than the ${MOST_UNPACKED / 1e6} MB that this page opens`);
  return parts;
}

/** Returns the encoding of a text: that of a byte order mark or an XML declaration, or UTF-8. */
function encodingOf(bytes) {
  const head = String.fromCharCode(...bytes.subarray(0, 400));
  if (/^(\xff\xfe|<\0)/.test(head)) return 'utf-16le';
  if (/^(\xfe\xff|\0<)/.test(head)) return 'utf-16be';
  const declared = /^\s*<\?xml[^>]*?\sencoding\s*=\s*["']([^"']+)/.exec(head)?.[1] ?? 'utf-8';
  return /^(utf-16|ucs-2|iso-10646-ucs-2)/i.test(declared) ? 'utf-8' : declared; // the declaration was readable as single bytes
}

/** Returns { text, note } of a file; the note names lost letters, if any. */
async function readText(file) {
  const bytes = await bytesOf(file), encoding = encodingOf(bytes);
  const decode = options => new TextDecoder(encoding, options).decode(bytes);
  try {
    return { text: decode({ fatal: true }), note: '' };
  } catch (error) {
    if (error instanceof RangeError) throw new Error(`${file.name} declares the encoding ${encoding}, which this browser does not support`);
    return { text: decode(), note: `; letters that are invalid in its encoding, ${encoding}, are lost` };
  }
}
