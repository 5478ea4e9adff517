// Unpacks plotly.js and the figures, draws a figure when it is first seen, opens what a link points to, and lays all
// out on paper before it is printed.
(() => {
  "use strict";
  // width of the text on A4 with the margins of report.css, and height of a figure that leaves room for its heading and
  // caption [px]
  const PAPER = 680, TALL = 860;
  const night = window.matchMedia("(prefers-color-scheme: dark)");
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  let book = null, printing = false;

  const unpack = async id => {
    const text = document.getElementById(id).textContent;
    const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).text();
  };

  // Light colours turned dark and dark ones light, hues kept; those in between serve on both grounds.
  const channels = words => {
    const hex = /^#([0-9a-f]{6})$/i.exec(words);
    if (hex) return [0, 2, 4].map(at => parseInt(hex[1].slice(at, at + 2), 16));
    const parts = /^rgba?\(([^)]*)\)$/i.exec(words);
    return parts ? parts[1].split(",").map(Number) : words === "white" ? [255, 255, 255] : null;
  };
  const turned = words => {
    const found = channels(words);
    if (!found) return words;
    const [r, g, b, alpha] = found, top = Math.max(r, g, b) / 255, low = Math.min(r, g, b) / 255;
    const light = (top + low) / 2, range = top - low;
    // ends of the scale are swapped onto 0.09 .. 0.9; coloured curves (0.3 .. 0.6) are only lifted a little
    const grey = range < 0.12;
    let now = light;
    if (light > 0.7) now = 0.09 + (1 - light) * 0.9;
    else if (light < 0.3 || grey) now = Math.min(0.9, 1.02 - 0.8 * light);
    else now = light + 0.1;
    const span = grey ? range * 0.5 : (range / Math.max(1e-6, 1 - Math.abs(2 * light - 1))) * (1 - Math.abs(2 * now - 1));
    const middle = (top + low) / 2;
    const scaled = [r, g, b].map(value => {
      const away = range ? (value / 255 - middle) / range : 0;
      return Math.round(255 * Math.min(1, Math.max(0, now + away * Math.min(span, 0.85))));
    });
    return alpha === undefined ? `rgb(${scaled.join(",")})` : `rgba(${scaled.join(",")},${alpha})`;
  };
  const COLOUR = /"(#[0-9a-f]{6}|rgba?\([0-9., ]+\)|white)"/gi;
  const dark = () => night.matches && !printing;
  const coloured = value => {
    const text = JSON.stringify(value);
    return JSON.parse(dark() ? text.replace(COLOUR, (_, words) => `"${turned(words)}"`) : text);
  };

  const shown = element => !element.parentElement.closest("details:not([open])");
  const draw = div => {
    const figure = book.figures[div.id];
    if (!figure) return;
    const { data, layout, frames } = coloured(figure);
    if (!layout.template || !Object.keys(layout.template).length) layout.template = coloured(book.template);
    layout.autosize = !printing;
    layout.width = printing ? Math.min(PAPER, div.clientWidth || PAPER) : undefined;
    const tall = figure.layout.height || 420;
    layout.height = printing ? Math.min(TALL, tall) : tall;
    div.style.height = `${layout.height}px`;
    div.dataset.drawn = dark() ? "dark" : "light";
    const config = { responsive: true, displaylogo: false, displayModeBar: printing ? false : "hover" };
    Plotly.react(div, { data, layout, frames, config });
    if (frames) Plotly.addFrames(div, frames);
  };
  const drawShown = () => {
    if (book) all(".plotly-graph-div").filter(div => !div.dataset.drawn && shown(div)).forEach(draw);
  };
  const again = () => all(".plotly-graph-div").filter(div => div.dataset.drawn).forEach(div => {
    Plotly.purge(div);
    delete div.dataset.drawn;
  });

  const open = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    all("details.fold", target).slice(0, 1).forEach(own => { own.open = true; });
    for (let own = target.closest("details"); own; own = own.parentElement.closest("details")) own.open = true;
    drawShown();
    target.scrollIntoView();
  };

  let opened = [];
  const before = () => {
    if (printing) return;
    printing = true;
    document.documentElement.classList.add("printing");
    opened = all("details:not([open])");
    opened.forEach(each => { each.open = true; });
    // a table that is too wide for the paper is set smaller
    all(".table").forEach(each => { each.style.zoom = Math.min(1, PAPER / each.firstElementChild.offsetWidth); });
    if (book) { again(); drawShown(); }
  };
  const after = () => {
    printing = false;
    document.documentElement.classList.remove("printing");
    opened.forEach(each => { each.open = false; });
    all(".table").forEach(each => { each.style.zoom = ""; });
    if (book) { again(); drawShown(); }
  };

  document.addEventListener("toggle", drawShown, true);
  window.addEventListener("hashchange", open);
  window.addEventListener("beforeprint", before);
  window.addEventListener("afterprint", after);
  night.addEventListener("change", () => { if (book) { again(); drawShown(); } });
  document.addEventListener("click", event => {
    const link = event.target.closest("a[href^='#']");
    if (link && link.hash === location.hash) open(); // a second click makes no change of the address
    const all_of = event.target.closest("[data-folds]");
    if (all_of) all("details.fold").forEach(each => { each.open = all_of.dataset.folds === "open"; });
  });

  (async () => {
    try {
      const script = document.createElement("script");
      script.textContent = await unpack("plotly-packed");
      document.head.append(script);
      book = JSON.parse(await unpack("figures-packed"));
    } catch (error) {
      all(".plotly-graph-div").forEach(div => { div.textContent = `This browser cannot draw the figures: ${error}`; });
      return;
    }
    open();
    drawShown();
    document.documentElement.dataset.ready = "yes";
  })();
})();
