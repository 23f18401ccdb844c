// The particle under the pointer, and the overlays of the picture: axes and scale bar.

/** The particle that is seen at a point of the canvas: {item, i, x}, or null. */
function pick(scene, px, py) {
  const { camera, canvas } = scene, width = canvas.clientWidth, height = canvas.clientHeight;
  const eye = along(camera.target, camera.back, camera.distance), tangent = Math.tan(VIEW_ANGLE / 2);
  const sx = ((2 * px) / width - 1) * camera.aspect, sy = 1 - (2 * py) / height;
  const [, , , limit] = scene.plane(), axis = scene.cut ? scene.cut.axis : -1;
  let best = null, nearest = Infinity;
  for (const item of scene.clouds) {
    if (!item.shown || !item.whole || item.cloud.role === "wall") continue;
    const radius = 0.5 * item.cloud.width * scene.scale;
    for (let i = 0; i < item.cloud.count; i++) {
      const x = scene.place(item, i);
      if (!x || (axis >= 0 && x[axis] > limit)) continue;
      const from = [x[0] - eye[0], x[1] - eye[1], x[2] - eye[2]], depth = -dot(from, camera.back);
      const reach = camera.flat ? camera.half : depth * tangent;
      if (!(reach > 0)) continue;
      const away = Math.hypot(dot(from, camera.right) - sx * reach, dot(from, camera.up) - sy * reach);
      const order = camera.flat ? away : depth;
      if (away < radius && order < nearest) [best, nearest] = [{ item, i, x }, order];
    }
  }
  return best;
}

/** What to say of a particle. */
function describe(scene, { item, i, x }) {
  const { cloud, numbers } = item, { axes, dimension } = scene.animation, { quantity } = scene.colors;
  const lines = [`${cloud.name}, particle ${typeof cloud.ids === "number" ? cloud.ids + i : cloud.ids[i]}`];
  if (scene.stretch === 1 || cloud.role !== "body") {
    for (let axis = 0; axis < dimension; axis++) lines.push(`${axes[axis]} = ${short(x[axis])} m`);
  }
  if (numbers) {
    const value = scene.colors.value(numbers[scene.frame * cloud.count + i]);
    lines.push(`${quantity.title} = ${short(value)} ${quantity.unit === "1" ? "" : quantity.unit}`);
  }
  return lines.join("\n");
}

/** Draw the directions of the axes, and in a plane a length. */
function drawOverlay(svg, scene) {
  const { camera, animation, canvas } = scene, height = canvas.clientHeight;
  svg.replaceChildren();
  const origin = [34, height - 34], names = [...animation.axes];
  const arrows = names.map((name, k) => {
    const unit = [0, 0, 0];
    unit[k] = 1;
    return { name, x: dot(unit, camera.right), y: dot(unit, camera.up), z: dot(unit, camera.back) };
  });
  for (const { name, x, y } of arrows.sort((a, b) => a.z - b.z)) {
    const [ex, ey] = [origin[0] + 22 * x, origin[1] - 22 * y];
    svg.append(element("line", { x1: origin[0], y1: origin[1], x2: ex, y2: ey, stroke: "#24292f", "stroke-width": 1.5 }));
    const text = element("text", { x: origin[0] + 30 * x - 3, y: origin[1] - 30 * y + 4, fill: "#24292f" });
    text.textContent = name;
    svg.append(text);
  }
  if (camera.flat) drawLength(svg, camera, height);
}

function drawLength(svg, camera, height) {
  const perMeter = height / (2 * camera.half), wanted = 130 / perMeter;
  const power = 10 ** Math.floor(Math.log10(wanted)), length = power * [5, 2, 1].find((factor) => factor * power <= wanted);
  const x = 80, y = height - 16, width = length * perMeter;
  svg.append(element("path", { d: `M${x},${y - 5}v5h${width}v-5`, stroke: "#24292f", fill: "none", "stroke-width": 1.5 }));
  const text = element("text", { x: x + width + 8, y, fill: "#24292f" });
  text.textContent = `${short(length)} m`;
  svg.append(text);
}
