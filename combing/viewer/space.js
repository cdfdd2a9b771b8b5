// Strands of one run in space: a cylinder on every element, a ball on every node.

class Space {
  constructor(place, run) {
    this.run = run;
    this.positions = unpacked(run.position);
    this.nodes = run.strands.reduce((sum, n) => sum + n, 0);
    this.strandOf = run.strands.flatMap((n, strand) => Array(n).fill(strand));
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setClearColor("#ffffff");
    place.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#8d949c", 2.2));
    this.camera = new THREE.PerspectiveCamera(30, 1, 1e-4, 1e3);
    this.camera.up.set(0, 0, 1);
    const lamp = new THREE.DirectionalLight("#ffffff", 1.6);
    lamp.position.set(-0.6, 0.8, 1);
    this.camera.add(lamp);
    this.scene.add(this.camera);
    this.material = new THREE.MeshLambertMaterial();
    this.tubes = this.instances(new THREE.CylinderGeometry(1, 1, 1, 12, 1, true));
    this.balls = this.instances(new THREE.SphereGeometry(1, 12, 8));
    this.addTine();
    this.lookAtAll();
  }

  instances(shape) {
    const mesh = new THREE.InstancedMesh(shape, this.material, this.nodes);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    return mesh;
  }

  addTine() {
    const tine = this.run.tine;
    if (!tine) return;
    const shape = new THREE.CylinderGeometry(tine.radius, tine.radius, 1, 24);
    this.tine = new THREE.Mesh(shape, new THREE.MeshLambertMaterial({ color: "#9aa3ad" }));
    const axis = new THREE.Vector3(...tine.axis);
    this.tine.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis);
    this.scene.add(this.tine);
  }

  lookAtAll() {
    const all = new THREE.Box3();
    const end = 3 * this.nodes;
    const point = new THREE.Vector3();
    for (let k = 0; k < end; k += 3) all.expandByPoint(point.fromArray(this.positions, k));
    const size = all.getSize(new THREE.Vector3());
    const span = Math.max(size.x, size.y, size.z);
    this.middle = all.getCenter(new THREE.Vector3());
    if (this.tine) this.tine.scale.y = Math.min(this.run.tine.length, 0.25 * span);
    const axis = new THREE.Vector3(...(this.run.tine ? this.run.tine.axis : [0, 1, 0]));
    const side = new THREE.Vector3().crossVectors(axis, this.camera.up);
    const from = axis.multiplyScalar(-1).addScaledVector(side, 0.35).setLength(2.05 * span);
    this.camera.position.copy(this.middle).add(from);
    this.camera.near = 0.01 * span;
    this.camera.far = 20 * span;
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.target.copy(this.middle);
    this.controls.addEventListener("change", () => this.draw());
    this.controls.update();
  }

  // Show a snapshot; `paint(node)` gives the colour of a node of it.
  show(snapshot, paint) {
    const from = 3 * this.nodes * snapshot;
    const [start, end, along] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    const [up, turn, size] = [new THREE.Vector3(0, 1, 0), new THREE.Quaternion(), new THREE.Vector3()];
    const [place, colour] = [new THREE.Matrix4(), new THREE.Color()];
    for (let node = 0; node < this.nodes; node++) {
      const radius = this.run.radius[this.strandOf[node]];
      const last = this.strandOf[node] !== this.strandOf[node + 1];
      start.fromArray(this.positions, from + 3 * node);
      place.makeScale(radius, radius, radius).setPosition(start);
      this.balls.setMatrixAt(node, place);
      if (last) end.copy(start);
      else end.fromArray(this.positions, from + 3 * node + 3);
      along.subVectors(end, start);
      const length = along.length();
      if (length > 0) turn.setFromUnitVectors(up, along.divideScalar(length));
      size.set(radius, length || 1e-9, radius);
      this.tubes.setMatrixAt(node, place.compose(start.add(end).multiplyScalar(0.5), turn, size));
      colour.setRGB(...paint(node), "srgb");
      this.balls.setColorAt(node, colour);
      this.tubes.setColorAt(node, colour);
    }
    for (const mesh of [this.balls, this.tubes]) {
      mesh.instanceMatrix.needsUpdate = mesh.instanceColor.needsUpdate = true;
    }
    if (this.tine) {
      const { position, way } = this.run.tine;
      this.tine.position.set(...position);
      this.tine.position.addScaledVector(new THREE.Vector3(...way), this.run.displacement[snapshot]);
    }
    this.draw();
  }

  fit() {
    const { clientWidth, clientHeight } = this.renderer.domElement.parentElement;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / Math.max(clientHeight, 1);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }
}
