// Theme of the page: as the system, dark, light, in turn; kept in the browser, since it is no part of the model.
const KEY = "epicyclic-theme";
const THEMES = [
  { name: "as the system", value: "auto", icon: "brightness_auto" },
  { name: "dark", value: true, icon: "dark_mode" },
  { name: "light", value: false, icon: "light_mode" },
];

export default {
  template: `<button type="button" class="ck-icon-button" aria-label="Theme" :title="'Theme: ' + theme.name" @click="next">
    <i class="q-icon notranslate material-icons" aria-hidden="true">{{ theme.icon }}</i></button>`,
  data: () => ({ at: 0 }),
  computed: {
    theme() {
      return THEMES[this.at];
    },
  },
  mounted() {
    let kept = null;
    try {
      kept = localStorage.getItem(KEY);
    } catch {
      // a browser that keeps nothing takes the system's theme
    }
    this.take(Math.max(0, THEMES.findIndex((theme) => String(theme.value) === kept)));
  },
  methods: {
    take(at) {
      this.at = at;
      window.Quasar?.Dark.set(this.theme.value);
    },
    next() {
      this.take((this.at + 1) % THEMES.length);
      try {
        localStorage.setItem(KEY, String(this.theme.value));
      } catch {
        // it lasts as long as the page
      }
    },
  },
};
