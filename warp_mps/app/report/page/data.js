// The page's data: JSON, and arrays that encode.py packed.

const DATA = JSON.parse(document.getElementById("data").textContent);
const MISSING = 65535;

/** Bytes of the base64 text of an element. */
function blockBytes(number) {
  const raw = atob(document.getElementById(`block${number}`).textContent);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Whole numbers of an array [frames, n], one frame after the other. */
async function unpack(item, frames) {
  const planes = await inflate(blockBytes(item.block));
  const count = planes.length / 2, each = count / frames;
  const numbers = new Uint16Array(count);
  for (let i = 0; i < count; i++) {
    const code = planes[i] | (planes[count + i] << 8);
    numbers[i] = (code >>> 1) ^ -(code & 1);
  }
  // the numbers wrap around at 2^16, as the differences did
  for (let order = 0; order < item.order; order++) {
    for (let i = each; i < count; i++) numbers[i] += numbers[i - each];
  }
  return numbers;
}

/** Positions as whole numbers, particle by particle, from [frames, axis, n]. */
async function unpackPlaces(cloud, axes) {
  const frames = cloud.places.frames, count = cloud.count;
  const apart = await unpack(cloud.places, frames);
  const places = new Uint16Array(apart.length);
  for (let frame = 0; frame < frames; frame++) {
    const start = frame * axes * count;
    for (let axis = 0; axis < axes; axis++) {
      for (let i = 0; i < count; i++) places[start + i * axes + axis] = apart[start + axis * count + i];
    }
  }
  return places;
}

/** The animation: what facts say of it, with arrays that are unpacked when they are first asked for. */
class Animation {
  constructor(facts) {
    Object.assign(this, facts);
    this.size = this.high.map((value, axis) => value - this.low[axis]);
    this.count = this.times.length;
    this.unpacked = new Map();
  }

  once(key, make) {
    if (!this.unpacked.has(key)) this.unpacked.set(key, make());
    return this.unpacked.get(key);
  }

  places(cloud) {
    return this.once(`places of ${cloud.name}`, () => unpackPlaces(cloud, this.dimension));
  }

  values(cloud, name) {
    const item = cloud.values[name];
    return item ? this.once(`${name} of ${cloud.name}`, () => unpack(item, this.count)) : Promise.resolve(null);
  }

  /** The frame at or before a time. */
  frameAt(time) {
    let frame = 0;
    while (frame + 1 < this.count && Math.abs(this.times[frame + 1] - time) <= Math.abs(this.times[frame] - time)) frame++;
    return frame;
  }
}

/** A number as short text. */
function short(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "-";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) {
    const [mantissa, power] = value.toExponential(Math.max(digits - 2, 0)).split("e");
    return `${Number(mantissa)}e${Number(power)}`;
  }
  return String(Number(value.toPrecision(digits)));
}

/** Round numbers between two others, about `count` of them. */
function ticks(low, high, count) {
  const raw = (high - low) / Math.max(count, 1);
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= raw * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

function element(name, attributes = {}, ...children) {
  const svg = ["svg", "path", "line", "text", "g", "circle", "rect", "linearGradient", "stop", "clipPath", "defs"];
  const made = svg.includes(name) ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
