// The drawing of the train: front view and axial section, turning, or a mode shape in the same drawing.
import { calm, loadColour, look, roundUp, written } from "./look.js";
import { make, Pane, Sheet } from "./pane.js";
import { drawFront, drawFrontMode, drawLoadKey, fitted, underFront } from "./train_front.js";
import { frontView, isGear, slowing } from "./train_geometry.js";
import { drawLinks, drawSection, sectionView, underSection } from "./train_section.js";

const FRONT_SHARE = 0.75; // of the height: front view 330 of 440 px, the section the rest
const KEY = 22; // [px] strip between them: colours of the loads, how much the turning is slowed
const SWING = 1.7; // [s] a period of a mode shape: slow enough to follow one body
const PERIOD = 1000 / 30; // [ms] between two pictures: thirty a second look smooth and leave the page its time
const LEAST_SPREAD = 0.1; // of the load about its fair share, so that equal loads do not look far apart
const NUDGE = 13; // [px] that the body of largest motion moves in a mode

const PLAY = "M4 2l10 6-10 6z";
const PAUSE = "M3 2h4v12H3zM9 2h4v12H9z";

export class TrainPane extends Pane {
  constructor(...given) {
    super(...given);
    this.sheet = new Sheet(this.root);
    this.root.prepend(this.sheet.canvas);
    this.button = make("button", { class: "ck-play", type: "button" });
    this.button.addEventListener("click", () => this.hub.setPlaying(!this.hub.playing));
    this.root.append(this.button);
    this.seconds = 0;
    this.last = 0;
    this.spread = 0;
    this.root.addEventListener("pointermove", (event) => this.onPointer(event));
    this.visible = () => this.schedule();
    document.addEventListener("visibilitychange", this.visible);
    this.stops.push(() => document.removeEventListener("visibilitychange", this.visible));
  }

  alsoHears() {
    return ["modes", "mode", "playing"];
  }

  emptyText() {
    return "The train is drawn here as soon as there is a model.";
  }

  clear() {
    this.sheet.fit(this.width, this.height);
    this.sheet.begin();
  }

  resized() {
    this.fit = null;
  }

  draw(part, time, stale) {
    if (this.part_ !== part) this.take(part);
    this.advance(time);
    this.sheet.fit(this.width, this.height);
    const context = this.sheet.begin();
    if (!this.front.stages.length) return;
    this.fit ??= this.views();
    const shape = this.shape();
    const muted = stale ? 0.4 : 1;
    context.globalAlpha = muted;
    if (shape) this.drawMode(context, shape);
    else this.drawTurning(context, part);
    this.drawButton();
    if (this.moves()) this.schedule();
  }

  /** A new part: geometry again only where the drawing has changed, so that a drag of a load costs nothing here. */
  take(part) {
    const isNew = this.part_?.head.title !== part.head.title || this.part_?.head.bodies.length !== part.head.bodies.length;
    if (isNew) Object.assign(this, { seconds: 0, spread: 0 });
    this.part_ = part;
    const drawing = JSON.stringify([part.head.bodies, part.head.meshes]);
    if (drawing !== this.drawing) {
      this.drawing = drawing;
      this.front = frontView(part.head);
      this.section = this.front.stages.length ? sectionView(this.front) : null;
      this.slow = slowing(this.front.bodies);
      this.fit = null;
    }
    this.loads = this.scaleOf(part);
    this.describe(part);
  }

  /** Loads of the meshes with their colour scale: about the fair share of 1, as wide as needed; it only grows in a drag. */
  scaleOf(part) {
    const values = part.arrays.load?.data ?? new Float32Array(part.head.meshes.length).fill(NaN);
    const known = [...values].filter(Number.isFinite);
    const away = known.length ? Math.max(...known.map((value) => Math.abs(value - 1))) : 0;
    const wanted = roundUp(Math.max(LEAST_SPREAD, away));
    this.spread = part.kind === "live" ? Math.max(this.spread, wanted) : wanted;
    const [low, high] = [Math.max(0, 1 - this.spread), 1 + this.spread];
    const place = (value) => (value - low) / (high - low);
    return {
      values, low, high,
      colour: (value) => loadColour(place(value)),
      edge: (value) => (look().dark ? loadColour(place(value) + 0.2) : loadColour(Math.max(0.55, place(value) + 0.2))),
    };
  }

  describe(part) {
    const worst = part.head.meshes[argmax(this.loads.values)];
    const load = worst ? `; largest mesh load ${written(Math.max(...[...this.loads.values].filter(Number.isFinite)))} of the fair share, ${worst.label}` : "";
    this.root.setAttribute("aria-label", `${this.options.label ?? "Train"}: ${part.head.title ?? ""}, ${part.head.bodies.length} bodies${load}. Arrow keys step through the mode shapes, Escape ends them, space stops the motion.`);
  }

  views() {
    const tall = Math.round(this.height * FRONT_SHARE);
    const head = this.front.stages.length > 1 ? 22 : 8;
    const ringHeld = this.front.bodies.some((body) => body.held && body.drawn) ? 7 : 0;
    const front = { x: 10 + ringHeld, y: head + ringHeld, width: this.width - 20 - 2 * ringHeld, height: tall - KEY - head - 2 * ringHeld };
    const section = { x: 24, y: tall + 8, width: this.width - 48, height: this.height - tall - 26 };
    return { front: fitted(this.front.bounds, front), section: this.section && fitted(this.section.bounds, section), key: tall - KEY / 2 };
  }

  moves() {
    return this.hub.playing && !document.hidden && !calm() && this.front?.stages.length > 0;
  }

  advance(time) {
    if (this.moves() && this.last) this.seconds += Math.min(0.1, (time - this.last) / 1000);
    this.last = this.moves() ? time : 0;
  }

  /** Pictures of a motion are thirty a second; news is drawn with the next picture of the browser. */
  schedule() {
    if (this.frameAsked || this.destroyed) return;
    this.frameAsked = requestAnimationFrame((time) => {
      this.frameAsked = 0;
      const isNews = this.part() !== this.shown || this.isNews;
      if (!isNews && this.moves() && time - (this.drawnAt ?? 0) < PERIOD - 4) return this.schedule();
      this.isNews = false;
      this.drawnAt = time;
      this.paint(time);
    });
  }

  hear(changed) {
    this.isNews = true;
    super.hear(changed);
  }

  /** Motion of every body in the chosen mode, (body, 6), or null; a shape of another set of bodies is none. */
  shape() {
    const modes = this.hub.parts.modes;
    if (this.hub.mode === null || !modes?.arrays.shape) return null;
    const row = modes.head.findIndex((mode) => mode.index === this.hub.mode);
    const { shape: [, bodies], data } = modes.arrays.shape;
    if (row < 0 || bodies !== this.front.bodies.length) return null;
    this.mode = modes.head[row];
    const of = (body) => Array.from(data.subarray(6 * (row * bodies + body), 6 * (row * bodies + body) + 6));
    return this.front.bodies.map((_, body) => of(body));
  }

  drawTurning(context, part) {
    const { front, section, key } = this.fit;
    const seconds = this.seconds / this.slow;
    drawFront(context, this.front, front, seconds, this.loads);
    if (section) {
      drawSection(context, this.section, section, this.loads, null);
      drawLinks(context, this.section, section, part.head.links ?? [], this.front.bodies);
    }
    const known = [...this.loads.values].some(Number.isFinite);
    if (known) drawLoadKey(context, 62, key, this.loads);
    context.font = `10.5px ${look().font}`;
    context.fillStyle = look().pale;
    context.textAlign = "right";
    if (this.slow > 1 && this.width > 330) context.fillText(`turning 1 : ${written(this.slow, 1)}`, this.width - 8, key + 0.5);
  }

  drawMode(context, shape) {
    const { front, section, key } = this.fit;
    const swing = calm() ? 1 : Math.sin((2 * Math.PI * this.seconds) / SWING);
    drawFrontMode(context, this.front, front, shape, NUDGE / front.scale, swing);
    if (section) drawSection(context, this.section, section, null, { shape, size: (0.6 * NUDGE) / section.scale, swing });
    context.font = `600 12px ${look().font}`;
    context.fillStyle = look().ink;
    context.textAlign = "left";
    const title = `${written(this.mode.frequency, 4)} Hz, ${this.mode.label}`;
    context.fillText(cut(context, title, this.width - 16), 8, key + 0.5);
  }

  drawButton() {
    const plays = this.hub.playing && !calm();
    if (this.button.dataset.plays === String(plays)) return;
    this.button.dataset.plays = String(plays);
    this.button.setAttribute("aria-label", plays ? "Stop the motion" : "Start the motion");
    this.button.title = plays ? "Stop the motion (space)" : "Start the motion (space)";
    const icon = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    icon.setAttribute("viewBox", "0 0 16 16");
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("d", plays ? PAUSE : PLAY);
    icon.append(path);
    this.button.replaceChildren(icon);
    this.button.hidden = calm();
  }

  onKey(event) {
    const modes = this.hub.parts.modes?.head ?? [];
    if (event.key === " " && event.target === this.root) {
      event.preventDefault();
      this.hub.setPlaying(!this.hub.playing);
    } else if (event.key === "Escape" && this.hub.mode !== null) this.choose(null);
    else if (["ArrowDown", "ArrowRight", "ArrowUp", "ArrowLeft"].includes(event.key) && modes.length) {
      event.preventDefault();
      const step = event.key === "ArrowDown" || event.key === "ArrowRight" ? 1 : -1;
      const at = modes.findIndex((mode) => mode.index === this.hub.mode);
      const next = at < 0 ? (step > 0 ? 0 : modes.length - 1) : (at + step + modes.length) % modes.length;
      this.choose(modes[next].index);
      this.say(`Mode ${next + 1} of ${modes.length}: ${written(modes[next].frequency, 4)} hertz, ${modes[next].label}`);
    }
  }

  choose(index) {
    this.hub.chooseMode(index);
    this.options.onMode?.(index);
  }

  onPointer(event) {
    if (!this.fit || !this.part_ || event.target === this.button) return this.hideTip();
    const edge = this.root.getBoundingClientRect();
    const [x, y] = [event.clientX - edge.left, event.clientY - edge.top];
    const seconds = this.shape() ? 0 : this.seconds / this.slow;
    const found = y < this.fit.key - KEY / 2
      ? underFront(this.front, this.fit.front, seconds, this.loads, x, y)
      : this.fit.section && underSection(this.section, this.fit.section, this.loads, x, y);
    if (!found) return this.hideTip();
    if (found.body) return this.showTip(x, y, this.bodyRows(found.body));
    const indices = found.mesh ? found.mesh.all : [found.mark.index];
    this.showTip(x, y, this.meshRows(indices));
  }

  bodyRows(body) {
    const rows = [[body.label || body.name, null]];
    if (isGear(body)) rows.push(["teeth", String(body.teeth)], ["pitch diameter", `${written(2 * body.pitch, 4)} mm`]);
    if (body.held) rows.push(["held", ""]);
    else if (Number.isFinite(body.speed)) rows.push(["speed", `${written((30 * body.speed) / Math.PI, 4)} rpm`]);
    if (body.floating) rows.push(["floats", ""]);
    this.front.meshes.forEach((mesh, index) => {
      const load = this.loads.values[index];
      if (rows.length < 9 && mesh.bodies.includes(body.index) && Number.isFinite(load)) rows.push([mesh.label, written(load), this.loads.edge(load)]);
    });
    return rows;
  }

  meshRows(indices) {
    const rows = [];
    for (const index of indices) {
      const load = this.loads.values[index];
      const mesh = this.front.meshes[index];
      rows.push([mesh.label, null], ["force over the fair share", written(load), Number.isFinite(load) ? this.loads.edge(load) : null]);
    }
    return rows.slice(0, 10);
  }
}

function argmax(values) {
  let best = -1;
  values.forEach((value, i) => {
    if (Number.isFinite(value) && (best < 0 || value > values[best])) best = i;
  });
  return best;
}

/** As much of a text as fits a width. */
function cut(context, text, width) {
  if (context.measureText(text).width <= width) return text;
  let end = text.length;
  while (end > 1 && context.measureText(`${text.slice(0, end)}…`).width > width) end -= 1;
  return `${text.slice(0, end)}…`;
}
