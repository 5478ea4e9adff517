// Front view: gears with their teeth, meshes in the colour of their load, the float of a body, what is held; or a mode.
import { faded, loadColour, look, short, translucent, written } from "./look.js";
import { isGear, isInternal, meshAt, placeAt } from "./train_geometry.js";

const TURN = 2 * Math.PI;
const ORDER = { carrier: 0, ring: 1, gear: 3, planet: 4, sun: 5 };

/** Scale [px/mm] and middle of a view of the bounds [x0, x1, y0, y1] within a box of pixels. */
export function fitted(bounds, { x, y, width, height }) {
  const scale = Math.min(width / (bounds[1] - bounds[0]), height / (bounds[3] - bounds[2]));
  return { scale, x: x + width / 2, y: y + height / 2, middle: [(bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2] };
}

/** A place of the drawing [mm] in pixels; y upwards. */
export const seen = (view, x, y) => [view.x + (x - view.middle[0]) * view.scale, view.y - (y - view.middle[1]) * view.scale];

export const kindColour = (body) => look().kinds[body.kind] ?? (isGear(body) ? look().kinds.gear : look().kinds.shaft);

/** Draw the train as it stands after so many seconds; `loads` {values, low, high} colours the meshes. */
export function drawFront(context, front, view, seconds, loads) {
  const order = [...front.bodies].filter((body) => body.drawn);
  order.sort((a, b) => (ORDER[a.kind] ?? 3) - (ORDER[b.kind] ?? 3) || b.outer - a.outer);
  for (const body of order) drawBody(context, body, view, placeAt(body, seconds));
  for (const body of order) if (isGear(body)) pitchCircle(context, body, view, placeAt(body, seconds));
  drawMeshes(context, front, view, seconds, loads);
  for (const body of order) drawHeld(context, body, view, placeAt(body, seconds));
  for (const body of onePerPlace(order)) drawCentre(context, body, view, placeAt(body, seconds));
  stageNames(context, front, view);
}

/** The bodies, of those on one centre the last alone: the front one, whose mark would cover that of the others. */
function onePerPlace(order) {
  const last = new Map(order.map((body) => [`${body.x} ${body.y} ${body.stage} ${isInternal(body) ? body.name : ""}`, body]));
  return order.filter((body) => [...last.values()].includes(body));
}

function drawBody(context, body, view, place, tone = {}) {
  const { fill = translucent(kindColour(body), look().dark ? 0.2 : 0.13), stroke = kindColour(body), width = 1.1 } = tone;
  context.save();
  context.translate(...seen(view, place.x, place.y));
  context.scale(view.scale, -view.scale);
  // A carrier has no teeth: it is turned with its pins.
  context.rotate(body.kind === "carrier" ? place.angle - body.phase : place.angle);
  context.lineWidth = width / view.scale;
  context.strokeStyle = stroke;
  if (isInternal(body)) {
    const rim = new Path2D(body.path);
    rim.arc(0, 0, body.outer, 0, TURN);
    context.fillStyle = fill;
    if (fill) context.fill(rim, "evenodd");
    context.stroke(body.path);
    context.beginPath();
    context.arc(0, 0, body.outer, 0, TURN);
    context.stroke();
  } else {
    // Opaque first: what lies behind a gear is not seen through it.
    context.fillStyle = look().surface;
    if (fill && isGear(body)) context.fill(body.path);
    context.fillStyle = fill;
    if (fill) context.fill(body.path);
    context.stroke(body.path);
  }
  if (isGear(body)) turnMark(context, body, stroke, width / view.scale);
  context.restore();
}

/** A stroke on one tooth, by which the turning is seen. */
function turnMark(context, body, colour, width) {
  const inner = isInternal(body);
  const [from, to] = inner ? [body.root, body.outer] : [0.74 * body.root, 0.93 * body.root];
  context.beginPath();
  context.moveTo(from, 0);
  context.lineTo(to, 0);
  context.lineWidth = 2.2 * width;
  context.strokeStyle = colour;
  context.stroke();
}

function pitchCircle(context, body, view, place) {
  context.beginPath();
  context.arc(...seen(view, place.x, place.y), body.pitch * view.scale, 0, TURN);
  context.setLineDash([7, 3, 1.5, 3]);
  context.lineWidth = 0.7;
  context.strokeStyle = translucent(look().pale, 0.7);
  context.stroke();
  context.setLineDash([]);
}

/** Meshes at one place of the front view, as of both helices of a herringbone pair, are one: the most loaded is shown. */
export function places(front, loads) {
  const found = new Map();
  front.meshes.forEach((mesh, index) => {
    const key = `${mesh.x.toFixed(3)} ${mesh.y.toFixed(3)} ${front.bodies[mesh.bodies[0]].stage}`;
    const load = loads.values[index];
    const known = found.get(key);
    if (!known) found.set(key, { mesh, index, load, all: [index] });
    else {
      known.all.push(index);
      if (load > known.load || !Number.isFinite(known.load)) Object.assign(known, { mesh, index, load });
    }
  });
  return [...found.values()];
}

/** Radius [px] of the patch in which the teeth of a mesh take the colour of its load. */
export function patch(mesh, bodies, view) {
  const modules = mesh.bodies.map((i) => bodies[i]).filter(isGear).map((body) => (2 * body.pitch) / body.teeth);
  return Math.min(Math.max(5 * Math.min(...modules, 20) * view.scale, 11), 26);
}

function drawMeshes(context, front, view, seconds, loads) {
  if (![...loads.values].some(Number.isFinite)) return; // a train without a load: its teeth alone
  for (const one of places(front, loads)) {
    const at = meshAt(one.mesh, front.bodies, seconds);
    const [x, y] = seen(view, at.x, at.y);
    const radius = patch(one.mesh, front.bodies, view);
    const known = Number.isFinite(one.load);
    const colour = known ? loads.colour(one.load) : look().other;
    const glow = context.createRadialGradient(x, y, 0.6 * radius, x, y, radius);
    glow.addColorStop(0, colour);
    glow.addColorStop(1, faded(colour, 0.35));
    for (const index of one.mesh.bodies) glowingTeeth(context, front.bodies[index], view, seconds, glow, [x, y, radius]);
    context.beginPath();
    context.arc(x, y, radius, 0, TURN);
    context.lineWidth = 1.3;
    context.strokeStyle = known ? loads.edge(one.load) : look().edge;
    context.stroke();
    if (known) meshNumber(context, front, view, seconds, one, [x, y], radius);
  }
}

/** The teeth of one gear in the colour of the mesh's load, strongest where they touch. */
function glowingTeeth(context, body, view, seconds, glow, [x, y, radius]) {
  if (!body.drawn) return;
  const place = placeAt(body, seconds);
  const [px, py] = seen(view, place.x, place.y);
  const onScreen = new DOMMatrix([view.scale, 0, 0, -view.scale, px, py]).rotate((180 * place.angle) / Math.PI);
  const teeth = new Path2D();
  teeth.addPath(body.path, onScreen);
  context.save();
  context.beginPath();
  context.arc(x, y, radius, 0, TURN);
  context.clip();
  const filled = new Path2D(teeth);
  if (isInternal(body)) filled.arc(px, py, body.outer * view.scale, 0, TURN);
  context.fillStyle = glow;
  context.fill(filled, "evenodd");
  context.lineWidth = 1.2;
  context.strokeStyle = look().surface;
  context.stroke(teeth);
  context.restore();
}

/** The load beside its mesh, inside the planet, where that has room for two of them and its number. */
function meshNumber(context, front, view, seconds, one, [x, y], radius) {
  const bodies = one.mesh.bodies.map((index) => front.bodies[index]).filter((body) => isGear(body) && !isInternal(body));
  const host = bodies.find((body) => body.kind === "planet") ?? bodies[0];
  if (!host || host.root * view.scale < radius + 38) return;
  const place = placeAt(host, seconds);
  const [cx, cy] = seen(view, place.x, place.y);
  const away = Math.hypot(cx - x, cy - y) || 1;
  // Clear of the patch in every direction: a number of three digits is twice as wide as tall.
  const reach = radius + 4 + (12 * Math.abs(cx - x) + 6 * Math.abs(cy - y)) / away;
  context.font = `600 10.5px ${look().font}`;
  context.textAlign = "center";
  context.fillStyle = look().ink;
  context.fillText(written(one.load, 3), x + ((cx - x) / away) * reach, y + ((cy - y) / away) * reach);
}

/** Strokes of the housing behind a body that does not turn: around a ring, inside another. */
function drawHeld(context, body, view, place) {
  if (!body.held) return;
  const [x, y] = seen(view, place.x, place.y);
  const ring = isInternal(body);
  const radius = (ring ? body.outer : isGear(body) ? 0.5 * body.root : 0.16 * body.outer) * view.scale;
  const deep = ring ? 7 : -Math.min(7, 0.5 * radius);
  const count = Math.max(12, Math.round((TURN * radius) / 9));
  context.beginPath();
  for (let i = 0; i < count; i++) {
    const angle = (TURN * i) / count;
    const end = angle + 7 / Math.max(radius, 8);
    context.moveTo(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
    context.lineTo(x + (radius + deep) * Math.cos(end), y + (radius + deep) * Math.sin(end));
  }
  context.moveTo(x + radius, y);
  context.arc(x, y, radius, 0, TURN);
  context.lineWidth = 1;
  context.strokeStyle = look().ink;
  context.stroke();
}

/** Number of a planet; a body that floats has an open ring about its centre, another a point. */
function drawCentre(context, body, view, place) {
  if (!isGear(body) && !body.floating) return;
  if (isInternal(body) && !body.floating) return;
  const [x, y] = seen(view, place.x, place.y);
  const room = body.root * view.scale;
  context.textAlign = "center";
  if (body.kind === "planet" && body.number != null) {
    const size = Math.max(9, Math.min(17, 0.42 * room));
    context.font = `600 ${size}px ${look().font}`;
    context.fillStyle = look().ink;
    context.fillText(String(body.number), x, y + 0.5);
    if (body.floating) floatMark(context, x, y, 0.78 * size + 3);
    return;
  }
  if (isInternal(body)) return ringFloat(context, body, view, x, y);
  if (body.floating) floatMark(context, x, y, Math.max(5, Math.min(10, 0.2 * room)));
  else {
    context.beginPath();
    context.arc(x, y, 2.2, 0, TURN);
    context.fillStyle = look().ink;
    context.fill();
  }
  if (isGear(body) && room > 22) {
    context.font = `11px ${look().font}`;
    context.fillStyle = look().ink;
    context.fillText(body.kind === "gear" ? body.label : body.kind, x, y + Math.min(0.52 * room, 20));
  }
}

function floatMark(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, TURN);
  context.lineWidth = 2;
  context.strokeStyle = look().ink;
  context.stroke();
}

/** The open ring of a floating ring gear stands on its rim, where it hides no teeth. */
function ringFloat(context, body, view, x, y) {
  const radius = (0.5 * (body.root + body.outer)) * view.scale;
  const size = Math.max(3.5, 0.34 * (body.outer - body.root) * view.scale);
  for (const angle of [-0.25 * Math.PI, 0.75 * Math.PI]) {
    floatMark(context, x + radius * Math.cos(angle), y + radius * Math.sin(angle), size);
  }
}

function stageNames(context, front, view) {
  if (front.stages.length < 2) return;
  context.font = `600 11px ${look().font}`;
  context.textAlign = "center";
  context.fillStyle = look().pale;
  for (const stage of front.stages) {
    const [x, y] = seen(view, (stage.box[0] + stage.box[1]) / 2, stage.box[3]);
    context.fillText(stage.name, x, Math.max(y - 12, 8));
  }
}

/** A mode shape: the bodies at rest in grey, and displaced by `swing` (-1..1) times the size [mm]. */
export function drawFrontMode(context, front, view, shape, size, swing) {
  const order = [...front.bodies].filter((body) => body.drawn);
  order.sort((a, b) => (ORDER[a.kind] ?? 3) - (ORDER[b.kind] ?? 3) || b.outer - a.outer);
  for (const body of order) {
    drawBody(context, body, view, placeAt(body, 0), { fill: null, stroke: look().other, width: 0.8 });
  }
  for (const body of order) {
    const place = displaced(body, shape, size * swing);
    const moves = amount(shape[body.index]);
    const colour = kindColour(body);
    const tone = moves < 0.03 ? { fill: null, stroke: look().edge } : { fill: translucent(colour, 0.1 + 0.3 * moves), stroke: colour };
    drawDisplaced(context, body, view, place, tone);
    if (body.kind === "planet" && body.number != null) {
      context.textAlign = "center";
      context.font = `600 ${Math.max(9, Math.min(15, 0.4 * body.root * view.scale))}px ${look().font}`;
      context.fillStyle = look().ink;
      context.fillText(String(body.number), ...seen(view, place.x, place.y));
    }
  }
  stageNames(context, front, view);
}

function drawDisplaced(context, body, view, place, tone) {
  context.save();
  context.translate(...seen(view, place.x, place.y));
  context.scale(view.scale, -view.scale);
  context.rotate(body.kind === "carrier" ? place.angle - body.phase : place.angle);
  context.lineWidth = 1.3 / view.scale;
  context.strokeStyle = tone.stroke;
  if (tone.fill) {
    context.fillStyle = tone.fill;
    const whole = new Path2D(body.path);
    if (isInternal(body)) whole.arc(0, 0, body.outer, 0, TURN);
    context.fill(whole, "evenodd");
  }
  context.stroke(body.path);
  if (isInternal(body)) {
    context.beginPath();
    context.arc(0, 0, body.outer, 0, TURN);
    context.stroke();
  }
  if (isGear(body)) turnMark(context, body, tone.stroke, 1.1 / view.scale);
  context.restore();
}

/** How far a body moves in a mode, 0..1 of the body that moves most. */
export const amount = (motion) => Math.min(1, Math.hypot(...motion));

/** Radius [mm] that turns a rotation of a mode shape, given as an arc, back into an angle. */
export const arcRadius = (body) => body.pitch ?? (body.pins.length ? body.pins[0].orbitRadius : body.outer) ?? 1;

function displaced(body, shape, size) {
  const [x, y, , , , rz] = shape[body.index];
  const rest = placeAt(body, 0);
  return { x: rest.x + size * x, y: rest.y + size * y, angle: rest.angle + (size * rz) / arcRadius(body) };
}

/** Body or mesh under a pixel: {mesh} or {body}, else null; the topmost first. */
export function underFront(front, view, seconds, loads, px, py) {
  for (const one of places(front, loads)) {
    const at = meshAt(one.mesh, front.bodies, seconds);
    const [x, y] = seen(view, at.x, at.y);
    if (Math.hypot(px - x, py - y) <= patch(one.mesh, front.bodies, view) + 2) return { mesh: one };
  }
  const order = [...front.bodies].filter((body) => body.drawn);
  order.sort((a, b) => (ORDER[b.kind] ?? 3) - (ORDER[a.kind] ?? 3) || a.outer - b.outer);
  for (const body of order) {
    const place = placeAt(body, seconds);
    const [x, y] = seen(view, place.x, place.y);
    const away = Math.hypot(px - x, py - y) / view.scale;
    const inside = isInternal(body) ? away >= body.tip && away <= body.outer : away <= body.outer;
    if (inside) return { body };
  }
  return null;
}

/** Key to the colours of the meshes: a bar from the least to the largest load. */
export function drawLoadKey(context, x, y, loads) {
  const width = 84;
  for (let i = 0; i < width; i++) {
    context.fillStyle = loadColour(i / (width - 1));
    context.fillRect(x + i, y - 4, 1.5, 8);
  }
  context.lineWidth = 1;
  context.strokeStyle = look().edge;
  context.strokeRect(x - 0.5, y - 4.5, width + 1.5, 9);
  context.font = `10.5px ${look().font}`;
  context.fillStyle = look().pale;
  context.textAlign = "right";
  context.fillText(short(loads.low, 3), x - 5, y + 0.5);
  context.textAlign = "left";
  context.fillText(`${short(loads.high, 3)}  force over the fair share`, x + width + 6, y + 0.5);
  return width;
}

