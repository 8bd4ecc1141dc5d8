// Goes through a store: which blocks a frame needs, and what they say. Bytes are fetched by groups of frames.
'use strict';

const mostGroupsKept = 3;

/// The lines of a manifest, up to the first that is not sound. `broken` says what is wrong with that.
class Manifest {
  constructor(text) {
    const lines = text.split('\n');
    const head = this.parsed(lines[0]);
    if (head.format !== 'marquetry evolving mesh' || head.version !== 2 || !(head.step > 0))
      refuse('The film', 'is no evolving mesh of version 2');
    Object.assign(this, {step: head.step, segments: [], frames: [], groups: [], bytes: 0, broken: ''});
    for (let i = 1; i < lines.length - 1 && !this.broken; ++i) this.broken = this.add(this.parsed(lines[i]), i + 1);
    if (lines[lines.length - 1]) this.broken = this.broken || 'its last line is not whole';
  }

  parsed(line) {
    try {
      return JSON.parse(line) || {};
    } catch {
      return {};
    }
  }

  /// What is wrong with a line, or nothing.
  add(line, number) {
    const isCount = (value) => Number.isInteger(value) && value >= 0;
    if (![line.offset, line.bytes, line.crc32, line.segment].every(isCount) || line.offset !== this.bytes)
      return `line ${number} lacks something or does not follow the last`;
    const block = {offset: line.offset, bytes: line.bytes, crc32: line.crc32, segment: line.segment};
    const isNext = block.segment === this.segments.length;
    if (line.frame !== undefined) {
      if (block.segment + 1 !== this.segments.length || !isCount(line.frame)) return `line ${number} is of no segment`;
      this.frames.push({...block, number: line.frame, group: this.groups.length - 1});
    } else {
      if (!isCount(line.vertices) || !isCount(line.triangles)) return `line ${number} lacks counts`;
      Object.assign(block, {vertices: line.vertices, triangles: line.triangles, group: this.groups.length});
      if (line.group !== undefined) {
        if (line.group !== this.groups.length || !(isNext || block.segment + 1 === this.segments.length))
          return `line ${number} begins another group or segment than the next`;
        this.groups.push({...block, firstFrame: this.frames.length, end: 0});
      } else if (!isNext || this.groups.length === 0) {
        return `line ${number} is not the next segment`;
      }
      if (isNext) this.segments.push({...block, group: this.groups.length - 1});
    }
    this.bytes += block.bytes;
    this.groups[this.groups.length - 1].end = this.bytes;
    return '';
  }
}

/// `fetched(begin, end)` promises these bytes of the blocks.
class StoreReader {
  constructor(manifest, fetched) {
    Object.assign(this, {manifest, fetched, kept: new Map(), now: null});
  }

  /// The bytes of a group. Those of the last few are kept.
  group(index) {
    let bytes = this.kept.get(index);
    if (!bytes) {
      const {offset, end} = this.manifest.groups[index];
      bytes = this.fetched(offset, end);
      bytes.catch(() => this.kept.delete(index));
      this.kept.set(index, bytes);
      for (const old of this.kept.keys()) if (this.kept.size > mostGroupsKept) this.kept.delete(old);
    }
    return bytes;
  }

  block(bytes, group, {offset, bytes: size, crc32: sum}, what) {
    const begin = offset - this.manifest.groups[group].offset, block = bytes.subarray(begin, begin + size);
    if (block.length !== size || crc32(block) !== sum) refuse(what, 'has other bytes than were written');
    return block;
  }

  /// A segment, told by the one before, where the motion goes on.
  async opened(now, index, bytes, counts, before) {
    const what = `Segment ${index}`, segment = await decodeChange(bytes, before, what);
    if (segment.vertexIds.length !== counts.vertices || segment.triangleIds.length !== counts.triangles)
      refuse(what, 'has not as much as it says');
    const motion = carriedOver(now.motion, segment.vertexPlaces, segment.corners);
    return {...now, segmentIndex: index, segment, motion,
            order: new CodingOrder(segment.corners, segment.vertexIds.length, !motion)};
  }

  /// Goes through the frames of a group, from the one after that which was read last if it can be, up to `index`.
  /// `found` is told each: its number in the store as `frame`, `segment`, `segmentIndex`, and `motion`, whose
  /// coordinates are in steps.
  async read(index, found) {
    const {frames, groups, segments} = this.manifest, {group} = frames[index];
    const bytes = await this.group(group);
    let now = this.now;
    this.now = null;  // what fails leaves nothing to go on from
    if (!now || now.group !== group || now.frame >= index) {
      const first = groups[group], block = this.block(bytes, group, first, `Segment ${first.segment}`);
      now = {group, frame: first.firstFrame - 1, motion: null};
      now = await this.opened(now, first.segment, block, first, emptySegment);
    }
    while (now.frame < index) {
      const next = frames[now.frame + 1];
      while (now.segmentIndex < next.segment) {
        const at = now.segmentIndex + 1, block = this.block(bytes, group, segments[at], `Segment ${at}`);
        now = await this.opened(now, at, block, segments[at], now.segment);
      }
      const what = `Frame ${next.number}`, block = this.block(bytes, group, next, what);
      const coordinates = await decodePositions(block, now.order, now.motion, what);
      now = {...now, frame: now.frame + 1, motion: MotionState.after(now.motion, coordinates)};
      found(now);
    }
    this.now = now;
    if (groups[group + 1] && index === groups[group + 1].firstFrame - 1) this.group(group + 1).catch(() => {});
  }
}
