// What every pane does: size, theme, one paint a frame of the browser, its revision in the DOM after the paint, tooltip.
import { font, px, watchTheme } from "./look.js";

export function make(tag, options = {}, ...children) {
  const { class: name, ...rest } = options;
  const element = document.createElement(tag);
  if (name) element.className = name;
  for (const [key, value] of Object.entries(rest)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

export class Pane {
  /** @param kind as in `data-kind`.  @param root element to draw in.  @param hub shared parts.  @param options label, onSpeed, onMode. */
  constructor(kind, root, hub, options) {
    Object.assign(this, { kind, root, hub, options, frameAsked: 0, width: 0, height: 0, toldStale: false });
    root.classList.add("ck-pane");
    root.dataset.kind = kind;
    root.dataset.rev = "-1";
    root.dataset.stale = "false";
    root.tabIndex = 0;
    root.setAttribute("role", "group");
    root.setAttribute("aria-label", options.label ?? kind);
    this.empty = make("div", { class: "ck-empty" });
    this.tip = make("div", { class: "ck-tip", hidden: "" });
    this.spoken = make("div", { class: "ck-hidden", "aria-live": "polite" });
    root.append(this.empty, this.tip, this.spoken);
    this.stops = [watchTheme(() => this.restyle())];
    this.sizes = new ResizeObserver(() => this.measure());
    this.sizes.observe(root);
    root.addEventListener("keydown", (event) => this.onKey(event));
    root.addEventListener("pointerleave", () => this.hideTip());
    hub.panes.add(this);
    // The resolution changes when a window moves to another screen, which no ResizeObserver tells.
    this.screen = () => this.measure();
    window.addEventListener("resize", this.screen);
  }

  /** Parts whose change asks for a paint; the first is the one whose revision the pane shows. */
  partNames() {
    return [this.kind];
  }

  hear(changed) {
    const own = [...this.partNames(), ...this.alsoHears()];
    // A newer frame without this part makes what is shown older than the state, which is to be seen.
    const nowOld = this.hub.isOld(this.partNames()[0]);
    if (!this.part() || changed.some((name) => own.includes(name)) || nowOld !== (this.root.dataset.stale === "true")) this.schedule();
  }

  alsoHears() {
    return ["ghost", "mode", "playing"];
  }

  part() {
    return this.hub.parts[this.partNames()[0]];
  }

  isStale() {
    return this.toldStale || this.hub.isOld(this.partNames()[0]);
  }

  setStale(isStale) {
    this.toldStale = isStale;
    this.schedule();
  }

  restyle() {
    this.schedule();
  }

  measure() {
    const { clientWidth, clientHeight } = this.root;
    const ratio = window.devicePixelRatio || 1;
    if (clientWidth === this.width && clientHeight === this.height && ratio === this.ratio) return;
    Object.assign(this, { width: clientWidth, height: clientHeight, ratio });
    this.resized();
    this.schedule();
  }

  resized() {}

  schedule() {
    if (this.frameAsked || this.destroyed) return;
    this.frameAsked = requestAnimationFrame((time) => {
      this.frameAsked = 0;
      this.paint(time);
    });
  }

  paint(time) {
    if (!this.width || !this.height || this.destroyed) return;
    const part = this.part();
    const stale = this.isStale();
    this.root.dataset.stale = String(Boolean(stale && part));
    this.empty.hidden = Boolean(part);
    if (!part) {
      this.empty.textContent = this.hub.instead || this.emptyText();
      this.clear();
      return;
    }
    this.draw(part, time, stale);
    if (this.shown !== part) this.afterPaint(part);
    this.shown = part;
  }

  clear() {}

  emptyText() {
    return "";
  }

  /** Why the present state has no such part, as a sentence; "" where it may have one. */
  reason(name) {
    const text = String(this.hub.missing[name] ?? "");
    return text && text[0].toUpperCase() + text.slice(1);
  }

  /** The revision stands in the DOM once the browser has painted it: a task queued from the frame runs after the paint. */
  afterPaint(part) {
    const { rev, arrived, kind, computed } = part;
    const channel = new MessageChannel();
    channel.port1.onmessage = () => {
      channel.port1.close();
      if (this.destroyed) return;
      if (kind === "curve") {
        this.hub.ahead = { rev, time: performance.now(), computed };
        return;
      }
      this.root.dataset.rev = String(rev);
      this.root.dataset.stage = kind;
      const time = performance.now();
      this.hub.painted = { rev, time, kind: this.kind, frame: kind, waited: time - arrived, computed };
    };
    channel.port2.postMessage(null);
  }

  onKey() {}

  /** End what swings in the pane. */
  rest() {}

  /** Tooltip at a place of the pane: rows of [text, value, colour]; text only, never markup. */
  showTip(x, y, rows) {
    const lines = rows.map(([text, value, colour]) => {
      const left = make("span");
      if (colour) {
        const mark = make("i");
        mark.style.background = colour;
        left.append(mark);
      }
      if (value == null) left.append(make("b", {}, text));
      else left.append(text);
      return value == null || value === "" ? make("div", {}, left) : make("div", {}, left, make("span", {}, value));
    });
    this.tip.replaceChildren(...lines);
    this.tip.hidden = false;
    const { offsetWidth: wide, offsetHeight: tall } = this.tip;
    const right = x + 14 + wide <= this.width ? x + 14 : x - 14 - wide;
    this.tip.style.left = `${Math.max(2, Math.min(right, this.width - wide - 2))}px`;
    this.tip.style.top = `${Math.max(2, Math.min(y + 12, this.height - tall - 2))}px`;
  }

  hideTip() {
    this.tip.hidden = true;
  }

  say(text) {
    this.spoken.textContent = text;
  }

  destroy() {
    this.destroyed = true;
    cancelAnimationFrame(this.frameAsked);
    this.hub.panes.delete(this);
    this.sizes.disconnect();
    for (const stop of this.stops) stop();
    window.removeEventListener("resize", this.screen);
  }
}

/** A canvas that fills an element, sharp on every screen; `begin` clears it and gives its context in pixels of the usual page. */
export class Sheet {
  constructor(parent) {
    this.canvas = make("canvas", { "aria-hidden": "true" });
    parent.append(this.canvas);
  }

  fit(width, height) {
    const ratio = px(window.devicePixelRatio || 1);
    const wide = Math.round(width * ratio);
    const tall = Math.round(height * ratio);
    if (this.canvas.width !== wide || this.canvas.height !== tall) {
      this.canvas.width = wide;
      this.canvas.height = tall;
      this.canvas.style.width = `${px(width)}px`;
      this.canvas.style.height = `${px(height)}px`;
    }
    Object.assign(this, { width, height, ratio });
  }

  /** Show what stands at the bottom of the sheet `up` pixels further up: where it is seen of a sheet that is scrolled. */
  lift(tall, up) {
    const context = this.canvas.getContext("2d");
    const [from, height] = [Math.round((this.height - tall) * this.ratio), Math.ceil(tall * this.ratio)];
    context.putImageData(context.getImageData(0, from, this.canvas.width, height), 0, from - Math.round(up * this.ratio));
  }

  begin() {
    const context = this.canvas.getContext("2d");
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    context.globalAlpha = 1;
    context.font = font(12);
    context.textBaseline = "middle";
    context.textAlign = "left";
    context.setLineDash([]);
    return context;
  }
}
