// Plots whose rows have names: dots about the fair share with a strip over the hunting period, and bars from zero.
import { circle, colourBar, lines as drawLines, write } from "./canvas.js";
import { font, loadColour, look, roundUp, short, translucent } from "./look.js";
import { decimalsOf } from "./plot.js";

export const ROW = { least: 12, most: 32 }; // [px]
const SHADES = 255; // steps of the colours of a strip
const HEAD = 24;
export const FOOT = 36; // numbers and title of the axis
const SCALE = 40; // [px] of a scale of values above bars

export const heightFor = (rows, isScaled) => HEAD + FOOT + (isScaled ? SCALE : 0) + rows * ROW.least;

function labelWidth(context, labels, most) {
  context.font = font(11);
  return Math.min(most, Math.max(30, ...labels.map((label) => context.measureText(label).width)) + 4);
}

/** Rows of both sides of a herringbone pair as one where there are more than `most`: [[index, ...], ...] and labels. */
export function folded(labels, most) {
  const plain = labels.map((_, i) => [i]);
  if (labels.length <= most) return { groups: plain, names: labels };
  const groups = new Map();
  labels.forEach((label, i) => {
    const name = label.replace(/,? (left|right)\b/, "");
    groups.set(name, [...(groups.get(name) ?? []), i]);
  });
  return { groups: [...groups.values()], names: [...groups.keys()] };
}

/** Places of the rows: {y, tall, top, bottom}. */
function spread(count, height, above = 0) {
  const top = HEAD + above;
  const tall = Math.min(ROW.most, (height - top - FOOT) / Math.max(count, 1));
  return { tall, top, bottom: top + tall * count, y: (row) => top + tall * (row + 0.5) };
}

function labels(context, rows, lines, width) {
  rows.forEach((label, row) => write(context, label, 6 + width, lines.y(row), { align: "right", room: width }));
}

/** Ticks of an axis from `low` to `high`, four to seven of them. */
export function ticks(low, high, most = 6) {
  const raw = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].find((one) => one * power >= raw * (1 - 1e-9)) * power;
  const found = [];
  const decimals = decimalsOf(step);
  for (let value = Math.ceil(low / step - 1e-9) * step; value <= high + 1e-9 * step; value += step) found.push(Math.abs(value) < 1e-12 * step ? 0 : value);
  return found.map((value) => ({ value, text: value.toFixed(decimals).replace("-", "−") }));
}

function axis(context, { x0, x1, low, high, title }, lines) {
  const place = (value) => x0 + ((value - low) / (high - low)) * (x1 - x0);
  for (const { value, text } of ticks(low, high, Math.max(2, Math.min(6, Math.floor((x1 - x0) / 52))))) {
    const x = Math.round(place(value)) + 0.5;
    upright(context, look().grid, 1, x, lines.top - 2, lines.bottom + 3);
    write(context, text, x, lines.bottom + 11, { align: "center" });
  }
  write(context, title, (x0 + x1) / 2, lines.bottom + 26, { size: 12, align: "center", room: x1 - x0 + 40 });
  return place;
}

const upright = (context, colour, width, x, top, bottom, dash) => drawLines(context, colour, width, [[[x, top], [x, bottom]]], dash);

/** The line that a value is measured against, as the fair share of 1. */
const reference = (context, x, lines, dash) => upright(context, look().pale, 1.4, x, lines.top - 4, lines.bottom + 3, dash);

/** The line of a limit, dashed. */
const limitLine = (context, x, top, bottom) => upright(context, look().levels.warn, 1.6, Math.round(x) + 0.5, top, bottom, [5, 3]);

const limitText = (limit) => `limit ${short(limit, 4)}`;

/** K_gamma of shares of the trains as dots from 1 to its limit: {marks: [[value, words], ...] rising, limit}. */
function valueScale(context, x0, x1, scale) {
  const y = HEAD + 18;
  const away = [...scale.marks.map(([value]) => value), scale.limit ?? 1].map((value) => value - 1);
  const place = (value) => x0 + ((value - 1) / (1.08 * Math.max(...away, 1e-4))) * (x1 - x0);
  drawLines(context, look().edge, 1, [[[x0, y], [x1, y]]]);
  write(context, "K_gamma 1", x0 - 8, y, { align: "right" });
  let start = Infinity; // of the words drawn last: the largest share has them first
  for (const [value, words] of [...scale.marks].reverse()) {
    const text = `${words}: ${value.toFixed(3)}`;
    const x = Math.min(place(value) + 6, x1 + 56);
    if (x < start) {
      write(context, text, x, y - 12, { align: "right" });
      start = x - context.measureText(text).width - 8;
    }
    dot(context, place(value), y, look().ink, 3.5);
  }
  if (scale.limit == null) return;
  const limit = place(scale.limit);
  limitLine(context, limit, y - 6, y + 8);
  write(context, limitText(scale.limit), limit, y + 14, { colour: look().levels.warn, align: limit < x0 + 60 ? "left" : "right" });
}

/** Whiskers of a band. */
function whisker(context, from, to, y) {
  const ends = [from, to].map((x) => [[x, y - 4], [x, y + 4]]);
  drawLines(context, look().ink, 1.3, [...ends, [[from, y], [to, y]]]);
}

/** Marks of a legend from right to left within the head: {text, draw(x, y)}. */
function legend(context, right, marks) {
  let x = right;
  context.font = font(11);
  for (const { text, draw } of [...marks].reverse()) {
    x -= context.measureText(text).width;
    write(context, text, x, 12, { colour: look().pale });
    x -= 10;
    draw(x, 12);
    x -= 16;
  }
  return x;
}

function dot(context, x, y, colour, size = 4) {
  circle(context, x, y, size);
  context.fillStyle = colour;
  context.fill();
}

function openDot(context, x, y, colour, size = 4.5) {
  circle(context, x, y, size);
  context.lineWidth = 1.6;
  context.strokeStyle = colour;
  context.stroke();
}

const dashedDiamond = (context, x, y) => drawLines(context, look().pale, 1.3, [[[x, y - 5], [x + 5, y], [x, y + 5], [x - 5, y], [x, y - 5]]], [2.5, 1.8]);

/** Ends of an axis about 1 that hold all the values; `least` half its width. */
export function about1(values, least) {
  const away = Math.max(least, ...values.filter(Number.isFinite).map((value) => Math.abs(value - 1)));
  return roundUp(1.05 * away);
}

/**
 * Load sharing: coefficients as dots with a line at 1, the twin as open dots, pin A as dashed diamonds, beside them
 * the rows over the hunting period. `data` {rows, groups (indices of each row), coefficient, twin, ghost, period, title, twinLabel, note, half, periodHalf}.
 */
export function drawSharing(context, width, height, data) {
  const lines = spread(data.rows.length, height);
  const names = labelWidth(context, data.rows, 0.3 * width);
  const value = 40;
  const x0 = names + 22;
  const x1 = data.period ? Math.round(x0 + 0.46 * (width - x0 - value)) : width - value - 16;
  labels(context, data.rows, lines, names);
  const [low, high] = [Math.max(0, 1 - data.half), 1 + data.half];
  const place = axis(context, { x0, x1, low, high, title: data.title }, lines);
  reference(context, place(1), lines);
  if (data.limit <= high) limitLine(context, place(data.limit), lines.top - 2, lines.bottom + 3);
  data.groups.forEach((group, row) => {
    const y = lines.y(row);
    group.forEach((index, i) => {
      const shift = (0.42 * lines.tall * (i - (group.length - 1) / 2)) / Math.max(1, group.length - 1);
      lollipop(context, place, y + (group.length > 1 ? shift : 0), index, data, group.length > 1 ? 2.8 : 4);
    });
    const most = Math.max(...group.map((index) => data.coefficient[index]));
    if (Number.isFinite(most)) write(context, most.toFixed(3), x1 + 8, y);
  });
  const strip = data.period ? drawStrip(context, x1 + value + 14, width - 10, lines, data) : null;
  const marks = [{ text: "as it is", draw: (x, y) => dot(context, x, y, look().ink) }];
  if (data.twin) marks.push({ text: data.twinLabel, draw: (x, y) => openDot(context, x, y, look().ink) });
  if (data.ghost) marks.push({ text: "A", draw: (x, y) => dashedDiamond(context, x, y) });
  if (data.limit != null) marks.push({ text: limitText(data.limit) + (data.limit > high ? " ▸" : ""), draw: (x, y) => limitLine(context, x, y - 6, y + 6) });
  const left = legend(context, width - 10, marks);
  write(context, data.note, 8, 12, { size: 12, weight: 600, room: left - 8 });
  return { lines, strip };
}

/** One coefficient: a stroke from the fair share, its dot, the open dot of the twin, the diamond of pin A. */
function lollipop(context, place, y, index, data, size) {
  const at = data.coefficient[index];
  if (!Number.isFinite(at)) return;
  context.globalAlpha = data.alpha; // of what is older than the state; its texts stay to be read
  drawLines(context, translucent(data.colours[index], 0.45), 1.5, [[[place(1), y], [place(at), y]]]);
  if (data.ghost?.[index] != null) dashedDiamond(context, place(data.ghost[index]), y);
  dot(context, place(at), y, data.colours[index], size);
  if (Number.isFinite(data.twin?.[index])) openDot(context, place(data.twin[index]), y, data.colours[index], size + 0.5);
  context.globalAlpha = 1;
}

/** Rows over the hunting period, coloured by load. */
function drawStrip(context, x0, x1, lines, { groups, period, periodHalf, cycles, alpha }) {
  const [rows, columns] = period.shape;
  if (!columns || x1 - x0 < 30) return null;
  const picture = document.createElement("canvas");
  Object.assign(picture, { width: columns, height: rows });
  const paint = picture.getContext("2d");
  const image = paint.createImageData(columns, rows);
  const [low, high] = [Math.max(0, 1 - periodHalf), 1 + periodHalf];
  const palette = Array.from({ length: SHADES + 1 }, (_, i) => loadColour(i / SHADES).match(/\d+/g).map(Number));
  for (let i = 0; i < rows * columns; i++) {
    const share = (period.data[i] - low) / (high - low);
    if (!Number.isFinite(share)) continue; // stays clear
    const [r, g, b] = palette[Math.round(SHADES * Math.min(Math.max(share, 0), 1))];
    const at = 4 * i;
    [image.data[at], image.data[at + 1], image.data[at + 2], image.data[at + 3]] = [r, g, b, 255];
  }
  paint.putImageData(image, 0, 0);
  context.imageSmoothingEnabled = false;
  context.globalAlpha = alpha;
  groups.forEach((group, row) => {
    const tall = (0.82 * lines.tall) / group.length;
    group.forEach((index, i) => context.drawImage(picture, 0, index, columns, 1, x0, lines.y(row) - 0.41 * lines.tall + i * tall, x1 - x0, tall));
  });
  context.globalAlpha = 1;
  write(context, "0", x0, lines.bottom + 11);
  const spaced = String(cycles ?? columns).replace(/\B(?=(\d{3})+$)/g, "\u2009");
  write(context, spaced, x1, lines.bottom + 11, { align: "right" });
  write(context, "hunting period [mesh cycles]", (x0 + x1) / 2, lines.bottom + 26, { size: 12, align: "center", room: x1 - x0 - 4 });
  drawScale(context, x0, x1, lines.bottom + 11, low, high);
  return { x0, x1, columns };
}

/** Colours of the strip, between the ends of its axis. */
function drawScale(context, x0, x1, y, low, high) {
  const width = 60;
  const middle = (x0 + x1) / 2;
  if (x1 - x0 < width + 130) return;
  colourBar(context, middle - width / 2, y - 4, width, 7);
  write(context, short(low, 3), middle - width / 2 - 4, y, { size: 10, align: "right", colour: look().pale });
  write(context, short(high, 3), middle + width / 2 + 5, y, { size: 10, colour: look().pale });
}

/** Bars from zero, named: `data` {rows, values, low and high of bands, ghost, title, note, line, scale, format}. */
export function drawBars(context, width, height, data) {
  const lines = spread(data.rows.length, height, data.scale ? SCALE : 0);
  const names = labelWidth(context, data.rows, 0.42 * width);
  const x0 = names + 18;
  const x1 = width - 62;
  const [low95, high95] = [data.low ?? [], data.high ?? []];
  const known = [...data.values, ...low95, ...high95, ...(data.ghost ?? []), data.line].filter(Number.isFinite);
  const most = Math.max(0, ...known);
  const least = Math.min(0, ...known);
  const high = most > 0 ? roundUp(most) : 0;
  const low = least < 0 ? -roundUp(-least) : 0;
  labels(context, data.rows, lines, names);
  const place = axis(context, { x0, x1, low, high: high > low ? high : 1, title: data.title }, lines);
  data.rows.forEach((_, row) => {
    const [y, at] = [lines.y(row), data.values[row]];
    const thick = Math.min(16, 0.66 * lines.tall);
    if (Number.isFinite(at)) {
      context.globalAlpha = data.alpha;
      context.fillStyle = row === data.strong ? look().ink : look().pale;
      context.fillRect(Math.min(place(0), place(at)), y - thick / 2, Math.max(1, Math.abs(place(at) - place(0))), thick);
      context.globalAlpha = 1;
    }
    if (data.ghost?.[row] != null) ghostBar(context, place(0), place(data.ghost[row]), y, thick + 3);
    if (high95[row] > low95[row]) whisker(context, place(low95[row]), place(high95[row]), y);
    const end = Math.max(...[0, high95[row], at, data.ghost?.[row]].filter(Number.isFinite).map(place));
    write(context, Number.isFinite(at) ? data.format(at) : "n/a", end + 6, y);
  });
  reference(context, place(0), lines);
  if (data.scale) valueScale(context, x0, x1, data.scale);
  if (data.line != null) reference(context, place(data.line), lines, [5, 3]);
  const left = data.ghost ? legend(context, width - 10, [{ text: "A", draw: (x, y) => ghostBar(context, x - 8, x + 4, y, 8) }]) : width;
  write(context, data.note, 8, 12, { size: 12, weight: 600, room: left - 16 });
  return { lines };
}

function ghostBar(context, x0, x1, y, thick) {
  context.setLineDash([3, 2.5]);
  context.lineWidth = 1.2;
  context.strokeStyle = look().pale;
  context.strokeRect(Math.min(x0, x1), y - thick / 2, Math.abs(x1 - x0), thick);
  context.setLineDash([]);
}
