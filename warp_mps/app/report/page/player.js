// The clock of the animation.

class Player {
  constructor(scene, redraw, moved) {
    Object.assign(this, { scene, redraw, moved, animation: scene.animation, playing: false, pace: 1, part: 0 });
    byId("scrub").max = this.animation.count - 1;
    const alone = this.animation.count < 2;
    for (const id of ["play", "back", "forward", "scrub", "pace"]) byId(id).disabled = alone;
    byId("play").addEventListener("click", () => this.toggle());
    byId("back").addEventListener("click", () => this.step(-1));
    byId("forward").addEventListener("click", () => this.step(1));
    byId("scrub").addEventListener("input", () => {
      this.pause();
      this.go(Number(byId("scrub").value));
    });
    byId("pace").addEventListener("change", () => {
      this.pace = Number(byId("pace").value);
      this.showPace();
    });
    addEventListener("keydown", (event) => this.key(event));
    this.showPace();
    this.go(0);
  }

  key(event) {
    if (event.target.closest?.("input, select, button, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
    const actions = { " ": () => this.toggle(), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1), Home: () => this.go(0), End: () => this.go(this.animation.count - 1) };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.animation.count < 2) return;
    if (this.scene.frame === this.animation.count - 1) this.go(0);
    this.playing = true;
    this.label();
    let last = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      this.part += ((now - last) / 1000) * this.animation.rate * this.pace;
      last = now;
      const steps = Math.floor(this.part);
      this.part -= steps;
      if (steps) this.go((this.scene.frame + steps) % this.animation.count);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.label();
  }

  label() {
    byId("play").textContent = this.playing ? "\u275A\u275A" : "\u25B6";
    byId("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }

  step(by) {
    this.pause();
    this.go(this.scene.frame + by);
  }

  go(frame) {
    const { count, times } = this.animation;
    this.scene.frame = Math.min(Math.max(frame, 0), count - 1);
    const time = times[this.scene.frame];
    byId("scrub").value = this.scene.frame;
    byId("time").textContent = `${DATA.timeLabel} ${time.toPrecision(4)} ${DATA.timeUnit}  \u00B7  ${this.scene.frame + 1}/${count}`;
    this.moved(time);
    this.redraw();
  }

  /** Say how much slower or faster than the run things are shown. */
  showPace() {
    const { times, count, rate } = this.animation;
    const ratio = count > 1 ? ((times[count - 1] - times[0]) / (count - 1)) * rate * this.pace : 0;
    byId("slow").textContent = !ratio || !DATA.timeUnit ? "" : ratio > 1.05 ? `${short(ratio, 2)} times as fast` : ratio < 0.95 ? `1/${short(1 / ratio, 2)} of true speed` : "true speed";
  }
}
