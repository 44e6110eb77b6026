// The face where a plane cuts a body: a ray from the eye that has crossed the surface an odd number of times
// is inside of it there. Crossings flip a bit of the stencil buffer; where it is set, a square in the plane
// is drawn.
import * as three from "three";

/** One square for all faces, placed alike, so that where bodies overlap the faces have the same depth to the bit. */
const square = new three.PlaneGeometry(1, 1);

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

  /**
   * @param geometry  the surface as far as it is kept
   * @param order  of the body: faces are drawn one after the other
   */
  constructor(geometry: three.BufferGeometry, colour: three.Color, order: number) {
    this.face = new three.Mesh(
      square,
      new three.MeshBasicMaterial({
        color: colour,
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
    this.objects = [new three.Mesh(geometry, this.crossings), this.face];
    this.objects.forEach((object, i) => {
      object.frustumCulled = false;
      object.visible = false;
      object.renderOrder = 10 + 2 * order + i;
    });
  }

  set visible(on: boolean) {
    for (const object of this.objects) object.visible = on;
  }

  set opacity(opacity: number) {
    this.face.material.opacity = opacity;
  }

  /** The square has to hold all that is cut. */
  cut(plane: three.Plane, middle: three.Vector3, size: number): void {
    plane.projectPoint(middle, this.face.position);
    this.face.quaternion.setFromUnitVectors(new three.Vector3(0, 0, 1), plane.normal);
    this.face.scale.setScalar(size);
  }

  dispose(): void {
    this.crossings.dispose();
    this.face.material.dispose();
  }
}
