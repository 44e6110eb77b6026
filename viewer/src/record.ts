// Pictures and videos of the view, with what lies over it.
import { Composed } from "./composed";

function save(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** Saves the view; it must have been drawn in this turn of the event loop. */
export function savePicture(view: HTMLCanvasElement, name: string): void {
  const picture = new Composed(view);
  picture.fit();
  picture.draw();
  picture.canvas.toBlob((blob) => blob && save(blob, `${name}.png`), "image/png");
}

/** Records the view from start to stop, at the size that it has at the start. */
export class Recorder {
  private recorder?: MediaRecorder;

  private readonly composed: Composed;

  constructor(view: HTMLCanvasElement) {
    this.composed = new Composed(view);
  }

  get running(): boolean {
    return this.recorder !== undefined;
  }

  /** The view must have been drawn in this turn of the event loop. Throws if the browser cannot record. */
  start(name: string): void {
    const type = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find((t) => MediaRecorder.isTypeSupported(t));
    if (!type) throw new Error("this browser cannot record video");
    this.composed.fit();
    this.composed.draw();
    const recorder = new MediaRecorder(this.composed.canvas.captureStream(30), { mimeType: type, videoBitsPerSecond: 8e6 });
    const parts: Blob[] = [];
    recorder.ondataavailable = (event) => parts.push(event.data);
    recorder.onstop = () => save(new Blob(parts, { type: "video/webm" }), `${name}.webm`);
    recorder.start(200);
    this.recorder = recorder;
  }

  /** Call when the view was drawn. */
  drawn(): void {
    if (this.running) this.composed.draw();
  }

  stop(): void {
    this.recorder?.stop();
    this.recorder = undefined;
  }
}
