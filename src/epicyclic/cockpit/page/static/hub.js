// What all panes of a page share: the newest part of every kind, the ghost of pin A, the chosen mode, play or pause.
import { decode } from "./frames.js";
import { alone, hue } from "./look.js";

// Keys of the head; arrays that belong to one begin with it. A frame brings some; the others stay as they were.
const PARTS = ["train", "modes", "sweep", "sharing", "errors", "job"];
const PREFIX = { train: "meshes/" };

/** Parts of a frame by name: {rev, kind, head, arrays}; a job is named after itself. */
export function partsOf(frame) {
  const found = {};
  for (const key of PARTS.filter((one) => frame.head[one] != null)) {
    const prefix = PREFIX[key] ?? `${key}/`;
    const own = Object.entries(frame.arrays).filter(([name]) => name.startsWith(prefix));
    const arrays = Object.fromEntries(own.map(([name, array]) => [name.slice(prefix.length), array]));
    const name = key === "job" ? `job:${frame.head.job.name}` : key;
    found[name] = { rev: frame.rev, kind: frame.kind, head: frame.head[key], arrays, computed: frame.head.state?.computed_ms ?? null };
  }
  return found;
}

export class Hub {
  constructor() {
    this.parts = {};
    this.pinned = {};
    this.missing = {};
    this.instead = ""; // words in the place of what was taken away
    this.resonance = null; // {speed, mark, level} of the answer on resonances, on the axis of the sweep
    this.previewed = null; // {speed, label, result, sweep} of a change that the pointer rests on
    this.rev = -1;
    this.mode = null;
    this.playing = true;
    this.dropped = 0;
    this.painted = { rev: -1, time: 0, kind: "" };
    this.ahead = { rev: -1, time: 0 }; // the last curve that was painted ahead of its state
    this.panes = new Set();
  }

  /** Take a packed frame; parts that are older than what is shown are dropped. `mode`: the chosen one in it, if another. */
  frame(packed, mode) {
    const arrived = performance.now();
    const frame = decode(packed);
    // the server sends a drawing once; that of a frame which comes late is kept too
    const drawing = frame.head.train?.drawing;
    if (drawing?.front) this.drawing = drawing;
    else if (drawing) frame.head.train.drawing = this.drawing;
    const changed = this.forget(frame);
    if (frame.kind === "live") this.instead = "";
    // a curve ahead of its state: the names of its peaks are those before, the revision of the page goes on with the rest
    const isAhead = frame.kind === "curve";
    if (isAhead && this.parts.sweep?.head.y_label === frame.head.sweep?.y_label) frame.head.sweep.peaks = this.parts.sweep.head.peaks;
    for (const [name, part] of Object.entries(partsOf(frame))) {
      if (this.parts[name] && this.parts[name].rev > part.rev) {
        this.dropped += 1;
        continue;
      }
      this.parts[name] = { ...part, arrived };
      changed.push(name);
    }
    if (frame.rev >= this.rev && frame.kind === "live") this.missing = frame.head.missing ?? {};
    // Frames of a job bring the answer that the job has found, and no other.
    const resonance = frame.rev >= this.rev && frame.kind !== "job" && frame.head.answers?.find((one) => one.key === "resonance");
    if (resonance) {
      this.resonance = resonance.speed == null ? null : resonance;
      changed.push("resonance");
    }
    // A job belongs to the state it was started in; it does not make what is shown of the present one older.
    if (!isAhead) this.rev = Math.max(this.rev, frame.rev);
    if (mode !== undefined && mode !== this.mode) {
      this.mode = mode;
      changed.push("mode");
    }
    // A part that the present state cannot have is not shown from an earlier one.
    for (const name of Object.keys(this.missing)) {
      if (this.parts[name]?.rev < this.rev) {
        delete this.parts[name];
        changed.push(name);
      }
    }
    this.tell(changed);
  }

  /** Another train: what was computed for the one before is not its older state, and is taken away. */
  forget(frame) {
    const title = frame.head.train?.title;
    if (title === undefined || frame.rev < this.rev || title === this.title) return [];
    const isFirst = this.title === undefined;
    this.title = title;
    if (isFirst) return [];
    // what a job has found of this very state may be here before its first frame
    const names = Object.keys(this.parts).filter((name) => this.parts[name].rev < frame.rev);
    for (const name of names) delete this.parts[name];
    return names;
  }

  /** Nothing that is shown is of the present model: a text stands in its place. */
  clear(text) {
    Object.assign(this, { parts: {}, missing: {}, resonance: null, mode: null, title: undefined, instead: text });
    this.tell(["mode"]);
  }

  /** Add the parts of a packed frame to the ghost; null takes it away. */
  ghost(packed) {
    this.pinned = packed == null ? {} : { ...this.pinned, ...partsOf(decode(packed)) };
    this.tell(["ghost"]);
  }

  /** What a change would give, beside what is shown: {speed, label, result} and the curves of a packed frame; null ends it. */
  preview(mark, packed) {
    this.previewed = mark && { ...mark, sweep: packed ? (partsOf(decode(packed)).sweep ?? null) : null };
    this.tell(["preview"]);
  }

  chooseMode(index) {
    if (this.mode === index) return;
    this.mode = index;
    this.tell(["mode"]);
  }

  /** Colour of a mesh by its label, the same in every chart: hue by branch, shade by pair and side; null of what is no mesh. */
  meshColour(label) {
    const mesh = this.parts.train?.head.meshes.find((one) => one.label === alone(label));
    return mesh ? hue(mesh.hue, mesh.shade) : null;
  }

  /** End the mode that swings in the drawing. */
  rest() {
    if (this.mode !== null) for (const pane of this.panes) pane.rest();
  }

  setPlaying(isPlaying) {
    this.playing = isPlaying;
    this.tell(["playing"]);
  }

  /** Whether the part of this name is older than the newest frame. */
  isOld(name) {
    return this.parts[name] != null && this.parts[name].rev < this.rev;
  }

  tell(changed) {
    for (const pane of this.panes) pane.hear(changed);
  }
}
