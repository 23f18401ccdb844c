// Where the particles are seen from.

const VIEW_ANGLE = (28 * Math.PI) / 180;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const along = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];

class Camera {
  /** A plane is seen straight on, without perspective; space from anywhere. */
  constructor(flat, up) {
    this.flat = flat;
    this.axes = up === "Z" && !flat ? { right: [1, 0, 0], up: [0, 0, 1], front: [0, -1, 0] } : { right: [1, 0, 0], up: [0, 1, 0], front: [0, 0, 1] };
    this.aspect = 1;
    this.turn(0.6, 0.35);
    this.target = this.home = [0, 0, 0];
    this.extent = 1;
    this.distance = 1;
  }

  turn(azimuth, elevation) {
    const limit = Math.PI / 2;
    this.azimuth = this.flat ? 0 : azimuth;
    this.elevation = this.flat ? 0 : Math.min(Math.max(elevation, -limit), limit);
    const { right, up, front } = this.axes;
    const [c, s, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    const level = along([0, 0, 0].map((_, k) => c * front[k]), right, s);
    this.right = along([0, 0, 0].map((_, k) => c * right[k]), front, -s);
    this.back = [0, 1, 2].map((k) => ce * level[k] + se * up[k]);
    this.up = [0, 1, 2].map((k) => ce * up[k] - se * level[k]);
  }

  /** Half of the height that is seen at the target. */
  get half() {
    return this.distance * Math.tan(VIEW_ANGLE / 2);
  }

  /** Move so that a box fills the view, but for parts of it at its right and its bottom, from where it is looked at now. */
  fit(low, high, right, bottom) {
    this.moved = false;
    this.target = low.map((value, k) => 0.5 * (value + high[k]));
    this.home = [...this.target];
    const width = this.aspect * (1 - right), height = 1 - bottom;
    const tangent = Math.tan(VIEW_ANGLE / 2);
    this.distance = 1e-9;
    for (let corner = 0; corner < 8; corner++) {
      const from = low.map((value, k) => ((corner >> k) & 1 ? high[k] : value) - this.target[k]);
      const depth = this.flat ? 0 : dot(from, this.back);
      const reach = Math.max(Math.abs(dot(from, this.up)) / height, Math.abs(dot(from, this.right)) / width);
      this.distance = Math.max(this.distance, depth + (1.06 * reach) / tangent);
    }
    this.target = along(along(this.target, this.right, this.half * this.aspect * right), this.up, -this.half * bottom);
    this.extent = Math.hypot(...low.map((value, k) => high[k] - value)) || 1;
  }

  /** Move the target by a part of the height that is seen. */
  pan(x, y) {
    this.target = along(along(this.target, this.right, -x * 2 * this.half), this.up, y * 2 * this.half);
  }

  /** Come closer by a factor, towards a point of the picture from -1 to 1 off its middle. */
  zoom(factor, x, y) {
    const before = this.half;
    this.distance = Math.min(Math.max(this.distance * factor, 1e-4 * this.extent), 1e3 * this.extent);
    const change = before - this.half;
    this.target = along(along(this.target, this.right, change * x * this.aspect), this.up, change * y);
  }

  /** View and projection, column by column. */
  matrices() {
    const eye = along(this.target, this.back, this.distance);
    const { right, up, back } = this;
    const view = [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, -dot(right, eye), -dot(up, eye), -dot(back, eye), 1];
    const reach = 2 * this.extent + Math.hypot(...this.target.map((value, k) => value - this.home[k]));
    const near = Math.max(this.distance - reach, 1e-3 * this.distance), far = this.distance + reach;
    const f = 1 / Math.tan(VIEW_ANGLE / 2), d = near - far;
    const projection = this.flat
      ? [1 / (this.half * this.aspect), 0, 0, 0, 0, 1 / this.half, 0, 0, 0, 0, 2 / d, 0, 0, 0, (far + near) / d, 1]
      : [f / this.aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, (2 * far * near) / d, 0];
    return { view: new Float32Array(view), projection: new Float32Array(projection) };
  }
}

/** Let a pointer turn, move and zoom a camera; `changed` is called after each change. */
function attachPointer(canvas, camera, changed, reset) {
  const held = new Map();
  const spread = () => {
    const [a, b] = [...held.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener("pointerdown", (event) => {
    camera.moved = true;
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = held.get(event.pointerId);
    if (!last) return;
    const dx = event.clientX - last.x, dy = event.clientY - last.y, before = held.size === 2 ? spread() : 0;
    held.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const height = canvas.clientHeight;
    if (held.size === 2) {
      camera.zoom(before / Math.max(spread(), 1), 0, 0);
      camera.pan(dx / height / 2, dy / height / 2);
    } else if (camera.flat || event.shiftKey || event.buttons & 6) camera.pan(dx / height, dy / height);
    else camera.turn(camera.azimuth - (4 * dx) / height, camera.elevation + (4 * dy) / height);
    changed();
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => held.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", reset);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.moved = true;
    const box = canvas.getBoundingClientRect(), scale = event.deltaMode === 1 ? 16 : 1;
    const x = (2 * (event.clientX - box.left)) / box.width - 1, y = 1 - (2 * (event.clientY - box.top)) / box.height;
    camera.zoom(Math.exp(Math.min(Math.max(0.0012 * event.deltaY * scale, -0.5), 0.5)), x, y);
    changed();
  }, { passive: false });
}
