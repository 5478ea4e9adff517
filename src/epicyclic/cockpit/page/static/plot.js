// What the panes with a plot on uPlot share: axes in the colours of the page, steady ranges, the key, what is older paler.
import { font, look, px, roundUp, translucent } from "./look.js";
import { make, Pane } from "./pane.js";
import uPlot from "./uPlot.min.js";

const FONT_SIZE = 11;
const LEAST_DRAG = 5; // [px] below which a drag is a click
export const STALE = 0.4; // opacity of what is older than the state

// uPlot reads whole pixels
export const axisFont = () => font(Math.round(px(FONT_SIZE)));

function axis(label, side) {
  return {
    side,
    label: side === 3 ? (plot) => fitted(plot, label) : label,
    labelSize: px(17),
    labelGap: 0,
    labelFont: font(Math.round(px(12))),
    font: axisFont(),
    size: px(side === 3 ? 44 : 24),
    gap: 3,
    stroke: () => look().ink,
    grid: { stroke: () => look().grid, width: 1 },
    ticks: { stroke: () => look().edge, width: 1, size: 4 },
    values: (_, splits) => splits.map((value) => (value == null ? "" : tick(value, splits))),
  };
}

/** A title beside an axis that is too short for it is the unit alone: the title of the plot says the rest. */
function fitted({ ctx, bbox, height, pxRatio = devicePixelRatio }, title) {
  const room = Math.min(height * pxRatio, bbox.height + 2 * bbox.top);
  return ctx.measureText(title).width <= room ? title : (title.match(/\[[^\]]*\]$/)?.[0] ?? title);
}

/** Decimals that a step between ticks needs. */
export function decimalsOf(step) {
  for (let decimals = 0; decimals < 8; decimals++) if (Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) < 1e-6) return decimals;
  return 8;
}

function tick(value, splits) {
  const known = splits.filter((one) => one != null);
  const text = value.toFixed(decimalsOf(Math.abs((known[1] ?? 1) - (known[0] ?? 0)) || 1)).replace("-", "−");
  return text.replace(/\d+/, (whole) => (whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u2009") : whole));
}

/**
 * A plot of so many curves whose looks and ranges `owner` tells: styles, rangeX(), rangeY(); hooks as uPlot's.
 * uPlot draws of each column of pixels the least and the largest value, so that no peak is lost.
 * `onZoom` takes the ends [from, to] of what is dragged over, null after a double click; the owner then tells its range.
 */
export function plotOf(parent, { width, height, xLabel, yLabel, count, owner, top, hooks, cursor = true, onZoom = null }) {
  const series = Array.from({ length: count }, (_, i) => ({
    label: "",
    stroke: () => owner.styles[i]?.colour ?? look().other,
    width: 1,
    points: { show: false },
    spanGaps: false,
  }));
  const zoomed = (plot) => {
    const { left, width: wide } = plot.select;
    if (wide < LEAST_DRAG) return;
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    onZoom([plot.posToVal(left, "x"), plot.posToVal(left + wide, "x")]);
  };
  const plot = new uPlot(
    {
      width, height,
      padding: [px(top), px(16), 0, 0],
      legend: { show: false },
      cursor: { show: cursor, y: false, drag: { x: Boolean(onZoom), y: false, setScale: false }, points: { size: 6 }, focus: { prox: 1e6 } },
      scales: { x: { time: false, range: () => owner.rangeX() }, y: { range: () => owner.rangeY() } },
      axes: [axis(xLabel, 2), axis(yLabel, 3)],
      series: [{}, ...series],
      hooks: onZoom ? { ...hooks, setSelect: [zoomed] } : hooks,
    },
    Array.from({ length: count + 1 }, () => []),
    parent,
  );
  if (onZoom) plot.over.addEventListener("dblclick", () => onZoom(null));
  return plot;
}

/** A pane around a plot: `data`, `styles` of the curves, `xRange` and `yRange` are its own. */
export class PlotPane extends Pane {
  styles = [];
  xRange = null;
  yRange = null;
  body = make("div", { class: "ck-fill" });
  keys = make("div", { class: "ck-keys" });

  rangeX() {
    return this.xRange ?? [0, 1];
  }

  rangeY() {
    return this.yRange ?? [0, 1];
  }

  dropPlot() {
    this.plot?.destroy();
    this.plot = null;
    this.keys.replaceChildren();
  }

  restyle() {
    this.dropPlot();
    this.schedule();
  }

  resized() {
    if (this.plot && this.width && this.height) this.plot.setSize({ width: this.width, height: this.height });
  }

  /** Both only queue; uPlot draws once, before this frame is painted. */
  redraw(stale) {
    for (const series of this.plot.series.slice(1)) series.alpha = stale ? STALE : 1;
    this.plot.batch(() => {
      this.plot.setData(this.data, true);
      this.plot.redraw(true, true);
    });
  }

  /** An entry of the key: a stroke as of the curve, and its name. */
  key(text, colour, name = "") {
    const mark = make("i", name ? { class: name } : {});
    mark.style.borderTopColor = colour;
    return make("span", {}, mark, text);
  }

  /** The place under the pointer among the values, null beside the plot; `rowsAt` says what the tooltip has. */
  onCursor({ cursor, bbox, pxRatio = window.devicePixelRatio || 1 }) {
    const isOver = cursor.idx != null && cursor.left >= 0 && this.data;
    if (isOver) this.showTip(bbox.left / pxRatio + cursor.left, bbox.top / pxRatio + Math.max(0, cursor.top), this.rowsAt(cursor.idx));
    else this.hideTip();
    return isOver ? cursor.idx : null;
  }

  destroy() {
    this.plot?.destroy();
    super.destroy();
  }
}

/** Unit of an axis, of its label. */
export const unitOf = (label) => label.match(/\[(.*)\]/)?.[1] ?? "";

/** Ends of a part of [least, most] that a key asks for: + and - about a place, arrows along; null: the whole, undefined: no such key. */
export function zoomOfKey(key, [from, to], [least, most], at) {
  if (["0", "Escape", "Home"].includes(key)) return null;
  const [width, step] = [to - from, { ArrowLeft: -0.25, ArrowRight: 0.25 }[key]];
  if (step) {
    const moved = Math.max(least - from, Math.min(most - to, step * width));
    return [from + moved, to + moved];
  }
  const factor = { "+": 0.5, "=": 0.5, "-": 2 }[key];
  return factor ? [at - factor * (at - from), at + factor * (to - at)] : undefined;
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

/** Least and largest number of rows; Infinity and -Infinity where there is none. */
export function endsOf(rows) {
  let [least, most] = [Infinity, -Infinity];
  for (const row of rows) {
    for (const value of row) {
      if (value === null) continue;
      if (value < least) least = value;
      if (value > most) most = value;
    }
  }
  return [least, most];
}

const FLAT = 0.7; // curves that stay above this share of their largest are drawn on an axis that starts below them
const SPAN = 0.08; // least range of such an axis, of the largest value: what is less is as good as constant
const ROOM = 0.3; // of the range above the curves, where the names of the peaks stand

/** Axis [low, high] that holds values from `least` to `most`: from 0, or about curves that lie close together. */
export function axisFor(least, most) {
  if (!(most > 0)) return [0, 1];
  if (least < FLAT * most) return [0, roundUp(1.12 * most)];
  const span = Math.max(1.25 * (most - least), SPAN * most);
  const step = roundUp(span / 6);
  const low = Math.floor((least - Math.max(0.15 * span, 0.7 * (span - (most - least)))) / step) * step;
  return [low, Math.ceil((most + ROOM * span) / step) * step];
}

/** The axis after news: it grows at once, and shrinks when the slider is let go, to that of the state alone. */
export function steadyAxis(axis, least, most, isReleased) {
  const wanted = axisFor(least, most);
  if (isReleased || !axis || !(axis[1] > axis[0])) return wanted;
  const holds = axis[0] <= least && (axis[1] >= 0.99 * most || axis[1] >= wanted[1]) && axis[1] >= most;
  return holds ? axis : [Math.min(axis[0], wanted[0]), Math.max(axis[1], wanted[1])];
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
