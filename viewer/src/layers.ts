// Layers drawn over the bodies: contacts, border edges with their crossings, cells, the pull.
import * as three from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import type { BodySet } from "./bodies";
import type { Arrays, Frame } from "./protocol";

const onTop = { depthTest: false, transparent: true } as const;

/** Of the arrows of contacts: neither a colour of amounts nor of tissue. */
const arrowColour = "#e600c8";

/** Of a marker that something covers. */
const coveredOpacity = 0.25;

/** Lines or points whose number changes from frame to frame. */
class Growing<T extends three.Line | three.LineSegments | three.Points> {
  constructor(readonly object: T) {
    object.frustumCulled = false;
    object.visible = false;
  }
  set(values: Float32Array): void {
    const geometry = this.object.geometry as three.BufferGeometry;
    const old = geometry.getAttribute("position") as three.BufferAttribute | undefined;
    if (!old || old.array.length < values.length) {
      geometry.dispose();  // the buffer on the graphics card has the old length
      const points = Math.ceil(values.length / 2);  // half of it as reserve, in whole points
      const room = new Float32Array(3 * Math.max(2, points));
      geometry.setAttribute("position", new three.BufferAttribute(room, 3).setUsage(three.DynamicDrawUsage));
    }
    const attribute = geometry.getAttribute("position") as three.BufferAttribute;
    (attribute.array as Float32Array).set(values);
    attribute.needsUpdate = true;
    geometry.setDrawRange(0, values.length / 3);
  }
}

/** A ring with a dark rim, drawn once. */
function ring(): three.Texture {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 32;
  const context = canvas.getContext("2d")!;
  for (const [width, colour] of [[8, "#000000"], [5, "#ffffff"]] as const) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.beginPath();
    context.arc(16, 16, 10, 0, 2 * Math.PI);
    context.stroke();
  }
  return new three.CanvasTexture(canvas);
}

/** A unit arrow along +y: shaft and head. */
function arrowGeometry(): three.BufferGeometry {
  const shaft = new three.CylinderGeometry(0.03, 0.03, 0.7, 5, 1, true).translate(0, 0.35, 0);
  const head = new three.ConeGeometry(0.1, 0.3, 6).translate(0, 0.85, 0);
  const all = new three.BufferGeometry();
  const positions = [...shaft.getAttribute("position").array, ...head.getAttribute("position").array];
  const count = shaft.getAttribute("position").count;
  all.setAttribute("position", new three.Float32BufferAttribute(positions, 3));
  all.setIndex([...shaft.getIndex()!.array, ...[...head.getIndex()!.array].map((i) => i + count)]);
  return all;
}

/** The twelve edges of the unit cube, once for each cell. */
function cellLines(): { object: three.LineSegments; offsets(values: Float32Array, size: number): void } {
  const geometry = new three.InstancedBufferGeometry();
  const box = new three.EdgesGeometry(new three.BoxGeometry(1, 1, 1).translate(0.5, 0.5, 0.5));
  geometry.setAttribute("position", box.getAttribute("position"));
  geometry.instanceCount = 0;
  const material = new three.ShaderMaterial({
    uniforms: { size: { value: 1 }, colour: { value: new three.Color("#7f7f7f") } },
    vertexShader:
      "attribute vec3 lower; uniform float size; void main() { gl_Position = projectionMatrix * viewMatrix * vec4(lower + size * position, 1.0); }",
    fragmentShader: "uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 0.35); }",
    transparent: true,
    depthWrite: false,
  });
  const object = new three.LineSegments(geometry, material);
  object.frustumCulled = false;
  object.visible = false;
  const offsets = (values: Float32Array, size: number) => {
    const old = geometry.getAttribute("lower") as three.InstancedBufferAttribute | undefined;
    if (!old || old.array.length < values.length) {
      geometry.dispose();
      geometry.setAttribute("lower", new three.InstancedBufferAttribute(new Float32Array(values.length + 3072), 3));
    }
    const attribute = geometry.getAttribute("lower") as three.InstancedBufferAttribute;
    (attribute.array as Float32Array).set(values);
    attribute.needsUpdate = true;
    geometry.instanceCount = values.length / 3;
    material.uniforms["size"]!.value = size;
  };
  return { object, offsets };
}

/** A ring of constant size at a point; drawn as if it lay a little nearer, so that the surface around the point does not cover it. */
function markerMaterial(nearer: number): three.PointsMaterial {
  const material = new three.PointsMaterial({ color: "#d55e00", size: 11, sizeAttenuation: false, map: ring(), transparent: true, depthWrite: false });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace("#include <project_vertex>", `#include <project_vertex>
      vec4 towardsEye = projectionMatrix * (mvPosition + vec4(0.0, 0.0, ${nearer.toExponential(6)}, 0.0));
      gl_Position.z = towardsEye.z / towardsEye.w * gl_Position.w;`);
  };
  return material;
}

export class Layers {
  readonly group = new three.Group();
  private arrows?: three.InstancedMesh;
  private readonly edges = new Growing(
    new three.LineSegments(new three.BufferGeometry(), new three.LineBasicMaterial({ color: "#0072b2", ...onTop })),
  );
  private readonly crossings = new Growing(
    new three.Points(
      new three.BufferGeometry(),
      new three.PointsMaterial({ color: "#d55e00", size: 5, sizeAttenuation: false, ...onTop }),
    ),
  );
  private readonly cells = cellLines();
  private readonly pull = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ color: "#d55e00", linewidth: 3, ...onTop }));
  private readonly ends = new Growing(
    new three.Points(
      new three.BufferGeometry(),
      new three.PointsMaterial({ color: "#d55e00", size: 8, sizeAttenuation: false, ...onTop }),
    ),
  );
  private readonly marker: Growing<three.Points>;
  /** The marker again, faint, also where something covers it. */
  private readonly covered: three.Points;
  private readonly arrowShape = arrowGeometry();
  private readonly arrowMaterial = new three.MeshBasicMaterial({ color: arrowColour, transparent: true });  // drawn after translucent bodies
  showArrows = false;

  constructor(
    private readonly diagonal: number,
    private readonly bodies: BodySet,
  ) {
    this.marker = new Growing(new three.Points(new three.BufferGeometry(), markerMaterial(0.015 * diagonal)));
    this.covered = new three.Points(this.marker.object.geometry, new three.PointsMaterial({ color: "#d55e00", size: 11, sizeAttenuation: false, map: ring(), opacity: coveredOpacity, ...onTop }));
    this.covered.frustumCulled = this.covered.visible = this.pull.frustumCulled = this.pull.visible = false;
    this.group.add(this.edges.object, this.crossings.object, this.cells.object, this.pull, this.ends.object, this.covered, this.marker.object);
    this.group.renderOrder = 1;  // after the bodies and their cut faces
  }

  set showBorders(on: boolean) {
    this.edges.object.visible = this.crossings.object.visible = on;
  }
  set showCells(on: boolean) {
    this.cells.object.visible = on;
  }

  update(frame: Frame, arrays: Arrays): void {
    const floats = (name: string) => arrays[name] as Float32Array | undefined;
    const both = (values: string, edges: string) => [...(arrays[values] ?? []), ...(arrays[edges] ?? [])];
    if (this.showArrows) this.updateArrows(both("contacts", "edge_contacts"), both("contact_places", "edge_contact_places"));
    else if (this.arrows) this.arrows.count = 0;
    const edges = floats("border_edges");
    if (edges) this.edges.set(edges);
    const crossings = floats("crossings");
    if (crossings) this.crossings.set(crossings);
    const cells = floats("cells");
    if (cells) this.cells.offsets(cells, frame.counts.cell_size);
  }

  /** The contacts of points and edges where both bodies are seen. */
  private seen(contacts: readonly number[], places: readonly number[]): number[] {
    const place = new three.Vector3();
    const list: number[] = [];
    for (let c = 0; c < contacts.length / 7; ++c) {
      place.fromArray(contacts, 7 * c);
      if (this.bodies.shows(places[3 * c + 1]!, place) && this.bodies.shows(places[3 * c + 2]!, place)) list.push(c);
    }
    return list;
  }

  /** For each contact an arrow along its direction; its length shows the depth. What lies in front covers it. */
  private updateArrows(contacts: readonly number[], places: readonly number[]): void {
    const list = this.seen(contacts, places);
    const count = list.length;
    if (!this.arrows || this.arrows.instanceMatrix.count < count) {
      if (this.arrows) {
        this.group.remove(this.arrows);
        this.arrows.dispose();
      }
      this.arrows = new three.InstancedMesh(this.arrowShape, this.arrowMaterial, Math.max(64, Math.ceil(1.5 * count)));
      this.arrows.frustumCulled = false;
      this.group.add(this.arrows);
    }
    const arrows = this.arrows;
    let deepest = 0;
    for (const c of list) deepest = Math.max(deepest, contacts[7 * c + 6]!);
    const up = new three.Vector3(0, 1, 0);
    const direction = new three.Vector3();
    const position = new three.Vector3();
    const turn = new three.Quaternion();
    const matrix = new three.Matrix4();
    list.forEach((c, i) => {
      const fraction = deepest > 0 ? contacts[7 * c + 6]! / deepest : 0;
      turn.setFromUnitVectors(up, direction.fromArray(contacts, 7 * c + 3));
      const size = this.diagonal * (0.01 + 0.03 * fraction);
      matrix.compose(position.fromArray(contacts, 7 * c), turn, new three.Vector3(size, size, size));
      arrows.setMatrixAt(i, matrix);
    });
    arrows.count = count;
    arrows.instanceMatrix.needsUpdate = true;
  }

  /** The picked point; null: none. */
  setMarker(place: three.Vector3 | null): void {
    this.marker.object.visible = this.covered.visible = place !== null;
    if (place) this.marker.set(Float32Array.from(place.toArray()));
  }

  /** Lines from each point that is pulled to its target; ends[i] are (point, target). */
  setPulls(ends: Float32Array): void {
    this.pull.visible = this.ends.object.visible = ends.length > 0;
    if (ends.length === 0) return;
    const { geometry } = this.pull;
    const old = geometry.getAttribute("instanceStart") as three.InterleavedBufferAttribute | undefined;
    if (old?.data.array.length === ends.length) {
      old.data.array.set(ends);
      old.data.needsUpdate = true;
    } else {
      geometry.dispose();  // the buffer on the graphics card has the old length
      geometry.setPositions(ends);
    }
    this.ends.set(ends);
  }
}
