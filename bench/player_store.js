// node bench/player_store.js STORE.evolving: milliseconds of processor time in which the player's scripts read each frame
// of a store, the least of several rounds, and make what the graphics card wants of each segment.
'use strict';

const fs = require('fs'), path = require('path'), vm = require('vm');

const scripts = ['store.js', 'positions.js', 'segments.js', 'reader.js', 'frames.js'];
const folder = path.join(__dirname, '../apps/player');
globalThis.document = {};  // so that frames.js waits for no page
const code = scripts.map((name) => fs.readFileSync(path.join(folder, name), 'utf8')).join('\n');
const {Manifest, StoreReader, shapeOf} = vm.runInThisContext(`${code};({Manifest, StoreReader, shapeOf})`);

async function main(store) {
  const text = fs.readFileSync(store, 'utf8'), {blocks} = JSON.parse(text.slice(0, text.indexOf('\n')));
  const bytes = new Uint8Array(fs.readFileSync(path.join(path.dirname(store), blocks)));
  const manifest = new Manifest(text), least = manifest.frames.map(() => Infinity);
  const now = () => process.cpuUsage().user / 1000;
  for (let round = 0; round < 8; ++round) {
    const reader = new StoreReader(manifest, async (begin, end) => bytes.subarray(begin, end));
    let begin = now(), opened = -1;
    for (const frame of manifest.frames.keys())
      await reader.read(frame, ({segmentIndex, segment}) => {
        if (segmentIndex !== opened) shapeOf(segment, new Uint32Array(segment.triangleIds.length), [[0, 0, 0]]);
        opened = segmentIndex;
        least[frame] = Math.min(least[frame], now() - begin);
        begin = now();
      });
  }
  console.log(`${manifest.frames.length} frames, ${manifest.segments.length} segments, ms of each:`);
  console.log(least.map((taken) => taken.toFixed(1)).join(' '));
}

main(process.argv[2]).catch((error) => {
  console.error(error.message);
  process.exitCode = 2;
});
