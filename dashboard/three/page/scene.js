// The things of the scene: points, sticks (axis, plumb line, pins, ruler), rings.
import { BufferAttribute, BufferGeometry, Group, LineSegments, Mesh, Points, Vector3 } from "./three.module.js";
import { pointMaterial, ringMaterial, stickMaterial } from "./shaders.js";

const VERMILION = "#d55e00", INK = "#1c2430", SOFT = "#7b8794", BLUE = "#0072b2";
const HEADER_BYTES = 40;

// what /3d/points.bin holds (dashboard/content/cloud.py)
export function readPoints(buffer) {
  const head = new DataView(buffer, 0, HEADER_BYTES);
  const magic = String.fromCharCode(...new Uint8Array(buffer, 0, 4));
  const n = head.getUint32(8, true);
  if (magic !== "twpc" || head.getUint32(4, true) !== 1 || buffer.byteLength !== HEADER_BYTES + 15 * n) {
    throw new Error("the points did not come whole; load the page again");
  }
  return {
    n,
    whole: head.getUint32(12, true),
    origin: [16, 24, 32].map((at) => head.getFloat64(at, true)),
    places: new Float32Array(buffer, HEADER_BYTES, 3 * n),
    deviation: new Int16Array(buffer, HEADER_BYTES + 12 * n, n),
    station: new Uint8Array(buffer, HEADER_BYTES + 14 * n, n),
  };
}

export function pointCloud(points, scene) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(points.places, 3));
  geometry.setAttribute("deviation", new BufferAttribute(points.deviation, 1));
  geometry.setAttribute("station", new BufferAttribute(points.station, 1));
  const cloud = new Points(geometry, pointMaterial(spacing(points.n, scene), scene.top_m));
  cloud.frustumCulled = false;
  return cloud;
}

export function radiusOf(scene) {
  const radii = scene.rings.map((ring) => ring.radius_m).sort((a, b) => a - b);
  return radii.length ? radii[radii.length >> 1] : scene.top_m / 20;
}

function spacing(n, scene) {
  // a point covers the place that it has on the wall, and a little more
  return 1.6 * Math.sqrt((2 * Math.PI * radiusOf(scene) * scene.top_m) / Math.max(n, 1));
}

export function ringLines(scene, corners = 96) {
  const places = [];
  for (const { east_m, north_m, up_m, radius_m } of scene.rings) {
    for (let corner = 0; corner < corners; corner += 1) {
      for (const step of [corner, corner + 1]) {
        const angle = (2 * Math.PI * step) / corners, radius = 1.006 * radius_m;
        places.push(east_m + radius * Math.sin(angle), north_m + radius * Math.cos(angle), up_m);
      }
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
  const lines = new LineSegments(geometry, ringMaterial(INK));
  lines.frustumCulled = false;
  return lines;
}

export function axisAndPlumbLine(scene) {
  const group = new Group(), top = 1.04 * scene.top_m;
  const dashes = [];
  for (let at = 0; at < 60; at += 2) dashes.push([[0, 0, (at * top) / 60], [0, 0, ((at + 1.2) * top) / 60]]);
  group.add(sticks(dashes, INK, 1.6, false, true));
  if (scene.axis) {
    const [east, north] = scene.axis.lean;
    group.add(sticks([[[0, 0, 0], [east * top, north * top, top]]], VERMILION, 3, true, true));
  }
  return group;
}

export function stationPins(scene) {
  const pins = scene.stations.map(({ east_m, north_m, up_m }) => [[east_m, north_m, 0], [east_m, north_m, up_m + 3]]);
  return sticks(pins, BLUE, 4, false, false);
}

export function ground(scene) {
  const group = new Group(), radius = groundRadius(scene), circle = [];
  for (let step = 0; step < 90; step += 1) {
    circle.push([step, step + 1].map((at) => onCircle(radius, (2 * Math.PI * at) / 90)));
  }
  group.add(sticks(circle, SOFT, 1.2, false, false));
  const tip = [0, 1.28 * radius, 0], side = 0.06 * radius;
  const arrow = [[[0, radius, 0], tip], [tip, [side, 1.16 * radius, 0]], [tip, [-side, 1.16 * radius, 0]]];
  group.add(sticks(arrow, INK, 2, false, false));
  return group;
}

export function groundRadius(scene) {
  const wanted = 2 * radiusOf(scene);
  return [1, 2, 5, 10, 20, 50, 100].find((size) => size >= wanted) || wanted;
}

// a ruler from the foot to the top, with ticks at round heights of the site
export function ruler(scene, heights) {
  const marks = heights.map((up) => [[0, 0, up], [-0.02 * scene.top_m, 0, up]]);
  return sticks([[[0, 0, 0], [0, 0, scene.top_m]], ...marks], SOFT, 1.2, false, false);
}

export function roundHeights(scene) {
  const low = scene.origin_m[2], high = low + scene.top_m;
  const step = [0.5, 1, 2, 5, 10, 20, 50, 100, 200].find((size) => scene.top_m / size <= 8) || 500;
  const found = [];
  for (let z = Math.ceil(low / step) * step; z <= high; z += step) found.push([z, z - low]);
  return found;
}

function onCircle(radius, angle) {
  return [radius * Math.sin(angle), radius * Math.cos(angle), 0];
}

function sticks(pairs, colour, width, bends, onTop) {
  const places = [], sides = [], faces = [], along = new Vector3(), across = new Vector3(), third = new Vector3();
  for (const [from, to] of pairs) {
    along.set(...to).sub(new Vector3(...from)).normalize();
    across.set(Math.abs(along.z) < 0.9 ? 0 : 1, 0, Math.abs(along.z) < 0.9 ? 1 : 0).cross(along).normalize();
    third.crossVectors(along, across);
    const first = places.length / 3;
    for (const end of [from, to]) {
      for (let corner = 0; corner < 6; corner += 1) {
        const turn = (Math.PI * corner) / 3, c = Math.cos(turn), s = Math.sin(turn);
        places.push(...end);
        sides.push(c * across.x + s * third.x, c * across.y + s * third.y, c * across.z + s * third.z);
      }
    }
    for (let corner = 0; corner < 6; corner += 1) {
      const a = first + corner, b = first + ((corner + 1) % 6);
      faces.push(a, b, a + 6, b, b + 6, a + 6);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
  geometry.setAttribute("side", new BufferAttribute(new Float32Array(sides), 3));
  geometry.setIndex(faces);
  const material = stickMaterial(colour, width, bends, onTop);
  material.side = 2;
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.renderOrder = onTop ? 2 : 0;
  return mesh;
}
