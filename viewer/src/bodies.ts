// The bodies as three.js meshes: one mesh per body, whose positions are changed in place.
import * as three from "three";
import { amountColour, neutral, niceAbove, noValue, type Colour } from "./colours";
import { CutFace } from "./cut_face";
import { CutSurface } from "./cut_surface";
import { Occlusion } from "./occlusion";
import type { Arrays, Binary, BodyInfo, Plan, Stage } from "./protocol";
import { edgesOf, isRound, sumNormals } from "./surface_normals";
import { Tets } from "./tets";

/** "body", "depth", "displacement", or the name of a field. */
export type Colouring = string;

/** Ends of the colour scale. Automatic ends grow with the values shown. */
export interface Scale {
  automatic: boolean;
  least: number;
  most: number;
}

/** The inside of tissue is darker than its skin. */
const cutShade = 0.72;

class BodyMesh {
  readonly front: three.Mesh<three.BufferGeometry, three.MeshLambertMaterial>;
  readonly edges: three.LineSegments<three.BufferGeometry, three.LineBasicMaterial>;
  readonly face: CutFace;
  readonly surface: CutSurface;
  readonly begin: number;
  readonly colour: Colour;
  readonly corners: Uint32Array;
  private readonly smooth: boolean;
  private edgesWanted = false;

  constructor(readonly info: BodyInfo, index: number, rest: Float32Array, triangles: Int32Array) {
    const [begin, end] = info.vertices;
    this.begin = begin;
    this.colour = info.color;
    this.corners = Uint32Array.from(triangles.subarray(3 * info.triangles[0], 3 * info.triangles[1]), (v) => v - begin);
    const start = rest.slice(3 * begin, 3 * end);
    this.smooth = isRound(this.corners, start);
    this.surface = new CutSurface(this.corners, start);
    const { geometry } = this.surface;
    this.front = new three.Mesh(
      geometry,
      new three.MeshLambertMaterial({ vertexColors: true, flatShading: !this.smooth, side: three.FrontSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }),
    );
    this.edges = new three.LineSegments(new three.BufferGeometry(), new three.LineBasicMaterial({ color: "#20262c", transparent: true, opacity: 0.35 }));
    this.face = new CutFace(geometry, index);
    this.front.frustumCulled = this.edges.frustumCulled = this.edges.visible = false;
    this.front.userData["body"] = index;
    this.front.castShadow = this.front.receiveShadow = true;
    this.update(start);
  }

  /** Normals of vertices, weighted by area: made for drawing if the body is smooth, otherwise computed on demand. */
  normals(): Float32Array {
    const normals = this.surface.values("normal");
    if (!this.smooth) sumNormals(this.corners, this.surface.values("position"), normals);
    return normals;
  }

  update(values: Float32Array): void {
    this.surface.values("position").set(values);
    if (this.smooth) sumNormals(this.corners, values, this.surface.values("normal"));
    this.drawnAnew();
  }

  private drawnAnew(): void {
    this.surface.update();
    this.edges.geometry.setAttribute("position", this.surface.geometry.getAttribute("position"));
  }

  showEdges(on: boolean): void {
    this.edgesWanted = on;
    if (on && !this.edges.geometry.index) this.edges.geometry.setIndex(new three.BufferAttribute(edgesOf(this.corners), 1));
    this.edges.visible = on && this.front.visible;
  }

  setOpacity(opacity: number, cut: boolean): void {
    this.front.visible = opacity > 0;
    this.face.visible = opacity > 0 && cut;
    this.face.opacity = opacity;
    this.showEdges(this.edgesWanted);
    const material = this.front.material;
    this.front.castShadow = opacity >= 1;
    material.transparent = opacity < 1;
    material.opacity = opacity;
    material.depthWrite = opacity >= 1;
    material.needsUpdate = true;
  }

  cut(plane: three.Plane | null, within: three.Sphere): void {
    this.edges.material.clippingPlanes = plane ? [plane] : [];
    this.surface.plane = plane;
    this.drawnAnew();
    if (plane) this.face.cut(plane, within.center, 2.1 * within.radius);
  }

  /** The colour of the face of a cut: that of the body's surface. */
  setFace(colour: Colour, shade = cutShade): void {
    this.face.colour = new three.Color().setRGB(...colour, three.SRGBColorSpace).multiplyScalar(shade);
  }

  dispose(): void {
    this.front.geometry.dispose();
    this.edges.geometry.dispose();
    this.front.material.dispose();
    this.edges.material.dispose();
    this.face.dispose();
  }
}

export class BodySet {
  readonly group = new three.Group();
  readonly meshes: BodyMesh[];
  readonly rest: Float32Array;
  readonly positions: Float32Array;
  readonly depths: Float32Array;
  colouring: Colouring = "body";
  /** In the unit of the scene. */
  readonly scale: Scale = { automatic: true, least: 0, most: 0 };
  private field: Float32Array | null = null;
  private readonly tets: Tets;
  /** Whether the last frame had inner points. */
  private hasInside = false;
  /** Names of the bodies that are coloured by amounts; none: deformable bodies. */
  private coloured: readonly string[] = [];
  private readonly light: Float32Array;
  private readonly occlusion = new Occlusion();
  /** The plane of the cut: bodies that are cut lose their part on its negative side; null: no cut. */
  plane: three.Plane | null = null;
  isCut: (body: number) => boolean = () => false;
  private readonly opacities: number[];
  private absent: boolean[];

  constructor(stage: Binary<Stage>) {
    this.rest = stage.arrays["rest"] as Float32Array;
    this.positions = this.rest.slice();
    this.depths = new Float32Array(this.rest.length / 3);
    this.light = new Float32Array(this.rest.length / 3).fill(1);
    const triangles = stage.arrays["triangles"] as Int32Array;
    this.tets = new Tets(stage);
    this.meshes = stage.header.bodies.map((info, i) => new BodyMesh(info, i, this.rest, triangles));
    this.opacities = this.meshes.map(() => 1);
    this.absent = this.meshes.map((mesh) => mesh.info.absent ?? false);
    for (const mesh of this.meshes) this.group.add(mesh.front, mesh.edges, ...mesh.face.objects);
    this.cut(null);
    this.colour();
  }

  update(arrays: Arrays): void {
    this.positions.set(arrays["positions"] as Float32Array);
    for (const mesh of this.meshes) {
      const [begin, end] = mesh.info.vertices;
      mesh.update(this.positions.subarray(3 * begin, 3 * end));
    }
    this.takeDepths(arrays);
    this.hasInside = this.tets.update(arrays);
    this.field = (arrays[this.colouring] as Float32Array | undefined) ?? null;
    if (this.colouring !== "body") this.colour();
  }

  /** Whether colours or sections need the inner points. */
  get needsInnerPoints(): boolean {
    return this.colouring !== "body" && this.colouring !== "depth";
  }

  private takeDepths(arrays: Arrays): void {
    const contacts = arrays["contacts"];
    const places = arrays["contact_places"];
    if (!contacts || !places) return;
    this.depths.fill(0);
    for (let c = 0; c < places.length / 3; ++c) {
      const vertex = places[3 * c]!;
      if (vertex >= 0) this.depths[vertex] = Math.max(this.depths[vertex]!, contacts[7 * c + 6]!);
    }
  }

  displacement(vertex: number): number {
    const i = 3 * vertex;
    const p = this.positions;
    const q = this.rest;
    return Math.hypot(p[i]! - q[i]!, p[i + 1]! - q[i + 1]!, p[i + 2]! - q[i + 2]!);
  }

  /** The amount shown at a vertex or an inner point; NaN if there is none. */
  private amount(corner: number): number {
    const inner = corner >= this.tets.vertices;
    if (this.colouring === "depth") return (inner ? 0 : this.depths[corner]) || NaN;
    if (this.colouring === "displacement") return inner ? this.tets.displacement(corner) : this.displacement(corner);
    return this.field?.[corner] ?? NaN;
  }

  /** For each body, whether amounts colour it: the bodies of the view; without these, deformable bodies; if none of these is visible, all. */
  private areColoured(): boolean[] {
    if (this.coloured.length > 0) return this.meshes.map((mesh) => this.coloured.includes(mesh.info.name));
    // Contacts have their depth on bodies of any kind.
    const all = this.colouring === "depth" || !this.meshes.some((mesh) => mesh.front.visible && !mesh.info.rigid);
    return this.meshes.map((mesh) => all || !mesh.info.rigid);
  }

  /**
   * An automatic scale only grows, so that a movie keeps its colours; this resets it.
   * @param coloured  names of the bodies that amounts colour; none: those that deform
   */
  setColouring(colouring: Colouring, scale?: { least: number; most: number }, coloured: readonly string[] = []): void {
    if (colouring !== this.colouring) this.field = null;
    this.colouring = colouring;
    this.coloured = coloured;
    this.setScale(scale);
  }

  setScale(scale?: { least: number; most: number }): void {
    Object.assign(this.scale, scale ? { automatic: false, ...scale } : { automatic: true, least: 0, most: 0 });
    this.colour();
  }

  /** Fits an automatic scale to the bodies that are coloured and visible, with their inside, as in pictures. */
  private growScale(): void {
    let least = 0;
    let most = 0;
    const add = (corner: number) => {
      const amount = this.amount(corner);
      if (amount > most) most = amount;
      if (amount < least) least = amount;
    };
    const areColoured = this.areColoured();
    this.meshes.forEach((mesh, body) => {
      if (!mesh.front.visible || !areColoured[body]) return;
      for (let v = mesh.info.vertices[0]; v < mesh.info.vertices[1]; ++v) add(v);
      const [begin, end] = this.tets.innerPoints[body]!;
      for (let i = begin; this.hasInside && i < end; ++i) add(i);
    });
    this.scale.most = Math.max(this.scale.most, niceAbove(most));
    this.scale.least = Math.min(this.scale.least, -niceAbove(-least));
  }

  /** Writes the colour of an amount of a body as three numbers in sRGB. */
  private write(mesh: BodyMesh, amount: number, colours: Float32Array, place: number): void {
    const { least, most } = this.scale;
    if (Number.isNaN(amount)) colours.set(mesh.info.rigid ? neutral : noValue, place);
    else amountColour((amount - least) / (most - least || 1), colours, place);
  }

  colour(): void {
    const linear = new three.Color();
    const shown = this.colouring !== "body";
    if (shown && this.scale.automatic) this.growScale();
    const areColoured = this.areColoured();
    for (const [body, mesh] of this.meshes.entries()) {
      const colours = mesh.surface.values("color");
      const coloured = shown && areColoured[body];
      const plain = shown ? neutral : mesh.colour;
      for (let i = 0, vertex = mesh.begin; vertex < mesh.info.vertices[1]; i += 3, ++vertex) {
        if (coloured) this.write(mesh, this.amount(vertex), colours, i);
        else colours.set(plain, i);
        linear.setRGB(colours[i]!, colours[i + 1]!, colours[i + 2]!, three.SRGBColorSpace);
        const light = this.light[vertex]!;
        colours[i] = light * linear.r;
        colours[i + 1] = light * linear.g;
        colours[i + 2] = light * linear.b;
      }
      mesh.surface.fill("color");
    }
    this.colourFaces();
  }

  /** Colours the faces of the cut by the amounts inside, as far as they are known. */
  private colourFaces(): void {
    const linear = new three.Color();
    const shown = this.colouring !== "body";
    const areColoured = this.areColoured();
    this.meshes.forEach((mesh, body) => {
      const coloured = shown && areColoured[body];
      // Without a value, neighbours still have to be distinguished.
      if (coloured && !mesh.info.rigid) mesh.setFace(noValue, cutShade * (1 - 0.18 * (body % 3)));
      else mesh.setFace(shown ? neutral : mesh.colour);
      if (!this.plane || !coloured || !this.needsInnerPoints || !this.hasInside || !this.isCut(body)) return mesh.face.section(null);
      const { positions, amounts } = this.tets.section(body, this.plane, this.positions, (corner) => this.amount(corner));
      const colours = new Float32Array(3 * amounts.length);
      amounts.forEach((amount, i) => {
        this.write(mesh, amount, colours, 3 * i);
        linear.setRGB(colours[3 * i]!, colours[3 * i + 1]!, colours[3 * i + 2]!, three.SRGBColorSpace).toArray(colours, 3 * i);
      });
      mesh.face.section({ positions, colours });
    });
  }

  /** Darkens places that other bodies shade. */
  shade(): void {
    this.occlusion.update(this, this.light);
    this.colour();
  }

  showEdges(on: boolean): void {
    for (const mesh of this.meshes) mesh.showEdges(on);
  }

  setOpacity(body: number, opacity: number): void {
    this.opacities[body] = opacity;
    this.meshes[body]?.setOpacity(this.opacity(body), this.isCut(body));
  }

  /** An absent body is not shown, whatever was chosen. */
  opacity(body: number): number {
    return this.absent[body] ? 0 : (this.opacities[body] ?? 1);
  }

  /** Bodies that a stage has inserted, removed or released; whether others are seen now. */
  takePlan(plan: Plan): boolean {
    this.meshes.forEach((mesh, body) => (mesh.info.rigid = plan.rigid.includes(body)));
    const absent = this.meshes.map((_, body) => plan.absent.includes(body));
    if (absent.every((one, body) => one === this.absent[body])) return false;
    this.absent = absent;
    this.meshes.forEach((mesh, body) => mesh.setOpacity(this.opacity(body), this.isCut(body)));
    this.colour();
    return true;
  }

  /** Sets the plane of the cut, for the bodies of these names; null: for all. */
  cut(plane: three.Plane | null, names: ReadonlySet<string> | null = null): void {
    this.plane = plane;
    this.isCut = (body) => plane !== null && (names === null || names.has(this.meshes[body]!.info.name));
    const within = this.sphere(this.isCut);
    this.meshes.forEach((mesh, i) => {
      mesh.cut(this.isCut(i) ? plane : null, within);
      mesh.setOpacity(this.opacity(i), this.isCut(i));
    });
    this.colourFaces();
  }

  /** A ball around all points of some bodies. */
  private sphere(wanted: (body: number) => boolean): three.Sphere {
    const box = new three.Box3();
    const place = new three.Vector3();
    for (const [body, mesh] of this.meshes.entries()) {
      if (!wanted(body)) continue;
      for (let v = mesh.info.vertices[0]; v < mesh.info.vertices[1]; ++v) box.expandByPoint(place.fromArray(this.positions, 3 * v));
    }
    return box.getBoundingSphere(new three.Sphere());
  }

  shownSphere(): three.Sphere {
    return this.sphere((body) => this.meshes[body]!.front.visible);
  }

  vertex(index: number): three.Vector3 {
    return new three.Vector3().fromArray(this.positions, 3 * index);
  }

  bodyOf(vertex: number): number {
    return this.meshes.findIndex((mesh) => mesh.info.vertices[0] <= vertex && vertex < mesh.info.vertices[1]);
  }

  /** whether a position of a body is visible: the body is shown, and the cut does not remove the position. */
  shows(body: number, place: three.Vector3): boolean {
    return this.meshes[body]!.front.visible && !(this.isCut(body) && this.plane!.distanceToPoint(place) < 0);
  }

  /** The vertices of the visible parts of bodies. */
  *shownVertices(): Generator<number> {
    const place = new three.Vector3();
    for (const [body, mesh] of this.meshes.entries()) {
      if (!mesh.front.visible) continue;
      for (let v = mesh.info.vertices[0]; v < mesh.info.vertices[1]; ++v) {
        if (!this.isCut(body) || this.plane!.distanceToPoint(place.fromArray(this.positions, 3 * v)) >= 0) yield v;
      }
    }
  }

  /** Positions of these vertices, 3 numbers each. */
  shownPositions(): Float32Array {
    const values: number[] = [];
    for (const v of this.shownVertices()) values.push(this.positions[3 * v]!, this.positions[3 * v + 1]!, this.positions[3 * v + 2]!);
    return Float32Array.from(values);
  }

  dispose(): void {
    for (const mesh of this.meshes) mesh.dispose();
  }
}
