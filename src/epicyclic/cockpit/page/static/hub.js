// What all panes of a page share: the newest part of every kind, the ghost of pin A, the chosen mode, play or pause.
import { decode } from "./frames.js";

// Key of the head -> prefixes of the arrays that belong to it. A frame brings some; the others stay as they were.
const PARTS = {
  train: ["meshes/"],
  modes: ["modes/"],
  sweep: ["sweep/"],
  sharing: ["sharing/"],
  errors: ["errors/"],
  job: ["job/"],
};

/** Parts of a frame by name: {rev, kind, head, arrays}; a job is named after itself. */
export function partsOf(frame) {
  const found = {};
  for (const [key, prefixes] of Object.entries(PARTS)) {
    if (frame.head[key] == null) continue;
    const arrays = {};
    for (const [name, array] of Object.entries(frame.arrays)) {
      const prefix = prefixes.find((one) => name.startsWith(one));
      if (prefix) arrays[name.slice(prefix.length)] = array;
    }
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
    this.resonance = null; // {speed, figure, level} of the answer on resonances, of the axis of the sweep
    this.rev = -1;
    this.mode = null;
    this.playing = true;
    this.dropped = 0;
    this.painted = { rev: -1, time: 0, kind: "" };
    this.panes = new Set();
  }

  /** Take a packed frame; parts that are older than what is shown are dropped. */
  frame(packed) {
    const arrived = performance.now();
    const frame = decode(packed);
    // the server sends a drawing once; that of a frame which comes late is kept too
    const drawing = frame.head.train?.drawing;
    if (drawing?.front) this.drawing = drawing;
    else if (drawing) frame.head.train.drawing = this.drawing;
    const changed = this.forget(frame);
    if (frame.kind === "live") this.instead = "";
    for (const [name, part] of Object.entries(partsOf(frame))) {
      if (this.parts[name] && this.parts[name].rev > part.rev) {
        this.dropped += 1;
        continue;
      }
      this.parts[name] = { ...part, arrived };
      changed.push(name);
    }
    if (frame.rev >= this.rev && frame.kind === "live") this.missing = frame.head.missing ?? {};
    if (frame.rev >= this.rev && frame.head.answers) this.resonance = frame.head.answers.find((one) => one.key === "resonance" && one.speed != null) ?? null;
    this.rev = Math.max(this.rev, frame.rev);
    // A job belongs to the state it was started in; it does not make what is shown of the present one older.
    const modes = this.parts.modes?.head;
    if (this.mode !== null && modes && !modes.some((mode) => mode.index === this.mode)) this.mode = null;
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
    this.mode = null;
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

  chooseMode(index) {
    if (this.mode === index) return;
    this.mode = index;
    this.tell(["mode"]);
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
