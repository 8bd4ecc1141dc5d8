// Positions of frames (evolving_motion.h): predicted from the frames before, and from the vertices before.
'use strict';

/// The frame before, and how it changed from the one before that, x, y, z of each vertex; null: none.
class MotionState {
  constructor(coordinates, change) {
    Object.assign(this, {coordinates, change});
  }
  static after(before, coordinates) {
    const change = new Float64Array(coordinates.length);
    if (before) for (let i = 0; i < change.length; ++i) change[i] = coordinates[i] - before.coordinates[i];
    return new MotionState(coordinates, change);
  }
}

/// The same for the vertices of another segment; those that are new are at the mean of their neighbours.
function carriedOver(before, from, corners) {
  if (!before) return null;
  const count = from.length, known = new Uint8Array(count);
  const coordinates = new Float64Array(3 * count), change = new Float64Array(3 * count);
  let unknown = 0;
  for (let v = 0; v < count; ++v) {
    if (from[v] < 0) {
      ++unknown;
      continue;
    }
    known[v] = 1;
    for (let k = 0; k < 3; ++k) {
      coordinates[3 * v + k] = before.coordinates[3 * from[v] + k];
      change[3 * v + k] = before.change[3 * from[v] + k];
    }
  }
  for (let round = 0; round < 64 && unknown > 0; ++round) {
    const counts = new Map();
    for (let i = 0; i < corners.length; i += 3)
      for (let k = 0; k < 3; ++k)
        for (let step = 1; step < 3; ++step) {
          const v = corners[i + k], n = corners[i + (k + step) % 3];
          if (known[v] || !known[n]) continue;
          counts.set(v, (counts.get(v) || 0) + 1);
          for (let axis = 0; axis < 3; ++axis) coordinates[3 * v + axis] += coordinates[3 * n + axis];
        }
    if (counts.size === 0) break;
    unknown -= counts.size;
    for (const [v, n] of counts) {
      known[v] = 1;
      for (let axis = 0; axis < 3; ++axis) coordinates[3 * v + axis] = nearestRatio(coordinates[3 * v + axis], n);
    }
  }
  return new MotionState(coordinates, change);
}

const motionContexts = 12;

/// Of each vertex that is known a d + c e, of which the prediction x'(v) + a mean d(n) + b e(v) + c mean e(n) takes the
/// mean.
class Moved {
  constructor(order, before, weights) {
    Object.assign(this, {order, before, weights, moved: new Float64Array(3 * order.count)});
  }
  predict(v, predicted) {
    const {moved, before: {coordinates, change}, order: {first, neighbours}} = this;
    const begin = first[v], end = first[v + 1];
    const count = Math.max(end - begin, 1), own = this.weights[1] * count, at = 3 * v;
    let x = own * change[at], y = own * change[at + 1], z = own * change[at + 2];
    for (let i = begin; i < end; ++i) {
      const n = 3 * neighbours[i];
      x += moved[n];
      y += moved[n + 1];
      z += moved[n + 2];
    }
    predicted[0] = coordinates[at] + nearestRatio(bounded(x), 64 * count);
    predicted[1] = coordinates[at + 1] + nearestRatio(bounded(y), 64 * count);
    predicted[2] = coordinates[at + 2] + nearestRatio(bounded(z), 64 * count);
  }
  know(x, v) {
    const {coordinates, change} = this.before;
    for (let i = 3 * v; i < 3 * v + 3; ++i)
      this.moved[i] = bounded(this.weights[0] * (x[i] - coordinates[i]) + this.weights[2] * change[i]);
  }
}

async function decodePositions(bytes, order, before, what) {
  const x = new Float64Array(3 * order.count), left = new Uint32Array(order.count);
  const from = await SymbolReader.of(bytes, motionContexts + 1, x.length + 3, what);
  const weights = [0, 0, 0].map(() => from.signed(motionContexts));
  const moved = before ? new Moved(order, before, weights) : null, predicted = new Float64Array(3);
  for (let v = 0; v < order.count; ++v) {
    const context = order.context(left, v, motionContexts);
    if (moved) moved.predict(v, predicted);
    else for (let k = 0; k < 3; ++k) predicted[k] = order.inSpace(x, 3, v, k, weights[0]);
    let own = 0;
    for (let k = 0; k < 3; ++k) {
      const value = from.signed(context);
      x[3 * v + k] = predicted[k] + value;
      own += boundedLeft(value);
    }
    left[v] = own;
    if (moved) moved.know(x, v);
  }
  from.end();
  return x;
}
