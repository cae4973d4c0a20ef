// The shaft of an epoch in three dimensions. What is drawn and how is in the address: it can be mailed.
import { Group, Object3D, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "./three.module.js";
import { OrbitControls } from "./OrbitControls.js";
import { Labels } from "./labels.js";
import { DEVIATION, HEIGHT, STATIONS, TIMES, button, byId, showLegend, told } from "./panel.js";
import * as things from "./scene.js";
import { listOf, rampOf, shared } from "./shaders.js";

Object3D.DEFAULT_UP.set(0, 0, 1);
const FIELD_OF_VIEW = 28, QUICK_S = 0.08, FEWEST = 20000;
const MODES = { height: "height", deviation: "deviation", station: "station" };
const wish = new URLSearchParams(location.hash.slice(1));

window.__ready = false;
start().catch((fault) => {
  window.__failed = String(fault.message || fault);
  byId("message").hidden = false;
  byId("message").textContent = window.__failed;
});

async function start() {
  const paths = ["/3d/scene.json", "/3d/points.bin"];
  const asked = await Promise.all(paths.map((path) => ask(path + location.search)));
  const scene = await asked[0].json();
  const points = things.readPoints(await asked[1].arrayBuffer());
  new View(scene, points).begin();
}

async function ask(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error((await answer.text()).trim() || `the server answered ${answer.status}`);
  return answer;
}

class View {
  constructor(scene, points) {
    this.scene = scene;
    this.points = points;
    this.mode = wish.get("colour") in MODES ? wish.get("colour") : scene.range_mm ? "deviation" : "height";
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.05, 20000);
    this.renderer = new WebGLRenderer({ canvas: byId("view"), antialias: true, alpha: true });
    this.controls = new OrbitControls(this.camera, byId("view"));
    this.labels = new Labels(byId("labels"));
    this.world = new Scene();
    this.right = new Vector3(1, 0, 0);
    this.quick = points.n;
    this.moving = false;
    this.asked = false;
    if (scene.axis) shared.lean.value.set(...scene.axis.lean);
  }

  begin() {
    this.fill();
    this.words();
    this.wire();
    this.setTimes(Number(wish.get("times")) || this.usualTimes());
    this.setMode(this.mode);
    this.resize();
    this.look(wish.get("camera") || "across");
    byId("message").hidden = true;
    byId("panel").hidden = false;
    byId("panel").open = innerWidth > 700;
    this.draw();
    this.finished();
    window.__points = this.points.n;
    window.__ready = true;
  }

  fill() {
    const { scene, points } = this;
    this.cloud = things.pointCloud(points, scene);
    this.ramps = { height: rampOf(HEIGHT), deviation: rampOf(DEVIATION), station: listOf(STATIONS) };
    this.parts = {
      points: this.cloud,
      rings: things.ringLines(scene),
      axis: things.axisAndPlumbLine(scene),
      stations: things.stationPins(scene),
    };
    this.heights = things.roundHeights(scene);
    this.ruler = new Group();
    this.ruler.add(things.ruler(scene, this.heights.map(([, up]) => up)));
    this.world.add(...Object.values(this.parts), things.ground(scene), this.ruler);
  }

  words() {
    const { scene, labels } = this, top = 1.045 * scene.top_m, radius = things.groundRadius(scene);
    labels.add("axis", "plumb line", [0, 0, top], "plumb");
    if (scene.axis) {
      const [east, north] = scene.axis.lean;
      this.axisLabel = labels.add("axis", "", [east * top, north * top, top], "axis", true);
    }
    labels.add("ground", "N", [0, 1.34 * radius, 0], "north");
    labels.add("ground", `${radius} m about the foot`, () => this.right.clone().multiplyScalar(radius).toArray(), "tick");
    for (const [z, up] of this.heights) {
      labels.add("ruler", `${z} m`, () => this.ruler.position.clone().add(new Vector3(0, 0, up)).toArray(), "tick");
    }
    for (const pin of scene.stations) {
      labels.add("stations", pin.station, [pin.east_m, pin.north_m, pin.up_m + 3], "station");
    }
    const { what } = scene;
    byId("name").textContent = what.name;
    byId("when").textContent = `epoch ${what.epoch}, ${what.day}`;
    byId("what").textContent = scene.axis
      ? `${what.result}: deviation ${scene.axis.deviation} (k=2) at ${scene.axis.height_m} m, towards ${scene.axis.azimuth}`
      : `${what.result}: -- no axis in this epoch`;
    byId("back").href = scene.links.back;
    // within a page of the dashboard there is nowhere to go back to
    byId("back").hidden = window.top !== window;
    document.title = `${what.name} ${what.epoch}, 3D`;
    const share = this.points.n < this.points.whole ? ` of ${this.points.whole.toLocaleString("en")}, an even sample` : "";
    byId("count").textContent = `${this.points.n.toLocaleString("en")} points${share}. Reflectance is not stored.`;
  }

  wire() {
    const cameras = { along: "along lean", across: "across lean", top: "top", site: "site" };
    Object.entries(cameras).forEach(([name, text], place) => {
      button("cameras", text, `key ${place + 1}`, () => this.look(name));
    });
    this.modeButtons = Object.keys(MODES).map((mode) => {
      const made = button("colours", MODES[mode], "key C: next", () => this.setMode(mode));
      made.disabled = mode === "deviation" && !this.scene.range_mm;
      if (made.disabled) made.title = "this epoch has no map of its surface";
      return [mode, made];
    });
    byId("times").max = TIMES.length - 1;
    byId("times").addEventListener("input", () => this.setTimes(TIMES[Number(byId("times").value)]));
    for (const end of ["low", "high"]) {
      const slide = byId(`clip-${end}`);
      slide.min = 0;
      slide.max = this.scene.top_m;
      slide.value = end === "low" ? 0 : this.scene.top_m;
      slide.addEventListener("input", () => this.clip(end));
    }
    this.clip("low");
    for (const name of Object.keys(this.parts)) {
      byId(`show-${name}`).addEventListener("change", () => this.show(name));
    }
    byId("show-far").addEventListener("change", () => this.later());
    addEventListener("resize", () => this.resize());
    addEventListener("keydown", (event) => this.key(event));
    this.controls.addEventListener("change", () => this.later());
    this.controls.addEventListener("start", () => { this.moving = true; });
    this.controls.addEventListener("end", () => { this.moving = false; this.later(); });
  }

  // the largest that keeps the top within an eighth of the height from the plumb line
  usualTimes() {
    const lean = shared.lean.value.length();
    return TIMES.filter((times) => times * lean <= 0.125).pop() || 1;
  }

  setTimes(times) {
    const known = TIMES.includes(times) ? times : 1;
    shared.times.value = known;
    byId("times").value = TIMES.indexOf(known);
    byId("times-told").textContent = told(known);
    if (this.axisLabel) this.axisLabel.textContent = `axis${known === 1 ? "" : `, lean ×${known}`}`;
    this.keep("times", known);
    this.later();
  }

  setMode(mode) {
    this.mode = mode;
    const { uniforms } = this.cloud.material;
    uniforms.mode.value = Object.keys(MODES).indexOf(mode);
    uniforms.ramp.value = this.ramps[mode];
    // stored in tenths of a millimetre
    uniforms.range.value = 10 * (this.scene.range_mm || 1);
    for (const [name, made] of this.modeButtons) made.setAttribute("aria-pressed", name === mode);
    showLegend(mode, this.scene);
    this.keep("colour", mode);
    this.later();
  }

  clip(end) {
    const low = byId("clip-low"), high = byId("clip-high");
    if (Number(low.value) > Number(high.value)) (end === "low" ? high : low).value = byId(`clip-${end}`).value;
    shared.clip.value.set(Number(low.value) - 1e-6, Number(high.value) + 1e-6);
    const [from, to] = [low, high].map((slide) => (Number(slide.value) + this.scene.origin_m[2]).toFixed(1));
    byId("clip-told").textContent = `z ${from} to ${to} m`;
    this.later();
  }

  show(name) {
    const visible = byId(`show-${name}`).checked;
    this.parts[name].visible = visible;
    this.labels.show(name, visible);
    this.later();
  }

  look(name) {
    const { scene, camera, controls } = this, height = scene.top_m;
    const lean = shared.lean.value, east = lean.x, north = lean.y;
    const flat = Math.hypot(east, north) > 0 ? new Vector3(east, north, 0).normalize() : new Vector3(0, 1, 0);
    const target = new Vector3(east, north, 0).multiplyScalar(shared.times.value * height * 0.5);
    // the head of the page lies over the upper end
    target.z = height * 0.53;
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360), wide = Math.min(1, this.room());
    const far = (1.24 * height) / 2 / half / Math.min(1, 1.9 * wide);
    const from = { along: flat.clone().negate(), across: new Vector3(flat.y, -flat.x, 0) }[name];
    if (name === "top") {
      const reach = things.groundRadius(scene) * 1.25 + shared.times.value * lean.length() * height;
      camera.position.set(target.x, target.y - 1e-3, height + reach / half / wide);
    } else if (name === "site") {
      const reach = Math.max(height, ...scene.stations.map((pin) => Math.hypot(pin.east_m, pin.north_m)));
      target.set(0, 0, height * 0.3);
      camera.position.set(0.35, -0.85, 0.5).normalize().multiplyScalar((1.1 * reach) / half / wide).add(target);
    } else {
      camera.position.copy(from || new Vector3(flat.y, -flat.x, 0)).multiplyScalar(far).add(target);
      camera.position.z += 0.05 * far;
    }
    controls.target.copy(target);
    controls.update();
    this.keep("camera", name);
    this.later();
  }

  // how wide the free part of the canvas is, as a share of its height
  room() {
    return innerWidth / innerHeight;
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input[type=text]")) return;
    const names = ["along", "across", "top", "site"], modes = Object.keys(MODES);
    const step = (by) => this.setTimes(TIMES[Math.min(Math.max(TIMES.indexOf(shared.times.value) + by, 0), TIMES.length - 1)]);
    const toggles = { p: "points", s: "rings", a: "axis", f: "far" };
    const pressed = event.key.toLowerCase();
    if (names[Number(pressed) - 1]) this.look(names[Number(pressed) - 1]);
    else if (pressed === "+" || pressed === "=") step(1);
    else if (pressed === "-") step(-1);
    else if (pressed === "c") {
      const free = modes.filter((mode) => mode !== "deviation" || this.scene.range_mm);
      this.setMode(free[(free.indexOf(this.mode) + 1) % free.length]);
    } else if (pressed in toggles) byId(`show-${toggles[pressed]}`).click();
  }

  keep(name, value) {
    wish.set(name, value);
    history.replaceState(null, "", `#${wish}`);
  }

  resize() {
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(innerWidth, innerHeight, false);
    this.camera.aspect = innerWidth / innerHeight;
    this.camera.updateProjectionMatrix();
    shared.perPixel.value = (2 * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / innerHeight;
    this.later();
  }

  later() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  draw() {
    const began = performance.now();
    const down = Math.abs(this.camera.getWorldDirection(new Vector3()).z) > 0.8;
    this.cloud.material.uniforms.hideFar.value = byId("show-far").checked || down ? 0 : 1;
    // while the view turns a first part of the mixed points is drawn: an even sample
    this.cloud.geometry.setDrawRange(0, this.moving ? this.quick : this.points.n);
    this.right.setFromMatrixColumn(this.camera.matrixWorld, 0).setZ(0).normalize();
    this.ruler.position.copy(this.right).multiplyScalar(-1.25 * things.groundRadius(this.scene));
    this.ruler.rotation.z = Math.atan2(this.right.y, this.right.x);
    const tall = this.scene.top_m / (this.camera.position.distanceTo(this.controls.target) * shared.perPixel.value);
    this.ruler.visible = !down && tall > 60;
    this.labels.show("ruler", this.ruler.visible && tall > 20 * this.heights.length);
    this.renderer.render(this.world, this.camera);
    this.labels.follow(this.camera, innerWidth, innerHeight);
    if (this.moving) {
      this.finished();
      const took = (performance.now() - began) / 1000;
      const next = Math.round(this.quick * Math.min(2, Math.max(0.5, QUICK_S / Math.max(took, 1e-3))));
      this.quick = Math.min(this.points.n, Math.max(FEWEST, next));
    }
  }

  // waits until the picture is there: reading a pixel needs it
  finished() {
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}
