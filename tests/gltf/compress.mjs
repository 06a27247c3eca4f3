// Usage: node compress.mjs MODULES FOLDER   with draco3dgltf and meshoptimizer in MODULES/node_modules
// Compresses files of make_models.py in FOLDER, with the encoders of Draco and meshoptimizer, to draco_*.glb and meshopt_*.glb. The
// decoders of both write the same documents without compression to FOLDER/decoded, under the same names.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, folder] = process.argv.slice(2);
const require = createRequire(resolve(modules, "package.json"));
const draco = require("draco3dgltf");
const { MeshoptEncoder, MeshoptDecoder } = await import(pathToFileURL(join(resolve(modules), "node_modules/meshoptimizer/index.js")));
await Promise.all([MeshoptEncoder.ready, MeshoptDecoder.ready]);
const dracoEncoder = await draco.createEncoderModule(), dracoDecoder = await draco.createDecoderModule();
mkdirSync(join(folder, "decoded"), { recursive: true });

const arrays = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const widths = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };
const moved = ["POSITION", "NORMAL", "TANGENT"];

function read(name) {
  const data = readFileSync(join(folder, name + ".glb")), size = data.readUInt32LE(12);
  return { json: JSON.parse(data.toString("utf8", 20, 20 + size)), bytes: new Uint8Array(data.subarray(28 + size)) };
}

/** A growing array of bytes. Each piece begins at a multiple of 4. */
class Bytes {
  data = new Uint8Array(0);
  add(piece) {
    const start = Math.ceil(this.data.length / 4) * 4, data = new Uint8Array(start + piece.byteLength);
    data.set(this.data);
    data.set(new Uint8Array(piece.buffer, piece.byteOffset, piece.byteLength), start);
    this.data = data;
    return start;
  }
}

function write(path, json, bytes) {
  const text = Buffer.from(JSON.stringify(json)), textSize = Math.ceil(text.length / 4) * 4, binSize = Math.ceil(bytes.length / 4) * 4;
  const file = Buffer.alloc(28 + textSize + binSize);
  file.write("glTF");
  [2, file.length, textSize].forEach((number, k) => file.writeUInt32LE(number, 4 + 4 * k));
  file.write("JSON", 16);
  file.fill(" ", 20, 20 + textSize);
  text.copy(file, 20);
  file.writeUInt32LE(binSize, 20 + textSize);
  file.write("BIN\0", 24 + textSize);
  Buffer.from(bytes).copy(file, 28 + textSize);
  writeFileSync(join(folder, path), file);
}

function requireExtension(json, extension) {
  for (const name of ["extensionsUsed", "extensionsRequired"]) json[name] = [...(json[name] ?? []), extension];
}

/** The numbers of an accessor whose elements follow one another, or have a stride. */
function numbers(json, bytes, accessor) {
  const view = json.bufferViews[accessor.bufferView], width = widths[accessor.type], kind = arrays[accessor.componentType];
  const stride = view.byteStride ?? width * kind.BYTES_PER_ELEMENT, result = new kind(accessor.count * width);
  for (let i = 0; i < accessor.count; ++i) {
    const start = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0) + i * stride;
    result.set(new kind(bytes.slice(start, start + width * kind.BYTES_PER_ELEMENT).buffer), i * width);
  }
  return result;
}

function bounds(accessor, values) {
  const width = widths[accessor.type];
  for (const [name, of] of [["min", Math.min], ["max", Math.max]]) {
    if (accessor[name]) accessor[name] = accessor[name].map((_, k) => of(...values.filter((_, i) => i % width === k)));
  }
}

// ---- EXT_meshopt_compression ----
/** What an accessor's view is encoded as, and the bytes that are encoded. */
function prepared(json, bytes, view, accessors, filters, uses) {
  const stride = view.byteStride ?? widths[accessors[0].type] * arrays[accessors[0].componentType].BYTES_PER_ELEMENT;
  const count = Math.floor(view.byteLength / stride), source = bytes.slice(view.byteOffset ?? 0, (view.byteOffset ?? 0) + count * stride);
  const how = { byteStride: stride, count }, use = uses.get(accessors[0]);
  if (use === "indices" && stride > 1) return { ...how, mode: count % 3 === 0 ? "TRIANGLES" : "INDICES", source };
  if (stride % 4 !== 0) return null;
  how.mode = "ATTRIBUTES";
  const one = accessors[0], values = numbers(json, bytes, one), bits = arrays[one.componentType].BYTES_PER_ELEMENT * 8;
  const width = widths[one.type], rows = new Float32Array(count * 4);
  for (let i = 0; i < values.length; ++i) rows[Math.floor(i / width) * 4 + (i % width)] = Math.max(-1, values[i] / (2 ** (bits - 1) - 1));
  if (filters && accessors.length === 1 && one.normalized && use !== "POSITION" && stride === (4 * bits) / 8) {
    if (use === "rotation") return { ...how, filter: "QUATERNION", source: MeshoptEncoder.encodeFilterQuat(rows, count, stride, 14) };
    if (use !== undefined) return { ...how, filter: "OCTAHEDRAL", source: MeshoptEncoder.encodeFilterOct(rows, count, stride, bits) };
  }
  if (filters && accessors.length === 1 && one.componentType === 5126 && use === "POSITION")
    return { ...how, filter: "EXPONENTIAL", source: MeshoptEncoder.encodeFilterExp(values, count, stride, 14) };
  return { ...how, source };
}

function usesOf(json) {
  const uses = new Map();
  for (const { primitives } of json.meshes) {
    for (const { attributes, indices, mode } of primitives) {
      if (indices !== undefined && (mode ?? 4) === 4) uses.set(json.accessors[indices], "indices");
      for (const name of moved) if (attributes[name] !== undefined) uses.set(json.accessors[attributes[name]], name);
    }
  }
  for (const { channels, samplers } of json.animations ?? [])
    for (const { sampler, target } of channels) if (target.path === "rotation") uses.set(json.accessors[samplers[sampler].output], "rotation");
  return uses;
}

/** fallback: whether the buffer of the decoded views is in the file too, so that the extension is not required. */
function compressWithMeshopt(from, name, { filters = false, fallback = false, extension = "EXT_meshopt_compression", version = 0 } = {}) {
  const { json, bytes } = read(from), decoded = structuredClone(json), packed = new Bytes(), plain = new Bytes(), uses = usesOf(json);
  json.bufferViews.forEach((view, k) => {
    const accessors = json.accessors.filter(accessor => accessor.bufferView === k);
    const how = accessors.length > 0 ? prepared(json, bytes, view, accessors, filters, uses) : null;
    let source = bytes.slice(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength);
    if (how) {
      const { source: raw, ...item } = how, data = MeshoptEncoder.encodeGltfBuffer(raw, item.count, item.byteStride, item.mode, version);
      source = new Uint8Array(item.count * item.byteStride);
      MeshoptDecoder.decodeGltfBuffer(source, item.count, item.byteStride, data, item.mode, item.filter);
      view.extensions = { [extension]: { buffer: 0, byteOffset: packed.add(data), byteLength: data.length, ...item } };
    }
    Object.assign(decoded.bufferViews[k], { byteOffset: plain.add(source), byteLength: source.length });
    Object.assign(view, how ? { ...decoded.bufferViews[k], buffer: 1 } : { byteOffset: packed.add(source) });
  });
  decoded.accessors.forEach((accessor, k) => {
    if (accessor.min && accessor.bufferView !== undefined && !accessor.sparse) bounds(accessor, numbers(decoded, plain.data, accessor));
    Object.assign(json.accessors[k], accessor);
  });
  json.buffers = [{ byteLength: packed.data.length }, { byteLength: plain.data.length }];
  if (fallback) {
    json.extensionsUsed = [...(json.extensionsUsed ?? []), extension];
    json.buffers[1].uri = "data:application/octet-stream;base64," + Buffer.from(plain.data).toString("base64");
  } else {
    requireExtension(json, extension);
    json.buffers[1].extensions = { [extension]: { fallback: true } };
  }
  decoded.buffers = [{ byteLength: plain.data.length }];
  write(name + ".glb", json, packed.data);
  write(join("decoded", name + ".glb"), decoded, plain.data);
}

// ---- KHR_draco_mesh_compression ----
const dracoKinds = { POSITION: "POSITION", NORMAL: "NORMAL", TEXCOORD: "TEX_COORD", COLOR: "COLOR" };

function encodedByDraco(json, bytes, primitive, method) {
  const builder = new dracoEncoder.MeshBuilder(), mesh = new dracoEncoder.Mesh(), encoder = new dracoEncoder.Encoder(), ids = {};
  for (const [name, index] of Object.entries(primitive.attributes)) {
    const accessor = json.accessors[index], values = numbers(json, bytes, accessor);
    const kind = dracoEncoder[dracoKinds[name.replace(/_\d$/, "")] ?? "GENERIC"];
    const add = { 5121: "AddUInt8Attribute", 5123: "AddUInt16Attribute", 5126: "AddFloatAttribute" }[accessor.componentType];
    ids[name] = builder[add](mesh, kind, accessor.count, widths[accessor.type], values);
  }
  const indices = numbers(json, bytes, json.accessors[primitive.indices]);
  builder.AddFacesToMesh(mesh, indices.length / 3, new Uint32Array(indices));
  encoder.SetEncodingMethod(dracoEncoder[method]);
  encoder.SetSpeedOptions(5, 5);
  encoder.SetAttributeQuantization(dracoEncoder.POSITION, 14);
  encoder.SetAttributeQuantization(dracoEncoder.NORMAL, 12);
  encoder.SetAttributeQuantization(dracoEncoder.TEX_COORD, 12);
  const into = new dracoEncoder.DracoInt8Array(), size = encoder.EncodeMeshToDracoBuffer(mesh, into);
  if (size === 0) throw new Error("Draco encodes nothing");
  return { data: Uint8Array.from({ length: size }, (_, i) => into.GetValue(i)), ids };
}

function compressWithDraco(from, name, method) {
  const { json, bytes } = read(from), decoded = structuredClone(json), packed = new Bytes(), plain = new Bytes();
  packed.add(bytes);
  plain.add(bytes);
  json.meshes.forEach(({ primitives }, m) => primitives.forEach((primitive, p) => {
    if ((primitive.mode ?? 4) !== 4 || primitive.indices === undefined || primitive.targets) return;
    const { data, ids } = encodedByDraco(json, bytes, primitive, method), decoder = new dracoDecoder.Decoder(), mesh = new dracoDecoder.Mesh();
    if (!decoder.DecodeArrayToMesh(data, data.length, mesh).ok()) throw new Error("Draco decodes nothing");
    const place = (index, values, count) => {
      const accessor = decoded.accessors[index], view = { buffer: 0, byteOffset: plain.add(values), byteLength: values.byteLength };
      accessor.count = count;
      bounds(accessor, values);
      Object.assign(json.accessors[index], accessor);
      delete json.accessors[index].bufferView;
      delete json.accessors[index].byteOffset;
      accessor.bufferView = decoded.bufferViews.push(view) - 1;
      accessor.byteOffset = 0;
    };
    for (const [name, id] of Object.entries(ids)) {
      const accessor = decoded.accessors[primitive.attributes[name]], attribute = decoder.GetAttributeByUniqueId(mesh, id);
      const kind = arrays[accessor.componentType], count = mesh.num_points() * widths[accessor.type], size = count * kind.BYTES_PER_ELEMENT;
      const type = { 5121: "DT_UINT8", 5123: "DT_UINT16", 5126: "DT_FLOAT32" }[accessor.componentType], pointer = dracoDecoder._malloc(size);
      decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, dracoDecoder[type], size, pointer);
      place(primitive.attributes[name], new kind(dracoDecoder.HEAPU8.slice(pointer, pointer + size).buffer), mesh.num_points());
    }
    const faces = mesh.num_faces(), pointer = dracoDecoder._malloc(12 * faces);
    decoder.GetTrianglesUInt32Array(mesh, 12 * faces, pointer);
    const indices = new Uint32Array(dracoDecoder.HEAPU8.slice(pointer, pointer + 12 * faces).buffer);
    place(primitive.indices, arrays[decoded.accessors[primitive.indices].componentType].from(indices), 3 * faces);
    const view = json.bufferViews.push({ buffer: 0, byteOffset: packed.add(data), byteLength: data.length }) - 1;
    json.meshes[m].primitives[p].extensions = { KHR_draco_mesh_compression: { bufferView: view, attributes: ids } };
  }));
  json.buffers = [{ byteLength: packed.data.length }];
  decoded.buffers = [{ byteLength: plain.data.length }];
  requireExtension(json, "KHR_draco_mesh_compression");
  write(name + ".glb", json, packed.data);
  write(join("decoded", name + ".glb"), decoded, plain.data);
}

compressWithMeshopt("attributes", "meshopt");
compressWithMeshopt("attributes", "meshopt_exponential", { filters: true });
compressWithMeshopt("everything", "meshopt_everything");
compressWithMeshopt("skin_played", "meshopt_skin");
compressWithMeshopt("skin_i16_turns", "meshopt_quaternions", { filters: true });
compressWithMeshopt("quantized_targets", "meshopt_octahedral", { filters: true });
compressWithMeshopt("quantized_i8_normalized", "meshopt_octahedral_i16", { filters: true });
compressWithMeshopt("indices_u32", "meshopt_fallback", { fallback: true });
compressWithMeshopt("attributes", "refused_khr_meshopt", { extension: "KHR_meshopt_compression", version: 1 });
compressWithDraco("attributes", "draco_edgebreaker", "MESH_EDGEBREAKER_ENCODING");
compressWithDraco("attributes", "draco_sequential", "MESH_SEQUENTIAL_ENCODING");
compressWithDraco("skin_u8_weights", "draco_skin", "MESH_EDGEBREAKER_ENCODING");
compressWithDraco("points_and_lines", "draco_and_lines", "MESH_SEQUENTIAL_ENCODING");
compressWithDraco("hierarchy", "draco_hierarchy", "MESH_EDGEBREAKER_ENCODING");
