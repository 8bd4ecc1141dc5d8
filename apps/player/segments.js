// Segments as what is new in them since the one before (evolving_change.h, triangle_codes.h, evolving_uvs.h).
'use strict';

// Streams of a segment's block.
const countStream = 0, vertexPlaceStream = 1, vertexIdStream = 2, trianglePlaceStream = 3, triangleIdStream = 4;
const sameStream = 5, uvPlaceStream = 6, cornerStream = 7, farCornerStream = 13, uvStream = 14, uvStreams = 16;
const triangleStream = uvStream + uvStreams, changeStreams = triangleStream + 18;
const sameCorners = 1, sameUvs = 2;

const emptySegment = {
  vertexIds: new Int32Array(0), triangleIds: new Int32Array(0), corners: new Int32Array(0),
  uvs: new Float64Array(0), cornerUvs: null,
};

/// Where things were, each mostly one after the last; `isNew(i)` is told which were nowhere. (Large numbers of all
/// streams have their bits in one row, so that numbers are read in the order in which they were written.)
function getPlaces(from, stream, count, countBefore, isNew) {
  const places = new Int32Array(count);
  let expected = 0;
  for (let i = 0; i < count; ++i) {
    const code = from.get(stream);
    if (code === 0) {
      places[i] = newPlace;
      isNew(i);
      continue;
    }
    const place = expected + unfolded(code - 1);
    if (place < 0 || place >= countBefore) from.fail('names a place that is not there');
    places[i] = place;
    expected = place + 1;
  }
  return places;
}

/// Ids, and where they were before.
function getIds(from, placeStream, idStream, count, before) {
  const fresh = new Int32Array(count);
  let expected = 0;
  const places = getPlaces(from, placeStream, count, before.length, (i) => {
    const id = expected + from.signed(idStream);
    if (id < 0 || id > largestInt) from.fail('holds an id out of range');
    fresh[i] = id;
    expected = Math.min(id + 1, largestInt);
  });
  return {places, ids: places.map((place, i) => (place === newPlace ? fresh[i] : before[place]))};
}

/// Where each thing of the segment before is now; -1: nowhere.
function placesNow(places, count) {
  const now = new Int32Array(count).fill(-1);
  places.forEach((place, i) => {
    if (place !== newPlace) now[place] = i;
  });
  return now;
}

/// Writes entry `place` of `before` with what its corners are now to entry t; false where one of them is gone.
function carry(before, place, now, to, t) {
  for (let k = 0; k < 3; ++k) {
    const corner = before[3 * place + k];
    to[3 * t + k] = corner < 0 ? -1 : now[corner];
    if (corner >= 0 && to[3 * t + k] < 0) return false;
  }
  return true;
}

/// Triangles by an edge of those before them and the vertex across.
class TriangleCoder {
  constructor(count) {
    Object.assign(this, {
      count, seen: new Uint8Array(count), next: new Int32Array(count).fill(-1), last: new Int32Array(count).fill(-1),
      begins: new Int32Array(32).fill(-1), ends: new Int32Array(32).fill(-1), recent: new Int32Array(16).fill(-1),
      newest: -1, firstNew: 0, newestEdge: 0, newestVertex: 0, before: 0, rotation: 0,
    });
  }

  nextNew() {
    for (let v = this.newest + 1; v < Math.min(this.count, this.newest + 16); ++v) if (!this.seen[v]) return v;
    while (this.firstNew < this.count && this.seen[this.firstNew]) ++this.firstNew;
    return this.firstNew;
  }
  see(vertex) {
    if (this.seen[vertex]) return;
    this.seen[vertex] = 1;
    this.newest = vertex;
  }

  know(corners, t) {
    const {next, last} = this, isBorder = [false, false, false];
    for (let k = 0; k < 3; ++k) {
      const a = corners[3 * t + k], b = corners[3 * t + (k + 1) % 3];
      isBorder[k] = next[b] !== a;
      if (isBorder[k]) continue;
      next[b] = -1;
      if (last[a] === b) last[a] = -1;
    }
    for (let k = 0; k < 3; ++k) {
      const a = corners[3 * t + k], b = corners[3 * t + (k + 1) % 3];
      this.see(a);
      if (!isBorder[k]) continue;
      next[a] = b;
      last[b] = a;
    }
  }

  remember(corners, t) {
    this.know(corners, t);
    for (let k = 0; k < 3; ++k) {
      const a = corners[3 * t + k];
      this.newestEdge = (this.newestEdge + 1) % 32;
      this.begins[this.newestEdge] = corners[3 * t + (k + 1) % 3];
      this.ends[this.newestEdge] = a;
      if (this.recent.includes(a)) continue;
      this.newestVertex = (this.newestVertex + 1) % 16;
      this.recent[this.newestVertex] = a;
    }
    this.before = corners[3 * t + 2];
  }

  required(from, vertex) {
    if (!(vertex >= 0 && vertex < this.count)) from.fail('names a vertex that is not there');
    return vertex;
  }
  getVertex(from, near) {
    const code = from.get(triangleStream + 4);
    const vertex = this.required(from, code === 0 ? this.nextNew() : near + unfolded(code - 1));
    this.see(vertex);
    return vertex;
  }
  getAcross(from, place, begin, end) {
    const hasAfter = this.next[begin] >= 0, hasBefore = this.last[end] >= 0;
    const code = from.index(triangleStream + 6 + 4 * Math.min(place, 2) + 2 * hasAfter + hasBefore, 20);
    let vertex = -1;
    if (code === 0) vertex = this.nextNew();
    else if (code === 1) vertex = this.next[begin];
    else if (code === 2) vertex = this.last[end];
    else if (code < 19) vertex = this.recent[(this.newestVertex + 16 - (code - 3)) % 16];
    else vertex = begin + from.signed(triangleStream + 5);
    return this.required(from, vertex);
  }

  get(from, corners, t) {
    const place = from.index(triangleStream, 33) - 1, at = 3 * t;
    if (place < 0) {
      for (let k = 0; k < 3; ++k) corners[at + k] = this.getVertex(from, k === 0 ? this.before : corners[at + k - 1]);
    } else {
      const edge = (this.newestEdge + 32 - place) % 32, begin = this.begins[edge], end = this.ends[edge];
      if (begin < 0) from.fail('names an edge that is not there');
      const r = from.index(triangleStream + 1 + this.rotation, 3);
      corners[at + r] = begin;
      corners[at + (r + 1) % 3] = end;
      corners[at + (r + 2) % 3] = this.getAcross(from, place, begin, end);
      this.rotation = r;
    }
    this.remember(corners, t);
  }
}

/// Texture coordinates of corners, by those that their vertices had last.
class CornerCoder {
  constructor(vertices, uvs) {
    Object.assign(this, {recent: new Int32Array(4 * vertices).fill(-1), seen: new Uint8Array(uvs), offset: 0});
  }
  use(vertex, uv) {
    if (uv < 0) return;
    if (!this.seen[uv]) this.offset = uv - vertex;
    this.seen[uv] = 1;
    let at = 4 * vertex;
    while (at < 4 * vertex + 3 && this.recent[at] !== uv) ++at;
    for (; at > 4 * vertex; --at) this.recent[at] = this.recent[at - 1];
    this.recent[at] = uv;
  }
  know(corners, cornerUvs, t) {
    for (let k = 0; k < 3; ++k) this.use(corners[3 * t + k], cornerUvs[3 * t + k]);
  }
  get(from, corners, cornerUvs, t) {
    let asBefore = true;
    for (let k = 0; k < 3; ++k) {
      const vertex = corners[3 * t + k], hasOne = this.recent[4 * vertex] >= 0;
      const code = from.index(cornerStream + 3 * hasOne + (k === 0 ? 0 : asBefore ? 1 : 2), 7);
      let uv = -1;
      if (code < 4) uv = this.recent[4 * vertex + code];
      else if (code !== 5) uv = vertex + this.offset + (code === 6 ? from.signed(farCornerStream) : 0);
      if (!(uv >= -1 && uv < this.seen.length)) from.fail('names a texture coordinate that is not there');
      asBefore = asBefore && code === 0;
      cornerUvs[3 * t + k] = uv;
      this.use(vertex, uv);
    }
  }
}

/// u and v that are new. The others, and what corners have, are there already.
function getUvs(from, segment, places) {
  const kind = from.index(countStream, 3), exponent = from.signed(countStream), {uvs, cornerUvs} = segment;
  if (Math.abs(exponent) > 1000) from.fail('has texture coordinates in no sensible step');
  if (!places.includes(newPlace)) return;
  if (kind !== 2) from.fail('has texture coordinates that are not rounded, which this page does not know');
  const weight = from.index(countStream, 65), step = 2 ** exponent;
  const values = uvs.map((value) => bounded(value / step));
  const used = [];
  for (let i = 0; cornerUvs && i < cornerUvs.length; i += 3) {
    const of = [cornerUvs[i], cornerUvs[i + 1], cornerUvs[i + 2]];
    if (of.some((uv) => uv >= 0 && places[uv] === newPlace)) used.push(...of);
  }
  const order = new CodingOrder(used, places.length, true), left = new Uint32Array(places.length);
  for (let uv = 0; uv < places.length; ++uv) {
    if (places[uv] !== newPlace) continue;
    const context = order.context(left, uv, uvStreams);
    const predicted = [order.inSpace(values, 2, uv, 0, weight), order.inSpace(values, 2, uv, 1, weight)];
    for (let k = 0; k < 2; ++k) {
      const value = from.signed(uvStream + context);
      left[uv] += boundedLeft(value);
      values[2 * uv + k] = predicted[k] + value;
      uvs[2 * uv + k] = values[2 * uv + k] * step;
    }
  }
}

/// A segment, and where its vertices were in `before`.
async function decodeChange(bytes, before, what) {
  const entries = before.vertexIds.length + before.triangleIds.length + before.uvs.length / 2;
  const most = entries + mostAddedPerByte * bytes.length;
  const from = await SymbolReader.of(bytes, changeStreams, 16 * (most + 1), what);
  const vertexCount = from.index(countStream, most + 1);
  const triangleCount = from.index(countStream, most + 1 - vertexCount);
  const uvCount = from.index(countStream, most + 1 - vertexCount - triangleCount);
  const hasUvs = from.index(countStream, 2) === 1;
  const vertices = getIds(from, vertexPlaceStream, vertexIdStream, vertexCount, before.vertexIds);
  const triangles = getIds(from, trianglePlaceStream, triangleIdStream, triangleCount, before.triangleIds);
  const vertexPlaces = vertices.places, trianglePlaces = triangles.places;
  const uvPlaces = getPlaces(from, uvPlaceStream, uvCount, before.uvs.length / 2, () => {});
  const segment = {
    vertexIds: vertices.ids, triangleIds: triangles.ids, vertexPlaces,
    corners: new Int32Array(3 * triangleCount), uvs: new Float64Array(2 * uvCount),
    cornerUvs: hasUvs ? new Int32Array(3 * triangleCount) : null,
  };
  uvPlaces.forEach((place, i) => {
    if (place === newPlace) return;
    segment.uvs[2 * i] = before.uvs[2 * place];
    segment.uvs[2 * i + 1] = before.uvs[2 * place + 1];
  });
  const {corners, cornerUvs} = segment;
  const verticesNow = placesNow(vertexPlaces, before.vertexIds.length);
  const uvsNow = placesNow(uvPlaces, before.uvs.length / 2), sames = new Uint8Array(triangleCount);
  for (let t = 0; t < triangleCount; ++t) {
    const place = trianglePlaces[t];
    if (place === newPlace) continue;
    sames[t] = from.index(sameStream, 4);
    if (sames[t] & sameCorners && !carry(before.corners, place, verticesNow, corners, t))
      from.fail('keeps a triangle whose vertices are gone');
    if (sames[t] & sameUvs && !(hasUvs && before.cornerUvs && carry(before.cornerUvs, place, uvsNow, cornerUvs, t)))
      from.fail('keeps texture coordinates that are gone');
  }
  const coder = new TriangleCoder(vertexCount), coordinates = new CornerCoder(vertexCount, uvCount);
  sames.forEach((same, t) => {
    if (same & sameCorners) coder.know(corners, t);
    if (same === (sameCorners | sameUvs)) coordinates.know(corners, cornerUvs, t);
  });
  for (let t = 0; t < triangleCount; ++t) {
    if (!(sames[t] & sameCorners)) coder.get(from, corners, t);
    if (hasUvs && !(sames[t] & sameUvs)) coordinates.get(from, corners, cornerUvs, t);
  }
  getUvs(from, segment, uvPlaces);
  from.end();
  return segment;
}
