// window.scanknit: gives tests, and users of the browser's console, the page's state, and sets exact views.

export function openToTests(scan, picture, depth, connection) {
  const { viewer, store, materials, ring, keeper } = picture ?? {};
  window.scanknit = Object.freeze({
    get link() { return scan.link; },
    get hello() { return scan.hello; },
    get state() { return scan.state; },
    get received() { return { ...scan.received }; },
    /// Milliseconds from the navigation to the first chunk of the mesh; null before.
    get firstMeshMs() { return scan.firstMeshMs; },
    /// How often each chunk came since the connection was opened.
    get revisions() { return Object.fromEntries(scan.revisions); },
    get depthPictures() { return depth.count; },
    get chunks() { return store?.chunks.size ?? 0; },
    get triangles() { return store?.triangles ?? 0; },
    get vertices() { return store?.vertices ?? 0; },
    get bounds() { return store && !store.extent().isEmpty() ? [store.extent().min.toArray(), store.extent().max.toArray()] : null; },
    /// Of a mesh in tiles: TilesScene.numbers; else null.
    get tiles() { return picture?.tiles.numbers ?? null; },
    /// Geometries that the graphics card holds.
    get geometries() { return viewer?.renderer.info.memory.geometries ?? 0; },
    get picturesDrawn() { return viewer?.drawn ?? 0; },
    get sectorsSeen() { return ring?.seenCount ?? 0; },
    get trailPoints() { return picture?.path.points.length ?? 0; },
    get shading() { return materials?.shading; },
    set shading(name) {
      document.querySelector(`[data-shading="${name}"]`).click();
    },
    /// Reconnects, as after a broken connection.
    reconnect() { connection.again(); },
    /// Sets eye and target in the scan's world, metres, and keeps the view there.
    look(eye, target) {
      keeper.set({ isFitting: false, isFollowing: false });
      viewer.look(eye, target);
    },
    /// Draws, and reads [red, green, blue, alpha] at a point of the canvas, in CSS pixels from its upper left.
    pixel(x, y) {
      viewer.draw();
      const gl = viewer.renderer.getContext();
      const ratio = viewer.renderer.getPixelRatio();
      const bytes = new Uint8Array(4);
      gl.readPixels(Math.floor(x * ratio), gl.drawingBufferHeight - 1 - Math.floor(y * ratio), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      return [...bytes];
    },
    /// What was measured: values in metres, square metres, radians; sigma is one standard deviation.
    get measures() {
      return (picture?.measuring.measures ?? []).map(({ kind, from, values, picks, words }) => ({ kind, from, values, picks, words }));
    },
    /// Where the crop box's handle of that axis and end ('min', 'max') is on the canvas, CSS pixels.
    cropHandle(axis, end) {
      const { draft } = picture.crop;
      const number = 'XYZ'.indexOf(axis);
      const p = draft.min.clone().add(draft.max).multiplyScalar(0.5).setComponent(number, draft[end].getComponent(number));
      return this.place(p.toArray());
    },
    /// Where a point of the scan's world is on the canvas, CSS pixels.
    place(p) {
      const seen = viewer.toShown(viewer.camera.position.clone().set(...p)).project(viewer.camera);
      const canvas = viewer.renderer.domElement;
      return [((seen.x + 1) / 2) * canvas.clientWidth, ((1 - seen.y) / 2) * canvas.clientHeight];
    },
  });
}
