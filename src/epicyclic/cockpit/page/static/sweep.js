// Mesh forces over speed: the worst curves strong, peaks named after their modes, the operating speed, pin A dashed.
import { nearestOf, placed } from "./labels.js";
import { circle, lines, write } from "./canvas.js";
import { alone, brief, font, hue, look, px, short, written } from "./look.js";
import { make } from "./pane.js";
import { axisFont, endsOf, ghostCurve, PlotPane, plotOf, rowsOf, STALE, steadyAxis, unitOf } from "./plot.js";

const NARROW = 460; // [px] of a pane below which the key has two lines
const LABEL = { height: 16, pad: 8, most: 210 }; // [px] of the name of a peak; longer ones are cut
const NEAR = 11; // [px] from a peak within which a click means its mode

export class SweepPane extends PlotPane {
  constructor(...given) {
    super(...given);
    this.peaks = make("div", { class: "ck-peaks" });
    this.note = make("div", { class: "ck-note" });
    this.raised = make("div", { class: "ck-note ck-at-left", hidden: "" }, "axis not from 0");
    this.root.prepend(this.body, this.keys, this.note, this.raised, this.peaks);
    this.cursor = -1;
    this.measured = new Map();
    this.measurer = document.createElement("canvas").getContext("2d");
  }

  emptyText() {
    return this.reason("sweep") || "Mesh forces over speed stand here as soon as they are computed.";
  }

  clear() {
    this.dropPlot();
    this.note.textContent = "";
    this.raised.hidden = true;
    this.peaks.replaceChildren();
  }

  resized() {
    if (this.plot && this.isNarrow !== this.width < NARROW) this.restyle(); // its key takes another number of lines
    super.resized();
  }

  dropPlot() {
    super.dropPlot();
    this.measured.clear();
    this.keyText = null;
  }

  hear(changed) {
    super.hear(changed);
    if (changed.includes("ghost")) this.pinned = this.ghostOf();
    if (changed.includes("preview")) this.previewed = this.ghostOf(this.hub.previewed?.sweep);
  }

  ghostOf(part = this.hub.pinned.sweep) {
    if (!part) return null;
    const curves = part.head.curves.map((curve, i) => ({ ...curve, row: i })).filter((curve) => curve.strong);
    const rows = rowsOf(part.arrays.y);
    return { head: part.head, x: Array.from(part.arrays.x.data), curves: curves.map((curve) => ({ ...curve, y: rows[curve.row] })) };
  }

  draw(part, _time, stale) {
    const { head, arrays } = part;
    const isNews = this.taken !== part || this.marked !== this.hub.resonance;
    if (this.taken !== part || !this.plot) this.take(part, head, arrays);
    if (isNews) this.describe(head);
    this.plot.root.classList.toggle("ck-stale", stale);
    this.redraw(stale);
    this.drawKeys(head);
  }

  /** A new sweep: curves in the order of painting, strong ones last, their colours kept. */
  take(part, head, arrays) {
    const isReleased = !["curve", "live"].includes(part.kind);
    const isOther = this.head?.x_label !== head.x_label || this.head?.y_label !== head.y_label;
    const rows = rowsOf(arrays.y);
    this.pinned = this.ghostOf();
    const peaks = head.peaks.map((peak) => peak.y);
    const [least, most] = endsOf([...rows, ...(this.pinned?.curves ?? []).map((curve) => curve.y), peaks]);
    this.yRange = steadyAxis(isOther ? null : this.yRange, least, most, isReleased);
    const range = head.range ?? [arrays.x.data[0], arrays.x.data[arrays.x.data.length - 1]];
    this.xRange = isOther || isReleased || !this.xRange ? range : [Math.min(range[0], this.xRange[0]), Math.max(range[1], this.xRange[1])];
    const order = head.curves.map((curve, i) => ({ ...curve, row: i }));
    order.sort((a, b) => Number(a.strong) - Number(b.strong) || a.row - b.row);
    this.order = order;
    this.styleCurves();
    this.data = [Array.from(arrays.x.data), ...order.map((curve) => rows[curve.row])];
    if (!this.plot || isOther || this.plot.series.length !== order.length + 1) this.build(head, order.length);
    order.forEach((curve, i) => {
      this.plot.series[i + 1].width = curve.strong ? 2 : 1;
      this.plot.series[i + 1].label = curve.label;
    });
    this.head = head;
    this.taken = part;
  }

  colourOf({ label, row }) {
    return this.hub.meshColour(label) ?? hue(row);
  }

  styleCurves() {
    this.styles = this.order.map((curve) => ({ colour: curve.strong ? this.colourOf(curve) : look().other }));
  }

  build(head, count) {
    this.dropPlot();
    this.isNarrow = this.width < NARROW;
    this.keys.classList.toggle("ck-two-lines", this.isNarrow);
    this.plot = plotOf(this.body, {
      width: this.width, height: this.height, xLabel: head.x_label, yLabel: head.y_label, count, owner: this, top: this.isNarrow ? 42 : 26,
      hooks: { drawAxes: [(plot) => this.drawBehind(plot)], draw: [(plot) => this.drawOver(plot)], setCursor: [(plot) => (this.cursor = this.onCursor(plot) ?? -1)] },
    });
    this.plot.over.addEventListener("click", (event) => this.onClick(event));
    this.plot.root.setAttribute("aria-hidden", "true");
  }

  drawBehind(plot) {
    const context = plot.ctx;
    for (const curve of this.pinned?.curves ?? []) {
      const same = this.order.find((one) => one.strong && one.label === curve.label);
      ghostCurve(context, plot, this.pinned.x, curve.y, same ? this.colourOf(curve) : look().pale);
    }
    for (const curve of this.previewed?.curves ?? []) ghostCurve(context, plot, this.previewed.x, curve.y, look().ink);
  }

  drawOver(plot) {
    const ratio = window.devicePixelRatio || 1;
    const context = plot.ctx;
    const { left, top, width, height } = plot.bbox;
    const frame = { context, ratio, left, top, right: left + width, bottom: top + height, at: (speed) => plot.valToPos(speed, "x", true) };
    context.save();
    const operating = this.drawOperating(frame);
    this.mark = this.drawMeeting(frame);
    const preview = this.drawPreview(frame);
    this.placePeaks(plot, ratio, { x: left / ratio, y: top / ratio, w: width / ratio, h: height / ratio }, [operating, this.mark, preview].filter(Boolean));
    context.globalAlpha = this.isStale() ? STALE : 1;
    for (const peak of this.shownPeaks) {
      circle(context, peak.x * ratio, peak.y * ratio, 3.2 * ratio);
      context.fillStyle = look().surface;
      context.strokeStyle = look().ink;
      context.lineWidth = 1.4 * ratio;
      context.fill();
      context.stroke();
      if (peak.box) leader(context, peak, ratio);
    }
    context.restore();
  }

  /** Whether a speed lies in what is shown. */
  isShown(speed) {
    return speed >= this.xRange[0] && speed <= this.xRange[1];
  }

  drawOperating({ context, ratio, left, top, right, bottom, at }) {
    const x = at(this.head.operating ?? NaN);
    if (!(x >= left - 1 && x <= right + 1)) return null;
    lines(context, look().ink, 1.5 * ratio, [[[x, top], [x, bottom]]]);
    const text = `operating, ${short(this.head.operating, 4)}`;
    const wide = widthOf(context, text, ratio);
    const meeting = at(this.hub.resonance?.speed ?? -Infinity);
    const isCrossed = meeting > x && meeting < x + wide + 12 * ratio && x - wide - 8 * ratio > left;
    const isRight = x + wide + 8 * ratio < right && !isCrossed;
    context.textBaseline = "top";
    write(context, text, isRight ? x + 5 * ratio : x - 5 * ratio - wide, top + 2 * ratio, bold(ratio));
    const start = isRight ? x : x - wide - 8 * ratio;
    return { x: start / ratio, y: top / ratio, w: wide / ratio + 8, h: px(15) };
  }

  /** The resonance of the first answer: a dashed line at its speed, one from there to the speed that is shown, its words. */
  drawMeeting({ context, ratio, left, top, right, bottom, at }) {
    const { speed, mark, level } = this.hub.resonance ?? {};
    if (!this.isShown(speed) || !Number.isFinite(this.head.operating)) return null;
    const [x, from, y] = [at(speed), at(this.head.operating), bottom - 7 * ratio];
    const colour = look().levels[level] ?? look().pale;
    lines(context, colour, 1.5 * ratio, [[[x, top], [x, bottom]]], [2 * ratio, 3 * ratio]);
    lines(context, colour, 1.5 * ratio, [[[from, y], [x, y]]]);
    const wide = widthOf(context, mark, ratio);
    const isLeft = x < from ? x - wide - 8 * ratio > left : x + wide + 8 * ratio > right;
    const beside = isLeft ? x - wide - 5 * ratio : x + 5 * ratio;
    const start = Math.max(left + 2 * ratio, Math.min(beside, right - wide - 2 * ratio));
    const box = { x: start / ratio - 2, y: bottom / ratio - px(16), w: wide / ratio + 4, h: px(15) };
    context.fillStyle = look().surface; // over the curves: names of peaks go elsewhere
    context.fillRect(box.x * ratio, box.y * ratio, box.w * ratio, box.h * ratio);
    context.textBaseline = "bottom";
    write(context, mark, start, bottom - 2 * ratio, { ...bold(ratio), colour });
    return box;
  }

  /** Where a change would move the resonance that it is about, while the pointer rests on the change. */
  drawPreview({ context, ratio, top, right, bottom, at }) {
    const { speed, label, result } = this.hub.previewed ?? {};
    this.root.dataset.preview = label ?? "";
    if (!this.isShown(speed)) return null;
    const [x, y] = [at(speed), top + 18 * ratio];
    lines(context, look().ink, 2 * ratio, [[[x, top], [x, bottom]]], [6 * ratio, 3 * ratio]);
    const wide = widthOf(context, result, ratio);
    const start = x + wide + 8 * ratio < right ? x + 5 * ratio : x - wide - 5 * ratio;
    context.fillStyle = look().surface;
    context.fillRect(start - 2 * ratio, y - ratio, wide + 4 * ratio, px(13) * ratio);
    context.textBaseline = "top";
    write(context, result, start, y, bold(ratio));
    return { x: start / ratio - 2, y: y / ratio, w: wide / ratio + 4, h: px(15) };
  }

  /** Names of the peaks as buttons, the highest first; where there is no room the point alone stays. */
  placePeaks(plot, ratio, bounds, obstacles) {
    const known = this.head.peaks.filter((peak) => this.isShown(peak.x));
    const sorted = [...known].sort((a, b) => b.y - a.y);
    const items = sorted.map((peak) => {
      const at = { x: plot.valToPos(peak.x, "x", true) / ratio, y: plot.valToPos(peak.y, "y", true) / ratio };
      return { ...at, w: this.widthOf(peak.label), h: px(LABEL.height), peak };
    });
    const points = this.curvePoints(plot, ratio);
    const dots = items.map(({ x, y }) => ({ x: x - 4, y: y - 4, w: 8, h: 8 }));
    const boxes = placed(items, bounds, [...obstacles, ...dots], points);
    this.shownPeaks = items.map((item, i) => ({ ...item, box: boxes[i] }));
    const shown = this.shownPeaks.filter((item) => item.box);
    while (this.peaks.children.length > shown.length) this.peaks.lastChild.remove();
    while (this.peaks.children.length < shown.length) this.peaks.append(this.peakButton());
    shown.forEach(({ peak, box }, i) => {
      const button = this.peaks.children[i];
      if (button.textContent !== peak.label) button.textContent = peak.label;
      button.dataset.mode = String(peak.mode);
      button.title = `${peak.text ?? peak.label}: ${written(peak.y, 4)} at ${short(peak.x, 4)}`;
      button.setAttribute("aria-label", `Show the mode of this peak: ${button.title}`);
      const mode = this.hub.mode;
      button.setAttribute("aria-pressed", String(mode !== null && mode >= peak.mode && mode < peak.mode + peak.count));
      Object.assign(button.style, { left: `${box.x.toFixed(1)}px`, top: `${box.y.toFixed(1)}px`, width: `${box.w}px` });
    });
  }

  peakButton() {
    const button = make("button", { class: "ck-peak", type: "button" });
    button.addEventListener("click", () => this.chooseMode(Number(button.dataset.mode)));
    return button;
  }

  chooseMode(index) {
    if (!Number.isInteger(index) || index < 0) return;
    this.hub.chooseMode(index);
    this.options.onMode?.(index);
  }

  widthOf(text) {
    if (!this.measured.has(text)) {
      if (this.measured.size > 400) this.measured.clear();
      this.measurer.font = axisFont();
      this.measured.set(text, Math.min(px(LABEL.most), Math.ceil(this.measurer.measureText(text).width) + LABEL.pad + 2));
    }
    return this.measured.get(text);
  }

  /** Points along the strong curves in pixels, close to each other, which names of peaks do not cover. */
  curvePoints(plot, ratio) {
    const points = [];
    const speeds = this.data[0].map((value) => plot.valToPos(value, "x", true) / ratio);
    this.order.forEach((curve, i) => {
      if (!curve.strong) return;
      let last = null;
      this.data[i + 1].forEach((value, j) => {
        const point = value === null ? null : [speeds[j], plot.valToPos(value, "y", true) / ratio];
        if (point && last) points.push(...between(last, point));
        last = point;
      });
    });
    return points;
  }

  drawKeys(head) {
    const strong = this.order.filter((curve) => curve.strong);
    const words = (curve) => {
      const label = withoutStage(brief(alone(curve.label)), strong);
      return this.previewed ? label.replace(/planet /g, "p") : label; // room for one more key
    };
    const rows = strong.map((curve) => this.key(words(curve), this.colourOf(curve)));
    const others = this.order.length - strong.length;
    if (others) rows.push(this.key(`${others} more`, look().other));
    if (this.pinned) rows.push(this.key("A", look().pale, "ck-dashed"));
    if (this.previewed) rows.push(this.key("changed", look().ink, "ck-dashed"));
    for (const row of rows.slice(strong.length)) row.classList.add("ck-whole");
    this.note.textContent = head.stage ?? "";
    this.raised.textContent = [this.yRange[0] > 0 ? "axis not from 0" : "", head.uncounted ? "relief not counted" : ""].filter(Boolean).join("; ");
    this.raised.title = head.uncounted ?? "";
    this.raised.hidden = !this.raised.textContent;
    const text = rows.map((row) => row.textContent).join("|") + look().dark + strong.map((curve) => this.colourOf(curve)).join();
    if (text === this.keyText) return;
    this.keyText = text;
    this.keys.replaceChildren(...rows);
  }

  describe(head) {
    const peaks = head.peaks.map((peak) => `${peak.label} at ${written(peak.x)}`).slice(0, 5).join("; ");
    const near = this.hub.resonance ? `; resonance of the answers: ${this.hub.resonance.mark}` : "";
    this.marked = this.hub.resonance;
    this.root.setAttribute("aria-label", `${this.options.label ?? "Sweep"}: ${head.y_label} over ${head.x_label}${peaks ? `; peaks: ${peaks}` : ""}${near}. Arrow keys move along the speeds, Enter operates there.`);
  }

  alsoHears() {
    return ["ghost", "mode", "resonance", "preview"];
  }

  rowsAt(index) {
    const at = this.data[0][index];
    const rows = [[`${short(at, 4)} ${unitOf(this.head.x_label)}`, null]];
    const strong = this.order.map((curve, i) => ({ ...curve, value: this.data[i + 1][index] })).filter((curve) => curve.strong && curve.value != null);
    strong.sort((a, b) => b.value - a.value);
    for (const curve of strong) rows.push([curve.label, `${written(curve.value, 4)} ${unitOf(this.head.y_label)}`, this.colourOf(curve)]);
    if (this.pinned) {
      const near = nearest(this.pinned.x, at);
      const most = Math.max(...this.pinned.curves.map((curve) => curve.y[near] ?? -Infinity));
      if (Number.isFinite(most)) rows.push(["A, largest", `${written(most, 4)} ${unitOf(this.head.y_label)}`, look().pale]);
    }
    return rows;
  }

  onClick(event) {
    const edge = this.plot.over.getBoundingClientRect();
    const [x, y] = [event.clientX - edge.left, event.clientY - edge.top];
    const ratio = window.devicePixelRatio || 1;
    const [left, top] = [this.plot.bbox.left / ratio, this.plot.bbox.top / ratio];
    const hit = this.shownPeaks.find((peak) => Math.hypot(peak.x - left - x, peak.y - top - y) <= NEAR);
    if (hit) this.chooseMode(hit.peak.mode);
    else this.operateAt(this.plot.posToVal(x, "x"));
  }

  operateAt(speed) {
    const relative = speed * (this.head.to_relative ?? 1);
    if (relative > 0 && Number.isFinite(relative)) this.options.onSpeed?.(relative);
  }

  onKey(event) {
    if (event.target !== this.root || !this.plot || !this.data) return;
    const last = this.data[0].length - 1;
    const step = event.shiftKey ? 10 : 1;
    const to = { ArrowRight: this.cursor + step, ArrowLeft: this.cursor - step, Home: 0, End: last }[event.key];
    if (to !== undefined) {
      event.preventDefault();
      const start = this.cursor < 0 ? nearest(this.data[0], this.head.operating ?? 0) : Math.max(0, Math.min(last, to));
      this.plot.setCursor({ left: this.plot.valToPos(this.data[0][start], "x"), top: 20 });
      this.say(this.rowsAt(start).map(([text, value]) => (value ? `${text} ${value}` : text)).join(", "));
    } else if (event.key === "Enter" && this.cursor >= 0) this.operateAt(this.data[0][this.cursor]);
    else if (event.key === "Escape") {
      this.cursor = -1;
      this.plot.setCursor({ left: -10, top: -10 });
      this.hideTip();
    }
  }
}

/** A label without the name of its stage, where all have the same. */
function withoutStage(label, curves) {
  const stage = label.match(/^[^:]+: /)?.[0];
  return stage && curves.every((curve) => curve.label.startsWith(stage)) ? label.slice(stage.length) : label;
}

/** Letters of the words beside a line of the plot, and what they take of it. */
const bold = (ratio) => ({ size: px(10.5) * ratio, weight: 600 });
function widthOf(context, text, ratio) {
  context.font = font(bold(ratio).size, bold(ratio).weight);
  return context.measureText(text).width;
}

function leader(context, { x, y, box }, ratio) {
  const [nx, ny] = nearestOf(box, { x, y });
  if (Math.hypot(nx - x, ny - y) < 10) return;
  lines(context, look().pale, ratio, [[[x * ratio, y * ratio], [nx * ratio, ny * ratio]]]);
}

/** Points from one to the other, at most so many pixels apart, the last left out. */
function between([x0, y0], [x1, y1]) {
  const count = Math.max(1, Math.ceil(Math.hypot(x1 - x0, y1 - y0) / 5));
  return Array.from({ length: count }, (_, i) => [x0 + ((x1 - x0) * i) / count, y0 + ((y1 - y0) * i) / count]);
}

function nearest(values, wanted) {
  let best = 0;
  for (let i = 1; i < values.length; i++) if (Math.abs(values[i] - wanted) < Math.abs(values[best] - wanted)) best = i;
  return best;
}
