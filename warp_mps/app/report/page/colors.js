// What colours mean: the maps, the range that they stand for, and the bar that says so.

const BAR = { width: 16, height: 180 };

class Colors {
  constructor(animation) {
    this.animation = animation;
    this.maps = DATA.maps;
    this.quantity = null;
    [this.plain, this.twofold] = Object.keys(this.maps);
    this.map = this.plain;
    this.range = [0, 1];
  }

  /** Colour by a quantity, null for the colours of the bodies. */
  choose(name) {
    this.quantity = this.animation.quantities.find((item) => item.name === name) || null;
    if (!this.quantity) return;
    this.range = [...this.quantity.shown];
    this.map = this.quantity.signed ? this.twofold : this.plain;
  }

  /** The value that a whole number stands for. */
  value(number) {
    const [low, high] = this.quantity.kept;
    return low + (high - low) * number / this.quantity.top;
  }

  /** Factor and summand that turn whole numbers into places on the map, 0 to 1. */
  scaling() {
    const [low, high] = this.quantity.kept, [from, to] = this.range;
    const width = to > from ? to - from : 1;
    return [(high - low) / this.quantity.top / width, (low - from) / width];
  }

  css(place) {
    const k = 3 * Math.round(255 * Math.min(Math.max(place, 0), 1)), map = this.maps[this.map];
    return `rgb(${map[k]},${map[k + 1]},${map[k + 2]})`;
  }

  /** Draw the bar with its name, its unit and its numbers. */
  draw(target) {
    target.replaceChildren();
    if (!this.quantity) return;
    const name = element("div", { class: "name" });
    name.textContent = this.label();
    const gradient = element("linearGradient", { id: "scale", x1: 0, y1: 1, x2: 0, y2: 0 });
    for (let k = 0; k <= 32; k++) gradient.append(element("stop", { offset: k / 32, "stop-color": this.css(k / 32) }));
    const svg = element("svg", { width: BAR.width + 70, height: BAR.height + 14, role: "img" }, element("defs", {}, gradient));
    svg.append(element("rect", { x: 0, y: 7, width: BAR.width, height: BAR.height, fill: "url(#scale)", stroke: "#8c959f" }));
    for (const [value, mark] of this.marks()) {
      const y = 7 + BAR.height * (1 - (value - this.range[0]) / (this.range[1] - this.range[0]));
      svg.append(element("line", { x1: BAR.width, x2: BAR.width + 5, y1: y, y2: y, stroke: "#24292f" }));
      const text = element("text", { x: BAR.width + 9, y: y + 4, fill: "#24292f" });
      text.textContent = mark;
      svg.append(text);
    }
    target.append(name, svg);
  }

  /** Numbers at the bar: its ends, with a sign where values lie beyond them, and round ones in between. */
  marks() {
    const [low, high] = this.range, { least, greatest } = this.quantity, slack = 1e-6 * (high - low);
    const inner = ticks(low, high, 5).filter((value) => value - low > 0.09 * (high - low) && high - value > 0.09 * (high - low));
    return [
      [low, (least < low - slack ? "\u2264 " : "") + short(low)],
      ...inner.map((value) => [value, short(value)]),
      [high, (greatest > high + slack ? "\u2265 " : "") + short(high)],
    ];
  }

  /** Whether values far off are on the page as the nearest one that it holds. */
  get clipped() {
    const { least, greatest, kept } = this.quantity;
    return kept[0] > least || kept[1] < greatest;
  }

  label() {
    return this.quantity.unit && this.quantity.unit !== "1" ? `${this.quantity.title} [${this.quantity.unit}]` : this.quantity.title;
  }

  /** The range as text. */
  stated() {
    if (!this.quantity) return "";
    const { least, greatest, kept, unit } = this.quantity, own = unit === "1" ? "" : ` ${unit}`;
    const text = `in the whole run ${short(least)} to ${short(greatest)}${own}`;
    return this.clipped ? `${text}; this page holds those from ${short(kept[0])} to ${short(kept[1])}${own}` : text;
  }
}
