// The drawing of the train: front view and axial section, turning, or a mode shape in the same drawing.
import { write } from "./canvas.js";
import { calm, loadColour, look, px, roundUp, written } from "./look.js";
import { make, Pane, Sheet } from "./pane.js";
import { deflected, drawLoadKey, fitted, paint, paintMode, placeAt, prepared, slowing, under } from "./train_paint.js";

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
    this.sheet.fit(this.wide, this.tall);
    this.sheet.begin();
  }

  /** Size in pixels of the usual page. */
  get wide() {
    return this.width / px(1);
  }

  get tall() {
    return this.height / px(1);
  }

  restyle() {
    this.fit = null;
    this.schedule();
  }

  resized() {
    this.fit = null;
  }

  draw(part, time, stale) {
    if (this.part_ !== part) this.take(part);
    this.advance(time);
    this.sheet.fit(this.wide, this.tall);
    const context = this.sheet.begin();
    if (!this.front.shapes.length) return;
    this.fit ??= this.views();
    const shape = this.shape();
    const muted = stale ? 0.4 : 1;
    context.globalAlpha = muted;
    if (shape) this.drawMode(context, shape);
    else this.drawTurning(context, part);
    this.drawButton();
    if (this.moves()) this.schedule();
  }

  /** A new part: outlines again only where the drawing has changed, so that a drag of a load costs nothing here. */
  take(part) {
    const { title, bodies, drawing } = part.head;
    const isNew = this.part_?.head.title !== title || this.part_?.head.bodies.length !== bodies.length;
    if (isNew) Object.assign(this, { seconds: 0, spread: 0 });
    this.part_ = part;
    if (drawing.key !== this.key) {
      const [front, section] = [drawing.front, drawing.section].map((text) => prepared(JSON.parse(text)));
      Object.assign(this, { key: drawing.key, front, section, fit: null });
    }
    this.slow = slowing(bodies.filter((_, index) => this.front.shapes.some((shape) => shape.body === index)));
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
    const tall = Math.round(this.tall * FRONT_SHARE);
    const head = this.front.shapes.some((shape) => shape.role === "stage") ? 22 : 8;
    const front = { x: 10, y: head, width: this.wide - 20, height: tall - KEY - head };
    const section = { x: 24, y: tall + 8, width: this.wide - 48, height: this.tall - tall - 26 };
    return { front: fitted(this.front.bounds, front), section: fitted(this.section.bounds, section), key: tall - KEY / 2 };
  }

  moves() {
    return this.hub.playing && !document.hidden && !calm() && this.front?.shapes.length > 0;
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

  /** Motion of every body in the chosen mode, six numbers and `bent`, or null; a shape of another set of bodies is none. */
  shape() {
    const modes = this.hub.parts.modes;
    if (this.hub.mode === null || !modes?.arrays.shape) return null;
    const row = modes.head.findIndex((mode) => mode.index === this.hub.mode);
    const { shape: [, bodies], data } = modes.arrays.shape;
    if (row < 0 || bodies !== this.part_.head.bodies.length) return null;
    this.mode = modes.head[row];
    const of = (body) => Array.from(data.subarray(6 * (row * bodies + body), 6 * (row * bodies + body) + 6));
    const { bent } = modes.arrays;
    let next = bent ? row * bent.shape[1] : 0;
    return this.part_.head.bodies.map(({ bends }, body) => {
      if (!bends || !bent) return Object.assign(of(body), { bending: null });
      const values = bent.data.subarray(next, (next += bends.length));
      // coordinates of matrices, e1, e2, .., say nothing of places between interfaces
      return Object.assign(of(body), { bending: bends[0].startsWith("e") ? null : { names: bends, values } });
    });
  }

  /** Where a shape of the front view is now; the section stands still. */
  placed(shape) {
    return placeAt(shape, this.part_.head.bodies[shape.body], this.shape() ? 0 : this.seconds / this.slow);
  }

  drawTurning(context, part) {
    const { front, section, key } = this.fit;
    const scene = { loads: this.loads, meshes: part.head.meshes };
    paint(context, this.front, front, { ...scene, place: (shape) => this.placed(shape) });
    paint(context, this.section, section, { ...scene, place: (shape) => shape.at });
    context.globalAlpha = 1;
    if ([...this.loads.values].some(Number.isFinite)) drawLoadKey(context, 62, key, this.loads);
    if (this.slow > 1 && this.wide > 330) write(context, `turning 1 : ${written(this.slow, 1)}`, this.wide - 8, key + 0.5, { size: 10.5, align: "right", colour: look().pale });
  }

  /** How points of a shape of the front view move, by which its body bends; null of a body that does not. */
  bentBy(motion, swing) {
    const wide = (NUDGE / this.fit.front.scale) * swing;
    return ({ at: [, , turn], body }) => {
      const { bending } = motion[body];
      if (!bending) return null;
      return (x, y) => {
        const [out, along] = deflected(bending.names, bending.values, Math.atan2(y, x) + turn);
        const [c, s] = [x / Math.hypot(x, y), y / Math.hypot(x, y)];
        return [x + wide * (c * out - s * along), y + wide * (s * out + c * along)];
      };
    };
  }

  /** Where shapes of both views are in a mode, `swing` -1..1: displaced and turned; moved in the plane, and tilted. */
  movedBy(motion, swing) {
    const { front, section } = this.fit;
    const { bodies } = this.part_.head;
    const [wide, narrow] = [(NUDGE / front.scale) * swing, ((0.6 * NUDGE) / section.scale) * swing];
    const turned = ({ at: [x, y, turn], body }) => {
      const [dx, dy, , , , rz] = motion[body];
      return [x + wide * dx, y + wide * dy, turn + (wide * rz) / bodies[body].arc];
    };
    // the plane of the section goes through the axis and the planet that is drawn in it
    const tilted = ({ at: [z, r, turn], body }) => {
      const [[dx, dy, dz, rx, ry], { plane, arc }] = [motion[body], bodies[body]];
      const [c, s] = [Math.cos(plane), Math.sin(plane)];
      const out = motion[body].bending ? deflected(motion[body].bending.names, motion[body].bending.values, plane)[0] : 0;
      return [z + narrow * dz, r + narrow * (dx * c + dy * s + out), turn + (narrow * (ry * c - rx * s)) / arc];
    };
    return [turned, tilted];
  }

  drawMode(context, motion) {
    const { front, section, key } = this.fit;
    const swing = calm() ? 1 : Math.sin((2 * Math.PI * this.seconds) / SWING);
    const amount = (index) => Math.min(1, Math.hypot(...motion[index], ...(motion[index].bending?.values ?? [])));
    const [turned, tilted] = this.movedBy(motion, swing);
    paintMode(context, this.front, front, turned, amount, this.bentBy(motion, swing));
    paintMode(context, this.section, section, tilted, amount);
    context.globalAlpha = 1;
    write(context, `${written(this.mode.frequency, 4)} Hz, ${this.mode.label}`, 8, key + 0.5, { size: 12, weight: 600, room: this.wide - 16 });
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
    } else if (["ArrowDown", "ArrowRight", "ArrowUp", "ArrowLeft"].includes(event.key) && modes.length) {
      event.preventDefault();
      const step = event.key === "ArrowDown" || event.key === "ArrowRight" ? 1 : -1;
      const at = modes.findIndex((mode) => mode.index === this.hub.mode);
      const next = at < 0 ? (step > 0 ? 0 : modes.length - 1) : (at + step + modes.length) % modes.length;
      this.choose(modes[next].index);
      this.say(`Mode ${next + 1} of ${modes.length}: ${written(modes[next].frequency, 4)} hertz, ${modes[next].label}`);
    }
  }

  rest() {
    this.choose(null);
  }

  choose(index) {
    this.hub.chooseMode(index);
    this.options.onMode?.(index);
  }

  onPointer(event) {
    if (!this.fit || !this.part_ || event.target === this.button) return this.hideTip();
    const edge = this.root.getBoundingClientRect();
    const [x, y] = [(event.clientX - edge.left) / px(1), (event.clientY - edge.top) / px(1)];
    const found = y < this.fit.key - KEY / 2
      ? under(this.front, this.fit.front, (shape) => this.placed(shape), x, y)
      : under(this.section, this.fit.section, (shape) => shape.at, x, y);
    if (!found) return this.hideTip();
    this.showTip(px(x), px(y), found.meshes ? this.meshRows(found.meshes) : this.bodyRows(found.body));
  }

  bodyRows(index) {
    const { bodies, meshes } = this.part_.head;
    const body = bodies[index];
    const rows = [[body.label || body.name, null]];
    if (body.teeth) rows.push(["teeth", String(body.teeth)], ["pitch diameter", `${written(2 * body.pitch, 4)} mm`]);
    if (body.held) rows.push(["held", ""]);
    else if (Number.isFinite(body.speed)) rows.push(["speed", `${written((30 * body.speed) / Math.PI, 4)} rpm`]);
    if (body.floating) rows.push(["floats", ""]);
    meshes.forEach((mesh, number) => {
      const load = this.loads.values[number];
      if (rows.length < 9 && mesh.bodies.includes(index) && Number.isFinite(load)) rows.push([mesh.label, written(load), this.loads.edge(load)]);
    });
    return rows;
  }

  meshRows(indices) {
    const rows = indices.flatMap((index) => {
      const load = this.loads.values[index];
      return [[this.part_.head.meshes[index].label, null], ["force over the fair share", written(load), Number.isFinite(load) ? this.loads.edge(load) : null]];
    });
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
