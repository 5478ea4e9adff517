// Colours from the CSS variables of the page, read once a theme; numbers as people read them.

let cached = null;

/** Colours of the present theme. */
export function look() {
  if (cached) return cached;
  const style = getComputedStyle(document.body);
  const of = (name) => style.getPropertyValue(`--ck-${name}`).trim();
  cached = {
    surface: of("surface"), raised: of("raised"), ink: of("ink"), pale: of("pale"), grid: of("grid"), edge: of("edge"),
    other: of("other"), font: of("font"), px: parseFloat(getComputedStyle(document.documentElement).fontSize) / 16,
    levels: { good: of("pale"), warn: of("warn"), bad: of("bad") },
    hues: [1, 2, 3, 4, 5, 6, 7, 8].map((i) => of(`hue-${i}`)),
    kinds: Object.fromEntries(["sun", "planet", "ring", "carrier", "shaft", "gear"].map((kind) => [kind, of(kind)])),
    load: [1, 2, 3, 4, 5].map((i) => rgb(of(`load-${i}`))),
    dark: document.body.classList.contains("body--dark"),
  };
  return cached;
}

/** Read the colours again: the style sheet has come. */
export function forget() {
  cached = null;
}

/** Call back when the theme of the page or the size of its text changes; returns what stops it. */
export function watchTheme(callback) {
  const now = () => `${document.body.classList.contains("body--dark")} ${getComputedStyle(document.documentElement).fontSize}`;
  let shown = now();
  const changed = () => {
    if (shown === now()) return;
    shown = now();
    cached = null;
    callback();
  };
  const observer = new MutationObserver(changed);
  observer.observe(document.body, { attributes: true, attributeFilter: ["class"] });
  window.addEventListener("resize", changed);
  return () => {
    observer.disconnect();
    window.removeEventListener("resize", changed);
  };
}

/** A length of the usual page in the present one, whose text grows with a wide window. */
export const px = (length) => length * look().px;

/** Font of a canvas, as CSS. */
export const font = (size, weight = 400) => `${weight} ${size}px ${look().font}`;

/** Colour of data number `at` from 0, the last of -1, as CSS; `shade` 0..1 takes it towards the ink, where it stands out as well. */
export function hue(at, shade = 0) {
  const colour = look().hues.at(at % look().hues.length);
  return shade ? `color-mix(in srgb, ${colour} ${Math.round(100 - 75 * shade)}%, ${look().ink})` : colour;
}

function rgb(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

/** Colour of a load whose place between the ends of the scale is 0..1, as CSS. */
export function loadColour(place) {
  const stops = look().load;
  const at = Math.min(Math.max(place, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  const mixed = stops[low].map((value, i) => Math.round(value + (stops[low + 1][i] - value) * (at - low)));
  return `rgb(${mixed.join(",")})`;
}

/** A colour `rgb(r,g,b)` or `#rrggbb` with an opacity in its own hue, as a gradient of a canvas needs it. */
export function faded(colour, alpha) {
  const parts = colour.startsWith("#") ? rgb(colour) : colour.match(/\d+/g).slice(0, 3);
  return `rgba(${parts.join(",")},${alpha})`;
}

/** A colour with an opacity, as CSS. */
export function translucent(colour, alpha) {
  return `color-mix(in srgb, ${colour} ${Math.round(100 * alpha)}%, transparent)`;
}

/** A colour as it looks with an opacity over the surface, as CSS. */
export function tinted(colour, alpha) {
  return `color-mix(in srgb, ${colour} ${Math.round(100 * alpha)}%, ${look().surface})`;
}

/** A number with so many significant digits, without an exponent; a thin space between thousands. */
export function written(value, digits = 3) {
  if (!Number.isFinite(value)) return "n/a";
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  const text = value.toFixed(Math.min(Math.max(digits - 1 - size, 0), 8));
  const [whole, part] = text.split(".");
  const minus = whole.startsWith("-") ? "−" : "";
  const spaced = whole.replace("-", "").replace(/\B(?=(\d{3})+$)/g, "\u2009");
  return minus + spaced + (part ? `.${part}` : "");
}

/** The same without zeros at the end of its decimals. */
export function short(value, digits = 3) {
  return written(value, digits).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
}

/** A label of a mesh or body in few letters: sides as L and R, which the whole label beside it spells out. */
export const brief = (label) => label.replace(/ left\b/, " L").replace(/ right\b/, " R");

/** The next 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten at or above a positive number. */
export function roundUp(value) {
  if (!(value > 0) || !Number.isFinite(value)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const step = [1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((one) => one * power >= value * (1 - 1e-9));
  return step * power;
}

/** The label of a curve without how many lie on it. */
export const alone = (label) => label.replace(/ and \d+ alike$/, "");

export const calm = () => window.matchMedia("(prefers-reduced-motion: reduce)").matches;
