// The film of water on a face through a day: the march of schemas/formats/htt-1.md.
const [RETURNS, DAYS] = [1e-9, 30]; // of the capacity, by which a film that returns may differ; days marched through at most

// The root r of r^3 + loss r^2 = water, 0 to 1, by Newton's method from above.
function root(loss, water) {
  if (!(water > 0)) return 0;
  let side = Math.min(Math.cbrt(water), loss > 0 ? Math.sqrt(water / loss) : Infinity);
  for (let pass = 0; pass < 60; pass++) {
    const change = (side * side * (side + loss) - water) / (side * (3 * side + 2 * loss));
    side -= change;
    if (Math.abs(change) <= 1e-16 * side) break;
  }
  return Math.min(side, 1);
}

// `steps` hold of each step of the day: the heat loss of a whole film above that of the dry face and its evaporation by offset, sunlight that
// it absorbs more, that of the dry face, and rain. Without `before`, the water at midnight before the day, the film returns after the day.
export class Film {
  constructor(steps, capacity, before) {
    Object.assign(this, { steps, capacity, before, returns: before === undefined, scale: 86400 / steps.length / capacity });
  }

  // Sunlight that a whole film absorbs more under a change of heat.
  light(absorbed) {
    return this.steps.map(({ sunlight, drySunlight }, k) => sunlight * Math.min(Math.max(1 + (drySunlight > 0 ? absorbed[k] / drySunlight : 0), 0), 1));
  }

  // Share that the film covers at each step, and the water at the end of the day over the capacity.
  shares(evaporation, start) {
    let water = start;
    const covered = this.steps.map(({ rain }, k) => {
      const gain = (Math.max(-evaporation[k], 0) + rain) * this.scale;
      const side = root(Math.max(evaporation[k], 0) * this.scale, water + gain);
      water = side ** 3;
      return side * side;
    });
    return { covered, end: water };
  }

  // Share at each step of the file's own day, the water before it and at its end.
  inTheOpen(evaporation) {
    if (!this.returns) {
      const start = Math.min(this.before / this.capacity, 1);
      return { covered: this.shares(evaporation, start).covered, start, end: start };
    }
    let [start, day] = [0, this.shares(evaporation, 0)];
    for (let days = 1; days < DAYS && day.end - start > RETURNS; days++) {
      start = day.end;
      day = this.shares(evaporation, start);
    }
    return { ...day, start };
  }
}
