// The live view's page: connects the connection, the picture and the panels. docs/live_view.md describes the protocol.

import { Vector3 } from 'three';
import { Banner } from './banner.js';
import { kChunkGone, kDepthPicture, kMeshChunk, readBinaryMessage } from './binary_message.js';
import { ChunkStore } from './chunk_store.js';
import { Commands } from './commands.js';
import { Connection } from './connection.js';
import { CoverageRing, RingPicture } from './coverage_ring.js';
import { CropBox } from './crop_box.js';
import { DepthPicture } from './depth_picture.js';
import { note } from './dialogs.js';
import { FilesPanel } from './files_panel.js';
import { MeasureTool } from './measure/measure_tool.js';
import { MeshMaterials } from './mesh_material.js';
import { showNumbers } from './numbers.js';
import { openToTests } from './test_access.js';
import { ScannerPath } from './scanner_path.js';
import { ViewKeeper } from './view_keeper.js';
import { TilesScene } from './tiles_scene.js';
import { connectTools } from './tools.js';
import { Viewer } from './viewer.js';

/// The length of the drawn scanner in a room; smaller for an object.
const kLargestPyramidM = 0.12;

const $ = (id) => document.getElementById(id);

const query = new URLSearchParams(location.search);
if (query.has('token')) {
  // The cookie has the token now: remove it from the address, so that no history or screenshot shows it.
  query.delete('token');
  history.replaceState(null, '', location.pathname + (query.size > 0 ? `?${query}` : ''));
}

const scan = {
  link: 'connecting', hello: null, state: null,
  received: { bytes: 0, messages: 0, chunks: 0, gone: 0, pictures: 0 }, firstMeshMs: null, revisions: new Map(),
};
const banner = new Banner($('banner'));
const depth = new DepthPicture($('depth'));
const files = new FilesPanel({
  panel: $('files'), list: $('file-list'), open: $('files-open'), close: $('files-close'), count: $('files-count'),
});
const picture = makePicture();

/// Makes everything that needs WebGL; null without WebGL.
function makePicture() {
  let viewer;
  try {
    viewer = new Viewer($('view'), { isTest: query.has('test') });
  } catch {
    $('no-webgl').hidden = false;
    return null;
  }
  const materials = new MeshMaterials();
  const store = new ChunkStore(viewer.world, materials, viewer.renderer.getContext());
  const tiles = new TilesScene({ viewer, materials, onNews: onTiles });
  const path = new ScannerPath(viewer.world);
  const ring = new CoverageRing();
  const keeper = new ViewKeeper(viewer, store, path);
  const cropButton = $('actions').querySelector('[data-command=crop]');
  const crop = new CropBox({
    viewer, materials, panel: $('crop'), rows: $('crop-rows'), extent: () => store.extent(),
    onToggle: (isOpen) => cropButton.setAttribute('aria-expanded', String(isOpen)),
  });
  const measuring = new MeasureTool({
    viewer, store, materials, panel: $('measure'), labels: $('measure-labels'), hello: () => scan.hello,
    onToggle: (isOpen, hadFocus) => {
      $('measure-open').setAttribute('aria-expanded', String(isOpen));
      if (hadFocus) { $('measure-open').focus(); }
    },
  });
  return { viewer, materials, store, tiles, path, ring, ringPicture: new RingPicture($('ring')), keeper, crop, measuring };
}

const connection = new Connection({ text: onText, binary: onBinary, status: onStatus });
const commands = new Commands($('actions'), connection, {
  done(command) {
    if (command === 'export') { files.show(true); }
    if (command === 'finish') { files.showNext(); }
  },
  crop: picture ? toggleCrop : null,
});
$('retry').addEventListener('click', () => connection.retryNow());

function onStatus(link) {
  scan.link = link;
  banner.show(link, scan.state, scan.hello);
  commands.update({ isOpen: link === 'open' });
  files.setReachable(link === 'open');
  if (scan.state) { showNumbers(scan.state, scan.hello, picture?.store.extent(), link === 'open'); }
}

const kTextHandlers = {
  hello(message) {
    const isFirst = scan.hello === null;
    if (!isFirst && scan.hello.title !== message.title) { picture?.measuring.forget(); }
    scan.hello = message;
    depth.clear();
    scan.revisions.clear();
    $('input').textContent = message.title;
    document.body.dataset.mode = message.mode;
    document.body.classList.toggle('of-tiles', Boolean(message.tiles));
    document.title = `${message.title} · ScanKnit`;
    commands.update({ allowed: new Set(message.commands) });
    if (!picture) { return; }
    picture.store.clear();  // the program sends the whole mesh again, in its newest revision
    picture.viewer.up = message.up;
    if (picture.keeper.isFollowing === null) { picture.keeper.set({ isFollowing: !message.is_orbit && message.mode !== 'file' }); }
    if (message.tiles) { picture.tiles.open(message.tiles); }
    if (isFirst) { tools.showRing(message.is_orbit); }
  },
  state(message) {
    scan.state = message;
    banner.show(scan.link, message, scan.hello);
    commands.update({ phase: message.phase, isCropEmpty: message.is_crop_empty, hasScan: message.fused > 0 });
    if (picture?.crop.isOpen && ['finished', 'failed'].includes(message.phase)) { picture.crop.close(); }
    showNumbers(message, scan.hello, picture?.store.extent(), scan.link === 'open');
    $('empty').hidden = !picture || Boolean(scan.hello?.tiles) || picture.store.triangles > 0;
  },
  pose(message) { picture?.path.setPose(message); },
  trail(message) {
    picture?.path.setTrail(message.points);
    if (!picture || message.points.length > 0) { return; }  // the rest: after a reset
    if (picture.crop.isOpen) { picture.crop.close(); }
    if (scan.hello?.mode !== 'file') { picture.measuring.forget(); }
  },
  files(message) { files.set(scan.hello?.tiles ? [] : message.files); },  // tiles are not for download one by one
  crop(message) { picture?.crop.setInForce(message.box); },
};

function onText(message) {
  kTextHandlers[message.type]?.(message);
  picture?.viewer.redrawSoon();
}

function onBinary(buffer) {
  const message = readBinaryMessage(buffer);
  ++scan.received.messages;
  scan.received.bytes += buffer.byteLength;
  if (message.kind === kDepthPicture) {
    ++scan.received.pictures;
    depth.show(message.jpeg);
    return;
  }
  if (message.kind === kMeshChunk) {
    ++scan.received.chunks;
    scan.firstMeshMs ??= performance.now();
    scan.revisions.set(message.chunk, (scan.revisions.get(message.chunk) ?? 0) + 1);
    picture?.store.set(message);
  } else if (message.kind === kChunkGone) {
    ++scan.received.gone;
    picture?.store.remove(message.chunk);
  }
  if (picture?.store.triangles > 0) { $('empty').hidden = true; }
  picture?.viewer.redrawSoon();
}

function onTiles() {
  picture.store.surround(picture.tiles.box);
  if (picture.tiles.numbers.tiles > 0) { scan.firstMeshMs ??= performance.now(); }
  picture.viewer.redrawSoon();
}

function toggleCrop() {
  if (picture.crop.isOpen) {
    picture.crop.close();
  } else if (picture.crop.open()) {
    picture.measuring.close();
    files.show(false);  // it would cover the mesh to crop
  } else {
    note('There is no mesh yet that could be cut.');
  }
}

function toggleMeasuring() {
  if (picture.measuring.isOpen) {
    picture.measuring.close();
  } else if (picture.measuring.open()) {
    if (picture.crop.isOpen) { picture.crop.close(); }
    files.show(false);
  } else {
    note('There is no mesh yet that could be measured.');
  }
}

function prepareDrawing(viewer) {
  const { materials, store, tiles, path, ring, ringPicture, keeper } = picture;
  keeper.keep();
  tiles.prepare();
  const bounds = store.extent();
  if (scan.state) { showNumbers(scan.state, scan.hello, bounds, scan.link === 'open'); }
  // Inside a room, the backs of its walls would hide the room.
  materials.showsBacks = !path.position || !bounds.containsPoint(path.position);
  const size = bounds.isEmpty() ? 0.3 : bounds.getSize(new Vector3()).length();
  path.prepare(Math.min(Math.round(120 * size) / 1000, kLargestPyramidM));
  materials.uniforms.T_scan_shown.value.copy(viewer.T_scan_shown);
  materials.uniforms.R_eye_scan.value = viewer.R_eye_scan;
  if ($('ring').hidden || !scan.hello) { return; }
  // Without a mesh, as after a reset, no side counts as seen.
  ring.setFrame(bounds.getCenter(new Vector3()), new Vector3(...scan.hello.up));
  ring.count(bounds.isEmpty() ? [] : path.points);
  ringPicture.draw(ring, ring.azimuth(viewer.camera.position.clone().applyMatrix4(viewer.T_scan_shown)));
}

const tools = connectTools(picture);
if (picture) {
  picture.viewer.beforeDraw.push(prepareDrawing);
  picture.viewer.renderer.domElement.addEventListener('webglcontextrestored', () => {
    picture.store.clear();  // only the graphics card had the mesh
    connection.again();
  });
  $('measure-open').addEventListener('click', toggleMeasuring);
  $('crop-close').addEventListener('click', toggleCrop);
  $('crop-apply').addEventListener('click', () => sendCrop(picture.crop.draft));
  $('crop-clear').addEventListener('click', () => sendCrop(null));
}

async function sendCrop(box) {
  const corners = box && [box.min.toArray(), box.max.toArray()];
  if (await commands.send('crop', { box: corners }) && picture.crop.isOpen) { picture.crop.close(); }
}

openToTests(scan, picture, depth, connection);
