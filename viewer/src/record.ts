// Pictures and videos of the view.

function save(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** Saves the content of the canvas; `draw` must have drawn in this turn of the event loop. */
export function savePicture(canvas: HTMLCanvasElement, name: string): void {
  canvas.toBlob((blob) => blob && save(blob, `${name}.png`), "image/png");
}

/** Records the canvas from start to stop. */
export class Recorder {
  private recorder?: MediaRecorder;

  constructor(private readonly canvas: HTMLCanvasElement) {}

  get running(): boolean {
    return this.recorder !== undefined;
  }

  /** Throws if the browser cannot record. */
  start(name: string): void {
    const type = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find((t) => MediaRecorder.isTypeSupported(t));
    if (!type) throw new Error("this browser cannot record video");
    const recorder = new MediaRecorder(this.canvas.captureStream(30), { mimeType: type, videoBitsPerSecond: 8e6 });
    const parts: Blob[] = [];
    recorder.ondataavailable = (event) => parts.push(event.data);
    recorder.onstop = () => save(new Blob(parts, { type: "video/webm" }), `${name}.webm`);
    recorder.start(200);
    this.recorder = recorder;
  }

  stop(): void {
    this.recorder?.stop();
    this.recorder = undefined;
  }
}
