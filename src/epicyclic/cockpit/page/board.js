// The element of NiceGUI around one pane: what Python calls, and what it hears.
import { createPane, cockpit } from "epicyclic-cockpit";

export default {
  template: "<div></div>",
  props: { kind: String, label: String },
  mounted() {
    this.pane = createPane(this.kind, this.$el, {
      label: this.label,
      onSpeed: (relative) => this.$emit("speed", relative),
      onMode: (index) => this.$emit("mode", index),
    });
    this.$emit("ready");
  },
  unmounted() {
    this.pane?.destroy();
  },
  methods: {
    frame(text, mode) {
      cockpit.frame(text, mode);
    },
    clear(text) {
      cockpit.clear(text);
    },
    ghost(text) {
      cockpit.ghost(text);
    },
    preview(mark, text) {
      cockpit.preview(mark, text);
    },
    mode(index) {
      cockpit.chooseMode(index);
    },
    stale(isStale) {
      this.pane.setStale(isStale);
    },
    play(isPlaying) {
      cockpit.setPlaying(isPlaying);
    },
    evidence(name) {
      this.pane.setEvidence?.(name);
    },
  },
};
