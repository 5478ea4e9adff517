// Places for labels beside their points: within bounds, apart from each other and from what must stay visible.

const meet = (a, b) => a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;
const within = (a, b) => a.x >= b.x && a.x + a.w <= b.x + b.w && a.y >= b.y && a.y + a.h <= b.y + b.h;

/** Places around a point, the nearest first: above, aside, then further up and to both sides, last below. */
function candidates({ x, y, w, h }) {
  const found = [];
  for (const lift of [7, 22, 38, 56, 76, 98]) {
    for (const side of [-w / 2, 8, -w - 8, 26, -w - 26]) found.push({ x: x + side, y: y - lift - h, w, h, cost: lift + 0.12 * Math.abs(side + w / 2) });
  }
  for (const side of [10, -w - 10]) found.push({ x: x + side, y: y - h / 2, w, h, cost: 16 });
  for (const side of [8, -w - 8]) found.push({ x: x + side, y: y + 7, w, h, cost: 60 });
  return found;
}

/**
 * Boxes {x, y, w, h} for items {x, y, w, h}, the first the most important, null where there is no room.
 * `obstacles` are boxes that stay free; `points` [x, y] of curves are covered only where nothing else is left.
 */
export function placed(items, bounds, obstacles, points) {
  const taken = [...obstacles];
  return items.map((item) => {
    let best = null;
    for (const box of candidates(item)) {
      // One pixel of air on every side.
      const aired = { x: box.x - 1, y: box.y - 1, w: box.w + 2, h: box.h + 2 };
      if (!within(aired, bounds) || taken.some((other) => meet(aired, other))) continue;
      const covered = points.reduce((count, [x, y]) => count + (x > box.x && x < box.x + box.w && y > box.y && y < box.y + box.h), 0);
      const cost = box.cost + 14 * covered;
      if (!best || cost < best.cost) best = { ...box, cost };
    }
    if (best) taken.push(best);
    return best;
  });
}
