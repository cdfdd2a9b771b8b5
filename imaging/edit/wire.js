// Live wire (Mortensen and Barrett 1995): the cheapest way over a picture that is cheap along
// ridges, from where the hand was to where it points.

const BUCKETS = 2048; // more than the dearest step: 255, three times for its colour, aslant
const UNLIKE = 60; // of colour (sRGB) from which on a place is three times as dear

class Wire {
  // `cost`: 1 (on a ridge) to 255; `rgba`: the photograph, as coarse; one place is so many pixels wide
  // and high as `scale` says.
  constructor(cost, rgba, width, height, scale) {
    Object.assign(this, { cost, rgba, width, height, scale });
    this.before = new Int32Array(width * height);
    this.dear = new Uint16Array(width * height);
  }

  static async from(ridges, photograph, scale) {
    const picture = await decoded(ridges), { width, height } = picture;
    const grey = pixelsOf(picture, width, height), cost = new Uint8Array(width * height);
    for (let i = 0; i < cost.length; i++) cost[i] = Math.max(1, grey[4 * i]);
    return new Wire(cost, pixelsOf(await decoded(photograph), width, height), width, height, scale);
  }

  place([x, y]) {
    const column = Math.min(this.width - 1, Math.max(0, Math.round((x + 0.5) / this.scale[0] - 0.5)));
    const row = Math.min(this.height - 1, Math.max(0, Math.round((y + 0.5) / this.scale[1] - 0.5)));
    return row * this.width + column;
  }

  point(place) {
    const row = Math.floor(place / this.width), column = place % this.width;
    return [(column + 0.5) * this.scale[0] - 0.5, (row + 0.5) * this.scale[1] - 0.5];
  }

  // Begin at a point (Dijkstra, with buckets of equal price).
  start(point) {
    this.seed = point;
    this.prefer(this.place(point));
    this.price = new Uint32Array(this.cost.length).fill(0xffffffff);
    this.buckets = Array.from({ length: BUCKETS }, () => []);
    this.before.fill(-1);
    [this.now, this.left] = [0, 1];
    this.price[this.place(point)] = 0;
    this.buckets[0].push(this.place(point));
  }

  // Make places dear whose colour is unlike that of the ridge the hand began at.
  prefer(seed) {
    const { cost, rgba, dear, width } = this;
    let at = seed;
    for (let dy = -2; dy <= 2; dy++) {
      for (let dx = -2; dx <= 2; dx++) {
        const near = seed + dy * width + dx;
        if (near >= 0 && near < cost.length && cost[near] < cost[at]) at = near;
      }
    }
    const [r, g, b] = rgba.subarray(4 * at, 4 * at + 3);
    for (let i = 0; i < cost.length; i++) {
      const off = Math.hypot(rgba[4 * i] - r, rgba[4 * i + 1] - g, rgba[4 * i + 2] - b);
      dear[i] = cost[i] * (1 + 2 * Math.min(off / UNLIKE, 1));
    }
  }

  // Go on until the cheapest way to a place is known: near places cost little time.
  reach(place) {
    const { price } = this;
    while (this.left && price[place] >= this.now) {
      const bucket = this.buckets[this.now & (BUCKETS - 1)];
      while (bucket.length) {
        const at = bucket.pop();
        this.left--;
        if (price[at] === this.now) this.spread(at);
      }
      this.now++;
    }
  }

  spread(at) {
    const { dear: cost, width, price, before } = this, column = at % width;
    for (let k = 0; k < 9; k++) {
      const dx = (k % 3) - 1, dy = Math.floor(k / 3) - 1, to = at + dy * width + dx;
      if (column + dx < 0 || column + dx >= width || to < 0 || to >= cost.length) continue;
      const sum = this.now + (dx && dy ? Math.round(Math.SQRT2 * cost[to]) : cost[to]);
      if (sum < price[to]) {
        price[to] = sum;
        before[to] = at;
        this.buckets[sum & (BUCKETS - 1)].push(to);
        this.left++;
      }
    }
  }

  // The way from where it was started, its ends where the hand put them.
  to(point) {
    const way = [];
    this.reach(this.place(point));
    for (let at = this.place(point); at >= 0; at = this.before[at]) way.push(this.point(at));
    way.reverse();
    way[0] = this.seed;
    if (way.length > 1) way[way.length - 1] = point;
    else way.push(point);
    return simplified(smooth(way), 0.35 * this.scale[0]);
  }
}

async function decoded(source) {
  const picture = new Image();
  picture.src = source;
  await picture.decode();
  return picture;
}

// Colours (RGBA) of a picture, as large as asked.
function pixelsOf(picture, width, height) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const pencil = canvas.getContext("2d", { willReadFrequently: true });
  pencil.drawImage(picture, 0, 0, width, height);
  return pencil.getImageData(0, 0, width, height).data;
}

// Means of three neighbours: steps of whole places are no bends.
function smooth(line) {
  for (let round = 0; round < 3; round++) {
    line = line.map((p, i) => i === 0 || i === line.length - 1 ? p
      : [0, 1].map((k) => (line[i - 1][k] + 2 * p[k] + line[i + 1][k]) / 4));
  }
  return line;
}
