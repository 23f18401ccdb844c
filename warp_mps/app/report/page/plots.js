// Diagrams of the history, as SVG: sharp at any size, with the values under the pointer.

const INKS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const PLOT = { width: 480, height: 230, left: 62, right: 12, top: 10, bottom: 36 };

class Diagram {
  /** `pointed` is called with a time when the diagram is clicked, else null. */
  constructor(facts, pointed) {
    this.facts = facts;
    this.inks = facts.lines.map((line, k) => (line.name === "balance" ? "#24292f" : INKS[k % INKS.length]));
    const { times } = facts;
    this.x = this.scale([times[0], times[times.length - 1]], PLOT.left, PLOT.width - PLOT.right);
    this.y = this.scale(this.bounds(), PLOT.height - PLOT.bottom, PLOT.top);
    this.svg = element("svg", { viewBox: `0 0 ${PLOT.width} ${PLOT.height}`, role: "img", "aria-label": facts.title });
    this.drawAxes();
    facts.lines.forEach((line, k) => this.drawLine(line, this.inks[k]));
    this.now = this.upright("#8250df", "none");
    this.mark = this.upright("#59636e", "3 2");
    this.read = element("g", { class: "read" });
    this.svg.append(this.now, this.mark, this.read);
    this.listen(pointed);
    this.root = element("div", { class: "diagram" }, this.heading(), this.svg, this.measured());
  }

  /** A map from values to places on the picture. */
  scale([low, high], from, to) {
    const width = high > low ? high - low : Math.abs(low) || 1, start = high > low ? low : low - 0.5 * width;
    const map = (value) => from + ((value - start) / width) * (to - from);
    return Object.assign(map, { low: start, high: start + width, back: (place) => start + ((place - from) / (to - from)) * width });
  }

  bounds() {
    let low = Infinity, high = -Infinity;
    for (const line of this.facts.lines) {
      for (const value of [...line.values, ...line.references.map((item) => item.value)]) {
        if (value !== null) [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
    }
    if (!(high >= low)) return [0, 1];
    // what hardly changes is shown as such, not its last digits
    const size = Math.max(Math.abs(low), Math.abs(high)), least = high - low <= 1e-6 * size ? 0.02 * size || 1 : 0;
    const room = 0.05 * Math.max(high - low, least) + 0.5 * least;
    return [low - room, high + room];
  }

  drawAxes() {
    const { left, right, top, bottom, width, height } = PLOT;
    for (const value of ticks(this.y.low, this.y.high, 5)) {
      this.svg.append(element("line", { x1: left, x2: width - right, y1: this.y(value), y2: this.y(value), stroke: "#e4e8ec" }));
      this.text(left - 6, this.y(value) + 4, short(value), "end");
    }
    for (const value of ticks(this.x.low, this.x.high, 6)) {
      this.svg.append(element("line", { x1: this.x(value), x2: this.x(value), y1: top, y2: height - bottom, stroke: "#eef1f4" }));
      this.text(this.x(value), height - bottom + 15, short(value), "middle");
    }
    this.svg.append(element("path", { d: `M${left},${top}V${height - bottom}H${width - right}`, stroke: "#8c959f", fill: "none" }));
    this.text(width - right, height - 4, DATA.timeUnit ? `${DATA.timeLabel} [${DATA.timeUnit}]` : DATA.timeLabel, "end");
  }

  drawLine(line, ink) {
    const { times } = this.facts;
    let path = "", pen = "M";
    line.values.forEach((value, k) => {
      if (value === null) pen = "M";
      else {
        path += `${pen}${this.x(times[k]).toFixed(2)},${this.y(value).toFixed(2)}`;
        pen = "L";
      }
    });
    const dash = line.name === "balance" ? "1.5 3" : "none";
    this.svg.append(element("path", { d: path, fill: "none", stroke: ink, "stroke-width": 1.5, "stroke-linejoin": "round", "stroke-dasharray": dash }));
    if (times.length === 1 && line.values[0] !== null) this.svg.append(element("circle", { cx: this.x(times[0]), cy: this.y(line.values[0]), r: 3, fill: ink }));
    for (const { times: ends, value } of line.references) {
      const y = this.y(value), [x1, x2] = [this.x(ends[0]), this.x(ends[ends.length - 1])];
      this.svg.append(ends.length === 2
        ? element("line", { x1, x2, y1: y, y2: y, stroke: ink, "stroke-dasharray": "6 4", "stroke-width": 1.2 })
        : element("circle", { cx: x1, cy: y, r: 4, fill: "#fff", stroke: "#24292f", "stroke-width": 1.3 }));
    }
  }

  upright(stroke, dash) {
    return element("line", { y1: PLOT.top, y2: PLOT.height - PLOT.bottom, x1: 0, x2: 0, stroke, "stroke-dasharray": dash, opacity: 0.75, visibility: "hidden" });
  }

  text(x, y, words, anchor, fill = "#24292f") {
    const made = element("text", { x, y, "text-anchor": anchor, fill });
    made.textContent = words;
    this.svg.append(made);
  }

  heading() {
    const title = element("span"), legend = element("small");
    title.textContent = this.facts.unit && this.facts.unit !== "-" ? `${this.facts.title} [${this.facts.unit}]` : this.facts.title;
    this.facts.lines.forEach((line, k) => {
      if (line.name) legend.append(element("i", { style: `background:${this.inks[k]}` }), line.name);
    });
    return element("h3", {}, title, legend);
  }

  /** The measurements that were drawn from these lines, beside their references. */
  measured() {
    const list = element("ul", { class: "measured" });
    for (const words of this.facts.measured) list.append(element("li", {}, words));
    return list;
  }

  listen(pointed) {
    const time = (event) => {
      const box = this.svg.getBoundingClientRect(), x = ((event.clientX - box.left) / box.width) * PLOT.width;
      return Math.min(Math.max(this.x.back(x), this.x.low), this.x.high);
    };
    this.svg.addEventListener("pointermove", (event) => this.show(time(event)));
    this.svg.addEventListener("pointerleave", () => this.hide());
    if (pointed) this.svg.addEventListener("click", (event) => pointed(time(event)));
  }

  /** Read the row next to a time. */
  show(time) {
    const { times, lines } = this.facts;
    let k = 0, end = times.length - 1;
    while (end - k > 1) {
      const middle = (k + end) >> 1;
      if (times[middle] <= time) k = middle;
      else end = middle;
    }
    if (Math.abs(times[end] - time) < Math.abs(times[k] - time)) k = end;
    const x = this.x(times[k]), right = x > 0.6 * PLOT.width;
    this.move(this.mark, x);
    this.read.replaceChildren();
    const words = [`${DATA.timeLabel} ${short(times[k], 5)} ${DATA.timeUnit}`, ...lines.map((line) => `${line.name} ${short(line.values[k], 5)}`.trim())];
    this.read.append(element("rect", { x: right ? x - 152 : x + 6, y: PLOT.top + 2, width: 146, height: 15 * words.length + 6, rx: 4, fill: "#fff", opacity: 0.9, stroke: "#d8dee4" }));
    words.forEach((word, row) => {
      const text = element("text", { x: right ? x - 145 : x + 13, y: PLOT.top + 16 + 15 * row, style: row ? `fill:${this.inks[row - 1]}` : "" });
      text.textContent = word;
      this.read.append(text);
    });
  }

  hide() {
    this.move(this.mark, null);
    this.read.replaceChildren();
  }

  /** Show at which time the animation is. */
  setTime(time) {
    this.move(this.now, time >= this.x.low && time <= this.x.high ? this.x(time) : null);
  }

  /** Put an upright line somewhere, or nowhere. */
  move(line, x) {
    line.setAttribute("visibility", x === null ? "hidden" : "visible");
    for (const end of x === null ? [] : ["x1", "x2"]) line.setAttribute(end, x);
  }
}
