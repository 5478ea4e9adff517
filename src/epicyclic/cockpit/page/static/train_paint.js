// The display list of the train painted on a canvas: areas, strokes, symbols and texts in [mm], each by its role.
import { circle, colourBar, lines, write } from "./canvas.js";
import { faded, look, short, tinted, translucent, written } from "./look.js";

const TURN = 2 * Math.PI;

// What each role looks like; of those that this page says in another way nothing. Areas: opacity of their colour by light
// and dark. Strokes: width [px], colour (else that of the kind of body), opacity, dashes.
export const ROLES = {
  area: { body: [0.13, 0.2], cut: [0.22, 0.28], shaft: [0.13, 0.2], "pin of the housing": [0.2, 0.2], flange: [1, 1] },
  stroke: {
    turning: { width: 2.4 },
    helix: { width: 0.8, alpha: 0.6 },
    "pitch circle": { width: 0.7, colour: "pale", alpha: 0.7, dash: [7, 3, 1.5, 3] },
    axis: { width: 1, colour: "pale", dash: [9, 3, 2, 3] },
    held: { width: 1, colour: "ink" },
    "held hub": { width: 1, colour: "ink" },
    housing: { width: 1, colour: "ink" },
    stem: { width: 1.2, colour: "ink" },
    couplings: { width: 1.5, colour: "ink", dash: [2, 2] },
    mesh: { load: true },
    "mesh beside": { load: true },
    "hidden edge": null,
  },
  symbol: { mesh: glow, floats, "floats on the rim": floats, centre: point, elastic: bearing, rigid: bearing, axial: bars },
  text: { number, name, stage },
};
const PAINTERS = { area, stroke, symbol, text: symbol };

// What moves in a mode shape, and what stands still there.
const MOVING = ["body", "cut", "shaft", "turning", "helix", "number"];
const STANDING = ["axis", "housing", "stem", "stage"];

/** A display list {contours, shapes, bounds} with the outline of every shape made. */
export function prepared({ contours, shapes, bounds }) {
  const known = new Map();
  const outlined = shapes.map((shape) => {
    if (!shape.contours) return shape;
    const key = `${shape.type} ${shape.contours}`;
    if (!known.has(key)) known.set(key, outlineOf(shape.contours.map((index) => contours[index]), shape.type === "area"));
    return { ...shape, outline: known.get(key) };
  });
  return { shapes: outlined, bounds, contours };
}

const BENT = 144; // corners of a circle that bends

/**
 * Contours [times, radius, x, y, ...] about the origin of their shape [mm]; of an area all times are one closed line.
 * `bent(x, y)` is where a point of a ring that bends goes.
 */
function outlineOf(contours, isClosed, bent = null) {
  const outline = new Path2D();
  for (let [times, radius, ...points] of contours) {
    if (!points.length && bent) [times, points] = [BENT, [radius, 0]];
    if (!points.length) {
      outline.moveTo(radius, 0);
      outline.arc(0, 0, radius, 0, TURN);
    }
    for (let time = 0; time < times; time++) {
      const [c, s] = [Math.cos((TURN * time) / times), Math.sin((TURN * time) / times)];
      for (let i = 0; i < points.length; i += 2) {
        const at = [c * points[i] - s * points[i + 1], s * points[i] + c * points[i + 1]];
        const [x, y] = bent ? bent(...at) : at;
        if (i === 0 && (time === 0 || !isClosed)) outline.moveTo(x, y);
        else outline.lineTo(x, y);
      }
    }
    if (isClosed) outline.closePath();
  }
  return outline;
}

/**
 * Motion [outward, along] of the centre line of a ring at a polar angle, of its coordinates by name: a2, b2, .. of
 * w = a cos n psi + b sin n psi, v = (b cos n psi - a sin n psi)/n, and of a ring that stretches a0, c1, d1, ..
 */
export function deflected(names, values, angle) {
  let [out, along] = [0, 0];
  names.forEach((name, i) => {
    const [part, n] = [name[0], Number(name.slice(1))];
    const [c, s] = [Math.cos(n * angle) * values[i], Math.sin(n * angle) * values[i]];
    const [w, v] = part === "a" || part === "c" ? [c, -s] : [s, c];
    if (part === "a" || part === "b") [out, along] = [out + w, along + v / Math.max(n, 1)];
    else if (n === 1) [out, along] = [out + w, along - v];
    else along += v;
  });
  return [out, along];
}

/** Scale [px/mm] and middle of a view of the bounds [x0, x1, y0, y1] within a box of pixels. */
export function fitted(bounds, { x, y, width, height }) {
  const scale = Math.min(width / (bounds[1] - bounds[0]), height / (bounds[3] - bounds[2]));
  return { scale, x: x + width / 2, y: y + height / 2, middle: [(bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2] };
}

/** A place of the drawing [mm] in pixels; y upwards. */
const seen = (view, x, y) => [view.x + (x - view.middle[0]) * view.scale, view.y - (y - view.middle[1]) * view.scale];

/** Place and angle [x, y, turn] of a shape after so many seconds: its body turns, and goes around the axis of its stage. */
export function placeAt({ at: [x, y, turn] }, body, seconds) {
  if (!body) return [x, y, turn];
  const [c, s] = [Math.cos(body.orbit * seconds), Math.sin(body.orbit * seconds)];
  return [body.axis + c * (x - body.axis) - s * y, s * (x - body.axis) + c * y, turn + body.speed * seconds];
}

/** Factor that slows the fastest body to a fifth of a revolution a second, rounded to 1, 2 or 5 times a power of ten. */
export function slowing(bodies) {
  const fastest = Math.max(0, ...bodies.map((body) => Math.abs(body.speed)));
  if (!(fastest > 0)) return 1;
  const wanted = fastest / (0.2 * TURN);
  const power = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].find((one) => one * power >= wanted * (1 - 1e-9));
  return step * power;
}

/**
 * Paint a list in a view. `scene` has `place`, where a shape is, and for the meshes `loads` {values, colour, edge},
 * `meshes` of the head.
 */
export function paint(context, list, view, scene) {
  const whole = { ...scene, shapes: list.shapes };
  for (const shape of list.shapes) PAINTERS[shape.type](context, shape, view, whole);
}

/**
 * A mode shape: bodies at rest in grey, then displaced by `moved(shape)`; `amount(body)` 0..1 of what moves most.
 * `bent(shape)` moves the points of its outline, null of a body that does not bend.
 */
export function paintMode(context, list, view, moved, amount, bent = () => null) {
  const moving = list.shapes.filter((shape) => shape.body !== undefined && MOVING.includes(shape.role));
  const atRest = (shape) => shape.at;
  const grey = { fill: null, stroke: look().other, width: 0.8 };
  for (const shape of moving) if (shape.type === "area") area(context, shape, view, { place: atRest, tone: grey });
  for (const shape of moving) {
    const [moves, colour] = [amount(shape.body), kindColour(shape)];
    const tone = moves < 0.03 ? { fill: null, stroke: look().edge } : { fill: translucent(colour, 0.1 + 0.3 * moves), stroke: colour };
    const by = shape.contours && bent(shape);
    const contours = by && shape.contours.map((index) => list.contours[index]);
    const seenAs = by ? { ...shape, outline: outlineOf(contours, shape.type === "area", by) } : shape;
    PAINTERS[shape.type](context, seenAs, view, { place: moved, tone });
  }
  for (const shape of list.shapes) if (STANDING.includes(shape.role)) PAINTERS[shape.type](context, shape, view, { place: atRest });
}

const kindColour = ({ kind }) => (kind ? (look().kinds[kind] ?? look().kinds.shaft) : look().ink);

/** Run in the coordinates of a shape [mm]. */
function within(context, view, [x, y, turn], draw) {
  context.save();
  context.translate(...seen(view, x, y));
  context.scale(view.scale, -view.scale);
  context.rotate(turn);
  draw();
  context.restore();
}

/** An area is opaque, so that what lies behind it is not seen through it; in a mode shape it has a tone of its own. */
function area(context, shape, view, { place, tone }) {
  const colour = kindColour(shape);
  const [light, dark] = ROLES.area[shape.role];
  within(context, view, place(shape), () => {
    context.fillStyle = tone ? tone.fill : tinted(colour, look().dark ? dark : light);
    if (!tone || tone.fill) context.fill(shape.outline, "evenodd");
    context.lineWidth = (tone?.width ?? 1.1) / view.scale;
    context.strokeStyle = tone ? tone.stroke : colour;
    context.stroke(shape.outline);
  });
}

function stroke(context, shape, view, scene) {
  const style = ROLES.stroke[shape.role];
  if (style === null) return;
  if (style.load) return meshLine(context, shape, view, scene);
  const colour = scene.tone?.stroke ?? (style.colour ? look()[style.colour] : kindColour(shape));
  within(context, view, scene.place(shape), () => {
    context.setLineDash((style.dash ?? []).map((part) => part / view.scale));
    context.lineWidth = style.width / view.scale;
    context.strokeStyle = style.alpha ? translucent(colour, style.alpha) : colour;
    context.stroke(shape.outline);
  });
}

function symbol(context, shape, view, scene) {
  const [x, y] = seen(view, ...scene.place(shape));
  context.lineWidth = 1;
  context.strokeStyle = context.fillStyle = look().ink;
  const alpha = context.globalAlpha; // of what is older than the state; its texts stay to be read
  if (shape.type === "text") context.globalAlpha = 1;
  ROLES[shape.type][shape.role](context, x, y, shape, view, scene);
  context.globalAlpha = alpha;
}

/** Of the meshes of a shape the most loaded one, -1 where no load is known. */
function worst({ meshes }, { values }) {
  return meshes.reduce((best, index) => (Number.isFinite(values[index]) && !(values[index] <= values[best]) ? index : best), -1);
}

/** Colours [edge, fill] of the load of a mesh. */
const coloursOf = (index, loads) => (index < 0 ? [look().edge, look().other] : [loads.edge(loads.values[index]), loads.colour(loads.values[index])]);

/** A mesh of the section in the colour of its load, of the planets that lie over each other there the most loaded. */
function meshLine(context, shape, view, { loads, place }) {
  const [edge, fill] = coloursOf(worst(shape, loads), loads);
  within(context, view, place(shape), () => {
    context.lineCap = "round";
    for (const [width, colour] of [[6, edge], [4, fill]]) {
      context.lineWidth = width / view.scale;
      context.strokeStyle = colour;
      context.stroke(shape.outline);
    }
  });
}

/** Radius [px] of the patch in which the teeth of a mesh take the colour of its load. */
const patch = ({ room }, view) => Math.min(Math.max(Math.min(room, 100) * view.scale, 11), 26);

/** The teeth at a pitch point in the colour of the load of their mesh, strongest where they touch. */
function glow(context, x, y, shape, view, scene) {
  const { loads, meshes, shapes, place } = scene;
  if (![...loads.values].some(Number.isFinite)) return; // a train without a load: its teeth alone
  const radius = patch(shape, view);
  const index = worst(shape, loads);
  const [edge, colour] = coloursOf(index, loads);
  const pair = meshes[index < 0 ? shape.meshes[0] : index].bodies;
  const bodies = shape.meshes.flatMap((one) => meshes[one].bodies); // of both halves, one of which has the number
  const shine = context.createRadialGradient(x, y, 0.6 * radius, x, y, radius);
  shine.addColorStop(0, colour);
  shine.addColorStop(1, faded(colour, 0.35));
  context.save();
  circle(context, x, y, radius);
  context.clip();
  for (const gear of shapes.filter((one) => one.type === "area" && pair.includes(one.body))) {
    const [gx, gy, turn] = place(gear);
    const teeth = new Path2D();
    teeth.addPath(gear.outline, new DOMMatrix([view.scale, 0, 0, -view.scale, ...seen(view, gx, gy)]).rotate((360 * turn) / TURN));
    context.fillStyle = shine;
    context.fill(teeth, "evenodd");
    context.lineWidth = 1.2;
    context.strokeStyle = look().surface;
    context.stroke(teeth);
  }
  context.restore();
  circle(context, x, y, radius);
  context.lineWidth = 1.3;
  context.strokeStyle = edge;
  context.stroke();
  const hosts = shapes.filter((one) => one.type === "text" && bodies.includes(one.body));
  const host = hosts.find((one) => one.role === "number") ?? hosts[0];
  if (index >= 0 && host) load(context, x, y, radius, loads.values[index], seen(view, ...place(host)), host.room * view.scale);
}

/** The load beside its mesh, inside the planet, where that has room for two of them and its number. */
function load(context, x, y, radius, value, [cx, cy], room) {
  if (room < radius + 38) return;
  const away = Math.hypot(cx - x, cy - y) || 1;
  // Clear of the patch in every direction: a number of three digits is twice as wide as tall.
  const reach = radius + 4 + (12 * Math.abs(cx - x) + 6 * Math.abs(cy - y)) / away;
  context.globalAlpha = 1;
  write(context, written(value, 3), x + ((cx - x) / away) * reach, y + ((cy - y) / away) * reach, { size: 10.5, weight: 600, align: "center" });
}

/** A body that floats has an open ring about its centre, or on its rim; another a point. */
function floats(context, x, y, { room, role }, view) {
  circle(context, x, y, role === "floats" ? Math.max(5, Math.min(10, 0.2 * room * view.scale)) : Math.max(3.5, 0.34 * room * view.scale));
  context.lineWidth = 2;
  context.stroke();
}

function point(context, x, y) {
  circle(context, x, y, 2.2);
  context.fill();
}

/** A bearing or support: a crossed square, filled where it is rigid. */
function bearing(context, x, y, { role }) {
  context.fillStyle = role === "rigid" ? look().edge : look().surface;
  context.fillRect(x - 3.5, y - 3.5, 7, 7);
  context.strokeRect(x - 3.5, y - 3.5, 7, 7);
  lines(context, look().ink, 1, [-3.5, 3.5].map((way) => [[x - 3.5, y - way], [x + 3.5, y + way]]));
}

/** Bars on both sides of a bearing or support that holds axially. */
function bars(context, x, y) {
  lines(context, look().ink, 1, [-5.5, 5.5].map((way) => [[x + way, y - 4.5], [x + way, y + 4.5]]));
}

function number(context, x, y, { room, text }, view) {
  write(context, text, x, y + 0.5, { size: Math.max(9, Math.min(17, 0.42 * room * view.scale)), weight: 600, align: "center" });
}

function name(context, x, y, { room, text }, view) {
  if (room * view.scale > 22) write(context, text, x, y + Math.min(0.52 * room * view.scale, 20), { align: "center" });
}

function stage(context, x, y, { text }) {
  write(context, text, x, Math.max(y - 12, 8), { weight: 600, align: "center", colour: look().pale });
}

let asked = null; // a context that only answers questions about outlines

/** The shape under a pixel that is a mesh or of a body, the topmost first, else null. */
export function under(list, view, place, px, py) {
  asked ??= document.createElement("canvas").getContext("2d");
  const meshes = list.shapes.filter((shape) => shape.meshes);
  const areas = list.shapes.filter((shape) => shape.type === "area" && shape.body !== undefined).reverse();
  return [...meshes, ...areas].find((shape) => covers(shape, view, place(shape), px, py)) ?? null;
}

function covers(shape, view, [x, y, turn], px, py) {
  const [sx, sy] = seen(view, x, y);
  if (shape.type === "symbol") return Math.hypot(px - sx, py - sy) <= patch(shape, view) + 2;
  const [dx, dy] = [(px - sx) / view.scale, (sy - py) / view.scale];
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  const [u, v] = [c * dx + s * dy, c * dy - s * dx];
  if (shape.type === "area") return asked.isPointInPath(shape.outline, u, v, "evenodd");
  asked.lineWidth = 8 / view.scale;
  return asked.isPointInStroke(shape.outline, u, v);
}

/** Key to the colours of the meshes: a bar from the least to the largest load. */
export function drawLoadKey(context, x, y, loads) {
  const width = 84;
  colourBar(context, x, y - 4, width, 8);
  context.lineWidth = 1;
  context.strokeStyle = look().edge;
  context.strokeRect(x - 0.5, y - 4.5, width + 1.5, 9);
  write(context, short(loads.low, 3), x - 5, y + 0.5, { size: 10.5, align: "right", colour: look().pale });
  write(context, `${short(loads.high, 3)}  force over the fair share`, x + width + 6, y + 0.5, { size: 10.5, colour: look().pale });
}
