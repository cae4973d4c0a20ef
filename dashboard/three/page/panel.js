// The controls, and the legend of the colours; names of the user's are inserted as text.
import { colourAt } from "./shaders.js";

export const TIMES = [1, 2, 5, 10, 20, 50, 100];
export const HEIGHT = [[0, "#00224e"], [0.25, "#434e6c"], [0.5, "#7d7c78"], [0.75, "#bcae6c"], [1, "#fee838"]];
export const DEVIATION = [[0, "#0b4a7f"], [0.25, "#6fa8d6"], [0.5, "#f7f7f7"], [0.75, "#e8a06a"], [1, "#a63d00"]];
export const STATIONS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5d4b8a", "#8a7f00"];

export const byId = (id) => document.getElementById(id);

export function button(home, text, title, act) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.title = title;
  made.addEventListener("click", act);
  byId(home).append(made);
  return made;
}

export function told(times) {
  return times === 1 ? "true to scale" : `×${times}`;
}

export function showLegend(mode, scene) {
  const home = byId("legend");
  home.replaceChildren();
  if (mode === "station") {
    const keys = document.createElement("div");
    keys.className = "keys";
    scene.station_names.forEach((name, place) => keys.append(key(name, STATIONS[place % STATIONS.length])));
    home.append(keys);
    return;
  }
  const stops = mode === "height" ? HEIGHT : DEVIATION;
  home.append(bar(stops));
  if (mode === "height") {
    home.append(ends([`z = ${scene.origin_m[2].toFixed(1)} m`, `${(scene.origin_m[2] + scene.top_m).toFixed(1)} m`]));
    return;
  }
  const range = scene.range_mm;
  home.append(ends([`≤ −${range} mm`, "0", `≥ +${range} mm`]));
  const note = document.createElement("p");
  note.className = "note";
  note.textContent = "Off the straight shaft, as the map of the surface has it, outward orange; grey: not told there.";
  home.append(note);
}

function key(name, colour) {
  const item = document.createElement("div"), mark = document.createElement("i"), text = document.createElement("span");
  item.className = "key";
  mark.style.background = colour;
  text.textContent = name;
  text.title = name;
  item.append(mark, text);
  return item;
}

function bar(stops) {
  const canvas = document.createElement("canvas");
  canvas.width = 256;
  canvas.height = 1;
  const pen = canvas.getContext("2d");
  for (let x = 0; x < 256; x += 1) {
    pen.fillStyle = `rgb(${colourAt(stops, x / 255).join(",")})`;
    pen.fillRect(x, 0, 1, 1);
  }
  return canvas;
}

function ends(words) {
  const line = document.createElement("div");
  line.className = "ends";
  for (const word of words) {
    const text = document.createElement("span");
    text.textContent = word;
    line.append(text);
  }
  return line;
}
