// Materials that know the lean: whatever stands on the axis is shifted along the lean, so that a lean too small to be seen
// is seen, and nothing changes its width.
import { Color, DataTexture, NearestFilter, RGBAFormat, ShaderMaterial, Vector2 } from "./three.module.js";

// one object for all materials: a slider that changes it changes all
export const shared = {
  lean: { value: new Vector2() },
  times: { value: 1 },
  clip: { value: new Vector2(-1e9, 1e9) },
  perPixel: { value: 1 },
};

export function pointMaterial(size, top) {
  return new ShaderMaterial({
    uniforms: {
      ...shared,
      size: { value: size },
      top: { value: top },
      range: { value: 1 },
      mode: { value: 0 },
      ramp: { value: null },
      hideFar: { value: 1 },
    },
    vertexShader: `
      attribute float deviation;
      attribute float station;
      uniform vec2 lean; uniform float times; uniform vec2 clip; uniform float perPixel;
      uniform float size; uniform float top; uniform float range; uniform int mode; uniform float hideFar;
      uniform sampler2D ramp;
      varying vec3 tint; varying float pixels;
      void main() {
        vec2 axis = lean * position.z;
        vec2 outward = normalize(position.xy - axis + vec2(1e-9));
        vec4 seen = modelViewMatrix * vec4(position.xy + (times - 1.0) * axis, position.z, 1.0);
        float facing = dot(normalize(normalMatrix * vec3(outward, 0.0)), normalize(-seen.xyz));
        bool gone = position.z < clip.x || position.z > clip.y || facing * hideFar < -0.08;
        gl_Position = gone ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * seen;
        pixels = clamp(size / (-seen.z * perPixel), 1.0, 14.0);
        gl_PointSize = pixels;
        float place = position.z / top;
        if (mode == 1) place = 0.5 + 0.5 * deviation / range;
        if (mode == 2) place = (station + 0.5) / 256.0;
        tint = texture2D(ramp, vec2(clamp(place, 0.0, 1.0), 0.5)).rgb;
        if (mode == 1 && deviation < -32767.5) tint = vec3(0.66, 0.69, 0.72);
        tint *= 0.74 + 0.26 * abs(facing);
      }`,
    fragmentShader: `
      varying vec3 tint; varying float pixels;
      void main() {
        if (pixels > 3.0 && length(gl_PointCoord - 0.5) > 0.5) discard;
        gl_FragColor = vec4(tint, 1.0);
      }`,
  });
}

// sticks of a width in pixels, whatever the distance; `bends` says whether they follow the lean
export function stickMaterial(colour, width, bends, onTop) {
  return new ShaderMaterial({
    uniforms: {
      ...shared,
      times: bends ? shared.times : { value: 1 },
      colour: { value: new Color().setStyle(colour, "") },
      width: { value: width },
    },
    depthTest: !onTop,
    transparent: onTop,
    vertexShader: `
      attribute vec3 side;
      uniform vec2 lean; uniform float times; uniform float perPixel; uniform float width;
      void main() {
        vec4 seen = modelViewMatrix * vec4(position.xy + (times - 1.0) * lean * position.z, position.z, 1.0);
        seen.xyz += normalize(normalMatrix * side) * 0.5 * width * -seen.z * perPixel;
        gl_Position = projectionMatrix * seen;
      }`,
    fragmentShader: "uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }",
  });
}

export function ringMaterial(colour) {
  return new ShaderMaterial({
    uniforms: { ...shared, colour: { value: new Color().setStyle(colour, "") } },
    vertexShader: `
      uniform vec2 lean; uniform float times; uniform vec2 clip;
      void main() {
        vec3 at = vec3(position.xy + (times - 1.0) * lean * position.z, position.z);
        bool gone = position.z < clip.x || position.z > clip.y;
        gl_Position = gone ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * modelViewMatrix * vec4(at, 1.0);
      }`,
    fragmentShader: "uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }",
  });
}

// 256 colours between stops, as sRGB; a list without places is one colour a place
export function rampOf(stops) {
  const data = new Uint8Array(256 * 4);
  for (let place = 0; place < 256; place += 1) {
    const [red, green, blue] = colourAt(stops, place / 255);
    data.set([red, green, blue, 255], 4 * place);
  }
  return texture(data);
}

export function listOf(colours) {
  const data = new Uint8Array(256 * 4);
  for (let place = 0; place < 256; place += 1) data.set([...parts(colours[place % colours.length]), 255], 4 * place);
  return texture(data);
}

export function colourAt(stops, share) {
  const above = Math.max(1, stops.findIndex(([place]) => place >= share));
  const [low, first] = stops[above - 1];
  const [high, last] = stops[above];
  const part = (share - low) / (high - low);
  const from = parts(first);
  return parts(last).map((value, index) => Math.round(from[index] + part * (value - from[index])));
}

function parts(hex) {
  return [1, 3, 5].map((start) => parseInt(hex.slice(start, start + 2), 16));
}

function texture(data) {
  const made = new DataTexture(data, 256, 1, RGBAFormat);
  made.magFilter = NearestFilter;
  made.minFilter = NearestFilter;
  made.needsUpdate = true;
  return made;
}
