// The face where a plane cuts a body: its inside is where a ray from the eye has left the body as often as it entered,
// counted in the stencil of the picture; there a square in the plane is drawn.
import * as three from "three";

/** One square for all faces, placed alike, so that where bodies overlap the faces have the same depth to the bit. */
const square = new three.PlaneGeometry(1, 1);

function counting(side: three.Side, count: three.StencilOp): three.MeshBasicMaterial {
  return new three.MeshBasicMaterial({
    side,
    depthTest: false,
    depthWrite: false,
    colorWrite: false,
    transparent: true,  // with the faces in one sorted list, body by body
    stencilWrite: true,
    stencilFunc: three.AlwaysStencilFunc,
    stencilFail: count,
    stencilZFail: count,
    stencilZPass: count,
  });
}

export class CutFace {
  readonly objects: three.Mesh[];
  private readonly enters = counting(three.FrontSide, three.DecrementWrapStencilOp);
  private readonly leaves = counting(three.BackSide, three.IncrementWrapStencilOp);
  private readonly face: three.Mesh<three.PlaneGeometry, three.MeshBasicMaterial>;

  /** @param order  of the body: faces are drawn one after the other */
  constructor(geometry: three.BufferGeometry, colour: three.Color, order: number) {
    this.face = new three.Mesh(
      square,
      new three.MeshBasicMaterial({
        color: colour,
        side: three.DoubleSide,
        transparent: true,
        stencilWrite: true,
        stencilRef: 0,
        stencilFunc: three.NotEqualStencilFunc,
        stencilFail: three.ReplaceStencilOp,
        stencilZFail: three.ReplaceStencilOp,  // leaves the stencil empty for the next body
        stencilZPass: three.ReplaceStencilOp,
      }),
    );
    this.objects = [new three.Mesh(geometry, this.leaves), new three.Mesh(geometry, this.enters), this.face];
    this.objects.forEach((object, i) => {
      object.frustumCulled = false;
      object.visible = false;
      object.renderOrder = 10 + 3 * order + i;
    });
  }

  set visible(on: boolean) {
    for (const object of this.objects) object.visible = on;
  }

  set opacity(opacity: number) {
    this.face.material.opacity = opacity;
  }

  /** @param size  of the square: more than any body's */
  cut(plane: three.Plane, size: number): void {
    for (const material of [this.enters, this.leaves]) material.clippingPlanes = [plane];
    this.face.position.copy(plane.coplanarPoint(new three.Vector3()));
    this.face.quaternion.setFromUnitVectors(new three.Vector3(0, 0, 1), plane.normal);
    this.face.scale.setScalar(size);
  }

  dispose(): void {
    for (const material of [this.enters, this.leaves, this.face.material]) material.dispose();
  }
}
