// The face where a plane cuts a body: a ray from the eye that has crossed the surface an odd number of times
// is inside of it there. Crossings flip a bit of the stencil buffer; where it is set, a square in the plane
// is drawn.
import * as three from "three";

/** One square for all faces, always placed in the same way, so that faces of overlapping bodies have exactly the same depth. */
const square = new three.PlaneGeometry(1, 1);

/** Of faces in one plane the last one is visible: each is nearer than the one before, by this many steps of the depth buffer. */
const nearer = 4;

export class CutFace {
  readonly objects: three.Mesh[];
  private readonly crossings = new three.MeshBasicMaterial({
    side: three.DoubleSide,
    forceSinglePass: true,
    depthTest: false,
    depthWrite: false,
    colorWrite: false,
    transparent: true,  // with the faces in one sorted list, body by body
    stencilWrite: true,
    stencilWriteMask: 1,
    stencilFunc: three.AlwaysStencilFunc,
    stencilFail: three.InvertStencilOp,
    stencilZFail: three.InvertStencilOp,
    stencilZPass: three.InvertStencilOp,
  });
  private readonly face: three.Mesh<three.PlaneGeometry, three.MeshBasicMaterial>;
  private readonly sections: three.Mesh<three.BufferGeometry, three.MeshBasicMaterial>;
  private seen = false;
  private sectioned = false;

  /**
   * @param geometry  the surface as far as it is kept
   * @param order  of the body: faces are drawn one after the other
   */
  constructor(geometry: three.BufferGeometry, order: number) {
    const place = { polygonOffset: true, polygonOffsetFactor: 0, polygonOffsetUnits: -nearer * (order + 1) };
    this.face = new three.Mesh(
      square,
      new three.MeshBasicMaterial({
        ...place,
        side: three.DoubleSide,
        transparent: true,
        forceSinglePass: true,
        stencilWrite: true,
        stencilRef: 0,
        stencilFunc: three.NotEqualStencilFunc,
        stencilFail: three.ReplaceStencilOp,
        stencilZFail: three.ReplaceStencilOp,  // leaves the stencil empty for the next body
        stencilZPass: three.ReplaceStencilOp,
      }),
    );
    this.sections = new three.Mesh(
      new three.BufferGeometry(),
      new three.MeshBasicMaterial({ ...place, vertexColors: true, side: three.DoubleSide, transparent: true, forceSinglePass: true }),
    );
    this.objects = [new three.Mesh(geometry, this.crossings), this.face, this.sections];
    this.objects.forEach((object, i) => {
      object.frustumCulled = false;
      object.visible = false;
      object.renderOrder = 10 + 2 * order + Math.min(i, 1);
    });
  }

  set visible(on: boolean) {
    this.seen = on;
    this.choose();
  }

  set opacity(opacity: number) {
    this.face.material.opacity = this.sections.material.opacity = opacity;
  }

  set colour(colour: three.Color) {
    this.face.material.color.copy(colour);
  }

  /** Triangles in the plane, with a colour at each corner; null: the face has one colour. */
  section(triangles: { positions: Float32Array; colours: Float32Array } | null): void {
    this.sectioned = triangles !== null;
    if (triangles) {
      this.sections.geometry.dispose();
      this.sections.geometry.setAttribute("position", new three.BufferAttribute(triangles.positions, 3));
      this.sections.geometry.setAttribute("color", new three.BufferAttribute(triangles.colours, 3));
    }
    this.choose();
  }

  private choose(): void {
    const [crossings, face, sections] = this.objects as [three.Mesh, three.Mesh, three.Mesh];
    crossings.visible = face.visible = this.seen && !this.sectioned;
    sections.visible = this.seen && this.sectioned;
  }

  /** Makes the square so large that it covers all bodies that are cut. */
  cut(plane: three.Plane, middle: three.Vector3, size: number): void {
    plane.projectPoint(middle, this.face.position);
    this.face.quaternion.setFromUnitVectors(new three.Vector3(0, 0, 1), plane.normal);
    this.face.scale.setScalar(size);
  }

  dispose(): void {
    this.crossings.dispose();
    this.face.material.dispose();
    this.sections.geometry.dispose();
    this.sections.material.dispose();
  }
}
