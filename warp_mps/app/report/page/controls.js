// The control panel beside the picture.

const byId = (id) => document.getElementById(id);

/** The number in a text field; null (and a red field) if it is not a number. */
function numberIn(input) {
  const value = Number(input.value.replace(",", "."));
  const good = input.value.trim() !== "" && Number.isFinite(value);
  input.classList.toggle("wrong", !good);
  return good ? value : null;
}

class Controls {
  constructor(scene, redraw) {
    Object.assign(this, { scene, colors: scene.colors, camera: scene.camera, animation: scene.animation, redraw });
    this.fillColors();
    this.fillBodies();
    this.fillViews();
    byId("help").textContent = this.camera.flat
      ? "Drag moves, wheel zooms, double click shows everything; space plays, arrows step."
      : "Drag turns, shift or right drag moves, wheel zooms, double click shows everything; space plays, arrows step.";
  }

  fillColors() {
    const choice = byId("quantity");
    for (const { name, title } of [{ name: "", title: "body" }, ...this.animation.quantities]) choice.append(new Option(title, name));
    for (const name of Object.keys(this.colors.maps)) byId("map").append(new Option(name, name));
    choice.addEventListener("change", () => this.choose(choice.value));
    byId("map").addEventListener("change", () => {
      this.colors.map = byId("map").value;
      this.scene.remap();
      this.showColors();
    });
    for (const id of ["lowest", "highest"]) byId(id).addEventListener("change", () => this.typed());
    const { colors } = this;
    byId("ordinary").addEventListener("click", () => this.setRange(...colors.quantity.shown));
    byId("whole").addEventListener("click", () => this.setRange(colors.quantity.least, colors.quantity.greatest));
    byId("now").addEventListener("click", () => this.setRange(...this.boundsNow()));
  }

  /** Colour by a quantity; resolves when it is seen. */
  async choose(name) {
    byId("quantity").value = name;
    this.colors.choose(name);
    byId("map").value = this.colors.map;
    await this.scene.recolor();
    this.showColors();
  }

  showColors() {
    const { quantity, range } = this.colors;
    for (const id of ["limits", "fits"]) byId(id).hidden = !quantity;
    byId("map").disabled = !quantity;
    if (quantity) {
      [byId("lowest").value, byId("highest").value] = range.map((value) => short(value));
      byId("unit").textContent = quantity.unit === "1" ? "" : quantity.unit;
      byId("whole").disabled = this.colors.clipped;
    }
    byId("stated").textContent = this.colors.stated();
    this.colors.draw(byId("colorbar"));
    this.redraw();
  }

  typed() {
    const low = numberIn(byId("lowest")), high = numberIn(byId("highest"));
    byId("highest").classList.toggle("wrong", high === null || (low !== null && high <= low));
    if (low !== null && high !== null && low < high) this.setRange(low, high);
  }

  setRange(low, high) {
    this.colors.range = high > low ? [low, high] : [low, low + (Math.abs(low) || 1)];
    this.showColors();
  }

  /** Minimum and maximum of the visible particles in the frame. */
  boundsNow() {
    let low = 65535, high = 0;
    for (const { cloud, numbers, shown } of this.scene.clouds) {
      if (!numbers || !shown) continue;
      const start = this.scene.frame * cloud.count;
      for (let i = start; i < start + cloud.count; i++) [low, high] = [Math.min(low, numbers[i]), Math.max(high, numbers[i])];
    }
    return high >= low ? [this.colors.value(low), this.colors.value(high)] : this.colors.range;
  }

  fillBodies() {
    for (const item of this.scene.clouds) {
      const box = element("input", { type: "checkbox" }), dot = element("i"), { cloud } = item;
      box.checked = item.shown;
      dot.style.background = `rgb(${this.scene.color(item).map((part) => Math.round(255 * part))})`;
      box.addEventListener("change", () => {
        item.shown = box.checked;
        this.redraw();
      });
      const words = element("span"), about = element("span", { class: "quiet" });
      words.textContent = cloud.name;
      about.textContent = `${cloud.role === "body" ? "" : `${cloud.role}, `}${cloud.count}`;
      byId("bodies").append(element("label", {}, box, dot, words, about));
    }
  }

  fillViews() {
    const { camera, scene } = this, quarter = Math.PI / 2;
    const views = camera.flat ? { "show all": [0, 0] } : { oblique: [0.6, 0.35], front: [0, 0], side: [quarter, 0], top: [0, quarter] };
    for (const [name, angles] of Object.entries(views)) {
      const button = element("button");
      button.textContent = name;
      button.addEventListener("click", () => this.look(...angles));
      byId("views").append(button);
    }
    byId("size").value = scene.scale;
    byId("size").addEventListener("input", () => {
      scene.scale = Number(byId("size").value);
      this.redraw();
    });
    byId("stretching").hidden = !this.animation.clouds.some((cloud) => cloud.role === "body");
    byId("stretch").addEventListener("change", () => {
      scene.stretch = numberIn(byId("stretch")) ?? scene.stretch;
      this.redraw();
    });
    byId("cutting").hidden = camera.flat;
    [...this.animation.axes].forEach((name, axis) => byId("axis").append(new Option(`along ${name}`, axis)));
    for (const id of ["axis", "cut"]) {
      byId(id).addEventListener("input", () => {
        scene.cut = byId("axis").value === "" ? null : { axis: Number(byId("axis").value), part: Number(byId("cut").value) };
        this.redraw();
      });
    }
    byId("picture").addEventListener("click", () => this.save());
  }

  /** Look from a direction, at everything. */
  look(azimuth = this.camera.azimuth, elevation = this.camera.elevation) {
    const room = Math.max(...this.animation.clouds.map((cloud) => 0.5 * cloud.width)), pad = (value) => [...value, 0].slice(0, 3);
    // what lies over the picture should hide nothing
    const { clientWidth, clientHeight } = this.scene.canvas, part = (size, of) => Math.min(size / Math.max(of, 1), 0.4);
    const right = this.colors.quantity ? part(140, clientWidth) : 0, bottom = this.camera.flat ? part(44, clientHeight) : 0;
    this.camera.turn(azimuth, elevation);
    const [low, high] = this.animation.seen;
    this.camera.fit(pad(low.map((value) => value - room)), pad(high.map((value) => value + room)), right, bottom);
    this.redraw();
  }

  save() {
    this.scene.draw();
    this.scene.canvas.toBlob((blob) => {
      const link = element("a", { download: `${document.title}_${this.scene.frame}.png` });
      link.href = URL.createObjectURL(blob);
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }
}
