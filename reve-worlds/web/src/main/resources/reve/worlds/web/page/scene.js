// SPDX-License-Identifier: Apache-2.0
// Draws a View. Bodies are drawn as instances, springs as lines or, if they have a width, as
// cylinders, and surfaces as triangles. It also draws aids such as a ground, a grid and arrows.
import * as THREE from "three";
import { OrbitControls } from "./three/OrbitControls.js";
import { CAPSULE, CYLINDER, ELLIPSOID, MESH_SHAPE, NONE, PLANE, SPHERE } from "./view.js";

const LABELS = 48;
const TRAIL_POINTS = 240;
const TRAIL_ITEMS = 120;
/** Number of lines of a circle in the outline of a sensor. */
const RING = 32;
const MANY = 600;
/** Colour of springs without a colour of their own. Its low byte is red. */
const SPRING_RGBA = 0xffa59a8f;
const UP = new THREE.Vector3(0, 1, 0);
const SLOW_SECONDS = 0.09;
/** Maximum length of a velocity arrow, as the time in which the body moves along it [s]. This limit
 *  keeps the arrows of bodies almost at rest short. */
const MOST_SECONDS = 2;
/** Bounds for objects whose parts move. They are infinite, so that three.js does not compute
 *  bounds. */
const EVERYWHERE = new THREE.Sphere(new THREE.Vector3(), Infinity);
const LINEAR = Float32Array.from({ length: 256 }, (_, i) => {
  const c = i / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
});

/** Returns whether an item has a colour of its own with alpha 0, which hides it. */
function isHidden({ colour }) {
  return colour !== undefined && colour >>> 24 === 0;
}

/** Writes the linear red, green and blue of a colour into an array. */
function putColour(rgba, array, at) {
  for (let k = 0; k < 3; k++) array[at + k] = LINEAR[(rgba >>> (8 * k)) & 255];
}

/** Adds a grid in metres to a material; with `fade`, the grid fades out with distance. */
function withGrid(material, uniforms, fade) {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nvarying vec3 vPlace;")
      .replace(
        "#include <begin_vertex>",
        `#include <begin_vertex>
        #ifdef USE_INSTANCING
          vPlace = (modelMatrix * instanceMatrix * vec4(position, 1.0)).xyz;
        #else
          vPlace = (modelMatrix * vec4(position, 1.0)).xyz;
        #endif`,
      );
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying vec3 vPlace;\nuniform float uStep;\nuniform vec3 uCentre;\nuniform float uReach;\nuniform float uGrid;")
      .replace(
        "#include <color_fragment>",
        `#include <color_fragment>
        vec2 cell = vPlace.xz / uStep;
        vec2 width = fwidth(cell);
        vec2 near = abs(fract(cell - 0.5) - 0.5) / max(width, vec2(1e-6));
        float line = (1.0 - min(min(near.x, near.y), 1.0)) * clamp(1.4 - 2.0 * max(width.x, width.y), 0.0, 1.0);
        diffuseColor.rgb *= 1.0 - 0.28 * uGrid * line;
        ${fade ? "diffuseColor.a *= 1.0 - smoothstep(0.25, 1.0, distance(vPlace.xz, uCentre.xz) / uReach);" : ""}`,
      );
  };
  return material;
}

/** Returns the lines of a sensor's outline, two points for each, for a reach of 1 m along +Z. */
function outline({ angle, aspect }) {
  const along = (x, y, z) => new THREE.Vector3(x, y, z).normalize();
  const ring = (point) => Array.from({ length: RING }, (_, i) => [point(i), point((i + 1) % RING)]).flat();
  const turn = (i) => (2 * Math.PI * i) / RING;
  if (aspect) {
    const y = Math.tan(angle / 2);
    const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([u, v]) => [u * y * aspect, v * y, 1]);
    return corners.flatMap((corner, i) => [new THREE.Vector3(), along(...corner), along(...corner), along(...corners[(i + 1) % 4])]);
  }
  if (angle > 2 * Math.PI - 1e-6) {
    return [
      ...ring((i) => along(Math.cos(turn(i)), Math.sin(turn(i)), 0)),
      ...ring((i) => along(Math.cos(turn(i)), 0, Math.sin(turn(i)))),
      ...ring((i) => along(0, Math.cos(turn(i)), Math.sin(turn(i)))),
    ];
  }
  const wide = Math.sin(angle / 2);
  const deep = Math.cos(angle / 2);
  const rim = (i) => along(wide * Math.cos(turn(i)), wide * Math.sin(turn(i)), deep);
  return [...ring(rim), ...[0, 1, 2, 3].flatMap((i) => [new THREE.Vector3(), rim((i * RING) / 4)])];
}

export class Scene {
  constructor(canvas, labels, view) {
    this.canvas = canvas;
    this.labelLayer = labels;
    this.view = view;
    this.selected = null;
    this.highlighted = new Set();
    this.options = {
      grid: true, shadows: true, springs: true, surfaces: true, labels: true, boxes: false, trails: false,
      velocity: false, force: false, sensors: false,
    };
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.05;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.three = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.01, 1e6);
    this.camera.position.set(8, 6, 12);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.hemisphere = new THREE.HemisphereLight(0xdfeeff, 0x4a4f55, 1.5);
    this.sun = new THREE.DirectionalLight(0xfff4e2, 2.6);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.02;
    this.three.add(this.hemisphere, this.sun, this.sun.target);
    this.gridUniforms = { uStep: { value: 1 }, uCentre: { value: new THREE.Vector3() }, uReach: { value: 100 }, uGrid: { value: 1 } };
    this.ground = new THREE.Mesh(
      new THREE.CircleGeometry(1, 96).rotateX(-Math.PI / 2),
      withGrid(new THREE.MeshStandardMaterial({ color: 0xaab4bb, roughness: 0.95, transparent: true }), this.gridUniforms, true),
    );
    this.ground.receiveShadow = true;
    this.ground.renderOrder = -1;
    this.three.add(this.ground);
    this.groups = new Map();
    this.geometries = new Map();
    this.materials = new Map();
    this.lines = this.#lineObject(0xffffff, 1);
    this.lines.material.vertexColors = true;
    this.rodMesh = this.#rodObject(8);
    this.velocityLines = this.#lineObject(0x4fd1c5, 2);
    this.forceLines = this.#lineObject(0xf6ad55, 2);
    this.boxLines = this.#lineObject(0x93a4b3, 1);
    this.sensorLines = this.#lineObject(0xb794f4, 1);
    this.trailLines = this.#lineObject(0x6fa8dc, 1);
    this.surfaces = new THREE.Mesh(
      new THREE.BufferGeometry(),
      new THREE.MeshStandardMaterial({ vertexColors: true, side: THREE.DoubleSide, flatShading: true, roughness: 0.7 }),
    );
    this.surfaces.frustumCulled = false;
    this.surfaces.geometry.boundingSphere = EVERYWHERE;
    this.surfaces.castShadow = this.surfaces.receiveShadow = true;
    this.three.add(this.surfaces);
    this.marker = new THREE.LineSegments(new THREE.EdgesGeometry(new THREE.BoxGeometry(1, 1, 1)), new THREE.LineBasicMaterial({ color: 0x4fd1c5 }));
    this.marker.visible = false;
    this.three.add(this.marker);
    this.ghost = new THREE.InstancedMesh(new THREE.SphereGeometry(0.5, 12, 8), new THREE.MeshBasicMaterial({ color: 0xffffff, transparent: true, opacity: 0.3 }), 1);
    this.ghost.count = 0;
    this.ghost.frustumCulled = false;
    this.ghost.boundingSphere = EVERYWHERE;
    this.three.add(this.ghost);
    this.quality = 2;
    this.slow = 0;
    this.built = -1;
    this.trails = new Map();
    this.flying = false;
    this.following = false;
    this.keys = new Set();
    this.followed = new THREE.Vector3();
    this.raycaster = new THREE.Raycaster();
    this.raycaster.params.Line.threshold = 0.05;
    this.frames = 0;
    this.setTheme(true);
  }

  #lineObject(colour, width) {
    const lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: colour, linewidth: width }));
    lines.frustumCulled = false;
    lines.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(0), 3));
    lines.geometry.boundingSphere = EVERYWHERE;
    this.three.add(lines);
    return lines;
  }

  /** Returns the springs that have a width, as cylinders. */
  #rodObject(capacity) {
    const rods = new THREE.InstancedMesh(new THREE.CylinderGeometry(0.5, 0.5, 1, 16), new THREE.MeshStandardMaterial({ roughness: 0.45 }), capacity);
    rods.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    rods.instanceColor = new THREE.InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    rods.count = 0;
    rods.frustumCulled = false;
    rods.boundingSphere = EVERYWHERE;
    rods.castShadow = rods.receiveShadow = true;
    this.three.add(rods);
    return rods;
  }

  setTheme(dark) {
    const sky = new THREE.Color(dark ? 0x1b2833 : 0xdfe8ef);
    this.three.background = sky;
    this.ground.material.color.set(dark ? 0x4a5a67 : 0xd8dee3);
    this.hemisphere.intensity = dark ? 1.3 : 1.7;
  }

  // ---- structure ----

  #rebuild() {
    const view = this.view;
    this.built = view.version;
    const wanted = new Map();
    this.bodies = [];
    this.springs = [];
    this.rods = [];
    this.triangles = [];
    let hasPlane = false;
    for (const item of view.items) {
      if (!item) continue;
      if (item.kind === "body") {
        if (!item.shape) continue;
        this.bodies.push(item.slot);
        hasPlane ||= item.shape === PLANE;
        const key = this.#key(item);
        if (!wanted.has(key)) wanted.set(key, []);
        wanted.get(key).push(item.slot);
      } else if (isHidden(item)) {
        continue;
      } else if (item.refers?.length === 2) {
        (item.width ? this.rods : this.springs).push(item);
      } else if (item.refers?.length === 3) {
        this.triangles.push(item);
      }
    }
    this.hasPlane = hasPlane;
    for (const [key, group] of this.groups) {
      if (!wanted.has(key)) {
        this.three.remove(group.mesh);
        group.mesh.dispose();
        this.groups.delete(key);
      }
    }
    for (const [key, slots] of wanted) {
      let group = this.groups.get(key);
      if (!group || group.capacity < slots.length) {
        if (group) {
          this.three.remove(group.mesh);
          group.mesh.dispose();
        }
        group = this.#group(view.items[slots[0]], Math.max(8, Math.ceil(slots.length * 1.25)));
        this.groups.set(key, group);
      }
      group.slots = slots;
      group.mesh.count = slots.length;
    }
    this.#colourSprings();
    const corners = 3 * this.triangles.length;
    this.surfaces.geometry.dispose();
    this.surfaces.geometry = new THREE.BufferGeometry();
    this.surfaces.geometry.boundingSphere = EVERYWHERE;
    this.surfaces.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
    this.surfaces.geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
  }

  #colourSprings() {
    const places = this.#resize(this.lines, 6 * this.springs.length);
    const colours = new Float32Array(places.array.length);
    for (const [i, { colour }] of this.springs.entries()) {
      putColour(colour ?? SPRING_RGBA, colours, 6 * i);
      putColour(colour ?? SPRING_RGBA, colours, 6 * i + 3);
    }
    this.lines.geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    if (this.rodMesh.instanceMatrix.count < this.rods.length) {
      this.three.remove(this.rodMesh);
      this.rodMesh.dispose();
      this.rodMesh = this.#rodObject(Math.ceil(this.rods.length * 1.25));
    }
    this.rodMesh.count = this.rods.length;
    for (const [i, { colour }] of this.rods.entries()) putColour(colour ?? SPRING_RGBA, this.rodMesh.instanceColor.array, 3 * i);
    this.rodMesh.instanceColor.needsUpdate = true;
  }

  #placeRods() {
    const { position } = this.view;
    const matrix = new THREE.Matrix4(), turn = new THREE.Quaternion(), middle = new THREE.Vector3(), size = new THREE.Vector3();
    const from = new THREE.Vector3(), along = new THREE.Vector3();
    for (const [i, { refers: [a, b], width }] of this.rods.entries()) {
      const whole = a >= 0 && b >= 0;
      if (whole) {
        from.fromArray(position, 3 * a);
        along.fromArray(position, 3 * b).sub(from);
        middle.copy(from).addScaledVector(along, 0.5);
        size.set(width, along.length(), width);
        turn.setFromUnitVectors(UP, along.lengthSq() > 0 ? along.normalize() : UP);
        matrix.compose(middle, turn, size);
      } else {
        matrix.makeScale(0, 0, 0);
      }
      this.rodMesh.setMatrixAt(i, matrix);
    }
    this.rodMesh.instanceMatrix.needsUpdate = true;
  }

  #key(item) {
    const material = item.material ? JSON.stringify(item.material) : "";
    return item.shape === MESH_SHAPE ? `mesh ${item.mesh} ${material}` : `${item.shape} ${material}`;
  }

  #group(item, capacity) {
    const geometry = this.#geometry(item);
    const mesh = new THREE.InstancedMesh(geometry, this.#material(item), capacity);
    mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    mesh.instanceColor = new THREE.InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    mesh.frustumCulled = false;
    mesh.boundingSphere = EVERYWHERE;
    mesh.castShadow = item.shape !== PLANE;
    mesh.receiveShadow = true;
    this.three.add(mesh);
    return { mesh, capacity, slots: [], shape: item.shape };
  }

  #geometry(item) {
    const detailed = this.bodies.length < MANY || this.view.items.length < MANY;
    const key = item.shape === MESH_SHAPE ? `mesh ${item.mesh}` : `${item.shape} ${detailed}`;
    let geometry = this.geometries.get(key);
    if (geometry) return geometry;
    switch (item.shape) {
      case SPHERE:
      case ELLIPSOID: // a sphere that its size stretches
        geometry = detailed ? new THREE.SphereGeometry(0.5, 40, 24) : new THREE.SphereGeometry(0.5, 14, 9);
        break;
      case CAPSULE: // the mesh's caps are round if the height is twice the width
        geometry = new THREE.CapsuleGeometry(0.5, 1, detailed ? 12 : 4, detailed ? 32 : 12).scale(1, 0.5, 1);
        break;
      case CYLINDER:
        geometry = new THREE.CylinderGeometry(0.5, 0.5, 1, detailed ? 48 : 14);
        break;
      case PLANE:
        geometry = new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2);
        break;
      case MESH_SHAPE:
        geometry = this.#meshGeometry(this.view.meshes.get(item.mesh));
        break;
      default:
        geometry = new THREE.BoxGeometry(1, 1, 1);
    }
    this.geometries.set(key, geometry);
    return geometry;
  }

  #meshGeometry(mesh) {
    if (!mesh) return new THREE.BoxGeometry(1, 1, 1);
    let geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(mesh.vertices, 3));
    if (mesh.normals) geometry.setAttribute("normal", new THREE.BufferAttribute(mesh.normals, 3));
    if (mesh.coordinates) geometry.setAttribute("uv", new THREE.BufferAttribute(mesh.coordinates, 2));
    if (mesh.colours) {
      const colours = new Float32Array((mesh.colours.length / 4) * 3);
      for (let i = 0, c = 0; i < mesh.colours.length; i += 4) for (let k = 0; k < 3; k++) colours[c++] = LINEAR[mesh.colours[i + k]];
      geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    }
    geometry.setIndex(new THREE.BufferAttribute(mesh.indices, 1));
    for (const [i, part] of mesh.parts.entries()) geometry.addGroup(3 * part.first, 3 * part.count, i);
    if (!mesh.normals) {
      const groups = geometry.groups;
      geometry = geometry.toNonIndexed();
      for (const group of groups) geometry.addGroup(group.start, group.count, group.materialIndex);
      geometry.computeVertexNormals();
    }
    return geometry;
  }

  #material(item) {
    const mesh = item.shape === MESH_SHAPE ? this.view.meshes.get(item.mesh) : null;
    if (mesh?.parts.length && !item.material) {
      return mesh.parts.map((part) => this.#standard(part.material, item.shape, mesh));
    }
    return this.#standard(item.material, item.shape, mesh);
  }

  #standard(given, shape, mesh) {
    const material = new THREE.MeshStandardMaterial({
      roughness: given?.roughness ?? (shape === PLANE ? 0.9 : 0.45),
      metalness: given?.metallic ?? 0,
      side: shape === PLANE || shape === MESH_SHAPE ? THREE.DoubleSide : THREE.FrontSide,
      vertexColors: Boolean(mesh?.colours),
    });
    if (given) {
      const c = given.colour;
      material.color.setRGB(LINEAR[c & 255], LINEAR[(c >>> 8) & 255], LINEAR[(c >>> 16) & 255], THREE.LinearSRGBColorSpace);
    }
    if (given?.texture) material.map = this.#texture(given.texture);
    return shape === PLANE ? withGrid(material, this.gridUniforms, false) : material;
  }

  #texture(id) {
    const source = this.view.textures.get(id);
    if (!source) return null;
    if (!source.three) {
      source.three = new THREE.DataTexture(source.rgba, source.width, source.height, THREE.RGBAFormat);
      source.three.colorSpace = THREE.SRGBColorSpace;
      source.three.wrapS = source.three.wrapT = THREE.RepeatWrapping;
      source.three.magFilter = THREE.LinearFilter;
      source.three.minFilter = THREE.LinearMipmapLinearFilter;
      source.three.generateMipmaps = true;
      source.three.flipY = false;
      source.three.needsUpdate = true;
    }
    return source.three;
  }

  // ---- each frame ----

  #place() {
    const { position, orientation, size, colourBytes } = this.view;
    for (const group of this.groups.values()) {
      const matrices = group.mesh.instanceMatrix.array;
      const colours = group.mesh.instanceColor.array;
      const isMesh = group.shape === MESH_SHAPE;
      const lift = group.shape === PLANE ? 1 : 0;
      for (let i = 0, m = 0, c = 0; i < group.slots.length; i++, m += 16) {
        const slot = group.slots[i];
        const s = 3 * slot;
        const q = 4 * slot;
        const shown = colourBytes[q + 3] !== 0 ? 1 : 0;
        const sx = shown * (isMesh ? 1 : size[s]);
        const sy = shown * (isMesh ? 1 : lift || size[s + 1]);
        const sz = shown * (isMesh ? 1 : size[s + 2]);
        let x = orientation[q], y = orientation[q + 1], z = orientation[q + 2], w = orientation[q + 3];
        const length = Math.hypot(x, y, z, w) || 1;
        x /= length; y /= length; z /= length; w /= length;
        matrices[m] = (1 - 2 * (y * y + z * z)) * sx;
        matrices[m + 1] = 2 * (x * y + w * z) * sx;
        matrices[m + 2] = 2 * (x * z - w * y) * sx;
        matrices[m + 3] = 0;
        matrices[m + 4] = 2 * (x * y - w * z) * sy;
        matrices[m + 5] = (1 - 2 * (x * x + z * z)) * sy;
        matrices[m + 6] = 2 * (y * z + w * x) * sy;
        matrices[m + 7] = 0;
        matrices[m + 8] = 2 * (x * z + w * y) * sz;
        matrices[m + 9] = 2 * (y * z - w * x) * sz;
        matrices[m + 10] = (1 - 2 * (x * x + y * y)) * sz;
        matrices[m + 11] = 0;
        matrices[m + 12] = position[s];
        matrices[m + 13] = position[s + 1];
        matrices[m + 14] = position[s + 2];
        matrices[m + 15] = 1;
        const dim = this.highlighted.size > 0 && !this.highlighted.has(slot) ? 0.25 : 1;
        colours[c++] = dim * LINEAR[colourBytes[q]];
        colours[c++] = dim * LINEAR[colourBytes[q + 1]];
        colours[c++] = dim * LINEAR[colourBytes[q + 2]];
      }
      group.mesh.instanceMatrix.needsUpdate = true;
      group.mesh.instanceColor.needsUpdate = true;
    }
  }

  #resize(lines, floats) {
    const attribute = lines.geometry.getAttribute("position");
    if (attribute.array.length < floats) {
      lines.geometry.dispose();
      lines.geometry = new THREE.BufferGeometry();
      lines.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(Math.ceil(floats * 1.25)), 3));
      lines.geometry.boundingSphere = EVERYWHERE;
    }
    lines.geometry.setDrawRange(0, floats / 3);
    return lines.geometry.getAttribute("position");
  }

  #placeLines() {
    const { position } = this.view;
    this.lines.visible = this.options.springs;
    this.rodMesh.visible = this.options.springs;
    if (this.options.springs) {
      this.#placeRods();
      const attribute = this.lines.geometry.getAttribute("position");
      const to = attribute.array;
      let at = 0;
      for (const { refers } of this.springs) {
        const [a, b] = refers;
        const whole = a >= 0 && b >= 0;
        for (const end of [a, b]) for (let k = 0; k < 3; k++) to[at++] = whole ? position[3 * end + k] : 0;
      }
      attribute.needsUpdate = true;
    }
    this.surfaces.visible = this.options.surfaces && this.triangles.length > 0;
    if (this.surfaces.visible) {
      const places = this.surfaces.geometry.getAttribute("position");
      const colours = this.surfaces.geometry.getAttribute("color");
      const bytes = this.view.colourBytes;
      let at = 0;
      for (const { refers, colour } of this.triangles) {
        const whole = refers.every((slot) => slot >= 0) && (colour !== undefined || refers.some((slot) => bytes[4 * slot + 3] !== 0));
        for (const slot of refers) {
          for (let k = 0; k < 3; k++, at++) {
            places.array[at] = whole ? position[3 * slot + k] : 0;
            const byte = colour === undefined ? bytes[4 * slot + k] : (colour >>> (8 * k)) & 255;
            colours.array[at] = whole ? LINEAR[byte] : 0;
          }
        }
      }
      places.needsUpdate = colours.needsUpdate = true;
      this.surfaces.geometry.computeVertexNormals();
    }
    this.#arrows(this.velocityLines, this.options.velocity, this.view.velocity, MOST_SECONDS);
    this.#arrows(this.forceLines, this.options.force, this.view.force, Infinity);
    this.#boxes();
    this.#sensors();
    this.#trail();
  }

  /** Draws arrows from the bodies along a vector column. All arrows have one scale: the longest
   *  arrow is an eighth of the scene. The scale does not exceed `most`, so the arrows may be
   *  shorter. */
  #arrows(lines, on, column, most) {
    lines.visible = on;
    if (!on) return;
    const { position } = this.view;
    let longest = 0;
    for (const slot of this.bodies) longest = Math.max(longest, Math.hypot(column[3 * slot], column[3 * slot + 1], column[3 * slot + 2]));
    const scale = longest > 0 ? Math.min((this.radius ?? 10) / 4 / longest, most) : 0;
    const attribute = this.#resize(lines, 18 * this.bodies.length);
    const to = attribute.array;
    const tip = new THREE.Vector3(), along = new THREE.Vector3(), side = new THREE.Vector3();
    let at = 0;
    for (const slot of this.bodies) {
      const s = 3 * slot;
      along.set(column[s], column[s + 1], column[s + 2]).multiplyScalar(scale);
      tip.set(position[s], position[s + 1], position[s + 2]).add(along);
      side.crossVectors(along, this.camera.getWorldDirection(side));
      side.setLength(along.length() * 0.1);
      const put = (x, y, z) => { to[at++] = x; to[at++] = y; to[at++] = z; };
      put(position[s], position[s + 1], position[s + 2]);
      put(tip.x, tip.y, tip.z);
      for (const sign of [1, -1]) {
        put(tip.x, tip.y, tip.z);
        put(tip.x - along.x * 0.22 + sign * side.x, tip.y - along.y * 0.22 + sign * side.y, tip.z - along.z * 0.22 + sign * side.z);
      }
    }
    attribute.needsUpdate = true;
  }

  #boxes() {
    this.boxLines.visible = this.options.boxes;
    if (!this.options.boxes) return;
    const { position, orientation, size } = this.view;
    const bodies = this.bodies.filter((slot) => this.view.items[slot].shape !== PLANE);
    const attribute = this.#resize(this.boxLines, 72 * bodies.length);
    const corner = new THREE.Vector3(), turn = new THREE.Quaternion();
    let at = 0;
    for (const slot of bodies) {
      turn.fromArray(orientation, 4 * slot);
      for (let axis = 0; axis < 3; axis++) {
        for (const u of [-0.5, 0.5]) for (const v of [-0.5, 0.5]) for (const end of [-0.5, 0.5]) {
          const c = [0, 0, 0];
          c[axis] = end * size[3 * slot + axis];
          c[(axis + 1) % 3] = u * size[3 * slot + ((axis + 1) % 3)];
          c[(axis + 2) % 3] = v * size[3 * slot + ((axis + 2) % 3)];
          corner.fromArray(c).applyQuaternion(turn);
          attribute.array[at++] = corner.x + position[3 * slot];
          attribute.array[at++] = corner.y + position[3 * slot + 1];
          attribute.array[at++] = corner.z + position[3 * slot + 2];
        }
      }
    }
    attribute.needsUpdate = true;
  }

  /** Draws the reach of the bodies' sensors: cones along the body's +Z axis, pyramids of cameras, and
   *  spheres of sensors that sense in all directions. A sensor without a range reaches through half
   *  of the scene. */
  #sensors() {
    this.sensorLines.visible = this.options.sensors;
    if (!this.options.sensors) return;
    const { position, orientation, items } = this.view;
    const lines = [];
    for (const item of items) {
      if (item?.kind !== "body" || !item.sensors) continue;
      const origin = new THREE.Vector3().fromArray(position, 3 * item.slot);
      const turn = new THREE.Quaternion().fromArray(orientation, 4 * item.slot);
      for (const sensor of item.sensors) {
        const reach = sensor.range ?? (this.radius ?? 10) / 2;
        for (const point of outline(sensor)) lines.push(point.multiplyScalar(reach).applyQuaternion(turn).add(origin));
      }
    }
    const attribute = this.#resize(this.sensorLines, 3 * lines.length);
    lines.forEach((point, i) => point.toArray(attribute.array, 3 * i));
    attribute.needsUpdate = true;
  }

  #trail() {
    this.trailLines.visible = this.options.trails;
    if (!this.options.trails) {
      this.trails.clear();
      return;
    }
    const slots = this.selected !== null && this.bodies.length > TRAIL_ITEMS ? [this.selected] : this.bodies.slice(0, TRAIL_ITEMS);
    const { position } = this.view;
    for (const slot of slots) {
      let points = this.trails.get(slot);
      if (!points) this.trails.set(slot, (points = []));
      const s = 3 * slot;
      const last = points.length - 3;
      const step = 0.002 * (this.radius ?? 10);
      if (last >= 0 && Math.hypot(points[last] - position[s], points[last + 1] - position[s + 1], points[last + 2] - position[s + 2]) < step) continue;
      points.push(position[s], position[s + 1], position[s + 2]);
      if (points.length > 3 * TRAIL_POINTS) points.splice(0, 3);
    }
    let segments = 0;
    for (const points of this.trails.values()) segments += Math.max(0, points.length / 3 - 1);
    const attribute = this.#resize(this.trailLines, 6 * segments);
    let at = 0;
    for (const points of this.trails.values()) {
      for (let i = 0; i + 5 < points.length; i += 3) for (let k = 0; k < 6; k++) attribute.array[at++] = points[i + k];
    }
    attribute.needsUpdate = true;
  }

  /** Returns the box around all shown bodies except planes. */
  bounds() {
    const box = new THREE.Box3();
    const { position, size, colourBytes } = this.view;
    const add = (planes) => {
      for (const slot of this.bodies ?? []) {
        const item = this.view.items[slot];
        if ((item.shape === PLANE) !== planes || colourBytes[4 * slot + 3] === 0) continue;
        const r = Math.hypot(size[3 * slot], size[3 * slot + 1], size[3 * slot + 2]) / 2 * (item.shape === SPHERE ? 0.58 : 1);
        box.expandByPoint(new THREE.Vector3(position[3 * slot] - r, position[3 * slot + 1] - r, position[3 * slot + 2] - r));
        box.expandByPoint(new THREE.Vector3(position[3 * slot] + r, position[3 * slot + 1] + r, position[3 * slot + 2] + r));
      }
    };
    add(false);
    if (box.isEmpty()) add(true);
    return box;
  }

  /** Moves the camera to the world's own viewpoint. Shows all bodies if the world has no viewpoint.
   *  */
  #first() {
    const own = this.view.camera;
    if (!own) {
      this.fit();
      return;
    }
    this.wasFitted = true;
    this.camera.position.fromArray(own.eye);
    this.camera.up.fromArray(own.up);
    this.camera.fov = Math.min(100, (own.fov * 180) / Math.PI);
    this.controls.target.fromArray(own.target);
    this.#scale();
    this.controls.update();
    this.camera.updateMatrixWorld();
    const sight = new THREE.Frustum().setFromProjectionMatrix(
      new THREE.Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse),
    );
    const place = new THREE.Vector3();
    const seen = this.bodies.some(
      (slot) => this.view.items[slot].shape !== PLANE && sight.containsPoint(place.fromArray(this.view.position, 3 * slot)),
    );
    if (!seen) this.fit(); // no body is visible from the world's viewpoint any more
  }

  /** Reduces the quality of drawing if the machine is too slow, for example without a GPU. */
  #adapt(seconds) {
    this.slow = this.slow * 0.9 + seconds * 0.1;
    if (this.quality > 0 && this.slow > SLOW_SECONDS && this.frames > 30) {
      this.quality--;
      this.slow = 0;
      this.frames = 0;
      if (this.quality === 0) this.renderer.setPixelRatio(0.6 * Math.min(devicePixelRatio, 2));
      this.width = 0;
    }
  }

  /** Moves the camera so that all bodies are visible, or the body of one slot. */
  fit(slot = null) {
    const box = slot === null ? this.bounds() : this.#boxOf(slot);
    if (box.isEmpty()) return;
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const radius = Math.max(sphere.radius, 1e-3);
    const narrow = Math.min(1, this.camera.aspect);
    const distance = (radius * 1.12) / Math.sin((this.camera.fov * Math.PI) / 360) / narrow;
    const direction = this.camera.position.clone().sub(this.controls.target);
    if (!this.wasFitted) direction.set(0.45, 0.42, 1);
    this.wasFitted = true;
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(direction.normalize(), distance);
    this.#scale(box);
  }

  #boxOf(slot) {
    const { position, size } = this.view;
    const r = Math.max(...size.subarray(3 * slot, 3 * slot + 3), 0.1) * 1.5;
    const centre = new THREE.Vector3().fromArray(position, 3 * slot);
    return new THREE.Box3(centre.clone().subScalar(r), centre.clone().addScalar(r));
  }

  /** Rotates the camera around its target by x and y steps (about 5 degrees each). */
  orbit(x, y) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const place = new THREE.Spherical().setFromVector3(offset);
    place.theta += x * 0.09;
    place.phi = Math.min(Math.max(place.phi + y * 0.07, 0.02), Math.PI - 0.02);
    this.camera.position.copy(this.controls.target).add(offset.setFromSpherical(place));
  }

  /** Multiplies the distance of the camera from its target. */
  zoom(factor) {
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(offset);
  }

  /** Adapts ground, light and depth range to the size of the scene. */
  #scale(box = this.bounds()) {
    if (box.isEmpty()) return;
    const all = this.bounds();
    const sphere = all.getBoundingSphere(new THREE.Sphere());
    const radius = Math.max(sphere.radius, 1e-3);
    this.radius = radius;
    this.camera.near = radius / 500;
    this.camera.far = radius * 400;
    this.camera.updateProjectionMatrix();
    const step = 10 ** Math.floor(Math.log10(radius));
    this.gridUniforms.uStep.value = step > radius / 2 ? step / 2 : step;
    this.gridUniforms.uCentre.value.copy(sphere.center);
    this.gridUniforms.uReach.value = radius * 12;
    const low = all.min.y;
    const level = low >= -1e-3 && low <= 2 * radius ? 0 : Math.floor(low / step) * step;
    this.ground.position.set(sphere.center.x, level, sphere.center.z);
    this.ground.scale.setScalar(radius * 12);
    const reach = radius * 1.7;
    this.sun.position.copy(sphere.center).add(new THREE.Vector3(0.55, 1, 0.4).normalize().multiplyScalar(radius * 4));
    this.sun.target.position.copy(sphere.center);
    const shadow = this.sun.shadow.camera;
    shadow.left = shadow.bottom = -reach;
    shadow.right = shadow.top = reach;
    shadow.near = radius * 0.5;
    shadow.far = radius * 9;
    shadow.updateProjectionMatrix();
    this.raycaster.params.Line.threshold = radius / 120;
  }

  /** Returns the side on which the camera sees the body of a slot, from -1 (left) to 1 (right). */
  side(slot) {
    const place = new THREE.Vector3().fromArray(this.view.position, 3 * slot).project(this.camera);
    return Number.isFinite(place.x) ? Math.min(1, Math.max(-1, place.x)) : 0;
  }

  /** Returns the slot of the item at a point of the canvas [px], or null. */
  pick(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    this.raycaster.setFromCamera(at, this.camera);
    let best = null;
    for (const group of this.groups.values()) {
      for (const hit of this.raycaster.intersectObject(group.mesh, false)) {
        const distance = hit.distance + (group.shape === PLANE ? 1e-3 : 0);
        if (!best || distance < best.distance) best = { distance, slot: group.slots[hit.instanceId] };
        break;
      }
    }
    if (this.rodMesh.visible && this.rods?.length) {
      const hit = this.raycaster.intersectObject(this.rodMesh, false)[0];
      if (hit && (!best || hit.distance < best.distance)) best = { distance: hit.distance, slot: this.rods[hit.instanceId].slot };
    }
    for (const [object, items, per] of [[this.lines, this.springs, 2], [this.surfaces, this.triangles, 3]]) {
      if (!object.visible || items.length === 0) continue;
      const hit = this.raycaster.intersectObject(object, false)[0];
      const place = hit && (per === 2 ? Math.floor(hit.index / 2) : Math.floor(hit.faceIndex));
      if (hit && items[place] && (!best || hit.distance < best.distance)) best = { distance: hit.distance, slot: items[place].slot };
    }
    return best?.slot ?? null;
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === this.width && clientHeight === this.height) return;
    this.width = clientWidth;
    this.height = clientHeight;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / Math.max(1, clientHeight);
    this.camera.updateProjectionMatrix();
  }

  /** Shows another state of the world, such as a predicted one, as white shapes. The argument null
   *  hides it. */
  showGhost(items) {
    this.ghost.count = 0;
    if (!items) return;
    const placed = items.filter((item) => item.location && item.symbols?.dimensions && item.symbols.dimensions[1] > 0);
    if (this.ghost.instanceMatrix.count < placed.length) {
      this.three.remove(this.ghost);
      this.ghost = new THREE.InstancedMesh(this.ghost.geometry, this.ghost.material, placed.length);
      this.ghost.frustumCulled = false;
      this.ghost.boundingSphere = EVERYWHERE;
      this.three.add(this.ghost);
    }
    const matrix = new THREE.Matrix4();
    placed.forEach((item, i) => {
      matrix.compose(new THREE.Vector3(...item.location), new THREE.Quaternion(...(item.orientation ?? [0, 0, 0, 1])), new THREE.Vector3(...item.symbols.dimensions).multiplyScalar(1.02));
      this.ghost.setMatrixAt(i, matrix);
    });
    this.ghost.count = placed.length;
    this.ghost.instanceMatrix.needsUpdate = true;
  }

  /** Draws a picture. The argument `moved` is true if the view has received a new frame. */
  draw(moved, seconds) {
    this.resize();
    if (this.built !== this.view.version) {
      this.#rebuild();
      moved = true;
    }
    if (moved) {
      this.#place();
      this.#placeLines();
      if (!this.wasFitted && this.bodies.length > 0) this.#first();
      else if (this.frames++ % 120 === 0) this.#scale();
    }
    this.ground.visible = !this.hasPlane && this.options.grid;
    this.gridUniforms.uGrid.value = this.options.grid ? 1 : 0;
    this.#adapt(seconds);
    this.sun.castShadow = this.options.shadows && this.quality === 2 && (this.bodies?.length ?? 0) < 4000;
    this.#moveCamera(seconds);
    this.#mark();
    this.renderer.render(this.three, this.camera);
    this.#label();
  }

  #moveCamera(seconds) {
    if (this.following && this.selected !== null && this.view.items[this.selected]?.kind === "body") {
      const at = new THREE.Vector3().fromArray(this.view.position, 3 * this.selected);
      const shift = at.clone().sub(this.controls.target);
      this.controls.target.copy(at);
      this.camera.position.add(shift);
    }
    if (this.flying && this.keys.size > 0) {
      const ahead = this.camera.getWorldDirection(new THREE.Vector3());
      const right = new THREE.Vector3().crossVectors(ahead, this.camera.up).normalize();
      const move = new THREE.Vector3();
      const has = (key) => (this.keys.has(key) ? 1 : 0);
      move.addScaledVector(ahead, has("w") - has("s")).addScaledVector(right, has("d") - has("a")).addScaledVector(this.camera.up, has("e") - has("q"));
      move.multiplyScalar((this.radius ?? 10) * 0.7 * Math.min(seconds, 0.1));
      this.camera.position.add(move);
      this.controls.target.add(move);
    }
    this.controls.update();
  }

  #mark() {
    const slot = this.selected;
    const item = slot === null ? null : this.view.items[slot];
    this.marker.visible = Boolean(item?.kind === "body" && item.shape !== NONE);
    if (!this.marker.visible) return;
    const { position, orientation, size } = this.view;
    this.marker.position.fromArray(position, 3 * slot);
    this.marker.quaternion.fromArray(orientation, 4 * slot);
    this.marker.scale.set(size[3 * slot] * 1.06 + 1e-3, size[3 * slot + 1] * 1.06 + 1e-3, size[3 * slot + 2] * 1.06 + 1e-3);
  }

  #label() {
    const wanted = [];
    if (this.options.labels && this.bodies) {
      const { position, size } = this.view;
      const place = new THREE.Vector3();
      const up = new THREE.Vector3(0, 1, 0).applyQuaternion(this.camera.quaternion);
      const few = this.bodies.length <= LABELS ? this.bodies : [...new Set([...this.highlighted, ...(this.selected === null ? [] : [this.selected])])].slice(0, LABELS);
      for (const slot of few) {
        const item = this.view.items[slot];
        if (!item?.shape || (item.shape === PLANE && slot !== this.selected)) continue;
        const radius = item.shape === PLANE ? 0 : Math.min(size[3 * slot], size[3 * slot + 1], size[3 * slot + 2]) / 2;
        place.fromArray(position, 3 * slot).addScaledVector(up, -radius).project(this.camera);
        if (place.z > 1 || place.z < -1 || Math.abs(place.x) > 1 || Math.abs(place.y) > 1) continue;
        wanted.push([item.name, ((place.x + 1) / 2) * this.width, ((1 - place.y) / 2) * this.height, slot === this.selected]);
      }
    }
    const layer = this.labelLayer;
    while (layer.children.length > wanted.length) layer.lastChild.remove();
    while (layer.children.length < wanted.length) layer.append(document.createElement("span"));
    wanted.forEach(([name, x, y, picked], i) => {
      const label = layer.children[i];
      if (label.textContent !== name) label.textContent = name;
      label.className = picked ? "picked" : "";
      label.style.transform = `translate(${x.toFixed(1)}px, ${(y + 4).toFixed(1)}px) translateX(-50%)`;
    });
  }
}
