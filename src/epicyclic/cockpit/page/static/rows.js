// Plots whose rows have names: dots about the fair share with a strip over the hunting period, and bars from zero.
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

function cut(context, text, width) {
  if (context.measureText(text).width <= width) return text;
  let end = text.length;
  while (end > 1 && context.measureText(`${text.slice(0, end)}…`).width > width) end -= 1;
  return `${text.slice(0, end)}…`;
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
  context.font = font(11);
  context.textAlign = "right";
  context.fillStyle = look().ink;
  rows.forEach((label, row) => context.fillText(cut(context, label, width), 6 + width, lines.y(row)));
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
  context.font = font(11);
  context.textAlign = "center";
  context.lineWidth = 1;
  for (const { value, text } of ticks(low, high, Math.max(2, Math.min(6, Math.floor((x1 - x0) / 52))))) {
    const x = Math.round(place(value)) + 0.5;
    context.strokeStyle = look().grid;
    context.beginPath();
    context.moveTo(x, lines.top - 2);
    context.lineTo(x, lines.bottom + 3);
    context.stroke();
    context.fillStyle = look().ink;
    context.fillText(text, x, lines.bottom + 11);
  }
  context.font = font(12);
  context.fillText(cut(context, title, x1 - x0 + 40), (x0 + x1) / 2, lines.bottom + 26);
  return place;
}

/** The line that a value is measured against, as the fair share of 1. */
function reference(context, x, lines) {
  context.beginPath();
  context.moveTo(x, lines.top - 4);
  context.lineTo(x, lines.bottom + 3);
  context.lineWidth = 1.4;
  context.strokeStyle = look().pale;
  context.stroke();
}

/** The line of a limit, dashed; none beyond the end of the axis. */
function limitLine(context, x, top, bottom) {
  context.setLineDash([5, 3]);
  context.beginPath();
  context.moveTo(Math.round(x) + 0.5, top);
  context.lineTo(Math.round(x) + 0.5, bottom);
  context.lineWidth = 1.6;
  context.strokeStyle = look().levels.warn;
  context.stroke();
  context.setLineDash([]);
}

const limitText = (limit) => `limit ${short(limit, 4)}`;

/** K_gamma of shares of the trains as dots from 1 to its limit: {marks: [[value, words], ...] rising, limit}. */
function valueScale(context, x0, x1, scale) {
  const y = HEAD + 18;
  const away = [...scale.marks.map(([value]) => value), scale.limit ?? 1].map((value) => value - 1);
  const place = (value) => x0 + ((value - 1) / (1.08 * Math.max(...away, 1e-4))) * (x1 - x0);
  const say = (text, x, below) => context.fillText(text, x, below ? y + 14 : y - 12);
  context.beginPath();
  context.moveTo(x0, y);
  context.lineTo(x1, y);
  context.lineWidth = 1;
  context.strokeStyle = look().edge;
  context.stroke();
  context.font = font(11);
  context.fillStyle = look().ink;
  context.textAlign = "right";
  context.fillText("K_gamma 1", x0 - 8, y);
  let start = Infinity; // of the words drawn last: the largest share has them first
  for (const [value, words] of [...scale.marks].reverse()) {
    const text = `${words}: ${value.toFixed(3)}`;
    const x = Math.min(place(value) + 6, x1 + 56);
    if (x < start) {
      say(text, x, false);
      start = x - context.measureText(text).width - 8;
    }
    dot(context, place(value), y, look().ink, 3.5);
  }
  if (scale.limit == null) return;
  limitLine(context, place(scale.limit), y - 6, y + 8);
  context.fillStyle = look().levels.warn;
  if (place(scale.limit) < x0 + 60) context.textAlign = "left";
  say(limitText(scale.limit), place(scale.limit), true);
}

/** Whiskers of a band. */
function whisker(context, from, to, y) {
  context.beginPath();
  for (const x of [from, to]) {
    context.moveTo(x, y - 4);
    context.lineTo(x, y + 4);
  }
  context.moveTo(from, y);
  context.lineTo(to, y);
  context.lineWidth = 1.3;
  context.strokeStyle = look().ink;
  context.stroke();
}

/** Marks of a legend from right to left within the head: {text, draw(x, y)}. */
function legend(context, right, marks) {
  let x = right;
  context.font = font(11);
  context.textAlign = "left";
  for (const { text, draw } of [...marks].reverse()) {
    x -= context.measureText(text).width;
    context.fillStyle = look().pale;
    context.fillText(text, x, 12);
    x -= 10;
    draw(x, 12);
    x -= 16;
  }
  return x;
}

function dot(context, x, y, colour, size = 4) {
  context.beginPath();
  context.arc(x, y, size, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
}

function openDot(context, x, y, colour, size = 4.5) {
  context.beginPath();
  context.arc(x, y, size, 0, 2 * Math.PI);
  context.lineWidth = 1.6;
  context.strokeStyle = colour;
  context.stroke();
}

function dashedDiamond(context, x, y) {
  context.beginPath();
  context.moveTo(x, y - 5);
  context.lineTo(x + 5, y);
  context.lineTo(x, y + 5);
  context.lineTo(x - 5, y);
  context.closePath();
  context.setLineDash([2.5, 1.8]);
  context.lineWidth = 1.3;
  context.strokeStyle = look().pale;
  context.stroke();
  context.setLineDash([]);
}

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
  context.textBaseline = "middle";
  if (data.limit <= high) limitLine(context, place(data.limit), lines.top - 2, lines.bottom + 3);
  data.groups.forEach((group, row) => {
    const y = lines.y(row);
    group.forEach((index, i) => {
      const shift = (0.42 * lines.tall * (i - (group.length - 1) / 2)) / Math.max(1, group.length - 1);
      lollipop(context, place, y + (group.length > 1 ? shift : 0), index, data, group.length > 1 ? 2.8 : 4);
    });
    const most = Math.max(...group.map((index) => data.coefficient[index]));
    if (!Number.isFinite(most)) return;
    context.font = font(11);
    context.textAlign = "left";
    context.fillStyle = look().ink;
    context.fillText(most.toFixed(3), x1 + 8, y);
  });
  const strip = data.period ? drawStrip(context, x1 + value + 14, width - 10, lines, data) : null;
  const marks = [{ text: "as it is", draw: (x, y) => dot(context, x, y, look().ink) }];
  if (data.twin) marks.push({ text: data.twinLabel, draw: (x, y) => openDot(context, x, y, look().ink) });
  if (data.ghost) marks.push({ text: "A", draw: (x, y) => dashedDiamond(context, x, y) });
  if (data.limit != null) marks.push({ text: limitText(data.limit) + (data.limit > high ? " ▸" : ""), draw: (x, y) => limitLine(context, x, y - 6, y + 6) });
  const left = legend(context, width - 10, marks);
  context.font = font(12, 600);
  context.textAlign = "left";
  context.fillStyle = look().ink;
  context.fillText(cut(context, data.note, left - 8), 8, 12);
  return { lines, strip };
}

/** One coefficient: a stroke from the fair share, its dot, the open dot of the twin, the diamond of pin A. */
function lollipop(context, place, y, index, data, size) {
  const at = data.coefficient[index];
  if (!Number.isFinite(at)) return;
  context.globalAlpha = data.alpha; // of what is older than the state; its texts stay to be read
  context.beginPath();
  context.moveTo(place(1), y);
  context.lineTo(place(at), y);
  context.lineWidth = 1.5;
  context.strokeStyle = translucent(data.colours[index], 0.45);
  context.stroke();
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
  context.font = font(11);
  context.fillStyle = look().ink;
  context.textAlign = "left";
  context.fillText("0", x0, lines.bottom + 11);
  context.textAlign = "right";
  const spaced = String(cycles ?? columns).replace(/\B(?=(\d{3})+$)/g, "\u2009");
  context.fillText(spaced, x1, lines.bottom + 11);
  context.textAlign = "center";
  context.font = font(12);
  context.fillText(cut(context, "hunting period [mesh cycles]", x1 - x0 - 4), (x0 + x1) / 2, lines.bottom + 26);
  drawScale(context, x0, x1, lines.bottom + 11, low, high);
  return { x0, x1, columns };
}

/** Colours of the strip, between the ends of its axis. */
function drawScale(context, x0, x1, y, low, high) {
  const width = 60;
  const middle = (x0 + x1) / 2;
  if (x1 - x0 < width + 130) return;
  for (let i = 0; i < width; i++) {
    context.fillStyle = loadColour(i / (width - 1));
    context.fillRect(middle - width / 2 + i, y - 4, 1.5, 7);
  }
  context.font = font(10);
  context.fillStyle = look().pale;
  context.textAlign = "right";
  context.fillText(short(low, 3), middle - width / 2 - 4, y);
  context.textAlign = "left";
  context.fillText(short(high, 3), middle + width / 2 + 5, y);
}

/** Bars from zero, named: `data` {rows, values, low and high of bands, ghost, title, note, line, scale, format}. */
export function drawBars(context, width, height, data) {
  const lines = spread(data.rows.length, height, data.scale ? SCALE : 0);
  const names = labelWidth(context, data.rows, 0.42 * width);
  const x0 = names + 18;
  const x1 = width - 62;
  const [low95, high95] = [data.low ?? [], data.high ?? []];
  const known = [...data.values, ...low95, ...high95, ...(data.ghost ?? []).filter((value) => value != null), ...(data.line == null ? [] : [data.line])].filter(Number.isFinite);
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
    context.font = font(11);
    context.textAlign = "left";
    context.fillStyle = look().ink;
    const end = Math.max(place(0), Number.isFinite(high95[row]) ? place(high95[row]) : 0, Number.isFinite(at) ? place(at) : 0, data.ghost?.[row] != null ? place(data.ghost[row]) : 0);
    context.fillText(Number.isFinite(at) ? data.format(at) : "n/a", end + 6, y);
  });
  reference(context, place(0), lines);
  if (data.scale) valueScale(context, x0, x1, data.scale);
  if (data.line != null) {
    context.setLineDash([5, 3]);
    reference(context, place(data.line), lines);
    context.setLineDash([]);
  }
  let left = width;
  if (data.ghost) left = legend(context, width - 10, [{ text: "A", draw: (x, y) => ghostBar(context, x - 8, x + 4, y, 8) }]);
  context.font = font(12, 600);
  context.textAlign = "left";
  context.fillStyle = look().ink;
  context.fillText(cut(context, data.note, left - 16), 8, 12);
  return { lines };
}

function ghostBar(context, x0, x1, y, thick) {
  context.setLineDash([3, 2.5]);
  context.lineWidth = 1.2;
  context.strokeStyle = look().pale;
  context.strokeRect(Math.min(x0, x1), y - thick / 2, Math.abs(x1 - x0), thick);
  context.setLineDash([]);
}
