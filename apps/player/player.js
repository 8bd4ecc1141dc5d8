// Plays a film: the surface of each frame, with the picture that its video shows at that moment.
//
// `film`, set by the script before this one, is what src/mq/io/film.h describes, and more:
//   title, rate     of the page, and frames a second
//   store           the manifest's file beside the page; null: the film is in the page, as
//   manifest        the store's manifest
//   blocks          data URIs of the store's blocks, one per group of frames
//   lives           data URI of the lives of charts
//   video           data URI or name of the texture video, one picture a frame; null: there is none
//
// The place after # asks for a state, such as #frame=12&colours=lives&seams&atlas&azimuth=40
// &elevation=10&pause; frame is the number that the frame has. Where it changes, what it names or has
// named before changes with it. <body data-frame> is the number shown.
'use strict';

const element = (id) => document.getElementById(id);

function say(text) {
  element('message').textContent = text;
  element('message').hidden = !text;
}

/// What is worth telling beside the film, a sentence per key; none: nothing more to say there.
const notes = new Map();
function note(key, text) {
  if (text) notes.set(key, text);
  else notes.delete(key);
  element('message').className = 'note';
  say([...notes.values()].join('\n'));
}

// ---------------------------------------------------------------------------------------------
// The film's bytes

async function bytesOf(uri) {
  return (await fetch(uri)).arrayBuffer();
}

/// What frames.js begins with.
async function openedFilm() {
  const lives = await bytesOf(film.lives);
  if (!film.store) {
    const blocks = await Promise.all(film.blocks.map(bytesOf));
    film.blocks = null;  // they are large
    return {manifest: film.manifest, blocks, url: null, lives};
  }
  if (location.protocol === 'file:')
    throw new Error('This page fetches its film from beside it, which browsers do from a server alone.\n' +
                    'One is begun in the page\'s folder by: python3 -m http.server');
  const place = new URL(film.store, location.href), answer = await fetch(place);
  if (!answer.ok) throw new Error(`${film.store} cannot be fetched (${answer.status}).`);
  const manifest = await answer.text();
  const {blocks} = JSON.parse(manifest.slice(0, manifest.indexOf('\n')));
  return {manifest, blocks: null, url: new URL(blocks, place).href, lives};
}

// ---------------------------------------------------------------------------------------------
// What is drawn

/// The surface, its seams, and the same flat, as it lies in the texture.
class Stage {
  constructor() {
    this.renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.autoClear = false;
    document.body.prepend(this.renderer.domElement);
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.01, 100);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.draw());

    this.surface = new THREE.Scene();
    const sky = new THREE.HemisphereLight(0xffffff, 0x777777, 0.65);
    const lamp = new THREE.DirectionalLight(0xffffff, 0.45);
    this.camera.add(lamp);
    lamp.position.set(0.3, 0.5, 1);
    this.surface.add(sky, this.camera);

    const behindLines = {side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1,
                         polygonOffsetUnits: 1};
    this.texture = null;
    this.materials = {
      captured: new THREE.MeshBasicMaterial(behindLines),
      lives: new THREE.MeshLambertMaterial({...behindLines, vertexColors: THREE.VertexColors}),
      plain: new THREE.MeshLambertMaterial({...behindLines, color: 0xd8d5cf}),
    };
    this.flatMaterials = {
      captured: this.materials.captured,
      lives: new THREE.MeshBasicMaterial({...behindLines, vertexColors: THREE.VertexColors}),
      plain: new THREE.MeshBasicMaterial({...behindLines, color: 0xd8d5cf}),
    };
    const line = new THREE.LineBasicMaterial({color: 0x16181c});
    this.mesh = new THREE.Mesh(new THREE.BufferGeometry(), this.materials.plain);
    this.seams = new THREE.LineSegments(new THREE.BufferGeometry(), line);
    this.flat = new THREE.Mesh(new THREE.BufferGeometry(), this.flatMaterials.plain);
    this.flatSeams = new THREE.LineSegments(new THREE.BufferGeometry(), line);
    for (const thing of [this.mesh, this.seams, this.flat, this.flatSeams]) thing.frustumCulled = false;
    this.surface.add(this.mesh, this.seams);

    this.atlas = new THREE.Scene();
    this.atlas.background = new THREE.Color(0x101114);
    this.atlas.add(this.flat, this.flatSeams);
    this.atlasCamera = new THREE.OrthographicCamera(-0.01, 1.01, 1.01, -0.01, -1, 1);
    this.showAtlas = false;
    window.addEventListener('resize', () => this.fit());
  }

  /// The triangles of a segment (`shape` of frames.js), in buffers of their own.
  open(segment) {
    const buffer = (values, size, normalised) => new THREE.BufferAttribute(values, size, normalised);
    const points = segment.vertexOf.length;
    const positions = buffer(new Float32Array(3 * points), 3);
    const normals = buffer(new Float32Array(3 * points), 3);
    positions.usage = normals.usage = THREE.DynamicDrawUsage;
    const flatPositions = new Float32Array(3 * points);
    for (let p = 0; p < segment.uvs.length / 2; ++p) {
      flatPositions[3 * p] = segment.uvs[2 * p];
      flatPositions[3 * p + 1] = segment.uvs[2 * p + 1];
    }
    const shared = {colours: buffer(segment.colours, 3, true), corners: buffer(segment.corners, 1),
                    borders: buffer(segment.borders, 1),
                    uvs: segment.hasUvs ? buffer(segment.uvs, 2) : null};
    const fill = (thing, where, index) => {
      thing.geometry.dispose();
      thing.geometry = new THREE.BufferGeometry();
      thing.geometry.setIndex(index);
      thing.geometry.setAttribute('position', where);
      if (!thing.isMesh) return;
      thing.geometry.setAttribute('color', shared.colours);
      if (shared.uvs) thing.geometry.setAttribute('uv', shared.uvs);
    };
    fill(this.mesh, positions, shared.corners);
    this.mesh.geometry.setAttribute('normal', normals);
    fill(this.seams, positions, shared.borders);
    const flat = buffer(flatPositions, 3);
    fill(this.flat, flat, shared.corners);
    fill(this.flatSeams, flat, shared.borders);
    this.vertexNormals = new Float32Array(3 * segment.vertices);
  }

  /// The positions of a frame. Normals are those of vertices, so that seams do not show in the light.
  move(segment, positions) {
    const position = this.mesh.geometry.attributes.position, p = position.array;
    const {vertexOf, corners} = segment;
    for (let i = 0; i < vertexOf.length; ++i)
      for (let k = 0; k < 3; ++k) p[3 * i + k] = positions[3 * vertexOf[i] + k];
    position.needsUpdate = true;

    const sums = this.vertexNormals.fill(0);
    for (let c = 0; c < corners.length; c += 3) {
      const a = 3 * corners[c], b = 3 * corners[c + 1], d = 3 * corners[c + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[d] - p[a], vy = p[d + 1] - p[a + 1], vz = p[d + 2] - p[a + 2];
      for (let k = 0; k < 3; ++k) {
        const v = 3 * vertexOf[corners[c + k]];
        sums[v] += uy * vz - uz * vy;
        sums[v + 1] += uz * vx - ux * vz;
        sums[v + 2] += ux * vy - uy * vx;
      }
    }
    const normal = this.mesh.geometry.attributes.normal;
    for (let i = 0; i < vertexOf.length; ++i) {
      const v = 3 * vertexOf[i], length = Math.hypot(sums[v], sums[v + 1], sums[v + 2]) || 1;
      for (let k = 0; k < 3; ++k) normal.array[3 * i + k] = sums[v + k] / length;
    }
    normal.needsUpdate = true;
  }

  show(video) {
    this.texture = new THREE.Texture(video);
    Object.assign(this.texture, {minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter,
                                 generateMipmaps: false, format: THREE.RGBFormat});
    this.materials.captured.map = this.texture;
    this.materials.captured.needsUpdate = true;
  }

  paint(colours) {
    this.mesh.material = this.materials[colours];
    this.flat.material = this.flatMaterials[colours];
    this.draw();
  }

  home(centre, radius, azimuth, elevation) {
    const toRadians = Math.PI / 180, distance = radius / Math.sin(0.5 * this.camera.fov * toRadians);
    const a = azimuth * toRadians, e = elevation * toRadians;
    this.camera.near = 0.01 * distance;
    this.camera.far = 10 * distance;
    this.controls.target.fromArray(centre);
    this.camera.position.fromArray(centre).add(new THREE.Vector3(
        distance * Math.cos(e) * Math.sin(a), distance * Math.sin(e), distance * Math.cos(e) * Math.cos(a)));
    this.controls.update();
    this.fit();
  }

  fit() {
    this.renderer.setSize(window.innerWidth, window.innerHeight);
    this.draw();
  }

  draw() {
    const width = window.innerWidth, height = window.innerHeight, bar = element('bar').offsetHeight;
    const side = this.showAtlas ? Math.min(Math.floor(width / 2), height - bar) : 0;
    const pane = {left: 0, bottom: bar, width: Math.max(1, width - side), height: Math.max(1, height - bar)};
    this.camera.aspect = pane.width / pane.height;
    this.camera.updateProjectionMatrix();
    this.renderer.setScissorTest(true);
    const render = (scene, camera, x, y, w, h) => {
      this.renderer.setViewport(x, y, w, h);
      this.renderer.setScissor(x, y, w, h);
      this.renderer.clear();
      this.renderer.render(scene, camera);
    };
    this.renderer.setScissor(0, 0, width, height);
    this.renderer.setClearColor(0x24262b);
    this.renderer.clear();
    render(this.surface, this.camera, pane.left, pane.bottom, pane.width, pane.height);
    if (side)
      render(this.atlas, this.atlasCamera, width - side, bar + Math.floor((height - bar - side) / 2), side, side);
  }
}

// ---------------------------------------------------------------------------------------------
// Time

/// Which frame it is: a video's, or that of a clock where there is none.
class Time {
  constructor(count, rate, video, show) {
    Object.assign(this, {count, rate, video, show, frame: 0, speed: 1, playing: false});
    if (!video) return;
    const shown = (now, picture) => {
      if (!this.video) return;
      this.show(this.frame = this.frameOf(picture.mediaTime), true);
      video.requestVideoFrameCallback(shown);
    };
    video.requestVideoFrameCallback(shown);
    video.addEventListener('play', () => { this.playing = true; this.changed(); });
    video.addEventListener('pause', () => { this.playing = false; this.changed(); });
  }

  frameOf(seconds) {
    return Math.max(0, Math.min(this.count - 1, Math.round(seconds * this.rate)));
  }

  go(frame) {
    this.frame = Math.max(0, Math.min(this.count - 1, frame));
    if (this.video) this.video.currentTime = (this.frame + 0.5) / this.rate;
    else this.show(this.frame);
  }

  play() {
    if (this.video) return this.video.play();
    this.playing = true;
    const begin = performance.now() - 1000 * this.frame / (this.rate * this.speed);
    const tick = (now) => {
      if (!this.playing) return;
      const frame = Math.floor((now - begin) / 1000 * this.rate * this.speed) % this.count;
      if (frame !== this.frame && frame >= 0) this.show(this.frame = frame);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    this.changed();
  }

  pause() {
    if (this.video) return this.video.pause();
    this.playing = false;
    this.changed();
  }

  /// Goes on by a clock.
  leaveVideo() {
    this.video = null;
    this.playing = false;
    this.changed();
  }

  setSpeed(speed) {
    this.speed = speed;
    if (this.video) this.video.playbackRate = speed;
    else if (this.playing) {
      this.pause();
      this.play();
    }
  }
}

/// An address that a video can be played from at any place: its own where the server sends parts of files, else that of
/// a copy.
async function playedFrom(uri, kind) {
  if (!film.store) return URL.createObjectURL(new Blob([await bytesOf(uri)], {type: kind}));
  const answer = await fetch(uri, {headers: {Range: 'bytes=0-0'}});
  if (!answer.ok) throw new Error(`${uri} cannot be fetched (${answer.status}).`);
  return answer.status === 206 ? uri : URL.createObjectURL(await answer.blob());
}

async function videoOf(uri) {
  const video = document.createElement('video');
  Object.assign(video, {muted: true, loop: true, playsInline: true, preload: 'auto'});
  if (!video.requestVideoFrameCallback)
    throw new Error('This browser does not say which picture of a video it shows.\n' +
                    'Newer ones do: Chromium 83, Safari 15.4, Firefox 132.');
  const kind = film.store ? uri : uri.slice(5, uri.indexOf(';'));
  video.src = await playedFrom(uri, kind);
  await new Promise((resolve, reject) => {
    video.addEventListener('loadeddata', resolve, {once: true});
    video.addEventListener('error', () => reject(new Error(
        `This browser cannot play the textures (${kind}): ${video.error.message}`)), {once: true});
  });
  return video;
}

// ---------------------------------------------------------------------------------------------

async function main() {
  try {
    new DecompressionStream('deflate-raw');
  } catch {
    throw new Error('This browser cannot unpack the film.\nNewer ones can: Chromium 103, Safari 16.4, Firefox 113.');
  }
  document.title = film.title;
  const stage = new Stage();
  let video = null;
  const withoutVideo = (reason) =>
      note('video', `${reason}\nThe shape, lives of charts and seams are shown without textures.`);
  try {
    if (film.video) video = await videoOf(film.video);
  } catch (error) {
    withoutVideo(error.message);
  }
  const opening = await openedFilm();
  let frames = null;
  if (video) stage.show(video);
  const seconds = film.frames.length / film.rate;
  if (video && Math.abs(video.duration - seconds) * film.rate > 1.5)
    note('length', `The video takes ${video.duration.toFixed(2)} s, and the film ${seconds.toFixed(2)} s ` +
                   `(${film.frames.length} frames, ${film.rate} a second): textures may be those of other ` +
                   'frames.\nMake the page with the video\'s own --rate, of a video with a picture for each frame.');

  let opened = null, shown = -1, isPictureNew = false;
  const draw = (frame, {shape, positions}) => {
    if (shape !== opened) stage.open(opened = shape);
    if (frame !== shown) stage.move(shape, positions);
    shown = frame;
    if (isPictureNew && stage.texture) stage.texture.needsUpdate = true;
    isPictureNew = false;
    stage.draw();
    element('time').value = frame;
    element('number').textContent = `frame ${film.frames[frame]}`;
    document.body.dataset.frame = film.frames[frame];
    if (notes.has('frames')) note('frames', '');
    begun();
  };
  let begun = null;
  const isBegun = new Promise((resolve, reject) => {
    begun = resolve;
    frames = new KeptFrames(opening, film.frames.length, draw, (text) => {
      note('frames', text);
      reject(new Error(text));
    });
  });
  const show = (frame, isNewPicture) => {
    isPictureNew = isPictureNew || isNewPicture;
    const found = frames.want(frame);
    if (found) draw(frame, found);
  };
  const time = new Time(film.frames.length, film.rate, video, show);
  time.changed = () => { element('play').textContent = time.playing ? 'Pause' : 'Play'; };

  const toggle = () => (time.playing ? time.pause() : time.play());
  const stepBy = (frames) => { time.pause(); time.go(time.frame + frames); };
  const low = film.low, high = film.high;
  const centre = low.map((v, k) => 0.5 * (v + high[k]));
  const radius = 0.5 * Math.hypot(...low.map((v, k) => high[k] - v)) || 1;
  let asked = new URLSearchParams(location.hash.slice(1));
  const number = (name, otherwise) => (asked.has(name) ? Number(asked.get(name)) || 0 : otherwise);
  const home = () => stage.home(centre, radius, number('azimuth', 25), number('elevation', 12));

  element('time').max = film.frames.length - 1;
  element('time').addEventListener('input', (e) => {
    note('frame', '');
    time.pause();
    time.go(Number(e.target.value));
  });
  element('play').addEventListener('click', toggle);
  element('home').addEventListener('click', home);
  element('speed').addEventListener('change', (e) => time.setSpeed(Number(e.target.value)));
  const paint = () => {
    const colours = element('colours').value;
    element('legend').hidden = colours !== 'lives';
    stage.paint(colours);
  };
  element('colours').addEventListener('change', paint);
  const overlay = () => {
    stage.seams.visible = stage.flatSeams.visible = element('seams').checked;
    stage.showAtlas = element('atlas').checked;
    stage.draw();
  };
  element('seams').addEventListener('change', overlay);
  element('atlas').addEventListener('change', overlay);
  window.addEventListener('keydown', (e) => {
    if (['SELECT', 'INPUT', 'BUTTON'].includes(e.target.tagName)) return;
    const action = {' ': toggle, ArrowLeft: () => stepBy(-1), ArrowRight: () => stepBy(1), Home: home}[e.key];
    if (!action) return;
    e.preventDefault();
    action();
  });

  const captured = element('colours').querySelector('[value=captured]');
  if (!video) captured.remove();
  else
    video.addEventListener('error', () => {
      withoutVideo(`This browser stopped playing the textures: ${video.error.message}`);
      captured.remove();
      time.leaveVideo();
      paint();
    }, {once: true});
  if (!film.segments.some((s) => s.has_uvs)) element('atlas').parentElement.hidden = true;
  /// Where the frame that is asked for is in the film, or the nearest one.
  const askedFrame = () => {
    note('frame', '');
    if (!asked.has('frame')) return 0;
    const wanted = asked.get('frame') === '' ? NaN : Number(asked.get('frame'));
    let nearest = 0;
    film.frames.forEach((frame, i) => {
      if (Math.abs(frame - wanted) < Math.abs(film.frames[nearest] - wanted)) nearest = i;
    });
    if (film.frames[nearest] !== wanted)
      note('frame', `There is no frame ${asked.get('frame')}: this is frame ${film.frames[nearest]}, of ` +
                    `${film.frames[0]} to ${film.frames[film.frames.length - 1]}.`);
    return nearest;
  };
  const look = (named) => {
    const colours = element('colours');
    if (named('colours'))
      colours.value = [...colours.options].some((o) => o.value === asked.get('colours')) ?
          asked.get('colours') : colours.options[0].value;
    for (const name of ['seams', 'atlas'])
      if (named(name)) element(name).checked = asked.has(name);
  };
  look(() => true);
  window.addEventListener('hashchange', () => {
    const before = asked;
    asked = new URLSearchParams(location.hash.slice(1));
    const named = (name) => asked.has(name) || before.has(name);
    look(named);
    overlay();
    paint();
    if (named('azimuth') || named('elevation')) home();
    if (asked.has('frame') || asked.has('pause')) time.pause();
    if (named('frame')) time.go(askedFrame());
    if (!asked.has('frame') && !asked.has('pause') && (named('frame') || named('pause'))) time.play();
  });
  element('bar').hidden = false;
  const first = askedFrame();
  note('loading', 'Loading …');
  show(first, true);
  await isBegun;
  note('loading', '');
  home();
  overlay();
  paint();
  if (first > 0 || video) time.go(first);
  if (!asked.has('frame') && !asked.has('pause')) await time.play();
}

main().catch((error) => say(error.message));
