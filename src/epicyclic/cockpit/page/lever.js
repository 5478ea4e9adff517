// A lever: slider and number box of one value. It moves without waiting for the server; what the server sends is shown
// where nobody holds the lever.

// [ms] between two moves that are sent; and after the last key press, until which a row of them is one drag.
const THROTTLE = 50;
const KEYS = 400;
// Positions of a logarithmic slider.
const POSITIONS = 400;

export default {
  props: {
    path: String, label: String, unit: String, why: String, message: String, changed: Boolean, assumed: String,
    least: Number, most: Number, step: Number, log: Boolean,
    // [count, value]: a new count shows the value, even one that was shown before
    shown: Array,
  },
  emits: ["move", "release", "typed", "reset", "restore"],
  template: `
    <div class="ck-lever" :data-lever="path" :data-refused="message ? 'true' : null">
      <div class="ck-lever-line">
        <span class="ck-lever-name" :title="why">{{ label }} <i v-if="unit">[{{ unit }}]</i></span>
        <abbr v-if="assumed" class="ck-assumed" :title="'Assumed, not given: ' + assumed">assumed</abbr>
        <button v-if="changed" type="button" class="ck-reset" :aria-label="label + ': value of the file'"
          title="Back to the value of the file" @click="$emit('reset')">↺</button>
        <input ref="box" class="ck-box-number" autocomplete="off" spellcheck="false" :aria-label="label + (assumed ? ' value, assumed' : ' value')" :title="unit ? 'in ' + unit + ', or with another unit' : null"
          :aria-invalid="message ? 'true' : null" @change="typed" @keydown.enter="typed" @keydown.esc="restore"
          @keydown.up.prevent="nudge(1)" @keydown.down.prevent="nudge(-1)" @input="dirty = true" @blur="release">
      </div>
      <input ref="slider" type="range" class="ck-range" role="slider" min="0" :max="last" step="1" :aria-label="label"
        :title="why" @input="moved" @change="changedByHand" @blur="release" @pointerdown="held = true">
      <div v-if="message" class="ck-message" role="alert">{{ message }}</div>
    </div>`,
  data: () => ({ held: false, dirty: false }),
  computed: {
    last() {
      if (this.log) return POSITIONS;
      return Math.max(1, Math.round((this.most - this.least) / this.step));
    },
  },
  watch: {
    // every change of another property brings an equal list anew
    shown(now, before) {
      if (now[0] !== before[0]) this.show();
    },
  },
  mounted() {
    this.value = this.shown[1];
    this.show();
  },
  unmounted() {
    clearTimeout(this.timer);
    clearTimeout(this.keys);
  },
  methods: {
    /** Show what the server says; what waits to be sent is of a state that has gone. */
    show() {
      if (this.held) return;
      clearTimeout(this.timer);
      clearTimeout(this.keys);
      this.timer = this.keys = this.waiting = undefined;
      this.value = this.shown[1];
      this.write(true);
    },
    write(withSlider) {
      const text = written(this.value);
      this.dirty = false;
      if (this.$refs.box.value !== text) this.$refs.box.value = text;
      if (withSlider) this.$refs.slider.value = this.position(this.value);
      this.$refs.slider.setAttribute("aria-valuetext", this.unit ? `${text} ${this.unit}` : text);
    },
    position(value) {
      const at = this.log
        ? Math.log(Math.max(value, this.least) / this.least) / Math.log(this.most / this.least)
        : (value - this.least) / (this.most - this.least);
      return Math.round(Math.min(Math.max(at, 0), 1) * this.last);
    },
    at(position) {
      const part = position / this.last;
      if (this.log) return Number((this.least * (this.most / this.least) ** part).toPrecision(3));
      const value = this.least + (this.most - this.least) * part;
      return Number((Math.round(value / this.step) * this.step).toPrecision(8));
    },
    moved(event) {
      this.value = this.at(Number(event.target.value));
      this.write(false);
      this.send();
    },
    /** Send a move now, or the newest one when the throttle lets it. */
    send() {
      if (this.timer !== undefined) {
        this.waiting = this.value;
        return;
      }
      this.$emit("move", this.value);
      this.waiting = undefined;
      this.timer = setTimeout(() => {
        this.timer = undefined;
        if (this.waiting !== undefined) this.send();
      }, THROTTLE);
      this.open = true;
    },
    changedByHand() {
      if (this.held) {
        this.held = false;
        this.release();
      } else {
        this.later();
      }
    },
    later() {
      clearTimeout(this.keys);
      this.keys = setTimeout(() => this.release(), KEYS);
    },
    /** End of a drag: everything is asked for. */
    release() {
      clearTimeout(this.keys);
      clearTimeout(this.timer);
      this.keys = this.timer = this.waiting = undefined;
      this.held = false;
      if (!this.open) return;
      this.open = false;
      this.$emit("release", this.value);
    },
    nudge(direction) {
      const now = this.position(this.value);
      const to = Math.min(Math.max(now + direction, 0), this.last);
      if (to === now) return;
      this.value = this.at(to);
      this.write(true);
      this.send();
      this.later();
    },
    typed(event) {
      const text = event.target.value.trim();
      if (!this.dirty) return;
      this.dirty = false;
      this.open = false;
      this.$emit("typed", text);
    },
    restore() {
      this.write(true);
      if (this.message) this.$emit("restore");
    },
  },
};

/** A number as it stands in the box: six digits, an exponent where zeros would hide the size. */
function written(value) {
  const short = Number(value.toPrecision(6));
  const size = Math.abs(short);
  return size !== 0 && (size >= 1e6 || size < 1e-4) ? short.toExponential().replace("e+", "e") : String(short);
}
