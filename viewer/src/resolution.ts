// Reduces the resolution while the picture moves on slow machines; full resolution as soon as it is still.

/** A picture that takes longer is slow, ms. */
const slowPicture = 34;
const patience = 5;
const rest = 350;

export class Resolution {
  /** Share of the pixels along each side. */
  fraction = 1;
  private slow = 0;
  private began = 0;
  private timer = 0;

  /** @param changed  called when the fraction is another */
  constructor(private readonly changed: () => void) {}

  /** A picture begins to be drawn. */
  draws(): void {
    this.began = performance.now();
    clearTimeout(this.timer);
    if (this.fraction < 1) this.timer = window.setTimeout(() => this.set(1), rest);
  }

  /** The browser is ready for the next. */
  ready(): void {
    if (this.began === 0) return;
    const took = performance.now() - this.began;
    this.began = 0;
    this.slow = took > slowPicture ? this.slow + 1 : Math.max(0, this.slow - 1);
    if (this.slow >= patience && this.fraction === 1) this.set(0.5);
  }

  private set(fraction: number): void {
    this.fraction = fraction;
    this.slow = 0;
    this.changed();
  }
}
