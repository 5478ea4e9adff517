// Axial section, the half above the axis: gears as rectangles along z, carrier with its pin, links, meshes by load.
import { look, translucent } from "./look.js";
import { angleAbout, beside, isGear, isInternal } from "./train_geometry.js";
import { amount, arcRadius, kindColour } from "./train_front.js";

/** What the section shows: rectangles {body, z0, z1, low, high} [mm], marks of meshes and links, bounds. */
export function sectionView(front) {
  const { bodies } = front;
  const shown = bodies.filter((body) => body.drawn && (body.kind !== "planet" || body.number == null || body.number === 1));
  const ranges = spans(shown, bodies);
  const moved = stageMoves(shown, ranges);
  const rows = shown.map((body) => rectangle(body, shifted(ranges.get(body), moved.get(body.stage) ?? 0)));
  const widths = new Map(rows.map((row) => [row.body.index, row]));
  const loose = bodies.filter((body) => !body.drawn && hasWidth(body) && moved.size < 2);
  const shafts = loose.map((body) => {
    const radius = body.tip ?? body.pitch ?? 0.12 * tallest(rows);
    return { body, z0: body.z[0], z1: body.z[1], low: 0, high: radius };
  });
  const meshes = front.meshes.map((mesh, index) => meshMark(mesh, index, front, widths, moved)).filter(Boolean);
  const all = [...rows, ...shafts];
  const bounds = [
    Math.min(...all.map((row) => row.z0)), Math.max(...all.map((row) => row.z1)), 0, Math.max(1e-9, ...all.map((row) => row.high)),
  ];
  return { rows, shafts, meshes, moved, bounds };
}

const hasWidth = (body) => Array.isArray(body.z) && body.z[1] > body.z[0];
const tallest = (rows) => Math.max(1, ...rows.map((row) => row.high));
const shifted = ([z0, z1], by) => [z0 + by, z1 + by];

/** Where each body stands along z; one without a width takes that of its stage, or a third of its radius. */
function spans(shown, bodies) {
  const found = new Map();
  for (const body of shown) {
    const mates = bodies.filter((other) => other.stage === body.stage && isGear(other) && hasWidth(other));
    const middle = Array.isArray(body.z) ? (body.z[0] + body.z[1]) / 2 : 0;
    if (body.kind === "carrier") {
      const planets = mates.filter((other) => other.kind === "planet");
      const width = planets.length ? planets[0].z : [middle - 0.17 * body.outer, middle + 0.17 * body.outer];
      const cheek = Math.max(0.16 * (width[1] - width[0]), 0.04 * body.outer);
      found.set(body, [width[0] - 1.6 * cheek, width[1] + 1.6 * cheek]);
    } else if (hasWidth(body)) found.set(body, body.z);
    else {
      const width = 0.3 * Math.min(...bodies.filter((one) => one.stage === body.stage && isGear(one)).map((one) => one.pitch));
      found.set(body, [middle - width / 2, middle + width / 2]);
    }
  }
  return found;
}

/** Stages that would lie over each other along z are laid side by side, as in the front view. */
function stageMoves(shown, ranges) {
  const names = [...new Set(shown.map((body) => body.stage))];
  const boxes = names.map((name) => {
    const own = shown.filter((body) => body.stage === name);
    const ends = own.map((body) => ranges.get(body));
    return [Math.min(...ends.map((end) => end[0])), Math.max(...ends.map((end) => end[1])), 0, Math.max(...own.map((body) => body.outer))];
  });
  const moved = beside(boxes, 0.12);
  return new Map(moved.some(([x]) => x) ? names.map((name, i) => [name, moved[i][0]]) : []);
}

function rectangle(body, [z0, z1]) {
  const height = body.kind === "planet" ? body.orbitRadius : body.orbitRadius || 0;
  if (body.kind === "carrier") return { body, z0, z1, low: 0, high: body.outer, pin: body.pins[0]?.orbitRadius ?? 0.7 * body.outer };
  if (isInternal(body)) return { body, z0, z1, low: body.tip, high: body.outer };
  const outer = body.tip ?? body.pitch;
  return { body, z0, z1, low: Math.max(0, height - outer), high: height + outer, centre: height };
}

function meshMark(mesh, index, front, widths, moved) {
  const pair = mesh.bodies.map((i) => front.bodies[i]);
  const first = pair.map((body) => widths.get(body.index) ?? likeFirst(body, widths)).filter(Boolean);
  if (first.length < 2) return null;
  const z0 = Math.max(...first.map((row) => row.z0));
  const z1 = Math.min(...first.map((row) => row.z1));
  const parallel = front.meshes.filter((other) => other.bodies.join() === mesh.bodies.join());
  const half = Math.max(0, (0.42 * (z1 - z0)) / parallel.length);
  const at = mesh.z ? (mesh.z[0] + mesh.z[mesh.z.length - 1]) / 2 + (moved.get(pair[0].stage) ?? 0) : (z0 + z1) / 2;
  const middle = parallel.length > 1 && at >= z0 && at <= z1 ? at : spread(parallel.indexOf(mesh), parallel.length, z0, z1);
  const axis = pair[0].axis;
  return { index, z0: middle - half, z1: middle + half, height: Math.hypot(mesh.x - axis.x, mesh.y - axis.y), pair };
}

const spread = (i, count, z0, z1) => z0 + ((i + 0.5) / count) * (z1 - z0);

/** Row of the planet that stands for this one. */
function likeFirst(body, widths) {
  if (body.kind !== "planet") return null;
  return [...widths.values()].find(({ body: other }) => other.kind === "planet" && other.stage === body.stage && Math.abs(other.orbitRadius - body.orbitRadius) < 1e-3 * body.outer);
}

/** Draw the section in a view; `loads` as in the front view, or null in a mode; `motion` {shape, size, swing} or null. */
export function drawSection(context, section, view, loads, motion) {
  axisLine(context, section, view);
  const order = { carrier: 0, shaft: 1, ring: 2, sun: 3, planet: 4 };
  const rows = [...section.rows, ...section.shafts].sort((a, b) => (order[a.body.kind] ?? 2) - (order[b.body.kind] ?? 2));
  for (const row of rows) {
    if (motion) drawRow(context, row, view, { fill: null, stroke: look().other });
    drawMoved(context, row, view, motion, rows);
  }
  if (loads) for (const mark of worst(section.meshes, loads)) meshLine(context, mark, view, loads);
}

const px = (view, z, h) => [view.x + (z - view.middle[0]) * view.scale, view.y - (h - view.middle[1]) * view.scale];

function axisLine(context, section, view) {
  const [x0, y] = px(view, section.bounds[0], 0);
  const [x1] = px(view, section.bounds[1], 0);
  context.beginPath();
  context.moveTo(x0 - 10, y);
  context.lineTo(x1 + 10, y);
  context.setLineDash([9, 3, 2, 3]);
  context.lineWidth = 1;
  context.strokeStyle = look().pale;
  context.stroke();
  context.setLineDash([]);
}

function drawMoved(context, row, view, motion, rows) {
  const colour = kindColour(row.body);
  if (!motion) return drawRow(context, row, view, { fill: translucent(colour, look().dark ? 0.28 : 0.22), stroke: colour });
  const shape = motion.shape[row.body.index];
  const moves = amount(shape);
  const tone = moves < 0.03 ? { fill: null, stroke: look().edge } : { fill: translucent(colour, 0.1 + 0.3 * moves), stroke: colour };
  // The plane of the section goes through the axis and the planet that is drawn in it.
  const planet = rows.find(({ body }) => body.kind === "planet" && body.stage === row.body.stage);
  const angle = planet ? angleAbout(planet.body) : Math.PI / 2;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const size = motion.size * motion.swing;
  const out = size * (shape[0] * c + shape[1] * s);
  const along = size * shape[2];
  const tilt = (size * (-shape[3] * s + shape[4] * c)) / arcRadius(row.body);
  const [x, y] = px(view, (row.z0 + row.z1) / 2, row.centre ?? 0);
  context.save();
  context.translate(x + along * view.scale, y - out * view.scale);
  context.rotate(-tilt);
  context.translate(-x, -y);
  drawRow(context, row, view, tone);
  context.restore();
}

function drawRow(context, row, view, tone) {
  context.lineWidth = 1.1;
  context.strokeStyle = tone.stroke;
  for (const [z0, z1, low, high] of pieces(row)) {
    const [x0, y0] = px(view, z0, high);
    const [x1, y1] = px(view, z1, low);
    const wide = Math.max(x1 - x0, 2);
    if (tone.fill) {
      if (row.body.kind !== "carrier") {
        context.fillStyle = look().surface;
        context.fillRect(x0, y0, wide, y1 - y0);
      }
      context.fillStyle = tone.fill;
      context.fillRect(x0, y0, wide, y1 - y0);
    }
    context.strokeRect(x0, y0, wide, y1 - y0);
  }
  if (isGear(row.body) && tone.fill) helix(context, row, view, tone.stroke);
  if (row.body.held && tone.fill) ground(context, row, view);
  if (row.body.floating && tone.fill) floats(context, row, view);
}

/** A carrier is two cheeks with the pin between them, a herringbone gear two faces, every other body one rectangle. */
function pieces({ body, z0, z1, low, high, pin }) {
  const faces = body.faces?.length > 1 ? body.faces : [];
  const move = faces.length ? z0 - Math.min(...faces.flatMap(([a, b]) => [a, b])) : 0;
  if (faces.length) return faces.map(([a, b]) => [a + move, b + move, low, high]);
  if (body.kind !== "carrier") return [[z0, z1, low, high]];
  const cheek = 0.16 * (z1 - z0);
  const half = 0.06 * high;
  return [[z0, z0 + 0.75 * cheek, 0, high], [z1 - 0.75 * cheek, z1, 0, high], [z0 + 0.75 * cheek, z1 - 0.75 * cheek, pin - half, pin + half]];
}

/** Strokes along the teeth, slanted by the hand of the helix, face by face. */
function helix(context, { body, z0, z1, low, high }, view, colour) {
  if (body.faces?.length) {
    const move = z0 - Math.min(...body.faces.flatMap(([a, b]) => [a, b]));
    for (const [a, b, hand] of body.faces) strokes(context, { z0: a + move, z1: b + move, low, high, hand }, view, colour);
  } else strokes(context, { z0, z1, low, high, hand: body.hand }, view, colour);
}

function strokes(context, { z0, z1, low, high, hand }, view, colour) {
  if (!hand) return;
  const [x0, y0] = px(view, z0, high);
  const [x1, y1] = px(view, z1, low);
  if (x1 - x0 < 10 || y1 - y0 < 8) return;
  context.save();
  context.beginPath();
  context.rect(x0, y0, x1 - x0, y1 - y0);
  context.clip();
  context.beginPath();
  const rise = (hand === "left" ? 0.3 : -0.3) * (x1 - x0);
  for (let y = y0 - Math.abs(rise); y < y1 + Math.abs(rise); y += 7) {
    context.moveTo(x0, y + rise / 2);
    context.lineTo(x1, y - rise / 2);
  }
  context.lineWidth = 0.7;
  context.strokeStyle = translucent(colour, 0.45);
  context.stroke();
  context.restore();
}

function ground(context, { body, z0, z1, high }, view) {
  const [x0, y] = px(view, z0, high);
  const [x1] = px(view, z1, high);
  const base = isInternal(body) ? y : y - 2;
  context.beginPath();
  for (let x = x0; x <= x1 - 2; x += 6) {
    context.moveTo(x, base);
    context.lineTo(x + 4, base - 5);
  }
  context.lineWidth = 1;
  context.strokeStyle = look().ink;
  context.stroke();
}

function floats(context, { z0, z1, low, high, body }, view) {
  const [x, y] = px(view, (z0 + z1) / 2, isInternal(body) ? (low + high) / 2 : 0);
  context.beginPath();
  context.arc(x, isInternal(body) ? y : y - 7, 4, 0, 2 * Math.PI);
  context.lineWidth = 1.8;
  context.strokeStyle = look().ink;
  context.stroke();
}

/** Of the planets' meshes that lie over each other in the section the most loaded. */
function worst(meshes, loads) {
  const found = new Map();
  for (const mark of meshes) {
    const key = `${mark.z0.toFixed(3)} ${mark.height.toFixed(2)}`;
    const load = loads.values[mark.index];
    if (!found.has(key) || load > loads.values[found.get(key).index]) found.set(key, mark);
  }
  return [...found.values()];
}

function meshLine(context, mark, view, loads) {
  const [x0, y] = px(view, mark.z0, mark.height);
  const [x1] = px(view, mark.z1, mark.height);
  const load = loads.values[mark.index];
  const known = Number.isFinite(load);
  for (const [width, colour] of [[6, known ? loads.edge(load) : look().edge], [4, known ? loads.colour(load) : look().other]]) {
    context.beginPath();
    context.moveTo(x0, y);
    context.lineTo(Math.max(x1, x0 + 2), y);
    context.lineCap = "round";
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.stroke();
  }
  context.lineCap = "butt";
}

/** Draw bearings, supports, couplings and splines where they sit on the axis of their body. */
export function drawLinks(context, section, view, links, bodies) {
  if (section.moved.size) return; // stages moved apart: the places of the links would be false
  const last = new Map();
  for (const link of links) {
    const ends = [link.body, link.to].map((name) => bodies.find((one) => one.name === name));
    if (link.kind === "coupling" && ends[0] && ends[1]) {
      shaftLine(context, view, ends);
      continue;
    }
    const body = ends.find((one) => one?.kind === "planet") ?? ends[0];
    if (!body || link.z == null || (body.kind === "planet" && body.number > 1)) continue;
    const height = body.kind === "planet" ? body.orbitRadius : 0;
    const [x, y] = px(view, link.z, height);
    const key = `${Math.round(x / 9)} ${Math.round(y)}`;
    if (last.has(key)) continue;
    last.set(key, true);
    linkMark(context, x, height ? y : y + 6, link);
  }
}

/** A coupling is a stroke on the axis from one body to the other. */
function shaftLine(context, view, ends) {
  const [from, to] = ends.map((body) => px(view, (body.z[0] + body.z[1]) / 2, 0));
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.lineWidth = 2.5;
  context.strokeStyle = translucent(look().kinds.shaft, 0.8);
  context.stroke();
}

function linkMark(context, x, y, { kind, to }) {
  context.beginPath();
  context.lineWidth = 1;
  context.strokeStyle = look().ink;
  if (kind === "bearing") {
    context.rect(x - 3.5, y - 3.5, 7, 7);
    context.moveTo(x - 3.5, y - 3.5);
    context.lineTo(x + 3.5, y + 3.5);
    context.moveTo(x + 3.5, y - 3.5);
    context.lineTo(x - 3.5, y + 3.5);
  } else if (kind === "spline") {
    for (const shift of [-3, 0, 3]) {
      context.moveTo(x + shift, y - 4);
      context.lineTo(x + shift, y + 4);
    }
  } else {
    for (let i = 0; i <= 6; i++) context.lineTo(x + (i % 2 ? 3 : -3), y - 4 + (8 * i) / 6);
  }
  if (to == null) {
    context.moveTo(x - 5, y + 5);
    context.lineTo(x + 5, y + 5);
  }
  context.stroke();
}

/** Row or mesh of the section under a pixel: {body} or {mark}, else null. */
export function underSection(section, view, loads, x, y) {
  for (const mark of worst(section.meshes, loads)) {
    const [x0, y0] = px(view, mark.z0, mark.height);
    const [x1] = px(view, mark.z1, mark.height);
    if (x >= x0 - 2 && x <= x1 + 2 && Math.abs(y - y0) <= 4) return { mark };
  }
  const order = ["planet", "sun", "ring", "shaft", "carrier"];
  const rows = [...section.rows, ...section.shafts].sort((a, b) => order.indexOf(a.body.kind) - order.indexOf(b.body.kind));
  for (const row of rows) {
    for (const [z0, z1, low, high] of pieces(row)) {
      const [x0, y0] = px(view, z0, high);
      const [x1, y1] = px(view, z1, low);
      if (x >= x0 && x <= x1 && y >= y0 && y <= y1) return { body: row.body };
    }
  }
  return null;
}
