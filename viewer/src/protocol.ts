// The messages of the server (docs/viewer.md), and their parser.

export type Range = [number, number];
export type Vector = [number, number, number];

export interface BodyInfo {
  name: string;
  vertices: Range;
  triangles: Range;
  points: number;
  tets: number;
  rigid?: boolean;
  /** Not there at the start. */
  absent?: boolean;
  color: Vector;
}

/** A view for which the scene asks for pictures (docs/scene.md). */
export interface ViewInfo {
  name: string;
  camera?: { position?: Vector; target?: Vector };
  bodies?: string[];
  cut?: { point: Vector; normal: Vector; bodies?: string[] };
  when?: string;
  displacement?: { most: number; bodies?: string[] };
  field?: { name: string; least: number; most: number | "auto"; bodies?: string[] };
}

/** One number a point that bodies can be coloured by; its dimension as powers of mass, length and time. */
export interface FieldInfo {
  name: string;
  title: string;
  /** Title of the field that it is, or that it is a component of. */
  group: string;
  dimension: [number, number, number];
}

export interface MotionInfo {
  body: number;
}

/** The settings that can change while a simulation runs: a block of the scene format. */
export interface Settings {
  gravity?: Vector;
  contact?: Record<string, unknown>;
}

export interface Stage {
  kind: "stage";
  mode: "live" | "replay";
  name: string;
  units: { length: string; mass: string; time: string };
  diagonal: number;
  time_step: number;
  origin: Vector;
  bodies: BodyInfo[];
  motions: MotionInfo[];
  views: ViewInfo[];
  /** The sides of the patient to which x, y and z point, such as "LPS". */
  axes?: string;
  fields?: FieldInfo[];
  forces?: ForceHistory;
  frames?: number;
  typical_stiffness?: number;
  /** Names, in their order. */
  stages?: string[];
  settings: Settings;
  choices?: Record<string, string[]>;
}

export interface Pulled {
  client: number;
  vertex: number;
  target: Vector;
  force: Vector;
  /** The largest force that the tissue there can bear. */
  most: number;
}

export interface DrivenMotion {
  time: number;
  offset: Vector;
  held: boolean;
  /** Whether a motion moves the body in this stage. */
  moves: boolean;
  /** Times of its path. */
  begin: number;
  end: number;
  /** The force of the motor while the body is held. */
  force?: Vector;
}

export interface Wrench {
  force: Vector;
  torque: Vector;
}

/** The force and torque of contacts on a body, and of what holds it if that is known. */
export interface BodyWrench extends Wrench {
  held?: Wrench;
}

/** The size of the contact force on each body over a stored run. */
export interface ForceHistory {
  times: number[];
  bodies: number[][];
}

/** The stage of a scene with stages, and which bodies are absent or rigid in it. */
export interface Plan {
  stage: string;
  number: number;
  done: boolean;
  absent: number[];
  rigid: number[];
  warnings: string[];
}

export interface Counts {
  contacts: number;
  border_edges: number;
  crossings: number;
  edge_contacts: number;
  movers: number;
  candidates: number;
  dropped_cells: number;
  cell_size: number;
  step?: number;
  frame?: number;
  deepest?: number;
  kinetic_energy?: number;
  elastic_energy?: number;
  solver_iterations?: number;
  steps_not_converged?: number;
  inverted_tets?: { now: number; most: number };
  too_far?: { steps: number; thinnest: number };
  at_rest?: boolean;
  pulls?: Pulled[];
  driven?: DrivenMotion[];
  plan?: Plan;
}

export interface Frame {
  kind: "frame";
  frame: number;
  playing: boolean;
  steps: number;
  ms: Record<string, number>;
  longest: number;
  totals: { steps: number; simulated: number; longest: number; ms: Record<string, number> };
  time: number;
  counts: Counts;
  occupied_cells?: number;
  forces?: BodyWrench[];
}

export interface State {
  kind: "state";
  playing: boolean;
  speed: number | "max";
  settings: Settings;
  error: string;
  pages: number;
}

export interface Refusal {
  kind: "refusal";
  why: string;
}

export type Arrays = Record<string, Float32Array | Int32Array>;
export interface Binary<Header> {
  header: Header;
  arrays: Arrays;
}

/** A binary message: length of the header, header, arrays. The arrays are views into the bytes. */
export function decode(bytes: ArrayBuffer): Binary<Stage | Frame> {
  const length = new DataView(bytes).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const arrays: Arrays = {};
  let begin = 4 + length;
  for (const [name, type, count] of header.arrays as [string, "f4" | "i4", number][]) {
    arrays[name] = type === "f4" ? new Float32Array(bytes, begin, count) : new Int32Array(bytes, begin, count);
    begin += 4 * count;
  }
  return { header, arrays };
}

export interface Listener {
  stage(stage: Binary<Stage>): void;
  frame(frame: Binary<Frame>): void;
  state(state: State): void;
  refusal(refusal: Refusal): void;
  connected(open: boolean): void;
}

/** The connection to the server; it opens again after it breaks. */
export class Connection {
  private socket?: WebSocket;
  private wait = 250;
  /** Bytes and frames received, for the frame rate shown. */
  bytes = 0;
  frames = 0;

  constructor(private readonly listener: Listener) {
    this.open();
  }

  private open(): void {
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    address.hash = address.search = "";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = 250;
      this.listener.connected(true);
    };
    socket.onmessage = (event) => this.take(event.data);
    socket.onclose = () => {
      this.listener.connected(false);
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, 2000);
    };
    this.socket = socket;
  }

  private take(data: string | ArrayBuffer): void {
    if (typeof data === "string") {
      const message = JSON.parse(data) as State | Refusal;
      if (message.kind === "state") this.listener.state(message);
      else this.listener.refusal(message);
      return;
    }
    this.bytes += data.byteLength;
    const message = decode(data);
    if (message.header.kind === "stage") {
      this.listener.stage(message as Binary<Stage>);
    } else {
      ++this.frames;
      this.listener.frame(message as Binary<Frame>);
    }
  }

  /** Sends a command; returns false without a connection. */
  send(name: string, values: object = {}): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ [name]: values }));
    return true;
  }
}
