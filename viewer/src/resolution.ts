// Reduces the resolution while the picture moves on slow machines; full resolution as soon as it is still.

/** A picture that takes longer than this is slow, ms. */
const slowPicture = 34;
const patience = 5;
const rest = 350;

export class Resolution {
  /** Fraction of the pixels along each side. */
  fraction = 1;
  private slow = 0;
  private began = 0;
  private timer = 0;

  /** @param changed  called when the fraction has changed */
  constructor(private readonly changed: () => void) {}

  /** Call when drawing of a picture begins. */
  draws(): void {
    this.began = performance.now();
    clearTimeout(this.timer);
  }

  /** Call when the browser is ready for the next picture. */
  ready(): void {
    if (this.began === 0) return;
    const took = performance.now() - this.began;
    this.began = 0;
    this.slow = took > slowPicture ? this.slow + 1 : Math.max(0, this.slow - 1);
    if (this.slow >= patience && this.fraction === 1) this.set(0.5);
    // From the end of a picture: one may take longer than this.
    if (this.fraction < 1) this.timer = window.setTimeout(() => this.set(1), rest);
  }

  private set(fraction: number): void {
    this.fraction = fraction;
    this.slow = 0;
    this.changed();
  }
}
