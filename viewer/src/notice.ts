// A line over the view: a refused command for some seconds, or an error until it is resolved.
import { byId } from "./parts";

export class Notice {
  private timer = 0;

  show(text: string, stays = false): void {
    const element = byId("notice");
    element.textContent = text;
    element.dataset["kind"] = stays ? "error" : "note";
    element.hidden = false;
    clearTimeout(this.timer);
    if (!stays) this.timer = window.setTimeout(() => this.hide(), 5000);
  }

  hide(): void {
    byId("notice").hidden = true;
  }

  /** Hides the error after its cause is gone. */
  hideError(): void {
    if (byId("notice").dataset["kind"] === "error") this.hide();
  }
}
