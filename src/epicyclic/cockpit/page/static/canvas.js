// What is drawn on every canvas: lines, circles, texts, the colours of loads.
import { font, loadColour, look } from "./look.js";

/** Draw paths through points [x, y] as lines. */
export function lines(context, colour, width, paths, dash = []) {
  context.save();
  context.beginPath();
  for (const [first, ...others] of paths) {
    context.moveTo(...first);
    for (const point of others) context.lineTo(...point);
  }
  context.setLineDash(dash);
  context.lineWidth = width;
  context.strokeStyle = colour;
  context.stroke();
  context.restore();
}

export function circle(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}

/** Write a text in its own font, which stays for what is measured next; cut to the width `room` where there is one. */
export function write(context, text, x, y, { size = 11, weight = 400, align = "left", colour = look().ink, room = Infinity } = {}) {
  context.font = font(size, weight);
  context.textAlign = align;
  context.fillStyle = colour;
  context.fillText(cut(context, text, room), x, y);
}

/** As much of a text as fits a width. */
function cut(context, text, width) {
  if (context.measureText(text).width <= width) return text;
  let end = text.length;
  while (end > 1 && context.measureText(`${text.slice(0, end)}…`).width > width) end -= 1;
  return `${text.slice(0, end)}…`;
}

/** The colours of loads from the least to the largest, side by side. */
export function colourBar(context, x, y, width, tall) {
  for (let i = 0; i < width; i++) {
    context.fillStyle = loadColour(i / (width - 1));
    context.fillRect(x + i, y, 1.5, tall);
  }
}
