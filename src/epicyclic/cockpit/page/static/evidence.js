// What an answer rests on: load sharing, what each error costs, lines or bars of a job.
import { brief, look, px, roundUp, short, written } from "./look.js";
import { lines as drawLines } from "./canvas.js";
import { make, Sheet } from "./pane.js";
import { endsOf, ghostCurve, PlotPane, plotOf, rowsOf, STALE, unitOf, zoomOfKey } from "./plot.js";
import { about1, drawBars, drawSharing, FOOT, folded, heightFor } from "./rows.js";

const GAPS = { sharing: 0.05, period: 0.1 }; // least half width of the axes about 1: below, all is as good as equal
const UNFOLDED = 14; // rows of load sharing that have room side by side with both sides of a herringbone pair
const LINES = 8; // curves of a job that get a place in the key
const DASHES = [null, [8, 4], [2, 3], [10, 3, 2, 3]]; // curves that are no meshes, which have the colours
const CLOSEST = 1e-3; // part of an axis that can be zoomed into

export class EvidencePane extends PlotPane {
  constructor(...given) {
    super(...given);
    this.scroll = make("div", { class: "ck-scroll" });
    this.old = make("div", { class: "ck-note ck-at-left", hidden: "" }, "of another state: run it again");
    this.hint = make("div", { class: "ck-note", hidden: "" });
    this.root.prepend(this.scroll, this.body, this.keys, this.old, this.hint);
    this.sheet = new Sheet(this.scroll);
    this.name = "sharing";
    this.halves = {};
    this.root.dataset.evidence = this.name;
    this.root.addEventListener("pointermove", (event) => this.onPointer(event));
    this.scroll.addEventListener("scroll", () => this.schedule());
  }

  partNames() {
    return [this.name === "sharing" || this.name === "errors" ? this.name : `job:${this.name}`];
  }

  /** What is shown: "sharing", "errors" or the name of a job. */
  setEvidence(name) {
    if (this.name === name) return;
    this.name = name;
    this.root.dataset.evidence = name;
    this.root.dataset.rev = String(-1);
    this.shown = null;
    this.halves = {};
    this.zoomed = null;
    this.dropPlot();
    this.hideTip();
    this.schedule();
  }

  alsoHears() {
    return ["ghost"];
  }

  emptyText() {
    const reason = this.reason(this.name);
    if (reason) return reason;
    if (this.name === "sharing") return "Load sharing stands here as soon as it is computed.";
    if (this.name === "errors") return "The errors are weighed when the slider is let go.";
    return "Not computed for this train yet: the result of the job stands here.";
  }

  clear() {
    this.dropPlot();
    this.sheet.fit(this.width / px(1), this.height / px(1));
    this.sheet.begin();
    this.old.hidden = true;
  }

  dropPlot() {
    super.dropPlot();
    this.hint.hidden = true;
  }

  ghostPart() {
    return this.hub.pinned[this.partNames()[0]];
  }

  draw(part, _time, stale) {
    const lines = part.head.lines;
    this.scroll.hidden = Boolean(lines);
    this.body.hidden = !lines;
    this.hit = null;
    this.old.hidden = !(stale && this.partNames()[0].startsWith("job:"));
    if (lines) return this.drawLines(part, lines, stale);
    this.dropPlot();
    const data = this.name === "sharing" ? this.sharing(part) : this.name === "errors" ? this.errors(part) : this.bars(part);
    if (!data.rows.length) {
      this.clear();
      this.empty.textContent = data.note || "There is nothing to show for this train.";
      this.empty.hidden = false;
      return;
    }
    const height = Math.max(this.height / px(1), heightFor(data.rows.length, data.scale));
    const width = (this.width - (px(height) > this.height ? 12 : 0)) / px(1); // without the scroll bar
    this.sheet.fit(width, height);
    const context = this.sheet.begin();
    data.alpha = stale ? STALE : 1;
    const drawn = this.name === "sharing" ? drawSharing(context, width, height, data) : drawBars(context, width, height, data);
    this.hit = { data, ...drawn };
    const below = this.scroll.scrollHeight - this.scroll.clientHeight - this.scroll.scrollTop;
    if (below > 1) this.sheet.lift(FOOT, below / px(1));
    this.describe(data.note, (data.labels ?? data.rows).map((row, i) => `${row} ${written((data.coefficient ?? data.values)[i])}`));
  }

  sharing(part) {
    const { head, arrays } = part;
    const labels = head.rows.map((row) => row.label);
    const { groups, names } = folded(labels, UNFOLDED);
    const twin = head.twin && arrays.twin ? arrays.twin.data : null;
    const pinned = this.ghostPart();
    const ghost = pinned && byLabel(labels, pinned.head.rows.map((row) => row.label), pinned.arrays.coefficient.data);
    const period = arrays.over_period?.shape[1] > 1 ? arrays.over_period : null;
    const values = [...arrays.coefficient.data, ...(twin ?? []), ...(ghost ?? []).filter((value) => value != null)];
    const isReleased = part.kind !== "live";
    return {
      labels, groups, twin, ghost, period,
      colours: labels.map((label) => this.hub.meshColour(label) ?? look().ink),
      rows: names.map(brief),
      coefficient: arrays.coefficient.data,
      cycles: head.cycles,
      title: "load-sharing coefficient [1]",
      twinLabel: head.twin ? `${head.twin.label}, ${written(head.twin.k_gamma, 4)}` : "",
      note: sharingNote(head),
      limit: head.verdict?.limit,
      half: this.half("sharing", about1(withLimit(values, head.verdict?.limit), GAPS.sharing), isReleased),
      periodHalf: period ? this.half("period", about1([...period.data], GAPS.period), isReleased) : 0,
    };
  }

  /** Half width of an axis about 1: it grows at once and shrinks when the slider is let go. */
  half(key, wanted, isReleased) {
    const known = this.halves[key] ?? 0;
    this.halves[key] = isReleased ? wanted : Math.max(known, wanted);
    return this.halves[key];
  }

  errors(part) {
    const { head, arrays } = part;
    const rows = head.rows.map((row) => row.label);
    const pinned = this.ghostPart();
    return {
      rows,
      values: Array.from(arrays.share?.data ?? []),
      ghost: pinned && byLabel(rows, pinned.head.rows.map((row) => row.label), pinned.arrays.share.data),
      title: `share of the ${head.of} − 1 [%]`,
      note: "What each error costs",
      strong: 0,
      more: head.rows.map((row) => (Number.isFinite(row.without) ? [["K_gamma without it", written(row.without, 4)]] : [])),
      ...asPercent,
    };
  }

  bars(part) {
    const { head, arrays } = part;
    const bars = head.bars ?? { x_label: "", rows: [] };
    const pinned = this.ghostPart();
    return {
      rows: bars.rows,
      values: Array.from(arrays.bar?.data ?? []),
      ghost: pinned?.head.bars && byLabel(bars.rows, pinned.head.bars.rows, pinned.arrays.bar.data),
      title: bars.x_label,
      note: bars.note ?? head.title ?? head.text ?? "",
      line: bars.line,
      low: arrays.low && Array.from(arrays.low.data),
      high: arrays.high && Array.from(arrays.high.data),
      scale: bars.scale,
      more: arrays.low && bars.rows.map((_, i) => [["95 % band", `${arrays.low.data[i].toFixed(5)} to ${arrays.high.data[i].toFixed(5)}`]]),
      format: (value) => (arrays.low ? value.toFixed(5).replace(/^-0.00000$/, "0.00000") : short(value, 4)),
    };
  }

  describe(title, texts) {
    this.root.setAttribute("aria-label", `${this.options.label ?? "Evidence"}: ${title}. ${texts.slice(0, 12).join("; ")}`);
  }

  drawLines(part, lines, stale) {
    if (this.taken !== part || !this.plot) this.takeLines(part, lines);
    this.redraw(stale);
  }

  takeLines(part, lines) {
    const rows = rowsOf(part.arrays.y);
    const x = Array.from(part.arrays.x.data);
    const pinned = this.ghostPart();
    this.ghost = pinned?.head.lines
      ? { x: Array.from(pinned.arrays.x.data), rows: rowsOf(pinned.arrays.y), labels: pinned.head.lines.curves.map((curve) => curve.label) }
      : null;
    const curves = lines.curves.map((curve, row) => ({ ...curve, row }));
    const isFew = curves.filter((curve) => !curve.pale).length <= 4;
    for (const curve of curves) curve.strong = !curve.pale && (isFew || Boolean(curve.strong));
    curves.sort((a, b) => Number(a.strong) - Number(b.strong) || a.row - b.row);
    const strong = curves.filter((curve) => curve.strong).slice(-4);
    const colourOf = (curve) => (strong.includes(curve) ? this.colourOf(curve) : curve.pale ? look().pale : look().other);
    strong.filter((curve) => !this.hub.meshColour(curve.label)).forEach((curve, at) => (curve.dash = DASHES[at]));
    this.styles = curves.map((curve) => ({ colour: colourOf(curve) }));
    this.curves = curves;
    this.data = [x, ...curves.map((curve) => rows[curve.row])];
    this.dropPlot();
    this.lines = lines;
    this.zoom(this.zoomed);
    this.plot = plotOf(this.body, {
      width: this.width, height: this.height, xLabel: lines.x_label, yLabel: lines.y_label, count: curves.length, owner: this, top: 26,
      hooks: { drawAxes: [(plot) => this.drawBehind(plot)], setCursor: [(plot) => this.onCursor(plot)] },
      onZoom: (range) => this.zoom(range),
    });
    this.plot.root.setAttribute("aria-hidden", "true");
    curves.forEach((curve, i) => Object.assign(this.plot.series[i + 1], { width: curve.strong ? 2 : curve.pale ? 1.5 : 1, label: curve.label, dash: curve.dash }));
    this.lineKeys(part.head, strong);
    this.taken = part;
    this.describe(part.head.title ?? "", [...strong.map((curve) => curve.label), "Plus and minus zoom, arrow keys move along, Escape shows all"]);
  }

  /** Show the part [from, to] of the horizontal axis, null: all of it; the vertical one holds what is seen there. */
  zoom(range) {
    const [least, most] = endsOf([this.data[0], ...(this.ghost ? [this.ghost.x] : [])]);
    let [from, to] = range ?? [least, most];
    if (to - from < CLOSEST * (most - least)) [from, to] = this.xRange;
    [from, to] = [Math.max(from, least), Math.min(to, most)];
    const isPart = to > from && to - from < (1 - CLOSEST) * (most - least);
    this.zoomed = isPart ? [from, to] : null;
    this.xRange = isPart ? [from, to] : [least, most];
    const seen = (x, row) => (isPart ? row.filter((_, i) => x[i] >= from && x[i] <= to) : row);
    const shown = [...this.data.slice(1).map((row) => seen(this.data[0], row)), ...(this.ghost?.rows ?? []).map((row) => seen(this.ghost.x, row))];
    this.yRange = ends(shown, this.lines.zero);
    this.root.dataset.zoomed = String(isPart);
    this.hint.textContent = isPart ? "double click: all" : "drag: zoom";
    this.hint.hidden = false;
    this.schedule();
  }

  colourOf({ label }) {
    return this.hub.meshColour(label) ?? look().ink;
  }

  lineKeys(head, strong) {
    const title = make("b", {}, head.title ?? "");
    title.style.color = "var(--ck-ink)";
    const pale = this.curves.filter((curve) => curve.pale);
    const shown = strong.length > 1 || this.ghost ? strong.slice(0, LINES) : [];
    const rows = shown.map((curve) => this.key(brief(curve.label), this.colourOf(curve), curve.dash ? (curve.dash[0] > curve.dash[1] ? "ck-dashed" : "ck-dashed ck-dotted") : ""));
    rows.unshift(...pale.map((curve) => this.key(curve.label, look().pale)));
    const more = this.curves.length - strong.length - pale.length;
    if (more) rows.push(this.key(`${more} more`, look().other));
    if (this.ghost) rows.push(this.key("A", look().pale, "ck-dashed"));
    // of many curves the tab says what they are
    this.keys.replaceChildren(...(shown.length > 3 ? [] : [title]), ...rows);
  }

  drawBehind(plot) {
    if (this.lines.zero) {
      const { bbox: { left, width }, ctx } = plot;
      const y = plot.valToPos(0, "y", true);
      drawLines(ctx, look().ink, window.devicePixelRatio || 1, [[[left, y], [left + width, y]]]);
    }
    if (!this.ghost) return;
    this.ghost.rows.forEach((row, i) => {
      const curve = this.curves.findIndex((one) => one.label === this.ghost.labels[i] && one.strong);
      if (curve >= 0 || this.ghost.rows.length <= 4) ghostCurve(plot.ctx, plot, this.ghost.x, row, this.styles[curve]?.colour ?? look().pale);
    });
  }

  rowsAt(index) {
    const rows = [[`${short(this.data[0][index], 4)} ${unitOf(this.lines.x_label)}`, null]];
    this.curves.forEach((curve, i) => {
      const value = this.data[i + 1][index];
      if ((curve.strong || curve.pale) && value != null && rows.length < 10) rows.push([curve.label, `${written(value, 4)} ${unitOf(this.lines.y_label)}`, this.styles[i].colour]);
    });
    return rows;
  }

  onPointer(event) {
    if (!this.hit || !this.hit.lines) return this.plot ? null : this.hideTip();
    const edge = this.root.getBoundingClientRect();
    const [x, y] = [event.clientX - edge.left, event.clientY - edge.top];
    const { data, lines, strip } = this.hit;
    const row = Math.floor(((y + this.scroll.scrollTop) / px(1) - lines.top) / lines.tall);
    if (row < 0 || row >= data.rows.length) return this.hideTip();
    this.showTip(x, y, data.coefficient ? this.sharingRows(data, row, strip, x / px(1)) : barRows(data, row));
  }

  /** What the tooltip says of the meshes of a row, and of the part of the hunting period under the pointer. */
  sharingRows(data, row, strip, x) {
    return data.groups[row].flatMap((index) => {
      const rows = [[data.labels[index], null], ["coefficient", written(data.coefficient[index], 4), data.colours[index]]];
      if (data.twin) rows.push([data.twinLabel.split(",")[0], written(data.twin[index], 4), data.colours[index]]);
      if (data.ghost?.[index] != null) rows.push(["A", written(data.ghost[index], 4), look().pale]);
      if (strip && x >= strip.x0 && x < strip.x1) {
        const column = Math.floor(((x - strip.x0) / (strip.x1 - strip.x0)) * strip.columns);
        rows.push(["in this part of the period", written(data.period.data[index * strip.columns + column], 4)]);
      }
      return rows;
    });
  }

  onKey(event) {
    if (this.plot && !(event.ctrlKey || event.metaKey || event.altKey)) {
      const [from, to] = this.xRange;
      const index = this.plot.cursor.left >= 0 ? this.plot.cursor.idx : null;
      const range = zoomOfKey(event.key, this.xRange, endsOf([this.data[0]]), index == null ? (from + to) / 2 : this.data[0][index]);
      if (range === undefined || (event.key === "Escape" && !this.zoomed)) return;
      event.preventDefault();
      this.zoom(range);
      this.say(`${this.lines.x_label}: ${short(this.xRange[0], 4)} to ${short(this.xRange[1], 4)}`);
      return;
    }
    const step = { ArrowDown: 40, ArrowUp: -40, PageDown: this.height, PageUp: -this.height }[event.key];
    if (step && this.scroll.scrollHeight > this.height) {
      event.preventDefault();
      this.scroll.scrollTop += step;
    }
  }
}

const asPercent = { format: (value) => `${short(value, 3)} %` };

/** What the tooltip says of a bar. */
function barRows(data, row) {
  const rows = [[data.rows[row], null], [data.title, data.format(data.values[row])]];
  for (const [text, value] of data.more?.[row] ?? []) rows.push([text, value]);
  if (data.ghost?.[row] != null) rows.push(["A", data.format(data.ghost[row]), look().pale]);
  return rows;
}

/** Values with a limit that leaves them a quarter of an axis about 1. */
function withLimit(values, limit) {
  const most = Math.max(GAPS.sharing, ...values.filter(Number.isFinite).map((value) => Math.abs(value - 1)));
  return limit != null && limit - 1 <= 4 * most ? [...values, limit] : values;
}

/** The load-sharing factor in a line: its definition, at rest or the largest while turning. */
function sharingNote(head) {
  const turning = Number.isFinite(head.k_gamma_turning) ? `, turning ${written(head.k_gamma_turning, 4)}` : "";
  return `K_gamma ${written(head.k_gamma, 4)} ${head.definition ? `(${head.definition})` : ""}${turning}`;
}

/** Values of another list of rows by name, null where it has none of that name. */
function byLabel(rows, labels, values) {
  return rows.map((row) => {
    const at = labels.indexOf(row);
    return at < 0 || !Number.isFinite(values[at]) ? null : values[at];
  });
}

/** Ends of an axis for rows of lines: from 0 where that leaves them most of it, else about their own range; with zero in it where that is asked for. */
function ends(rows, withZero) {
  const [low, high] = endsOf(withZero ? [...rows, [0]] : rows);
  if (!(high >= low)) return [0, 1];
  if (low >= 0 && low < 0.4 * high) return [0, roundUp(1.05 * high)];
  const room = 0.08 * (high - low || Math.abs(high) || 1);
  return [low - room, high + room];
}
