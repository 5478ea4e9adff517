// Places for labels beside their points: within bounds, apart from each other and from what must stay visible.

const CELL = 4; // [px] raster in which points of curves are counted
const STEP = { aside: 10, up: 8 }; // [px] between two places that are tried
const REACH = { aside: 44, up: 112 }; // [px] furthest place that is tried
const COST = { point: 12, crossing: 45, below: 50, aside: 0.35 }; // against one pixel of distance from the point

const meet = (a, b) => a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;
const within = (a, b) => a.x >= b.x && a.x + a.w <= b.x + b.w && a.y >= b.y && a.y + a.h <= b.y + b.h;

/** Place of a box that lies nearest to a point. */
export const nearestOf = (box, { x, y }) => [Math.max(box.x, Math.min(x, box.x + box.w)), Math.max(box.y, Math.min(y, box.y + box.h))];

/** Places tried around a point: all heights above it, from the left of it to the right; a few beside and below. */
function candidates({ x, y, w, h }) {
  const found = [];
  for (let lift = 6; lift <= REACH.up; lift += STEP.up) {
    for (let left = x - w - REACH.aside; left <= x + REACH.aside; left += STEP.aside) found.push({ x: left, y: y - lift - h, w, h, more: 0 });
    found.push({ x: x - w / 2, y: y - lift - h, w, h, more: 0 });
  }
  for (const left of [x + 9, x - w - 9]) found.push({ x: left, y: y - h / 2, w, h, more: 0 });
  for (const left of [x + 8, x - w - 8]) found.push({ x: left, y: y + 6, w, h, more: COST.below });
  return found;
}

/** Counts of points in any box, by sums over a raster. */
class Counts {
  constructor(bounds, points) {
    Object.assign(this, { x: bounds.x, y: bounds.y, wide: Math.ceil(bounds.w / CELL) + 1, tall: Math.ceil(bounds.h / CELL) + 1 });
    const stride = this.wide + 1;
    this.sums = new Uint32Array(stride * (this.tall + 1));
    for (const [px, py] of points) {
      const [i, j] = [Math.floor((px - this.x) / CELL), Math.floor((py - this.y) / CELL)];
      if (i >= 0 && i < this.wide && j >= 0 && j < this.tall) this.sums[(j + 1) * stride + i + 1] += 1;
    }
    for (let j = 1; j <= this.tall; j++) {
      for (let i = 1; i <= this.wide; i++) {
        const at = j * stride + i;
        this.sums[at] += this.sums[at - 1] + this.sums[at - stride] - this.sums[at - stride - 1];
      }
    }
  }

  of({ x, y, w, h }) {
    const stride = this.wide + 1;
    const column = (value) => Math.max(0, Math.min(this.wide, Math.floor((value - this.x) / CELL)));
    const row = (value) => Math.max(0, Math.min(this.tall, Math.floor((value - this.y) / CELL)));
    const [i0, i1, j0, j1] = [column(x), column(x + w + CELL), row(y), row(y + h + CELL)];
    return this.sums[j1 * stride + i1] - this.sums[j0 * stride + i1] - this.sums[j1 * stride + i0] + this.sums[j0 * stride + i0];
  }
}

/** Whether the straight line between two points goes through a box. */
function crosses([x0, y0], [x1, y1], box) {
  for (let i = 1; i < 10; i++) {
    const [x, y] = [x0 + ((x1 - x0) * i) / 10, y0 + ((y1 - y0) * i) / 10];
    if (x > box.x && x < box.x + box.w && y > box.y && y < box.y + box.h) return true;
  }
  return false;
}

/**
 * Boxes {x, y, w, h} for items {x, y, w, h}, the first the most important, null where there is no room.
 * `obstacles` are boxes that stay free; `points` [x, y] of curves are covered only where nothing else is left.
 */
export function placed(items, bounds, obstacles, points) {
  const counts = new Counts(bounds, points);
  const taken = [...obstacles];
  const lines = [];
  return items.map((item) => {
    let best = null;
    for (const box of candidates(item)) {
      // One pixel of air on every side.
      const aired = { x: box.x - 1, y: box.y - 1, w: box.w + 2, h: box.h + 2 };
      if (!within(aired, bounds) || taken.some((other) => meet(aired, other))) continue;
      const end = nearestOf(box, item);
      const away = Math.hypot(end[0] - item.x, end[1] - item.y);
      const lean = COST.aside * Math.abs(box.x + box.w / 2 - item.x);
      let cost = away + lean + box.more + COST.point * counts.of(box);
      if (best && cost >= best.cost) continue;
      const own = [item.x, item.y];
      const through = taken.slice(obstacles.length).some((other) => crosses(own, end, other)) || lines.some(([a, b]) => crosses(a, b, box));
      if (through) cost += COST.crossing;
      if (!best || cost < best.cost) best = { ...box, cost, end };
    }
    if (best) {
      taken.push(best);
      lines.push([[item.x, item.y], best.end]);
    }
    return best;
  });
}
