// Frames of the film in the page, as frames.js makes them beside it.
'use strict';

const framesAhead = 8;
const mostKept = 192e6;  // bytes

/// Frames are kept while there is room for them; the next ones are made ahead of time.
class KeptFrames {
  /// Begins frames.js with `opening`. `arrived` is told a frame that was wanted once it is there, `failed` why not.
  constructor(opening, count, arrived, failed) {
    Object.assign(this, {count, arrived, failed, kept: new Map(), shapes: new Map(), bad: new Map()});
    Object.assign(this, {wanted: 0, asked: -1});  // -1: none
    const scripts = [...document.querySelectorAll('script[data-worker]')].map((script) => script.textContent);
    this.worker = new Worker(URL.createObjectURL(new Blob(scripts, {type: 'text/javascript'})));
    this.worker.onmessage = ({data}) => this.take(data);
    this.worker.onerror = (event) => failed(event.message);
    this.worker.postMessage(opening, opening.blocks || []);
  }

  /// A frame, if it is there: its `shape` and `positions`.
  want(frame) {
    this.wanted = frame;
    this.ask();
    if (this.bad.has(frame)) this.failed(this.bad.get(frame));
    return this.kept.get(frame);
  }

  ask() {
    for (let k = 0; this.asked < 0 && k <= Math.min(framesAhead, this.count - 1); ++k) {
      const frame = (this.wanted + k) % this.count;
      if (this.kept.has(frame) || this.bad.has(frame)) continue;
      this.asked = frame;
      this.isWanted = k === 0;
      this.worker.postMessage({frame, has: [...this.shapes.keys()]});
    }
  }

  take(data) {
    if (data.failed !== undefined) {
      this.bad.set(this.asked, data.failed);
      if (this.asked === this.wanted) this.failed(data.failed);
    }
    if (data.failed !== undefined || data.done !== undefined) {
      this.asked = -1;
      this.leaveOut();
      return this.ask();
    }
    const {frame, segment, positions, shape} = data;
    if (shape) this.shapes.set(segment, shape);
    const found = {segment, positions, shape: this.shapes.get(segment)};
    this.kept.set(frame, found);
    // Where they are made too slowly, those that were wanted are shown late rather than not at all.
    if (frame === this.wanted || (frame === this.asked && this.isWanted)) this.arrived(frame, found);
  }

  /// How far it is from the one that is wanted; after the last comes the first.
  distance(frame) {
    const frames = Math.abs(frame - this.wanted);
    return Math.min(frames, this.count - frames);
  }

  /// Those farthest away, where all are too large.
  leaveOut() {
    const users = new Map();  // of each shape
    let bytes = 0;
    for (const {positions, segment} of this.kept.values()) {
      bytes += positions.byteLength;
      users.set(segment, (users.get(segment) || 0) + 1);
    }
    for (const shape of this.shapes.values()) bytes += shapeBytes(shape);
    for (const frame of [...this.kept.keys()].sort((a, b) => this.distance(b) - this.distance(a))) {
      if (bytes <= mostKept || this.distance(frame) <= framesAhead) return;
      const {positions, segment, shape} = this.kept.get(frame);
      this.kept.delete(frame);
      bytes -= positions.byteLength;
      users.set(segment, users.get(segment) - 1);
      if (users.get(segment) > 0) continue;
      this.shapes.delete(segment);
      bytes -= shapeBytes(shape);
    }
  }
}

function shapeBytes({uvs, vertexOf, corners, borders, colours}) {
  return [uvs, vertexOf, corners, borders, colours].reduce((sum, part) => sum + part.byteLength, 0);
}
