// The panes of the cockpit. `window.cockpit` is the hub of the page: what is shown, and what was painted when.
import { EvidencePane } from "./evidence.js";
import { Hub } from "./hub.js";
import { forget } from "./look.js";
import { SweepPane } from "./sweep.js";
import { TrainPane } from "./train.js";

const KINDS = { train: TrainPane, sweep: SweepPane, evidence: EvidencePane };

export const cockpit = (window.cockpit ??= new Hub());

for (const name of ["board.css", "uPlot.min.css"]) {
  const href = new URL(`./${name}`, import.meta.url).href;
  if (![...document.styleSheets].some((sheet) => sheet.href === href)) {
    const link = Object.assign(document.createElement("link"), { rel: "stylesheet", href });
    link.onload = () => {
      forget();
      for (const pane of cockpit.panes) pane.restyle();
    };
    document.head.prepend(link); // before the page's own rules, which may then change the looks
  }
}

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && !event.defaultPrevented) cockpit.rest();
});

export function createPane(kind, root, options = {}) {
  return new KINDS[kind](kind, root, cockpit, options);
}
