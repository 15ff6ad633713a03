// SPDX-License-Identifier: Apache-2.0
// The items of a world as columns. The slot of an item is its index in the columns. The columns are
// read from binary frames or from perceptions.

const FRAME = 1, MESH = 2, TEXTURE = 3;
const HEADER_BYTES = 32;
export const POSITION = 0, ORIENTATION = 1, SIZE = 2, COLOUR = 3, VELOCITY = 4, FORCE = 5, CONTACTS = 6;
const COMPONENTS = [3, 4, 3, 1, 3, 3, 2];
const NAMES = ["position", "orientation", "size", "colour", "velocity", "force", "contacts"];
export const NONE = 0, SPHERE = 1, BOX = 2, PLANE = 3, MESH_SHAPE = 4, CAPSULE = 5, CYLINDER = 6, ELLIPSOID = 7;

const text = new TextDecoder();

/** Columns of all items by slot. The field `version` counts changes of the structure, that is, of
 *  the set of items and of their looks. */
export class View {
  constructor() {
    this.clear();
  }

  clear() {
    this.slots = 0;
    this.items = [];
    this.byName = new Map();
    this.meshes = new Map();
    this.textures = new Map();
    this.camera = null;
    this.measuresContacts = false;
    this.frame = 0;
    this.time = 0;
    this.version = (this.version ?? 0) + 1;
    this.bytes = 0;
    for (const [i, name] of NAMES.entries()) this[name] = new Float32Array(COMPONENTS[i] * 64);
    this.colourBytes = new Uint8Array(this.colour.buffer);
    this.forgetContacts();
  }

  /** Forgets how many contacts have begun, so that the next frame reports none. */
  forgetContacts() {
    this.contacts.fill(NaN);
    this.begun = [];
  }

  /** Returns the contacts that have begun since the last call, as slot and force [N]. */
  takeContacts() {
    const begun = this.begun;
    this.begun = [];
    return begun;
  }

  #grow(slots) {
    this.slots = Math.max(this.slots, slots);
    if (this.colour.length >= slots) return;
    const room = Math.max(slots, 2 * this.colour.length);
    for (const [i, name] of NAMES.entries()) {
      const larger = new Float32Array(COMPONENTS[i] * room);
      if (i === CONTACTS) larger.fill(NaN);
      larger.set(this[name]);
      this[name] = larger;
    }
    this.colourBytes = new Uint8Array(this.colour.buffer);
  }

  /** Reads a binary message. Returns true if the message is a frame. */
  read(buffer) {
    this.bytes += buffer.byteLength;
    const data = new DataView(buffer);
    switch (data.getUint32(0, true)) {
      case FRAME:
        this.#readFrame(buffer, data);
        return true;
      case MESH:
        this.#readMesh(buffer, data);
        return false;
      case TEXTURE:
        this.textures.set(data.getUint32(4, true), {
          width: data.getUint32(8, true),
          height: data.getUint32(12, true),
          rgba: new Uint8Array(buffer, 16),
        });
        return false;
      default:
        return false;
    }
  }

  #readFrame(buffer, data) {
    const bytes = data.getUint32(4, true);
    let sections = data.getUint32(8, true);
    this.#grow(data.getUint32(12, true));
    this.frame = data.getFloat64(16, true);
    this.time = data.getFloat64(24, true);
    if (bytes > 0) {
      const structure = JSON.parse(text.decode(new Uint8Array(buffer, HEADER_BYTES, bytes)));
      if (structure.camera) this.camera = structure.camera;
      if (structure.measuresContacts) this.measuresContacts = true;
      for (const slot of structure.left) this.#remove(slot);
      for (const item of structure.items) this.#put(item);
      this.#dropUnused();
      this.version++;
    }
    let at = HEADER_BYTES + ((bytes + 3) & ~3);
    for (; sections > 0; sections--) {
      const column = data.getUint32(at, true);
      const count = data.getUint32(at + 4, true);
      const components = COMPONENTS[column];
      const slots = new Uint32Array(buffer, at + 8, count);
      const values = new Float32Array(buffer, at + 8 + 4 * count, count * components);
      const target = this[NAMES[column]];
      if (column === COLOUR) {
        const from = new Uint32Array(values.buffer, values.byteOffset, count);
        const to = new Uint32Array(target.buffer);
        for (let i = 0; i < count; i++) to[slots[i]] = from[i];
      } else {
        if (column === CONTACTS) this.#noteContacts(slots, values);
        for (let i = 0, v = 0; i < count; i++) {
          for (let c = 0, t = slots[i] * components; c < components; c++) target[t++] = values[v++];
        }
      }
      at += 8 + 4 * count * (1 + components);
    }
  }

  /** Notes the bodies whose number of contacts has grown. A number that was unknown before, or that
   *  has fallen because the server started again, is not news. */
  #noteContacts(slots, values) {
    slots.forEach((slot, i) => {
      if (values[2 * i] > this.contacts[2 * slot]) this.begun.push({ slot, force: values[2 * i + 1] });
    });
  }

  #put(item) {
    const before = this.items[item.slot];
    if (before?.name !== item.name) this.contacts[2 * item.slot] = NaN;
    if (before && before.name !== item.name && this.byName.get(before.name) === before) this.byName.delete(before.name);
    this.items[item.slot] = item;
    this.byName.set(item.name, item);
  }

  #remove(slot) {
    const item = this.items[slot];
    if (item && this.byName.get(item.name) === item) this.byName.delete(item.name);
    this.items[slot] = undefined;
  }

  /** Discards the meshes and textures that no item uses. The server does the same, so it sends them
   *  again if necessary. */
  #dropUnused() {
    if (this.meshes.size + this.textures.size === 0) return;
    const meshes = new Set();
    const textures = new Set();
    for (const item of this.items) {
      if (!item) continue;
      meshes.add(item.mesh);
      textures.add(item.material?.texture);
      for (const part of this.meshes.get(item.mesh)?.parts ?? []) textures.add(part.material.texture);
    }
    for (const id of this.meshes.keys()) if (!meshes.has(id)) this.meshes.delete(id);
    for (const [id, texture] of this.textures) {
      if (textures.has(id)) continue;
      texture.three?.dispose();
      this.textures.delete(id);
    }
  }

  #readMesh(buffer, data) {
    const vertices = data.getUint32(8, true);
    const indices = data.getUint32(12, true);
    const flags = data.getUint32(16, true);
    let parts = data.getUint32(20, true);
    let at = 24;
    const floats = (count) => {
      const values = new Float32Array(buffer, at, count);
      at += 4 * count;
      return values;
    };
    const mesh = { vertices: floats(3 * vertices), parts: [] };
    if (flags & 1) mesh.normals = floats(3 * vertices);
    if (flags & 2) mesh.coordinates = floats(2 * vertices);
    if (flags & 4) {
      mesh.colours = new Uint8Array(buffer, at, 4 * vertices);
      at += 4 * vertices;
    }
    mesh.indices = new Uint32Array(buffer, at, indices);
    at += 4 * indices;
    for (; parts > 0; parts--, at += 24) {
      mesh.parts.push({
        first: data.getUint32(at, true),
        count: data.getUint32(at + 4, true),
        material: {
          colour: data.getUint32(at + 8, true),
          roughness: data.getFloat32(at + 12, true),
          metallic: data.getFloat32(at + 16, true),
          texture: data.getUint32(at + 20, true),
        },
      });
    }
    this.meshes.set(data.getUint32(4, true), mesh);
  }

  /** Reads a perception of an agent. It contains locations and symbols but no shapes, so all items
   *  are drawn as boxes. */
  perceive(message) {
    this.frame = message.frame;
    this.time = message.time;
    if (message.items) {
      for (let slot = 0; slot < this.slots; slot++) if (this.items[slot]) this.#remove(slot);
      this.slots = 0;
      this.version++;
    }
    for (const name of message.left ?? []) {
      const item = this.byName.get(name);
      if (item) this.#remove(item.slot);
      this.version++;
    }
    for (const perceived of [...(message.items ?? []), ...(message.entered ?? [])]) this.#enter(perceived);
    for (const change of message.changed ?? []) {
      const item = this.byName.get(change.name);
      if (item) this.#place(item, change);
    }
  }

  #enter(perceived) {
    let slot = this.byName.get(perceived.name)?.slot ?? this.items.findIndex((item) => !item);
    if (slot < 0) slot = this.items.length;
    this.#grow(slot + 1);
    const item = { slot, name: perceived.name, kind: perceived.symbols?.class ?? "item", perceived };
    if (perceived.location) {
      item.kind = "body";
      item.class = perceived.symbols?.class;
      item.shape = perceived.symbols?.dimensions ? BOX : SPHERE;
    }
    this.#put(item);
    this.size.set(perceived.symbols?.dimensions?.map((side) => Math.max(side, 0.01)) ?? [0.2, 0.2, 0.2], 3 * slot);
    this.orientation.set([0, 0, 0, 1], 4 * slot);
    this.colourBytes.set(hashColour(perceived.symbols?.class ?? perceived.name), 4 * slot);
    this.#place(item, perceived);
    this.version++;
  }

  #place(item, from) {
    Object.assign(item.perceived, from);
    if (from.location) this.position.set(from.location, 3 * item.slot);
    if (from.orientation) this.orientation.set(from.orientation, 4 * item.slot);
  }
}

function hashColour(name) {
  let hash = 2166136261;
  for (const c of name) hash = Math.imul(hash ^ c.codePointAt(0), 16777619);
  const hue = ((hash >>> 0) % 360) / 60;
  const part = (shift) => Math.round(255 * (0.62 + 0.26 * Math.cos(((hue + shift) * Math.PI) / 3)));
  return [part(0), part(4), part(2), 255];
}
