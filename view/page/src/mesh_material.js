// Shaders for vertices of 16 bytes: lit, unlit, by normal or by coverage. Unlit pixels have exactly the vertices'
// colours.

import { DoubleSide, FrontSide, Matrix4, ShaderMaterial, Vector3 } from 'three';

export const kShadings = ['lit', 'unlit', 'normals', 'coverage'];

const kVertexShader = `
#ifndef TILE
attribute uvec4 vertexBits;  // x: q.x q.y, y: q.z, z: red green blue coverage, w: normal
#endif
uniform mat4 T_scan_shown;
varying vec3 vColour;     // linear
varying vec3 vNormal;     // in the scan's world; zero when there is none
varying vec3 vPosition;   // in the scan's world, metres
varying vec3 vSeen;       // from the eye
varying float vCoverage;

float linearOf(uint byte) {
  float s = float(byte & 255u) / 255.0;
  return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

void main() {
#ifdef TILE  // glTF's attributes
  #if defined(USE_COLOR) || defined(USE_COLOR_ALPHA)
    vColour = color.rgb;
  #endif
  vNormal = mat3(T_scan_shown) * mat3(modelMatrix) * normal;
  vec4 shown = modelMatrix * vec4(position, 1.0);
#else
  vec3 q = vec3(vertexBits.x & 65535u, vertexBits.x >> 16, vertexBits.y & 65535u);
  ivec3 n = ivec3(vertexBits.www << uvec3(24u, 16u, 8u)) >> 24;
  uint rgba = vertexBits.z;
  vColour = vec3(linearOf(rgba), linearOf(rgba >> 8), linearOf(rgba >> 16));
  vCoverage = float(rgba >> 24) / 255.0;
  vNormal = vec3(n) / 127.0;
  vec4 shown = modelMatrix * vec4(q, 1.0);
#endif
  vPosition = (T_scan_shown * shown).xyz;
  vec4 seen = viewMatrix * shown;
  vSeen = seen.xyz;
  gl_Position = projectionMatrix * seen;
}`;

const kFragmentShader = `
uniform int shading;
uniform mat3 R_eye_scan;
uniform bool isCropping;
uniform vec3 cropLow;
uniform vec3 cropHigh;
varying vec3 vColour;
varying vec3 vNormal;
varying vec3 vPosition;
varying vec3 vSeen;
varying float vCoverage;

vec3 linearOf(vec3 s) { return mix(s / 12.92, pow((s + 0.055) / 1.055, vec3(2.4)), step(0.04045, s)); }

// Dark violet, teal, pale yellow: they differ in brightness, too.
vec3 coverageColour(float c) {
  vec3 low = vec3(0.38, 0.10, 0.36), middle = vec3(0.13, 0.55, 0.56), high = vec3(0.96, 0.91, 0.45);
  return linearOf(c < 0.5 ? mix(low, middle, 2.0 * c) : mix(middle, high, 2.0 * c - 1.0));
}

vec3 eyeNormal() {
  vec3 n = R_eye_scan * vNormal;
  if (dot(n, n) < 0.01) { n = cross(dFdx(vSeen), dFdy(vSeen)); }
  n = normalize(n);
  return gl_FrontFacing ? n : -n;
}

// A lamp at the viewer's left shoulder, one far to the right, and light from above.
float light(vec3 n) {
  float key = max(dot(n, normalize(vec3(-0.45, 0.55, 0.70))), 0.0);
  float fill = max(dot(n, normalize(vec3(0.80, 0.10, 0.40))), 0.0);
  return 0.20 + 0.12 * n.y + 0.80 * key + 0.22 * fill;
}

void main() {
  vec3 own = vColour;
  #ifdef CLAY
    own = vec3(0.52, 0.50, 0.47);
  #endif
  vec3 colour = own;
  if (shading == 0) {
    colour = own * light(eyeNormal());
  } else if (shading == 2) {
    colour = linearOf(0.5 + 0.5 * eyeNormal() * R_eye_scan);
  } else if (shading == 3) {
    colour = coverageColour(vCoverage) * (0.45 + 0.55 * light(eyeNormal()));
  }
  if (!gl_FrontFacing) { colour = mix(colour, vec3(0.05, 0.07, 0.10), 0.80) * (0.5 + 0.5 * light(eyeNormal())); }
  if (isCropping && (any(lessThan(vPosition, cropLow)) || any(greaterThan(vPosition, cropHigh)))) {
    colour = mix(vec3(dot(colour, vec3(0.21, 0.72, 0.07))), vec3(0.02, 0.03, 0.04), 0.75);
  }
  gl_FragColor = vec4(colour, 1.0);
  #include <colorspace_fragment>
}`;

/// Materials over the same uniforms: for chunks and for tiles, with colours and without.
export class MeshMaterials {
  constructor() {
    this.uniforms = {
      shading: { value: 0 },
      T_scan_shown: { value: new Matrix4() },
      R_eye_scan: { value: null },
      isCropping: { value: false },
      cropLow: { value: new Vector3() },
      cropHigh: { value: new Vector3() },
    };
    this.colour = this.material({});
    this.clay = this.material({ CLAY: 1 });
    this.tile = this.material({ TILE: 1 }, { vertexColors: true });
    this.clayTile = this.material({ TILE: 1, CLAY: 1 });
  }

  material(defines, more = {}) {
    return new ShaderMaterial({
      vertexShader: kVertexShader, fragmentShader: kFragmentShader, uniforms: this.uniforms, defines, side: DoubleSide, ...more,
    });
  }

  set shading(name) { this.uniforms.shading.value = kShadings.indexOf(name); }
  get shading() { return kShadings[this.uniforms.shading.value]; }

  /// The user looks into a room through the backs of its walls, which are not drawn. An object's backs are drawn dark.
  set showsBacks(value) {
    for (const material of [this.colour, this.clay, this.tile, this.clayTile]) { material.side = value ? DoubleSide : FrontSide; }
  }

  get areBacksShown() { return this.colour.side === DoubleSide; }

  /// Draws everything outside of the box grey; null: no box.
  set crop(box) {
    this.uniforms.isCropping.value = box !== null;
    if (box) {
      this.uniforms.cropLow.value.copy(box.min);
      this.uniforms.cropHigh.value.copy(box.max);
    }
  }
}
