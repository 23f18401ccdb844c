// Puts the page together.

const report = { errors: [] };
// for scripts that inspect the page
window.report = report;

function complain(text) {
  const line = element("li");
  line.textContent = text;
  byId("remarks").append(line);
}

/** State that an open page keeps when it reloads during a run. */
const KEPT = `warp-mps report of ${document.title}`;

function keep() {
  const { scene, player, colors } = report, { azimuth, elevation, target, distance } = scene.camera;
  const last = scene.frame === scene.animation.count - 1;
  const state = { y: scrollY, frame: last ? null : scene.frame, playing: player.playing, quantity: colors.quantity?.name ?? "", azimuth, elevation, target, distance };
  try {
    sessionStorage.setItem(KEPT, JSON.stringify(state));
  } catch { /* a browser that keeps nothing for files */ }
}

/** What the page that was here before took along, once. */
function takeKept() {
  try {
    const text = sessionStorage.getItem(KEPT);
    sessionStorage.removeItem(KEPT);
    return JSON.parse(text);
  } catch {
    return null;
  }
}

async function startPlayer(facts, moved) {
  byId("animation").hidden = false;
  const animation = new Animation(facts), camera = new Camera(facts.dimension === 2, facts.up);
  const colors = new Colors(animation), scene = new Scene(byId("view"), animation, camera, colors);
  let waiting = false;
  const redraw = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      scene.draw();
      drawOverlay(byId("overlay"), scene);
    });
  };
  scene.scale = camera.flat ? 1.45 : 1.2;
  scene.resize();
  const controls = new Controls(scene, redraw), player = new Player(scene, redraw, moved);
  Object.assign(report, { animation, camera, colors, scene, controls, player });
  attachPointer(scene.canvas, camera, redraw, () => controls.look());
  // a picture that nobody has moved stays whole
  new ResizeObserver(() => (scene.resize() && !camera.moved ? controls.look() : redraw())).observe(scene.canvas);
  hover(scene);
  const before = takeKept();
  await scene.load();
  await controls.choose(before ? before.quantity : facts.first);
  controls.look();
  if (DATA.reload || before) player.go(before?.frame ?? animation.count - 1);
  if (before) {
    Object.assign(camera, { target: before.target, distance: before.distance });
    camera.turn(before.azimuth, before.elevation);
    scrollTo(0, before.y);
    camera.moved = true;
    if (before.playing) player.play();
  }
  byId("busy").hidden = true;
  redraw();
}

function hover(scene) {
  const box = byId("hover");
  let asked = null;
  scene.canvas.addEventListener("pointermove", (event) => {
    if (!asked) {
      requestAnimationFrame(() => {
        const found = asked && !asked.buttons && pick(scene, asked.offsetX, asked.offsetY);
        box.hidden = !found;
        if (found) {
          box.textContent = describe(scene, found);
          const left = asked.offsetX > scene.canvas.clientWidth - 220;
          box.style.left = `${asked.offsetX + (left ? -16 - box.offsetWidth : 16)}px`;
          box.style.top = `${Math.min(asked.offsetY + 12, scene.canvas.clientHeight - box.offsetHeight - 6)}px`;
        }
        asked = null;
      });
    }
    asked = event;
  });
  scene.canvas.addEventListener("pointerleave", () => {
    asked = null;
    box.hidden = true;
  });
}

function startDiagrams() {
  byId("history").hidden = !DATA.diagrams.length;
  const pointed = DATA.frames ? (time) => { report.player?.pause(); report.player?.go(report.animation.frameAt(time)); } : null;
  report.diagrams = DATA.diagrams.map((facts) => new Diagram(facts, pointed));
  byId("diagrams").append(...report.diagrams.map((diagram) => diagram.root));
}

addEventListener("error", (event) => report.errors.push(event.message));
addEventListener("unhandledrejection", (event) => report.errors.push(String(event.reason)));
startDiagrams();
report.ready = (async () => {
  if (!DATA.frames) return;
  try {
    await startPlayer(DATA.frames, (time) => report.diagrams.forEach((diagram) => diagram.setTime(time)));
  } catch (error) {
    report.errors.push(String(error));
    byId("animation").hidden = true;
    complain(`The animation cannot be shown: ${error.message}`);
  }
})();
if (DATA.reload) {
  setTimeout(() => {
    if (report.player) keep();
    location.reload();
  }, 1000 * DATA.reload);
}
