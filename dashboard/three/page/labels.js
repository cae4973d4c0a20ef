// Words at places of the scene, as elements over the canvas; whatever they say is inserted as text.
import { Vector3 } from "./three.module.js";
import { shared } from "./shaders.js";

const place = new Vector3();

export class Labels {
  constructor(home) {
    this.home = home;
    this.all = [];
  }

  // `at` is an array of east, north, up, or a function that gives one; `bends`: it follows the lean
  add(group, text, at, kind, bends = false) {
    const element = document.createElement("span");
    element.className = kind;
    element.textContent = text;
    this.home.append(element);
    this.all.push({ group, element, at, bends });
    return element;
  }

  show(group, visible) {
    for (const label of this.all) if (label.group === group) label.hidden = !visible;
  }

  follow(camera, width, height) {
    for (const { element, at, bends, hidden } of this.all) {
      const [east, north, up] = typeof at === "function" ? at() : at;
      const more = bends ? (shared.times.value - 1) * up : 0;
      place.set(east + more * shared.lean.value.x, north + more * shared.lean.value.y, up).project(camera);
      const inside = Math.abs(place.x) < 1.02 && Math.abs(place.y) < 1.02 && place.z < 1;
      element.style.display = inside && !hidden ? "" : "none";
      if (inside && !hidden) {
        const x = ((place.x + 1) / 2) * width, y = ((1 - place.y) / 2) * height;
        const beside = element.className === "plumb" ? "translate(calc(-100% - 6px), -50%)" : "translate(6px, -50%)";
        element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) ${beside}`;
      }
    }
  }
}
