// The shapes of /api/v1 (docs/openapi.json).

export interface Info {
  project: string;
  version: string;
  started: string;
  now: string;
  demo: boolean;
  allow_write: boolean;
  editable: boolean;
  history: boolean;
  generation: number;
}

export type Quality = 'good' | 'uncertain' | 'bad' | 'never_read';
export type Scalar = string | number | boolean | null;

/** A value of the stream's snapshot. Instants are milliseconds since 1970. */
export interface LiveValue {
  name: string;
  line?: string;
  device?: string;
  type: string;
  unit: string;
  value: Scalar;
  text: string;
  words?: string;
  quality: Quality;
  reason: string;
  cause?: string;
  sampled_at: number | null;
  area?: string;
  register?: number;
  bit?: number;
  count?: number;
  raw?: number[];
  writable: boolean;
  trigger: boolean;
  local: boolean;
  /** A write is read back before it is done. */
  verify?: boolean;
  /** Nothing reads it: the value is what was written last. */
  write_only?: boolean;
  /** All devices of the line get a write, and none acknowledges it. */
  broadcast?: boolean;
  /** Its numbers stand for words. */
  enumeration?: boolean;
  /** The values that are usual for a write, where the project has such a range. */
  write_range?: { least?: number; greatest?: number };
  deadline_ms?: number | null;
  proved_age_ms?: number | null;
}
/** index, value, text, quality, reason, sampled_at, words */
export type ValueChange = [number, Scalar, string, Quality, string, number | null, string?];

export interface Snapshot {
  generation: number;
  time: number;
  values: LiveValue[];
}
export interface ValueBatch {
  time: number;
  values: ValueChange[];
}
/** Instants of reads that found values unchanged: instant, first and last index. */
export interface ReadBatch {
  time: number;
  reads: [number | null, number, number][];
}
export interface Notice {
  time: number;
  severity: 'info' | 'warning' | 'error';
  text: string;
}

/** Why the project is not in order. */
export interface Problem {
  severity: 'error' | 'warning' | 'note';
  kind: string;
  line?: string;
  device?: string;
  output?: string;
  /** "0x03 500..501" */
  request?: string;
  /** Variables that are not good. */
  variables: string[];
  count?: number;
  of?: number;
  since_ms?: number;
  text: string;
  tried?: string;
  advice?: string;
}
export interface DeviceStatus {
  name: string;
  address: number;
  state: 'unknown' | 'answering' | 'not_answering' | 'switched_off' | 'link_down';
  cause?: string;
  /** It answers again and again, and most of its requests fail. */
  fails_often?: boolean;
  /** The end of the back-off, after the time of the status. */
  back_off: { next_probe_ms: number; pause_ms: number } | null;
  values: Record<Quality, number>;
  response_ms: number | null;
  sent: number;
  failed: number;
  exceptions: number;
  outages: number;
  availability_percent: number | null;
  downtime_ms: number;
  late_answers: number;
  surplus_answers: number;
  delays: { text: string; setting: string; advised_ms: number | null; count: number; later: number } | null;
  noise: { text: string } | null;
  turnaround: {
    exchanges: number;
    longest_ms: number;
    p999_ms: number | null;
    learnt: boolean;
    advised: string | null;
    text?: string;
  } | null;
  late_responses: { count: number; requests: number; longest_ms: number; text?: string } | null;
}
export interface LineStatus {
  name: string;
  state: string;
  load: number;
  planned_cycle_ms: number;
  measured_cycle_ms: number | null;
  availability_percent: number | null;
  downtime_ms: number;
  requests: number;
  overrun: number;
  devices: DeviceStatus[];
}
export interface Status {
  time: string;
  health: 'ok' | 'degraded' | 'failed';
  /** The worst first. */
  problems: Problem[];
  uptime_ms: number;
  values: Record<Quality, number>;
  lines: LineStatus[];
  outputs: OutputStatus[];
}
export interface OutputStatus {
  name: string;
  state: string;
  destination: string;
  sampled: number;
  delivered: number;
  waiting: number;
  dropped: number;
  failure: string | null;
  falls_behind: { samples_per_s: number; text: string; advice: string } | null;
}

export interface Finding {
  severity: 'error' | 'warning' | 'note';
  code: string;
  file: string;
  line: number;
  column: number;
  path: string;
  value: string;
  allowed: string;
  message: string;
  advice: string;
}
export interface PlannedRequest {
  device: string;
  unit: number;
  function: number | null;
  write_function: number | null;
  start: number;
  quantity: number;
  write_start?: number;
  write_quantity?: number;
  variables: string[];
  period_ms: number | null;
  phase_ms: number | null;
  read_trigger: string | null;
  write_trigger: string | null;
  write_on_change: boolean;
  bus_time_us: number;
  share: number;
  c_us: number | null;
  response_us: number | null;
  deadline_us: number | null;
  age_us: number | null;
  ages_us: (number | null)[];
  why: string;
  bridged?: string;
}
export interface Cost {
  requests: number;
  bytes: number;
  bus_time_us: number;
  cycle_us: number;
  utilization: number;
  requests_per_second: number;
  bytes_per_second: number;
}
export type Strategy = 'single' | 'classic' | 'optimal';
export interface Change {
  path: string;
  name: string;
  key: string;
  from: string;
  to: string;
}
export interface Measure {
  kinds: string[];
  text: string;
  changes: Change[];
  variable: string;
  response_before_us: number | null;
  response_after_us: number | null;
  deadline_us: number;
  utilization_before: number;
  utilization_after: number;
}
export interface PlannedLine {
  name: string;
  framing: string;
  baud: number | null;
  utilization: number;
  cycle_us: number;
  requests: PlannedRequest[];
  /** turnaround_us: null: it is neither written nor measured */
  devices: { name: string; unit: number; share: number; turnaround_us: number | null }[];
  ungrouped_requests: number;
  request_count: number;
  feasible: boolean;
  verdict: 'cannot_hold' | 'not_proved' | 'response_unknown' | 'holds';
  worst_utilization: number;
  measures: Measure[];
  compare: {
    grouped: Cost;
    ungrouped: Cost;
    strategies: Record<Strategy, Cost & { saved_percent: Record<string, number> }>;
  };
}
/** When the requests of a line occupy it: request, start and end in microseconds, whether it is late. */
export interface Course {
  length_ms: number;
  bars: [number, number, number, boolean][];
}
export interface Evaluation {
  findings: Finding[];
  lines: PlannedLine[];
  courses: Course[];
  took_ms: number;
}

/** A node of the project document: scalars are the raw texts of the file. */
export type Node = string | null | Node[] | Mapping;
export interface Mapping {
  [key: string]: Node | number;
}
/** A part that comes from a table or a template. */
export interface FilePart {
  path: string;
  file: string;
  rows: Record<string, string>[];
}
export interface ProjectFile {
  file: string;
  revision: string;
  /** null: the file has faults that an editor cannot keep. */
  document: Mapping | null;
  findings: Finding[];
  read_only_parts: FilePart[];
}
export interface Saved {
  revision: string;
  backup: string | null;
  applied: boolean;
  apply_error?: string;
  findings: Finding[];
}

export interface FieldRule {
  kind: string;
  required: boolean;
  least?: number;
  greatest?: number;
  tolerated?: number;
  words?: string[];
  allowed: string;
  default?: string;
  /** The object behind the key: its rules are those of the items or of the mapping. */
  object?: string;
}
export type FieldTable = Record<string, Record<string, FieldRule>>;

export type Cells = Record<string, string>;
/** A row; that of a device may have the `variables` below its window. */
export type ImportedRow = Record<string, string | Cells[]>;
export interface ImportedRows {
  kind: 'variables' | 'locals' | 'served' | 'list' | 'devices';
  rows: ImportedRow[];
  findings: Finding[];
}

export interface CommandResult {
  outcome: 'done' | 'waiting' | 'refused' | 'unknown' | 'expired';
  reason: string;
  text: string;
  written?: Scalar;
  read_back?: Scalar;
}
export interface CommandPreview {
  frames: { raw: string; words: string; bus_time_us: number }[];
  value_written: Scalar;
  rounded: boolean;
}

export interface WireItems {
  variable: string;
  /** Registers, or bits as 0 and 1; null: no response was seen yet. */
  items: number[] | null;
  bits: boolean;
  function?: number;
  start?: number;
  quantity?: number;
  received_at?: number;
}

export interface ItemRange {
  first: number;
  last: number;
}
export interface LearntGaps {
  device: string;
  unit: number;
  function: number;
  confirmed: ItemRange[];
  refused: (ItemRange & { exception: number; since_s: number; checked_s: number })[];
  untried: ItemRange[];
  most_items: number | null;
}
export interface Learnt {
  time: string;
  lines: { name: string; learns: boolean; learnt: LearntGaps[] }[];
}

export interface FoundDevice {
  target: string;
  unit: number;
  identity: string;
  response_ms: number;
  exception: number | null;
  garbled: boolean;
  doubled: boolean;
  /** The line of the running project with this endpoint. */
  line: string | null;
  known_as: string | null;
  line_node: Mapping | null;
  device_node: Mapping | null;
}
export interface ProbedDevice {
  target: string;
  unit: number;
  text: string;
  summary: string;
  line: string | null;
  known_as: string | null;
  keys: Mapping;
}
/** Serial ports and hosts that a scan can begin with. */
export interface SearchTargets {
  targets: string[];
}
export interface Search {
  id: number;
  kind: 'none' | 'scan' | 'probe';
  running: boolean;
  cancelled: boolean;
  elapsed_ms: number;
  done: number;
  total: number;
  requests: number;
  where: string;
  error: string | null;
  devices: FoundDevice[];
  troubles: { kind: string; target: string; text: string }[];
  absent_hosts: number;
  probed: ProbedDevice[];
}

export interface Hop {
  hop: 'device' | 'line' | 'queue' | 'back_off' | 'trigger' | 'period' | 'enable';
  state: 'ok' | 'wait' | 'trouble';
  text: string;
  ms?: number;
}
export interface Why {
  variable: string;
  quality: Quality;
  age_ms: number | null;
  proved_age_ms: number | null;
  hops: Hop[];
}

export interface Frame {
  t: number;
  line: string;
  device?: string;
  unit: number;
  direction?: 'tx' | 'rx';
  function?: number;
  words: string;
  raw?: string;
  fault?: string;
  /** It is no frame. */
  incident?: 'no_response' | 'late_response' | 'surplus_response' | 'connected' | 'disconnected';
  after_ms?: number;
  /** surplus_response: what came, and what was asked. */
  instead?: { part: 'unit' | 'function' | 'transaction'; came: number; asked: number };
}
export interface RequestCounters {
  device: string;
  unit: number;
  function: number | null;
  write_function: number | null;
  start: number;
  quantity: number;
  variables: string[];
  period_ms: number | null;
  real_period_ms: number | null;
  sent: number;
  answered: number;
  timeouts: number;
  faults: number;
  exceptions: number;
  mean_us: number | null;
  p50_us: number | null;
  p99_us: number | null;
  longest_us: number | null;
  planned_us: number | null;
  histogram: [number, number][];
  longer_than_proved: number;
  late_refreshes: number;
}
/** Durations of one part of a line's time. */
export interface LineTimes {
  count: number;
  p50_us: number;
  p99_us: number;
  longest_us: number;
  histogram: [number, number][];
}
export type LinePart = 'wire' | 'turnaround' | 'host';
export interface LineRequests {
  name: string;
  utilization: number;
  cycle_us: number;
  measured_cycle_us: number | null;
  times: Record<LinePart, LineTimes | null>;
  requests: RequestCounters[];
}

export interface HistoryPoint {
  time: string;
  value: number;
  /** The poll before: the change happened after it. */
  previous_poll?: string;
}
export interface HistoryPixel {
  index: number;
  samples: number;
  first?: HistoryPoint;
  min?: HistoryPoint;
  max?: HistoryPoint;
  last?: HistoryPoint;
}
export interface HistoryVariable {
  name: string;
  device: string;
  type: string;
  unit: string;
  samples: number;
  min: number | null;
  max: number | null;
  mean: number | null;
  good_share: number;
  known_until: string;
  /** The value that holds at the begin of the range. */
  held: HistoryPoint | null;
  points: HistoryPixel[];
  bad: { from: string; to: string; quality: Quality; reason?: string }[];
}
export interface HistoryGap {
  from: string;
  to: string;
  cause: string;
  samples: number | null;
}
export interface History {
  from: string;
  to: string;
  variables: HistoryVariable[];
  gaps: HistoryGap[];
  /** Damaged parts of the database: samples of these times may be missing. */
  damage?: HistoryDamage[];
}
export interface HistoryDamage {
  part: 'log' | 'chunk' | 'rollup' | 'gap' | 'series' | 'state' | 'recorded';
  row: number | null;
  variable: string | null;
  from: string | null;
  to: string | null;
  samples: number | null;
}
/** A message or a command of the past. */
export interface HistoryMark {
  time: number;
  kind: 'message' | 'command';
  severity: Notice['severity'];
  text: string;
  outcome?: CommandResult['outcome'];
  /** The address of the browser that gave the command. */
  origin?: string;
}
export interface HistorySeries {
  name: string;
  device: string;
  type: string;
  unit: string;
  oldest: string | null;
  newest: string | null;
}
