// The particles of a frame, drawn by WebGL 2.

const PAPER = [0.973, 0.976, 0.98];
const THIN = 0.2; // opacity of walls in space

class Scene {
  constructor(canvas, animation, camera, colors) {
    this.gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("This browser has no WebGL 2, which the player needs.");
    Object.assign(this, { canvas, animation, camera, colors });
    const { program, places } = compile(this.gl);
    this.uniform = places;
    this.gl.useProgram(program);
    this.frame = 0;
    this.scale = 1;
    this.stretch = 1;
    this.cut = null;
    this.texture = this.gl.createTexture();
    this.clouds = animation.clouds.map((cloud) => ({ cloud, shown: true, places: this.gl.createBuffer(), values: null, whole: null }));
  }

  /** Give the positions to the graphics card; once. */
  async load() {
    for (const item of this.clouds) {
      item.whole = await this.animation.places(item.cloud);
      this.gl.bindBuffer(this.gl.ARRAY_BUFFER, item.places);
      this.gl.bufferData(this.gl.ARRAY_BUFFER, item.whole, this.gl.STATIC_DRAW);
    }
  }

  /** Take over the quantity that is coloured by, and the map. */
  async recolor() {
    const { gl, colors } = this, name = colors.quantity?.name;
    for (const item of this.clouds) {
      const numbers = name ? await this.animation.values(item.cloud, name) : null;
      // meanwhile another one may have been chosen
      if (name !== colors.quantity?.name) return;
      gl.deleteBuffer(item.values);
      item.numbers = numbers;
      item.values = numbers ? gl.createBuffer() : null;
      if (!numbers) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, item.values);
      gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
    }
    this.remap();
  }

  remap() {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(this.colors.maps[this.colors.map]));
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  }

  /** Fit the drawing to the size of its element; whether that changed. */
  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2), { canvas } = this;
    const width = Math.max(Math.round(canvas.clientWidth * ratio), 1), height = Math.max(Math.round(canvas.clientHeight * ratio), 1);
    this.camera.aspect = width / height;
    if (canvas.width === width && canvas.height === height) return false;
    [canvas.width, canvas.height] = [width, height];
    return true;
  }

  draw() {
    const { gl, uniform, camera } = this, { low, size } = this.animation;
    this.resize();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...PAPER, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { view, projection } = camera.matrices();
    gl.uniformMatrix4fv(uniform.view, false, view);
    gl.uniformMatrix4fv(uniform.projection, false, projection);
    gl.uniform3f(uniform.low, low[0], low[1], low[2] || 0);
    gl.uniform3f(uniform.size, size[0], size[1], size[2] || 0);
    gl.uniform4f(uniform.cut, ...this.plane());
    gl.uniform2f(uniform.scaling, ...(this.colors.quantity ? this.colors.scaling() : [0, 0]));
    gl.uniform1f(uniform.shading, camera.flat ? 0 : 1);
    gl.uniform1f(uniform.rim, camera.flat ? 0.15 : 0.12);
    const seen = this.clouds.filter((item) => item.shown && item.whole);
    const solid = seen.filter((item) => camera.flat || item.cloud.role !== "wall");
    gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    for (const item of solid) this.drawCloud(item, 1);
    gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    this.drawThin(seen.filter((item) => !solid.includes(item)));
  }

  /** Transparent walls: their depth first, so that only the nearest wall surface is blended. */
  drawThin(items) {
    const { gl } = this;
    gl.colorMask(false, false, false, false);
    for (const item of items) this.drawCloud(item, THIN);
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.EQUAL);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    for (const item of items) this.drawCloud(item, THIN);
    gl.disable(gl.BLEND);
  }

  drawCloud(item, opacity) {
    const { gl, uniform } = this, { cloud } = item, axes = this.animation.dimension;
    const wall = cloud.role === "wall", flat = this.camera.flat, radius = 0.5 * cloud.width * (wall ? Math.max(this.scale, 1) : this.scale);
    gl.uniform1f(uniform.radius, radius);
    // in a plane walls lie behind what touches them
    gl.uniform1f(uniform.behind, flat && wall ? 2 * radius : 0);
    gl.uniform1f(uniform.opacity, opacity);
    gl.uniform1f(uniform.stretch, cloud.role === "body" ? this.stretch : 1);
    gl.uniform1i(uniform.mapped, item.values ? 1 : 0);
    gl.uniform3f(uniform.color, ...this.color(item));
    const frame = Math.min(this.frame, cloud.places.frames - 1);
    this.attribute(0, item.places, axes, 2 * frame * axes * cloud.count);
    this.attribute(1, item.places, axes, 0);
    if (item.values) this.attribute(2, item.values, 1, 2 * this.frame * cloud.count);
    else gl.disableVertexAttribArray(2);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, cloud.count);
  }

  attribute(place, buffer, size, offset) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.UNSIGNED_SHORT, false, 0, offset);
    gl.vertexAttribDivisor(place, 1);
  }

  color(item) {
    const { role, color } = item.cloud;
    if (role === "wall") return [0.78, 0.79, 0.8];
    // particles without a value keep their own colour; a fluid's is paled, because the colour map contains it
    return this.colors.quantity && !item.values && role === "fluid" ? color.map((part) => 0.3 * part + 0.66) : color;
  }

  /** Normal and offset of the plane beyond which nothing is drawn. */
  plane() {
    if (!this.cut) return [0, 0, 0, 1];
    const normal = [0, 0, 0], { axis, part } = this.cut;
    normal[axis] = 1;
    return [...normal, this.animation.low[axis] + part * this.animation.size[axis]];
  }

  /** Position of a particle in this frame as it is drawn, or null. */
  place(item, i) {
    const { animation } = this, axes = animation.dimension, { whole, cloud } = item;
    const at = (Math.min(this.frame, cloud.places.frames - 1) * cloud.count + i) * axes;
    if (whole[at] === MISSING) return null;
    const x = [0, 0, 0], stretch = cloud.role === "body" ? this.stretch : 1;
    for (let axis = 0; axis < axes; axis++) {
      const now = whole[at + axis], start = whole[i * axes + axis];
      x[axis] = animation.low[axis] + (animation.size[axis] * (start + stretch * (now - start))) / 65534;
    }
    return x;
  }
}
