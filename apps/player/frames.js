// Frames as they are drawn, made beside the page (in a Worker) by the scripts before this one. The page sends
//   {manifest, blocks, url, lives}   first: a store's manifest, and its blocks as a buffer per group or where they are;
//   {frame, has}                     what it wants, and the segments that it has,
// and is sent, for each frame that is gone through to that one, and once that is there,
//   {frame, segment, positions, shape}   3V floats; `shape` where the page has not the segment;
//   {done: frame} or {failed: text}.
'use strict';

/// Lives of triangles as colours (src/mq/io/film.h): for each segment runs of how many and which.
class Lives {
  constructor(bytes, segments) {
    const from = new ByteReader(bytes, 'The lives of charts');
    this.colours = [];
    for (let left = from.leb(); left > 0; --left) this.colours.push([from.leb(), from.leb(), from.leb()]);
    this.runs = segments.map(({triangles}) => {
      const runs = [];
      for (let at = 0; at < triangles; at += runs[runs.length - 2]) {
        runs.push(from.leb(), from.leb());
        if (runs[runs.length - 2] === 0 || runs[runs.length - 1] >= this.colours.length) from.fail('say nothing');
      }
      return runs;
    });
  }

  /// Which colour each triangle of a segment has.
  of(segment, triangles) {
    const lives = new Uint32Array(triangles), runs = this.runs[segment];
    for (let i = 0, at = 0; i < runs.length; i += 2) lives.fill(runs[i + 1], at, at += runs[i]);
    return lives;
  }
}

/// A segment as a graphics card wants it: a vertex is a point for each pair of texture coordinates and life. `borders`
/// are pairs of points, edges with one triangle between such points, each edge of the surface once.
function shapeOf(segment, lives, colours) {
  const {corners, cornerUvs, uvs} = segment, vertices = segment.vertexIds.length;
  const first = new Int32Array(vertices).fill(-1), points = new Uint32Array(corners.length);
  const next = [], vertexOf = [], uvOf = [], lifeOf = [];
  for (let i = 0; i < corners.length; ++i) {
    const vertex = corners[i], uv = cornerUvs ? cornerUvs[i] : -1, life = lives[Math.floor(i / 3)];
    let point = first[vertex];
    while (point >= 0 && (uvOf[point] !== uv || lifeOf[point] !== life)) point = next[point];
    if (point < 0) {
      point = vertexOf.length;
      next.push(first[vertex]);
      first[vertex] = point;
      vertexOf.push(vertex);
      uvOf.push(uv);
      lifeOf.push(life);
    }
    points[i] = point;
  }
  const shape = {
    vertices, vertexOf: Uint32Array.from(vertexOf), corners: points, borders: bordersOf(points, vertexOf),
    hasUvs: uvs.length > 0, uvs: new Float32Array(uvs.length > 0 ? 2 * uvOf.length : 0),
    colours: new Uint8Array(3 * lifeOf.length),
  };
  for (let i = 0; i < shape.uvs.length; ++i) shape.uvs[i] = uvOf[i >> 1] < 0 ? 0 : uvs[2 * uvOf[i >> 1] + (i & 1)];
  lifeOf.forEach((life, i) => shape.colours.set(colours[life], 3 * i));
  return shape;
}

function bordersOf(points, vertexOf) {
  // Of each point the edges to higher ones.
  const first = new Int32Array(vertexOf.length).fill(-1), next = new Int32Array(points.length);
  const high = new Int32Array(points.length), count = new Uint32Array(points.length);
  let edges = 0;
  for (let i = 0; i < points.length; i += 3)
    for (let k = 0; k < 3; ++k) {
      const a = points[i + k], b = points[i + (k + 1) % 3], low = Math.min(a, b), up = Math.max(a, b);
      let edge = first[low];
      while (edge >= 0 && high[edge] !== up) edge = next[edge];
      if (edge < 0) {
        edge = edges++;
        high[edge] = up;
        next[edge] = first[low];
        first[low] = edge;
      }
      ++count[edge];
    }
  const borders = [], drawn = new Set();
  for (let low = 0; low < first.length; ++low)
    for (let edge = first[low]; edge >= 0; edge = next[edge]) {
      if (count[edge] > 1) continue;
      const a = vertexOf[low], b = vertexOf[high[edge]];
      const name = Math.min(a, b) * 2 ** 26 + Math.max(a, b);
      if (drawn.has(name)) continue;
      drawn.add(name);
      borders.push(low, high[edge]);
    }
  return Uint32Array.from(borders);
}

/// Bytes of a file on a server, a range at a time; where it sends all of it at once, that is kept.
function ranges(url) {
  let whole = null;
  return async (begin, end) => {
    if (!whole) {
      const answer = await fetch(url, {headers: {Range: `bytes=${begin}-${end - 1}`}});
      if (!answer.ok) throw new Error(`${url} cannot be fetched (${answer.status}).`);
      const bytes = new Uint8Array(await answer.arrayBuffer());
      if (answer.status === 206) return bytes;
      whole = bytes;
    }
    return whole.subarray(begin, end);
  };
}

class FrameServer {
  constructor({manifest, blocks, url, lives}) {
    this.manifest = new Manifest(manifest);
    const fetched = url ? ranges(url) : async (begin) => {
      const group = this.manifest.groups.findIndex(({offset}) => offset === begin);
      return new Uint8Array(blocks[group]);
    };
    this.reader = new StoreReader(this.manifest, fetched);
    this.lives = new Lives(new Uint8Array(lives), this.manifest.segments);
  }

  send({frame, segmentIndex, segment, motion}, has) {
    const positions = new Float32Array(motion.coordinates.length), {step} = this.manifest;
    for (let i = 0; i < positions.length; ++i) positions[i] = step * motion.coordinates[i];
    const message = {frame, segment: segmentIndex, positions, shape: null}, buffers = [positions.buffer];
    if (!has.has(segmentIndex)) {
      has.add(segmentIndex);
      const lives = this.lives.of(segmentIndex, segment.triangleIds.length);
      message.shape = shapeOf(segment, lives, this.lives.colours);
      for (const part of Object.values(message.shape)) if (ArrayBuffer.isView(part)) buffers.push(part.buffer);
    }
    postMessage(message, buffers);
  }

  async answer({frame, has}) {
    const known = new Set(has);
    await this.reader.read(frame, (now) => this.send(now, known));
    postMessage({done: frame});
  }
}

if (typeof document === 'undefined') {
  let server = null;
  self.onmessage = async ({data}) => {
    try {
      if (!server) server = new FrameServer(data);
      else await server.answer(data);
    } catch (error) {
      postMessage({failed: error.message});
    }
  };
}
