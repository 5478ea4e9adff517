// Where the bodies of a train stand, how their teeth are turned into mesh, and how they move; pure, in [mm] and [rad].

const TURN = 2 * Math.PI;
const PRESSURE = Math.tan((20 * Math.PI) / 180); // flanks of the drawn teeth: a rack of 20 degrees

const COAXIAL = ["sun", "ring", "carrier"];

export const isInternal = (body) => body.internal ?? (body.tip != null && body.root != null && body.tip < body.root);
export const isGear = (body) => body.teeth > 0 && body.pitch > 0;

/** Radius of a body as drawn: rim of an internal gear, tip of another, pins of a carrier. */
export function outerRadius(body, pinRadius = 0) {
  if (isInternal(body)) return Math.max(body.outer ?? 0, body.root + Math.max(0.04 * body.root, 1.2 * (body.root - body.tip)));
  return body.tip ?? body.pitch ?? pinRadius;
}

/** Outline of a gear about its own centre, tooth 0 on the x axis: a Path2D [mm] of trapezoids with its true teeth. */
export function outline(body) {
  const path = new Path2D();
  const pitch = body.pitch;
  const depth = (2.25 * 2 * pitch) / body.teeth; // of a standard tooth, where the drawing gives no tip or root
  const tip = body.tip ?? pitch + depth / 2.25;
  const root = body.root ?? pitch - (1.25 * depth) / 2.25;
  const step = TURN / body.teeth;
  const half = 0.243 * step; // a little under a quarter of the pitch: backlash, so that flanks do not merge
  const atTip = Math.max(half - (Math.abs(tip - pitch) * PRESSURE) / pitch, 0.1 * step);
  const atRoot = Math.min(half + (Math.abs(pitch - root) * PRESSURE) / pitch, 0.46 * step);
  const corners = [[root, -atRoot], [pitch, -half], [tip, -atTip], [tip, atTip], [pitch, half], [root, atRoot]];
  for (let tooth = 0; tooth < body.teeth; tooth++) {
    for (const [radius, angle] of corners) {
      const x = radius * Math.cos(angle + tooth * step);
      const y = radius * Math.sin(angle + tooth * step);
      if (tooth === 0 && angle === -atRoot) path.moveTo(x, y);
      else path.lineTo(x, y);
    }
  }
  path.closePath();
  return path;
}

/** Outline of a carrier about its axis: a plate whose lobes hold the pins at the angles given. */
export function plate(radius, angles) {
  const path = new Path2D();
  for (let i = 0; i <= 180; i++) {
    const angle = (TURN * i) / 180;
    let reach = 0.6 * radius;
    for (const pin of angles) {
      const away = Math.atan2(Math.sin(angle - pin), Math.cos(angle - pin));
      reach = Math.max(reach, radius * (0.6 + 0.4 * Math.exp(-((away / 0.4) ** 4))));
    }
    if (i === 0) path.moveTo(reach * Math.cos(angle), reach * Math.sin(angle));
    else path.lineTo(reach * Math.cos(angle), reach * Math.sin(angle));
  }
  path.closePath();
  return path;
}

/** Axis of every stage: that of its sun, ring or carrier, else the middle of its planets, else its first body. */
function axes(bodies) {
  const found = new Map();
  for (const stage of new Set(bodies.map((body) => body.stage))) {
    const own = bodies.filter((body) => body.stage === stage);
    const centre = own.find((body) => COAXIAL.includes(body.kind));
    const planets = own.filter((body) => body.kind === "planet");
    const mean = (key) => planets.reduce((sum, body) => sum + body[key], 0) / planets.length;
    if (centre) found.set(stage, { x: centre.x, y: centre.y });
    else if (planets.length > 1) found.set(stage, { x: mean("x"), y: mean("y") });
    else found.set(stage, { x: own[0].x, y: own[0].y });
  }
  return found;
}

/** Angle by which each gear is turned so that its teeth stand in the gaps of its mates, found along the meshes. */
export function phases(bodies, meshes) {
  const turned = new Array(bodies.length).fill(0);
  const seen = new Set();
  const mates = bodies.map(() => []);
  for (const { bodies: [a, b] } of meshes) {
    if (!isGear(bodies[a] ?? {}) || !isGear(bodies[b] ?? {})) continue;
    mates[a].push(b);
    mates[b].push(a);
  }
  for (let start = 0; start < bodies.length; start++) {
    if (seen.has(start)) continue;
    seen.add(start);
    const queue = [start];
    while (queue.length) {
      const one = queue.shift();
      for (const other of mates[one]) {
        if (seen.has(other)) continue;
        seen.add(other);
        turned[other] = mated(bodies[one], turned[one], bodies[other]);
        queue.push(other);
      }
    }
  }
  return turned;
}

/** Angle of `b` at which a gap of it faces the tooth of `a`, which is turned by `angle`. */
function mated(a, angle, b) {
  const internal = isInternal(a) || isInternal(b);
  // An internal mesh lies on the far side of the inner gear, seen from the ring: one direction serves both gears.
  const ring = isInternal(a) ? a : b;
  const inner = isInternal(a) ? b : a;
  const from = internal ? Math.atan2(inner.y - ring.y, inner.x - ring.x) : Math.atan2(b.y - a.y, b.x - a.x);
  const share = ((from - angle) * a.teeth) / TURN; // place within the pitch of `a`, 0 on the middle of a tooth
  const facing = internal ? from : from + Math.PI;
  const own = internal ? share + 0.5 : -share - 0.5;
  return facing - (own * TURN) / b.teeth;
}

/** Boxes [x0, x1, y0, y1] laid side by side where they lie over each other: how far each is moved along x and y. */
export function beside(boxes, gapShare = 0.06) {
  const meet = (a, b) => a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3];
  const clash = boxes.some((a, i) => boxes.slice(i + 1).some((b) => meet(a, b)));
  if (!clash) return boxes.map(() => [0, 0]);
  const tallest = Math.max(...boxes.map((box) => box[3] - box[2]));
  let at = 0;
  return boxes.map((box) => {
    const moved = [at - box[0], -(box[2] + box[3]) / 2];
    at += box[1] - box[0] + gapShare * tallest;
    return moved;
  });
}

const APART = 0.03; // of the centre distance: pitch radii that miss it by more are not those of the teeth that mesh

/**
 * Bodies and meshes whose radii fit their centre distances. A published train may give tooth counts and a centre distance
 * beside radii that belong to neither; its gears are then drawn by the first two.
 */
export function fittingRadii(bodies, meshes) {
  const factors = new Map();
  for (const { bodies: [a, b] } of meshes) {
    const pair = [bodies[a], bodies[b]];
    if (!pair.every((body) => body && isGear(body))) continue;
    const distance = Math.hypot(pair[0].x - pair[1].x, pair[0].y - pair[1].y);
    const signs = pair.map((body) => (isInternal(body) ? -1 : 1));
    const sum = (of) => Math.abs(signs[0] * of(pair[0]) + signs[1] * of(pair[1]));
    if (Math.abs(sum((body) => body.pitch) - distance) <= APART * distance) continue;
    const perTooth = distance / sum((body) => body.teeth);
    for (const index of [a, b]) if (!factors.has(index)) factors.set(index, (perTooth * bodies[index].teeth) / bodies[index].pitch);
  }
  if (!factors.size) return { bodies, meshes };
  const scaled = (value, factor) => (value == null ? value : value * factor);
  const fitted = bodies.map((body, index) => {
    const factor = factors.get(index);
    if (!factor) return body;
    const radii = ["pitch", "tip", "root", "outer"].map((key) => [key, scaled(body[key], factor)]);
    return { ...body, ...Object.fromEntries(radii) };
  });
  return { bodies: fitted, meshes: meshes.map((mesh) => (factors.has(mesh.bodies[0]) ? { ...mesh, ...pitchPoint(mesh, fitted) } : mesh)) };
}

/** Where the pitch circles of a mesh touch: on the line of centres. */
function pitchPoint(mesh, bodies) {
  const [a, b] = mesh.bodies.map((index) => bodies[index]);
  const [from, to] = isInternal(b) ? [b, a] : [a, b];
  const away = Math.hypot(to.x - from.x, to.y - from.y) || 1;
  return { x: from.x + (from.pitch * (to.x - from.x)) / away, y: from.y + (from.pitch * (to.y - from.y)) / away };
}

/** The train as it is drawn from the front: bodies with their place, axis, phase and outlines, stages, bounds. */
export function frontView(train) {
  const { bodies, meshes } = fittingRadii(train.bodies, train.meshes);
  const centres = axes(bodies);
  const turned = phases(bodies, meshes);
  const placed = bodies.map((body, index) => {
    const axis = centres.get(body.stage);
    return { ...body, index, axis, orbitRadius: Math.hypot(body.x - axis.x, body.y - axis.y), phase: Number.isFinite(body.turn) ? body.turn : turned[index] };
  });
  for (const body of placed) {
    const pins = placed.filter((other) => other.kind === "planet" && other.stage === body.stage);
    body.pins = body.kind === "carrier" ? pins : [];
    const pinRadius = pins.length ? Math.max(...pins.map((pin) => pin.orbitRadius + 0.3 * (pin.pitch ?? 0))) : 0;
    body.outer = body.kind === "carrier" ? (body.outer || pinRadius || (body.tip ?? 0)) : outerRadius(body);
    body.drawn = body.outer > 0 && (isGear(body) || body.pins.length > 0);
  }
  const names = [...new Set(placed.filter((body) => body.drawn).map((body) => body.stage))];
  const boxes = names.map((name) => box(placed.filter((body) => body.drawn && body.stage === name)));
  const moved = beside(boxes);
  const stages = names.map((name, i) => ({ name, move: moved[i], box: shift(boxes[i], moved[i]) }));
  for (const body of placed) {
    const stage = stages.find((one) => one.name === body.stage);
    body.move = stage ? stage.move : [0, 0];
    if (!body.drawn) continue;
    body.path = isGear(body) ? outline(body) : plate(body.outer, body.pins.map((pin) => angleAbout(pin)));
  }
  return { bodies: placed, meshes, stages, bounds: around(stages.map((stage) => stage.box)), title: train.title };
}

export const angleAbout = (body) => Math.atan2(body.y - body.axis.y, body.x - body.axis.x);

function box(bodies) {
  const ends = bodies.map((body) => [body.x - body.outer, body.x + body.outer, body.y - body.outer, body.y + body.outer]);
  return around(ends);
}

function around(boxes) {
  if (!boxes.length) return [-1, 1, -1, 1];
  const least = (i) => Math.min(...boxes.map((one) => one[i]));
  const most = (i) => Math.max(...boxes.map((one) => one[i]));
  return [least(0), most(1), least(2), most(3)];
}

const shift = (one, [x, y]) => [one[0] + x, one[1] + x, one[2] + y, one[3] + y];

/** Place and angle of a body after so many seconds, speeds as given: {x, y, angle}, stages moved apart. */
export function placeAt(body, seconds) {
  const angle = body.phase + (body.speed ?? 0) * seconds;
  const turn = (body.orbit ?? 0) * seconds;
  const [x, y] = rotated(body.x, body.y, body.axis, turn);
  return { x: x + body.move[0], y: y + body.move[1], angle };
}

/** Place of a mesh after so many seconds: it goes around with its planet. */
export function meshAt(mesh, bodies, seconds) {
  const [a, b] = mesh.bodies.map((index) => bodies[index]);
  const carried = b.orbit ? b : a;
  const [x, y] = rotated(mesh.x, mesh.y, carried.axis, (carried.orbit ?? 0) * seconds);
  return { x: x + carried.move[0], y: y + carried.move[1] };
}

function rotated(x, y, axis, angle) {
  if (!angle) return [x, y];
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [axis.x + c * (x - axis.x) - s * (y - axis.y), axis.y + s * (x - axis.x) + c * (y - axis.y)];
}

/** Factor that slows the fastest body to a fifth of a revolution a second, rounded to 1, 2 or 5 times a power of ten. */
export function slowing(bodies) {
  const fastest = Math.max(0, ...bodies.filter((body) => body.drawn).map((body) => Math.abs(body.speed ?? 0)));
  if (!(fastest > 0)) return 1;
  const wanted = fastest / (0.2 * TURN);
  const power = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].find((one) => one * power >= wanted * (1 - 1e-9));
  return step * power;
}
