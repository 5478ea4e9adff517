// Packed frames: uint32 length of the JSON, the JSON padded to a multiple of four, float32 numbers; little-endian.

/** Bytes of a base64 text. */
export function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

/** Frame {rev, kind, head, arrays: {name: {shape, data}}} of base64 text or bytes; the arrays are views, not copies. */
export function decode(packed) {
  const bytes = typeof packed === "string" ? bytesOf(packed) : packed;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const length = view.getUint32(0, true);
  const start = bytes.byteOffset + 4 + length;
  if (4 + length > bytes.byteLength) throw new RangeError("a frame shorter than its head");
  const { rev, kind, head, arrays } = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  const named = {};
  for (const [name, shape, offset] of arrays) {
    const size = shape.reduce((product, n) => product * n, 1);
    named[name] = { shape, data: new Float32Array(bytes.buffer, start + 4 * offset, size) };
  }
  return { rev, kind, head, arrays: named };
}
