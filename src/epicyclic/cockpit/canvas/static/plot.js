// What the plots on uPlot share: axes in the colours of the page, colours that stay with a curve, steady ranges.
import { look, roundUp, translucent, written } from "./look.js";
import uPlot from "./uPlot.min.js";

const FONT_SIZE = 11;

export const axisFont = () => `${FONT_SIZE}px ${look().font}`;

function axis(label, side) {
  return {
    side,
    label,
    labelSize: 17,
    labelGap: 0,
    labelFont: `12px ${look().font}`,
    font: axisFont(),
    size: side === 3 ? 40 : 24,
    gap: 3,
    stroke: () => look().ink,
    grid: { stroke: () => look().grid, width: 1 },
    ticks: { stroke: () => look().edge, width: 1, size: 4 },
    values: (_, splits) => splits.map((value) => (value == null ? "" : tick(value, splits))),
  };
}

/** A tick as short as the step between ticks allows. */
function tick(value, splits) {
  const step = Math.abs((splits[1] ?? 1) - (splits[0] ?? 0)) || 1;
  const decimals = Math.min(8, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  const text = value.toFixed(decimals);
  if (Math.abs(value) < 10000) return text.replace("-", "−");
  return written(value, Math.max(3, Math.ceil(Math.log10(Math.abs(value)) + 1e-9) + decimals));
}

/** A plot of so many curves whose looks and ranges `owner` tells: styles, rangeX(), rangeY(); hooks as uPlot's. */
export function plotOf(parent, { width, height, xLabel, yLabel, count, owner, top, hooks, cursor = true }) {
  const series = Array.from({ length: count }, (_, i) => ({
    label: "",
    stroke: () => owner.styles[i]?.colour ?? look().other,
    width: 1,
    points: { show: false },
    spanGaps: false,
  }));
  return new uPlot(
    {
      width, height,
      padding: [top, 16, 0, 0],
      legend: { show: false },
      cursor: { show: cursor, y: false, drag: { x: false, y: false, setScale: false }, points: { size: 6 }, focus: { prox: 1e6 } },
      scales: { x: { time: false, range: () => owner.rangeX() }, y: { range: () => owner.rangeY() } },
      axes: [axis(xLabel, 2), axis(yLabel, 3)],
      series: [{}, ...series],
      hooks,
    },
    Array.from({ length: count + 1 }, () => []),
    parent,
  );
}

/** Rows of a float array (n, m) as uPlot takes them: null where there is no number. */
export function rowsOf({ shape: [count, length], data }) {
  const rows = [];
  for (let i = 0; i < count; i++) {
    const row = new Array(length);
    for (let j = 0; j < length; j++) {
      const value = data[i * length + j];
      row[j] = Number.isFinite(value) ? value : null;
    }
    rows.push(row);
  }
  return rows;
}

/** Largest number of rows, 0 where there is none. */
export function largest(rows) {
  let most = 0;
  for (const row of rows) for (const value of row) if (value !== null && value > most) most = value;
  return most;
}

/** Colours of the strong curves: a curve keeps its colour from frame to frame as long as it stays strong. */
export class Colours {
  constructor() {
    this.slots = new Map();
  }

  take(names) {
    for (const name of [...this.slots.keys()]) if (!names.includes(name)) this.slots.delete(name);
    for (const name of names) {
      if (this.slots.has(name)) continue;
      const used = new Set(this.slots.values());
      this.slots.set(name, [0, 1, 2, 3].find((slot) => !used.has(slot)) ?? 3);
    }
  }

  of(name) {
    return look().strong[this.slots.get(name) ?? 0];
  }
}

/** Top of an axis from 0 that grows at once and shrinks only when the slider is let go and much of it is empty. */
export function steadyTop(top, most, isReleased) {
  if (most > 0.99 * top) return roundUp(1.12 * most);
  if (isReleased && most < 0.55 * top && most > 0) return roundUp(1.12 * most);
  return top;
}

/** Draw a dashed curve of another state in a plot. */
export function ghostCurve(context, plot, x, y, colour) {
  context.save();
  const { left, top, width, height } = plot.bbox;
  context.beginPath();
  context.rect(left, top, width, height);
  context.clip();
  context.beginPath();
  let isDown = false;
  for (let i = 0; i < x.length; i++) {
    if (x[i] === null || y[i] === null) {
      isDown = false;
      continue;
    }
    const [px, py] = [plot.valToPos(x[i], "x", true), plot.valToPos(y[i], "y", true)];
    if (isDown) context.lineTo(px, py);
    else context.moveTo(px, py);
    isDown = true;
  }
  const ratio = window.devicePixelRatio || 1;
  context.lineWidth = 1.5 * ratio;
  context.setLineDash([5 * ratio, 4 * ratio]);
  context.strokeStyle = translucent(colour, 0.75);
  context.stroke();
  context.restore();
}
