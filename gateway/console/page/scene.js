// The laboratory in three dimensions: what the gateway believes, solid; what would happen without it, as a ghost.
// World frame, z up, metres. Bodies of the ships have z down, as on board.
import * as THREE from './vendor/three.module.js';
import {armPoints} from './arm.js';
import {wantedPlace} from './score.js';

const freshS = 0.5;
const trailS = 4;
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const vector = p => new THREE.Vector3(...p);
const setPose = (object, p, q) => {
  object.position.set(...p);
  object.quaternion.set(q[1], q[2], q[3], q[0]);
};

// Whether pixels are computed by the processor: then there have to be few and plain ones. "?quality=full" or "plain" says it.
function isPlain() {
  const wanted = new URLSearchParams(location.search).get('quality');
  if (wanted) return wanted !== 'full';
  const gl = document.createElement('canvas').getContext('webgl');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
const plain = isPlain();

const paint = (colour, roughness = 0.6, metalness = 0.1) => plain
    ? new THREE.MeshLambertMaterial({color: colour})
    : new THREE.MeshStandardMaterial({color: colour, roughness, metalness});
const materials = {
  deck: paint('#9fb0bf', 0.7), frame: paint('#5d7183', 0.6, 0.4), leg: paint('#c9d3dc', 0.3, 0.7), foot: paint('#46525e', 0.8),
  robot: paint('#d8412f', 0.45), dark: paint('#2f3740', 0.5, 0.3), steel: paint('#aeb8c2', 0.3, 0.8),
  load: paint('#ffb020', 0.35, 0.2), device: paint('#2a9d8f', 0.5), camera: paint('#303a46', 0.5),
};

function solid(geometry, material) {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  return mesh;
}

// A rod between two points that move.
class Rod {
  constructor(parent, radius, material, radiusEnd = radius) {
    this.mesh = solid(new THREE.CylinderGeometry(radiusEnd, radius, 1, 20), material);
    this.mesh.geometry.translate(0, 0.5, 0);
    parent.add(this.mesh);
  }
  between(a, b) {
    const along = vector(b).sub(this.mesh.position.set(...a));
    const length = Math.max(along.length(), 1e-6);
    this.mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length));
    this.mesh.scale.set(1, length, 1);
  }
}

// A moving platform on six legs. Its group has the body's frame: z down.
class Platform {
  constructor(scene, {width, length, deck, joint, radius, foot, neutral}) {
    this.group = new THREE.Group();
    const plate = solid(new THREE.BoxGeometry(length, width, 0.12), materials.deck);
    plate.position.z = deck + 0.06;
    const under = solid(new THREE.CylinderGeometry(0.55 * width, 0.36 * width, Math.max(joint - deck - 0.12, 0.1), 6), materials.frame);
    under.rotation.x = -Math.PI / 2;
    under.position.z = deck + 0.12 + Math.max(joint - deck - 0.12, 0.1) / 2;
    this.group.add(plate, under);
    const edge = new THREE.LineSegments(new THREE.EdgesGeometry(plate.geometry), new THREE.LineBasicMaterial({color: '#e8c547'}));
    edge.position.copy(plate.position);
    this.group.add(edge);
    scene.add(this.group);
    this.legs = [];
    for (let i = 0; i < 6; ++i) {
      const pair = Math.floor(i / 2) * 2 * Math.PI / 3, side = i % 2 ? 1 : -1;
      const top = [radius * Math.cos(pair + side * 0.88), radius * Math.sin(pair + side * 0.88), joint];
      const floor = [neutral[0] + foot * Math.cos(pair + side * 0.2), neutral[1] + foot * Math.sin(pair + side * 0.2), 0.08];
      const shoe = solid(new THREE.CylinderGeometry(0.16, 0.2, 0.12, 20), materials.foot);
      shoe.rotation.x = Math.PI / 2;
      shoe.position.set(floor[0], floor[1], 0.06);
      scene.add(shoe);
      this.legs.push({top, floor, body: new Rod(scene, 0.075, materials.frame), piston: new Rod(scene, 0.042, materials.leg)});
    }
  }
  // Feet are told apart in the world, tops in the body: each leg goes to the foot that is nearest at neutral.
  settleLegs() {
    this.group.updateMatrixWorld();
    const free = this.legs.map(leg => leg.floor);
    for (const leg of this.legs) {
      const top = this.group.localToWorld(vector(leg.top));
      free.sort((a, b) => top.distanceTo(vector(a)) - top.distanceTo(vector(b)));
      leg.floor = free.shift();
    }
  }
  place(p, q) {
    setPose(this.group, p, q);
    this.group.updateMatrixWorld();
    for (const {top, floor, body, piston} of this.legs) {
      const end = this.group.localToWorld(vector(top));
      const middle = vector(floor).lerp(end, 0.55);
      body.between(floor, middle.toArray());
      piston.between(floor, end.toArray());
    }
  }
}

class Arm {
  constructor(parent, geometry) {
    this.geometry = geometry;
    this.group = new THREE.Group();
    parent.add(this.group);
    const pedestal = solid(new THREE.CylinderGeometry(0.36, 0.42, 0.3, 32), materials.dark);
    pedestal.rotation.x = Math.PI / 2;
    pedestal.position.z = 0.15;
    this.turret = new THREE.Group();
    const turret = solid(new THREE.CylinderGeometry(0.27, 0.33, geometry.d1_m - 0.3, 32), materials.robot);
    turret.rotation.x = Math.PI / 2;
    turret.position.z = 0.3 + (geometry.d1_m - 0.3) / 2;
    const bracket = solid(new THREE.BoxGeometry(geometry.a1_m + 0.3, 0.42, 0.3), materials.robot);
    bracket.position.set(geometry.a1_m / 2, 0, geometry.d1_m - 0.06);
    this.turret.add(turret, bracket);
    this.joints = ['shoulder', 'elbow'].map(name => {
      const joint = solid(new THREE.CylinderGeometry(0.2, 0.2, 0.52, 32), materials.dark);
      this.group.add(joint);
      return {name, joint};
    });
    this.upper = new Rod(this.group, 0.15, materials.robot, 0.12);
    this.knuckle = new Rod(this.group, 0.15, materials.robot);
    this.forearm = new Rod(this.group, 0.13, materials.robot, 0.085);
    this.tool = new Rod(this.group, 0.06, materials.steel, 0.035);
    this.sheave = solid(new THREE.TorusGeometry(0.07, 0.022, 12, 28), materials.dark);
    this.group.add(pedestal, this.turret, this.sheave);
  }
  pose(q) {
    const at = armPoints(this.geometry, q);
    this.turret.rotation.z = -q[0];
    for (const {name, joint} of this.joints) {
      joint.position.set(...at[name]);
      joint.rotation.set(0, 0, -q[0]);
    }
    this.upper.between(at.shoulder, at.elbow);
    this.knuckle.between(at.elbow, at.forearm);
    this.forearm.between(at.forearm, at.wrist);
    this.tool.between(at.wrist, at.tool);
    this.sheave.position.set(...at.tool);
    this.sheave.rotation.set(Math.PI / 2, -q[0], 0, 'YXZ');
    return at.tool;
  }
}

// Where something was in the last seconds, as a line that fades.
class Trail {
  constructor(scene, colour) {
    this.points = [];
    this.most = 240;
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * this.most), 3));
    this.geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(4 * this.most), 4));
    this.line = new THREE.Line(this.geometry, new THREE.LineBasicMaterial({vertexColors: true, transparent: true, depthWrite: false}));
    this.line.frustumCulled = false;
    this.colour = new THREE.Color(colour);
    scene.add(this.line);
  }
  add(t, p) {
    if (p && !(t - this.points[this.points.length - 1]?.t < trailS / this.most)) this.points.push({t, p: [...p]});
    while (this.points.length && (this.points[0].t < t - trailS || this.points.length > this.most)) this.points.shift();
    const {position, color} = this.geometry.attributes;
    this.points.forEach((point, i) => {
      position.setXYZ(i, ...point.p);
      color.setXYZW(i, this.colour.r, this.colour.g, this.colour.b, Math.max(0, 1 - (t - point.t) / trailS));
    });
    position.needsUpdate = color.needsUpdate = true;
    this.geometry.setDrawRange(0, this.points.length);
  }
}

function label(text, colour) {
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d');
  const font = '600 44px system-ui, sans-serif';
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 24;
  canvas.height = 60;
  context.font = font;
  context.lineWidth = 8;
  context.lineJoin = 'round';
  context.strokeStyle = css('--page');
  context.strokeText(text, 12, 44);
  context.fillStyle = colour;
  context.fillText(text, 12, 44);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map: texture, depthTest: false, transparent: true}));
  sprite.scale.set(canvas.width * 0.0042, canvas.height * 0.0042, 1);
  sprite.renderOrder = 10;
  return sprite;
}

// Turns, shifts and nears the view: mouse, touch, or the arrow keys.
class Orbit {
  constructor(element, camera) {
    Object.assign(this, {element, camera, pointers: new Map()});
    element.addEventListener('pointerdown', event => {
      element.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
    });
    element.addEventListener('pointermove', event => this.drag(event));
    for (const type of ['pointerup', 'pointercancel']) element.addEventListener(type, event => this.pointers.delete(event.pointerId));
    element.addEventListener('wheel', event => {
      event.preventDefault();
      this.near(Math.exp(0.001 * event.deltaY));
    }, {passive: false});
    element.addEventListener('keydown', event => {
      const turn = {ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.06], ArrowDown: [0, -0.06]}[event.key];
      const near = {'+': 0.9, '-': 1.1}[event.key];
      if (turn) this.turn(...turn);
      if (near) this.near(near);
      if (turn || near) event.preventDefault();
    });
  }
  look(target, azimuth, elevation, distance) {
    Object.assign(this, {target: vector(target), azimuth, elevation, distance});
    this.apply();
  }
  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.min(Math.max(this.elevation + elevation, -0.1), 1.5);
    this.apply();
  }
  near(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, 1.2), 30);
    this.apply();
  }
  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
    if (this.pointers.size === 2) {
      const other = [...this.pointers.values()].find(pointer => pointer.pointerId !== event.pointerId);
      const gap = e => Math.hypot(e.clientX - other.clientX, e.clientY - other.clientY);
      this.near(gap(before) / Math.max(gap(event), 1));
    } else if (event.buttons & 2 || event.shiftKey) {
      const side = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0), up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 1);
      this.target.addScaledVector(side, -dx * this.distance * 0.0012).addScaledVector(up, dy * this.distance * 0.0012);
      this.apply();
    } else {
      this.turn(-dx * 0.006, dy * 0.005);
    }
    this.pointers.set(event.pointerId, event);
  }
  apply() {
    const flat = this.distance * Math.cos(this.elevation);
    this.camera.position.set(this.target.x + flat * Math.cos(this.azimuth), this.target.y + flat * Math.sin(this.azimuth),
                             this.target.z + this.distance * Math.sin(this.elevation));
    this.camera.lookAt(this.target);
  }
}

const views = {
  1: [[-0.3, -0.2, 3.35], -0.86, 0.16, 9.8],   // everything
  2: [[0.5, -0.2, 4.3], -0.9, 0.1, 4.6],     // the load
  3: [[0.2, 0, 3.6], -Math.PI / 2, 0.06, 8], // from the side
  4: [[-0.6, 0, 3.5], 0.0, 1.49, 11],        // from above
};

export class Scene {
  constructor(canvas, config) {
    this.canvas = canvas;
    this.config = config;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !plain, preserveDrawingBuffer: true});
    this.renderer.shadowMap.enabled = !plain;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.1, 80);
    this.camera.up.set(0, 0, 1);
    this.orbit = new Orbit(canvas, this.camera);
    this.view(1);
    canvas.addEventListener('contextmenu', event => event.preventDefault());

    this.sky = new THREE.HemisphereLight('#dfefff', '#46525e', 1.6);
    const sun = new THREE.DirectionalLight('#fff4e0', 2.4);
    sun.position.set(4, -5, 11);
    sun.target.position.set(-1, 0, 2);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, {left: -6, right: 6, top: 6, bottom: -6, near: 1, far: 22});
    sun.shadow.bias = -0.0006;
    sun.shadow.normalBias = 0.02;
    this.scene.add(this.sky, sun, sun.target);

    this.floor = new THREE.Mesh(new THREE.CircleGeometry(30, 64), plain ? new THREE.MeshBasicMaterial() : new THREE.MeshStandardMaterial({roughness: 0.95}));
    this.floor.receiveShadow = true;
    this.scene.add(this.floor);

    const {poses, arm, reference} = config;
    this.first = new Platform(this.scene, {width: 4.1, length: 3.5, deck: poses.em8000_to_comau.p_m[2], joint: -0.25, radius: 1.5,
                                           foot: 2.3, neutral: poses.world_to_em8000.p_m});
    this.second = new Platform(this.scene, {width: 2.0, length: 2.1, deck: -0.169, joint: 0.12, radius: 0.85, foot: 1.15,
                                            neutral: poses.world_to_em1500.p_m});
    for (const [platform, pose] of [[this.first, poses.world_to_em8000], [this.second, poses.world_to_em1500]]) {
      platform.place(pose.p_m, pose.q);
      platform.settleLegs();
      platform.place(pose.p_m, pose.q);
    }
    const base = new THREE.Group();
    setPose(base, poses.em8000_to_comau.p_m, poses.em8000_to_comau.q);
    this.first.group.add(base);
    this.base = base;
    this.arm = new Arm(base, arm);
    this.arm.pose([0, 0, -Math.PI / 2]);
    const mru = solid(new THREE.BoxGeometry(0.16, 0.16, 0.2), materials.device);
    mru.position.set(...poses.em8000_to_mru1.p_m);
    mru.position.z = poses.em8000_to_comau.p_m[2] - 0.1;
    this.first.group.add(mru);

    this.wire = new Rod(this.scene, 0.012, materials.dark);
    this.load = new THREE.Group();
    const ball = solid(new THREE.SphereGeometry(0.15, 40, 24), materials.load);
    const hook = solid(new THREE.CylinderGeometry(0.03, 0.045, 0.12, 20), materials.dark);
    hook.rotation.x = Math.PI / 2;
    hook.position.z = 0.19;
    this.load.add(ball, hook);
    this.scene.add(this.load);

    this.ghost = new THREE.Group();
    this.ghostMaterial = new THREE.MeshLambertMaterial({transparent: true, opacity: 0.45, depthWrite: false});
    const spectre = new THREE.Mesh(new THREE.SphereGeometry(0.15, 32, 20), this.ghostMaterial);
    this.ghost.add(spectre);
    this.ghostWire = new THREE.Line(new THREE.BufferGeometry().setFromPoints([vector([0, 0, 0]), vector([0, 0, 1])]),
                                    new THREE.LineDashedMaterial({dashSize: 0.07, gapSize: 0.05, transparent: true, opacity: 0.8}));
    this.ghostWire.frustumCulled = false;
    this.scene.add(this.ghost, this.ghostWire);
    this.ghostSpot = spectre;

    this.target = new THREE.Group();
    const ring = new THREE.Mesh(new THREE.TorusGeometry(0.27, 0.008, 8, 64), new THREE.MeshBasicMaterial());
    const cross = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(
        [[-0.36, 0, 0], [-0.2, 0, 0], [0.2, 0, 0], [0.36, 0, 0], [0, -0.36, 0], [0, -0.2, 0], [0, 0.2, 0], [0, 0.36, 0]].map(vector)),
        new THREE.LineBasicMaterial());
    this.target.add(ring, cross);
    this.targetMaterials = [ring.material, cross.material];
    this.target.position.set(...reference.p_world_load_m);
    this.scene.add(this.target);

    this.cameras = new THREE.Group();
    this.cameras.add(new THREE.AxesHelper(0.5));
    setPose(this.cameras, poses.world_to_qtm.p_m, poses.world_to_qtm.q);
    this.world = new THREE.AxesHelper(0.7);
    this.world.position.z = 0.01;
    this.scene.add(this.cameras, this.world);
    this.labels = [];
    this.recolour();
    this.trail = new Trail(this.scene, '#ffb020');
    this.ghostTrail = new Trail(this.scene, '#8b7cf6');
    this.source = null;
    this.slow = plain ? 2 : 0;
    this.ratio = plain ? 0.75 : undefined;
    this.frames = [];
  }

  view(number) { this.orbit.look(...views[number]); }

  recolour() {
    const back = new THREE.Color(css('--sky'));
    this.scene.background = back;
    this.scene.fog = new THREE.Fog(back, 12, 26);
    this.floor.material.color.set(css('--floor'));
    if (this.grid) this.scene.remove(this.grid);
    this.grid = new THREE.GridHelper(24, 24, css('--grid'), css('--grid'));
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = 0.004;
    this.grid.material.transparent = true;
    this.grid.material.opacity = 0.45;
    this.scene.add(this.grid);
    this.ghostMaterial.color.set(css('--twin'));
    this.ghostWire.material.color.set(css('--twin'));
    for (const material of this.targetMaterials) material.color.set(css('--aim'));
    for (const [parent, sprite] of this.labels) parent.remove(sprite);
    this.labels = [];
    const name = (parent, text, at, colour = css('--soft')) => {
      const sprite = label(text, colour);
      sprite.position.set(...at);
      parent.add(sprite);
      this.labels.push([parent, sprite]);
    };
    name(this.first.group, 'EM8000', [-1.2, -1.75, this.config.poses.em8000_to_comau.p_m[2] - 0.3]);
    name(this.second.group, 'EM1500', [-0.75, -0.7, -0.4]);
    name(this.cameras, 'cameras', [0, 0, -0.3]);
    name(this.world, 'world', [0.1, 0.1, 0.25]);
    name(this.ghost, 'without control', [0, 0, -0.34], css('--twin'));
  }

  // What there is to draw, and from what: the estimate, else the simulated truth.
  seen(lab) {
    const estimate = lab.fresh('motionlab/estimate', freshS), truth = lab.fresh('truth/world', freshS);
    const arm = lab.fresh('motionlab/arm_state', freshS);
    const from = estimate?.valid ? estimate : truth;
    return {from, truth, estimate, q: arm?.q_rad ?? truth?.q_rad, source: !from ? null : from === truth ? 'truth' : 'estimate'};
  }

  tick(lab) {
    const {from, truth, estimate, q, source} = this.seen(lab);
    this.source = source;
    const now = lab.now();
    if (from) {
      this.first.place(from.p_world_platform_m, from.q_world_platform);
      if (estimate?.second_valid) this.second.place(estimate.p_world_second_m, estimate.q_world_second);
      if (q) this.arm.pose(q);
      this.wire.between(from.p_world_tool_m, from.p_world_load_m);
      this.load.position.set(...from.p_world_load_m);
      this.load.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1),
                                              vector(from.p_world_tool_m).sub(vector(from.p_world_load_m)).normalize());
    } else if (!this.load.position.lengthSq()) {  // nothing was heard yet: as configured
      const tool = this.base.localToWorld(vector(this.arm.pose([0, 0, -Math.PI / 2])));
      this.load.position.set(...this.config.reference.p_world_load_m);
      this.wire.between(tool.toArray(), this.config.reference.p_world_load_m);
    }
    this.trail.add(now, from?.p_world_load_m);
    this.ghost.visible = this.ghostWire.visible = Boolean(truth);
    if (truth) {
      this.ghost.position.set(...truth.p_world_twin_load_m);
      const {position} = this.ghostWire.geometry.attributes;
      position.setXYZ(0, ...truth.p_world_twin_tool_m);
      position.setXYZ(1, ...truth.p_world_twin_load_m);
      position.needsUpdate = true;
      this.ghostWire.computeLineDistances();
    }
    this.ghostTrail.add(now, truth?.p_world_twin_load_m);
    this.target.position.set(...wantedPlace(lab, this.config));
    this.resize();
    this.renderer.render(this.scene, this.camera);
    this.pace();
  }

  get fps() { return this.frames.length > 1 ? 1000 * (this.frames.length - 1) / (this.frames[this.frames.length - 1] - this.frames[0]) : 0; }

  // A slow machine gets a plainer picture rather than a jerky one.
  pace() {
    const here = performance.now();
    this.frames.push(here);
    while (this.frames[0] < here - 2000) this.frames.shift();
    if (this.frames[0] > here - 1500 || this.fps >= 25 || this.slow >= 2) return;
    ++this.slow;
    this.frames = [];
    if (this.slow === 1) this.ratio = 1;
    else this.renderer.shadowMap.autoUpdate = false;
  }

  resize() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const ratio = this.ratio ?? Math.min(window.devicePixelRatio, 2);
    if (this.size === `${width}x${height}x${ratio}` || !width || !height) return;
    this.size = `${width}x${height}x${ratio}`;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }
}
