// Reads the store of an evolving mesh, version 2, as docs/evolving_format.md describes it.
//
// All numbers are whole and exact, below 2^53: what would leave that is refused. Names are those of src/mq/io/detail.
// It runs in the page and, as frames.js wants it, beside the page.
'use strict';

const newPlace = -1;
const mostAddedPerByte = 16;
const largestInt = 0x7fffffff;

/// Refuses what `what` names.
function refuse(what, found) {
  throw new Error(`${what} ${found}.\nMake the page again.`);
}

/// 0, -1, 1, -2, ... from 0, 1, 2, 3, ...
function unfolded(value) {
  if (value <= largestInt) return (value >>> 1) ^ -(value & 1);
  return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
}

const crcTable = Uint32Array.from({length: 256}, (_, i) => {
  for (let bit = 0; bit < 8; ++bit) i = i & 1 ? 0xEDB88320 ^ (i >>> 1) : i >>> 1;
  return i;
});

/// CRC-32 of IEEE 802.3.
function crc32(bytes) {
  let sum = -1;
  for (let i = 0; i < bytes.length; ++i) sum = crcTable[(sum ^ bytes[i]) & 255] ^ (sum >>> 8);
  return ~sum >>> 0;
}

/// Bytes, one after the other.
class ByteReader {
  constructor(bytes, what) {
    Object.assign(this, {bytes, what, at: 0});
  }
  fail(found) { refuse(this.what, found); }
  byte() {
    if (this.at === this.bytes.length) this.fail('ends too early');
    return this.bytes[this.at++];
  }
  leb() {
    let value = 0;
    for (let unit = 1; unit <= 2 ** 49; unit *= 128) {
      const byte = this.byte();
      value += (byte & 127) * unit;
      if (byte < 128) return value;
    }
    this.fail('holds a number of more than 53 bits');
  }
  part(size) {
    if (size > this.bytes.length - this.at) this.fail('ends too early');
    this.at += size;
    return this.bytes.subarray(this.at - size, this.at);
  }
}

// ---------------------------------------------------------------------------------------------
// Streams of numbers (symbol_streams.h)

/// How likely each symbol is, in parts of 2^bits, and how to look it up: Draco's rANS.
class RansTable {
  constructor(from, bits) {
    const count = from.leb();
    if (count / 64 > from.bytes.length - from.at) from.fail('holds a table that is too short');
    const share = new Uint32Array(count), begin = new Uint32Array(count);
    this.symbols = new Uint32Array(2 ** bits);
    let sum = 0;
    for (let i = 0; i < count; ++i) {
      const byte = from.byte(), kind = byte & 3;
      if (kind === 3) {  // so many symbols that do not occur
        i += byte >>> 2;
        if (i >= count) from.fail('holds a table that goes on after its end');
        continue;
      }
      let value = byte >>> 2;
      for (let k = 0; k < kind; ++k) value += from.byte() * 2 ** (8 * k + 6);
      if (value > 2 ** bits - sum) from.fail('holds a table of more than all');
      share[i] = value;
      begin[i] = sum;
      this.symbols.fill(i, sum, sum += value);
    }
    if (sum !== 2 ** bits) from.fail('holds a table of less than all');
    Object.assign(this, {bits, share, begin});
  }

  /// `count` symbols of what follows.
  decode(from, count, symbols) {
    const data = from.part(from.leb()), {bits, share, begin} = this;
    let at = data.length, state = 0;
    if (at === 0) from.fail('holds no state');
    const size = (data[at - 1] >>> 6) + 1;
    if (size > at) from.fail('holds half a state');
    for (let k = 1; k <= size; ++k) state = state * 256 + (k === 1 ? data[at - 1] & 63 : data[at - k]);
    at -= size;
    const least = 2 ** (bits + 2), mask = 2 ** bits - 1;
    state += least;
    if (state >= least * 256) from.fail('holds a state that is too large');
    for (let i = 0; i < count; ++i) {
      while (state < least && at > 0) state = (state << 8) | data[--at];
      const rest = state & mask, symbol = this.symbols[rest];
      state = (state >>> bits) * share[symbol] + rest - begin[symbol];
      symbols[i] = symbol;
    }
  }
}

/// Draco's EncodeSymbols, of one component.
function dracoSymbols(from, count) {
  const symbols = new Uint32Array(count), scheme = from.byte();
  if (scheme === 1) {
    const bits = from.byte();
    if (bits < 1 || bits > 18) from.fail('holds a stream of no sensible precision');
    new RansTable(from, Math.max(12, Math.min(20, Math.floor(3 * bits / 2)))).decode(from, count, symbols);
    return symbols;
  }
  if (scheme !== 0) from.fail('holds a stream of a coding that is not known');
  new RansTable(from, 12).decode(from, count, symbols);  // how many bits each number has
  let bit = 8 * from.at;
  for (let i = 0; i < count; ++i) {
    const length = symbols[i];
    if (length > 31 || bit + length > 8 * from.bytes.length) from.fail('ends too early');
    let value = 0;
    for (let k = 0; k < length; ++k, ++bit) value |= (from.bytes[bit >>> 3] >>> (bit & 7) & 1) << k;
    symbols[i] = value;
  }
  return symbols;
}

/// What deflate made of `size` bytes.
async function inflated(from, size) {
  const plain = new Uint8Array(size);
  let at = 0;
  try {
    const packed = new Blob([from.bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw')).getReader();
    for (let part = await packed.read(); !part.done; part = await packed.read()) {
      plain.set(part.value, at);  // throws where there are more
      at += part.value.length;
    }
  } catch {
    at = -1;
  }
  if (at !== size) from.fail('holds a stream that cannot be unpacked');
  return plain;
}

/// All streams of a block, and the bits that follow.
class SymbolReader {
  /// At most `most` numbers in all.
  static async of(bytes, count, most, what) {
    const reader = new SymbolReader(), from = new ByteReader(bytes, what);
    Object.assign(reader, {what, at: new Uint32Array(count), tokens: [], bit: 0});
    for (let s = 0; s < count; ++s) {
      const size = from.leb();
      if (size > most) reader.fail('holds more numbers than it can');
      most -= size;
      reader.tokens.push(size === 0 ? [] : await reader.decode(from, size));
    }
    reader.bits = from.part(from.leb());
    for (let i = from.at; i < bytes.length; ++i) if (bytes[i] !== 0) reader.fail('goes on after its end');
    return reader;
  }
  fail(found) { refuse(this.what, found); }

  decode(from, size) {
    const method = from.byte(), payload = new ByteReader(from.part(from.leb()), this.what);
    if (method === 0) return new Uint8Array(size).fill(payload.byte());
    if (method === 1) return dracoSymbols(payload, size);
    if (method === 3) return inflated(payload, size);
    this.fail(`holds a stream of method ${method}, which browsers do not know`);
  }

  get(stream) {
    const tokens = this.tokens[stream], at = this.at[stream]++;
    if (at >= tokens.length) this.fail('ends too early');
    return tokens[at] < 16 ? tokens[at] : this.longNumber(tokens[at]);
  }
  longNumber(token) {
    const low = ((token - 16) >>> 1) + 3;
    if (low > 51) this.fail('holds a number of more than 53 bits');
    if (this.bit + low > 8 * this.bits.length) this.fail('ends too early');
    let value = 0;
    if (low <= 24) {  // as is usual
      const {bits} = this, at = this.bit >>> 3;
      const word = bits[at] | (bits[at + 1] << 8) | (bits[at + 2] << 16) | (bits[at + 3] << 24);
      value = (word >>> (this.bit & 7)) & ((1 << low) - 1);
      this.bit += low;
      return value + ((2 + (token & 1)) << low);
    }
    for (let got = 0; got < low;) {
      const within = this.bit & 7, take = Math.min(8 - within, low - got);
      value += (this.bits[this.bit >>> 3] >>> within & ((1 << take) - 1)) * 2 ** got;
      got += take;
      this.bit += take;
    }
    return value + (2 + (token & 1)) * 2 ** low;
  }
  signed(stream) { return unfolded(this.get(stream)); }
  index(stream, end) {
    const value = this.get(stream);
    if (value >= end) this.fail(`holds an index of ${value} where there are ${end}`);
    return value;
  }
  end() {
    if (this.tokens.some((tokens, s) => tokens.length !== this.at[s])) this.fail('holds numbers that nothing needs');
  }
}

// ---------------------------------------------------------------------------------------------
// Predictions (coding_order.h)

/// The nearest whole number to a / b.
const nearestRatio = (a, b) => Math.floor((a + Math.floor(b / 2)) / b);

function rowStarts(counts) {
  const first = new Int32Array(counts.length + 1);
  for (let row = 0; row < counts.length; ++row) first[row + 1] = first[row] + counts[row];
  return first;
}

/// Of each vertex those before it in its triangles; and three corners of parallelograms.
class CodingOrder {
  constructor(corners, count, hasParallelograms) {
    this.count = count;
    const counts = new Int32Array(count);
    const each = (found) => {
      const edge = (a, b) => {
        if (a >= 0 && a < b) found(b, a);
        else if (b >= 0 && b < a) found(a, b);
      };
      for (let i = 0; i < corners.length; i += 3) {
        edge(corners[i], corners[i + 1]);
        edge(corners[i + 1], corners[i + 2]);
        edge(corners[i + 2], corners[i]);
      }
    };
    each((v) => ++counts[v]);
    this.first = rowStarts(counts);
    const next = this.first.slice(), neighbours = this.neighbours = new Int32Array(this.first[count]);
    each((v, n) => { neighbours[next[v]++] = n; });
    this.across = hasParallelograms ? this.parallelograms(corners) : null;
  }

  /// Pairs of two triangles at an edge, at most one for two of its triangles: `first` per vertex, a, b, c.
  parallelograms(corners) {
    const counts = new Int32Array(this.count);
    const each = (found) => {
      for (let i = 0; i < corners.length; i += 3) {
        if (corners[i] < 0 || corners[i + 1] < 0 || corners[i + 2] < 0) continue;
        for (let k = 0; k < 3; ++k) {
          const a = corners[i + (k + 1) % 3], b = corners[i + (k + 2) % 3];
          if (a !== b) found(Math.min(a, b), Math.max(a, b), corners[i + k]);
        }
      }
    };
    each((low) => ++counts[low]);
    const rows = rowStarts(counts), next = rows.slice();
    const highs = new Int32Array(rows[this.count]), apexes = new Int32Array(rows[this.count]);
    each((low, high, apex) => {
      let at = next[low]++;
      for (; at > rows[low] && highs[at - 1] > high; --at) {
        highs[at] = highs[at - 1];
        apexes[at] = apexes[at - 1];
      }
      highs[at] = high;
      apexes[at] = apex;
    });
    const found = [];
    counts.fill(0);
    for (let low = 0; low < this.count; ++low)
      for (let i = rows[low]; i + 1 < rows[low + 1]; ++i) {
        if (highs[i] !== highs[i + 1]) continue;
        const c = Math.min(apexes[i], apexes[i + 1]), v = Math.max(apexes[i], apexes[i + 1]);
        if (v > highs[i] && v !== c) {
          found.push(v, low, highs[i], c);
          ++counts[v];
        }
        ++i;
      }
    const first = rowStarts(counts), place = first.slice(), of = new Int32Array(3 * first[this.count]);
    for (let i = 0; i < found.length; i += 4) {
      const at = 3 * place[found[i]]++;
      for (let k = 0; k < 3; ++k) of[at + k] = found[i + 1 + k];
    }
    return {first, of};
  }

  /// Which of so many streams has what is left of v's values.
  context(left, v, contexts) {
    const begin = this.first[v], end = this.first[v + 1];
    let sum = 0;
    for (let i = begin; i < end; ++i) sum += left[this.neighbours[i]];
    if (end > begin) sum = Math.floor(4 * sum / (end - begin));
    else if (v > 0) sum = 4 * left[v - 1];
    return Math.min(32 - Math.clz32(sum), contexts - 1);
  }

  /// Value k of v, of `dimension` each, from those before it.
  inSpace(values, dimension, v, k, weight) {
    const begin = this.first[v], end = this.first[v + 1], near = end - begin;
    if (near === 0) return v > 0 ? values[dimension * (v - 1) + k] : 0;
    let around = 0, across = 0;
    for (let i = begin; i < end; ++i) around += values[dimension * this.neighbours[i] + k];
    const {first, of} = this.across, far = first[v + 1] - first[v];
    if (far === 0) return nearestRatio(around, near);
    for (let i = 3 * first[v]; i < 3 * first[v + 1]; i += 3)
      across += values[dimension * of[i] + k] + values[dimension * of[i + 1] + k] - values[dimension * of[i + 2] + k];
    return nearestRatio(bounded(around * (64 - weight) * far + across * weight * near), 64 * near * far);
  }
}

/// Above this, quotients are not exact.
function bounded(value) {
  if (Math.abs(value) < 2 ** 51) return value;
  refuse('The film', 'has numbers that are too large for a browser');
}

/// What a prediction leaves, as it counts for those after it.
const boundedLeft = (left) => Math.min(left < 0 ? -left - 1 : left, 1 << 20);
