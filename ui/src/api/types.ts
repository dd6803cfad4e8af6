// The shapes of /api/v1. Written by tools/api_types from docs/openapi.json.

export interface Events {
  /**
   * Events before this time are not kept: there are the newest 1,000 commands and the newest 1,000
   * messages
   */
  since: number;
  /** In order of time */
  events: HistoryMark[];
}

export interface Error {
  error: {
    /** Stable; http_STATUS for requests that were rejected before they were understood */
    code: string;
    /** In the language of the request */
    text: string;
  };
}

/** A number, text, true, false or null */
export type Scalar = string | number | boolean | null;

export type Quality = 'good' | 'uncertain' | 'bad' | 'never_read';

export interface Info {
  /** Name of the project file */
  project: string;
  version: string;
  started: string;
  now: string;
  demo: boolean;
  /** Routes that change something work */
  allow_write: boolean;
  /** PUT /project works */
  editable: boolean;
  /** The project has a history */
  history: boolean;
  /** Of the configuration; grows with each applied project */
  generation: number;
}

export interface QualityCounts {
  good: number;
  uncertain: number;
  bad: number;
  never_read: number;
}

/** docs/commands/ctl.md describes all keys */
export interface DeviceStatus {
  name: string;
  address: number;
  state: 'unknown' | 'answering' | 'not_answering' | 'switched_off' | 'link_down';
  cause?: string;
  /** Unit 0: it is written to and never answers. */
  broadcast?: boolean;
  /** It answers again and again, and most of its requests fail. */
  fails_often?: boolean;
  /** The end of the back-off, after the time of the status. */
  back_off: {
    /**
     * after the time of the status; zero or less: it is due. A line with no other request to send probes
     * earlier
     */
    next_probe_ms: number;
    pause_ms: number;
  } | null;
  values: QualityCounts;
  response_ms: number | null;
  sent: number;
  failed: number;
  exceptions: number;
  outages: number;
  availability_percent: number | null;
  downtime_ms: number;
  late_answers: number;
  surplus_answers: number;
  delays: {
    /** the setting that is too short */
    setting: string;
    delay_ms: number;
    limit_ms: number;
    advised_ms: number | null;
    count: number;
    later: number;
    text: string;
  } | null;
  noise: {
    least_bytes: number;
    most_bytes: number;
    text: string;
  } | null;
  turnaround: ResponseTimes | null;
  late_responses: LateResponses | null;
}

export interface LineStatus {
  name: string;
  state: 'connected' | 'never_connected' | 'lost';
  /** Part of the last seconds that the line was busy */
  load: number;
  planned_cycle_ms: number;
  measured_cycle_ms: number | null;
  availability_percent: number | null;
  downtime_ms: number;
  requests: number;
  overrun: number;
  devices: DeviceStatus[];
  /** Why it has no link */
  text?: string;
}

/** The object of `takt ctl PATH --json status` */
export interface Status {
  time: string;
  health: 'ok' | 'degraded' | 'failed';
  /** The worst first. */
  problems: Problem[];
  uptime_ms: number;
  values: QualityCounts;
  lines: LineStatus[];
  outputs: OutputStatus[];
  /** as the control socket has it */
  event: string;
  command: string;
}

export interface Values {
  time: string;
  values: ({
    name: string;
    line?: string;
    device?: string;
    value: Scalar;
    text: string;
    words?: string;
    unit?: string;
    quality: Quality;
    reason: string;
    cause?: string;
    age_ms: number | null;
    /** Registers that hold the value; with raw=1 */
    raw?: number[];
  })[];
  /** as the control socket has it */
  event: string;
  command: string;
}

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
  /** ms since 1970 */
  sampled_at: number | null;
  area?: 'coils' | 'discrete' | 'input' | 'holding';
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
  write_range?: {
    least?: number;
    greatest?: number;
  };
  deadline_ms?: number | null;
  proved_age_ms?: number | null;
}

/** Event `snapshot` */
export interface Snapshot {
  generation: number;
  /** ms since 1970 */
  time: number;
  values: LiveValue[];
}

/** Event `values`, at most ten a second */
export interface ValueBatch {
  time: number;
  values: ValueChange[];
}

/** Event `notice` */
export interface Notice {
  time: number;
  severity: 'info' | 'warning' | 'error';
  text: string;
}

/** An item of the event `frames`: a frame, dropped bytes, or an incident */
export interface Frame {
  /** ms since 1970 */
  t: number;
  line: string;
  device?: string;
  unit: number;
  direction?: 'tx' | 'rx';
  function?: number;
  words: string;
  /** Hexadecimal; the characters of ASCII frames */
  raw?: string;
  /** Why bytes were dropped, or `exception` */
  fault?: string;
  /** It is no frame. */
  incident?: 'no_response' | 'late_response' | 'surplus_response' | 'connected' | 'disconnected';
  /** Of no_response: how long the response was awaited; of late_response: how long after that it came */
  after_ms?: number;
  /** no_response, surplus_response: what came, and what was asked; `length`: bytes */
  instead?: {
    part: 'unit' | 'function' | 'transaction' | 'length';
    came: number;
    asked: number;
  };
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
  /** Within 12.5 % */
  p50_us: number | null;
  p99_us: number | null;
  longest_us: number | null;
  planned_us: number | null;
  /** Longest time of the bucket in us, count */
  histogram: [number, number][];
  /** Answered transactions that took longer than their C of the proof */
  longer_than_proved: number;
  /** How often values were older than their bound before they were read again */
  late_refreshes: number;
}

/** Durations of one part of a line's time. */
export interface LineTimes {
  count: number;
  /** Within 12.5 % */
  p50_us: number;
  p99_us: number;
  longest_us: number;
  /** Longest time of the bucket in us, count */
  histogram: [number, number][];
}

export interface Requests {
  lines: LineRequests[];
}

export interface Command {
  kind?: 'set' | 'write' | 'trigger';
  variable: string;
  value?: Scalar;
}

export interface CommandResult {
  outcome: 'done' | 'waiting' | 'refused' | 'unknown' | 'expired';
  reason: string;
  text: string;
  written?: Scalar;
  read_back?: Scalar;
  rounded?: boolean;
}

export interface CommandPreview {
  frames: {
    raw: string;
    words: string;
    bus_time_us: number;
  }[];
  value_written: Scalar;
  rounded: boolean;
}

export interface Why {
  variable: string;
  quality: Quality;
  age_ms: number | null;
  proved_age_ms: number | null;
  hops: Hop[];
}

export interface Probe {
  line: string;
  device: string;
}

export interface ProbeResult {
  outcome: 'done' | 'refused';
  reason: string;
  text: string;
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

/**
 * Mappings are objects, lists are arrays, scalars are strings with their raw text. `$from` of a mapping
 * in a list: its index in the file
 */
export interface Mapping {
  [key: string]: Node | number;
}

export interface Evaluation {
  findings: Finding[];
  lines: PlannedLine[];
  /** The course of the polling of each line: when its requests occupy it, if nothing fails */
  courses: Course[];
  took_ms: number;
}

export interface Fields {
  objects: FieldTable;
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

export interface ImportedRows {
  kind: 'variables' | 'locals' | 'served' | 'list' | 'devices';
  rows: ImportedRow[];
  findings: Finding[];
}

/** Serial ports and hosts that a scan can begin with. */
export interface SearchTargets {
  /** Serial ports of this computer, and the hosts of its networks */
  targets: string[];
}

/** Instants of reads that found values unchanged: instant, first and last index. */
export interface ReadBatch {
  time: number;
  /** instant of the read, first and last index in the snapshot */
  reads: ([number | null, number, number])[];
}

/** as `learnt` of `takt plan --json`: docs/commands/plan.md */
export interface Learnt {
  time: string;
  lines: {
    name: string;
    learns: boolean;
    learnt: LearntGaps[];
  }[];
}

export interface Registers {
  registers: WireItems[];
}

export interface ScanOrder {
  /**
   * as of `takt scan`: tcp://10.0.0.1-20:502, rtu:///dev/ttyUSB0; or line:NAME, a line of the project
   * that runs
   */
  targets: string[];
  /** 1-10,16 */
  units?: string;
  /**
   * Of a line of the project: a request is sent only if it has ended before a polled request is due.
   * Default: false
   */
  spare?: boolean;
  timeout_ms?: number;
  identify?: boolean;
  thorough?: boolean;
  bauds?: string;
  parities?: string;
  stop_bits?: string;
}

export interface ProbeOrder {
  target: string;
  unit: number;
  /** first address */
  from?: number;
  /** last address */
  to?: number;
  /** for each area */
  max_requests?: number;
  /**
   * Of a line of the project: a request is sent only if it has ended before a polled request is due.
   * Default: false
   */
  spare?: boolean;
  timeout_ms?: number;
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
  troubles: ({
    kind: string;
    target: string;
    text: string;
    unit: number | null;
    code: string | null;
  })[];
  absent_hosts: number;
  probed: ProbedDevice[];
}

/** index, value, text, quality, reason, sampled_at, words */
export type ValueChange = [number, Scalar, string, Quality, string, number | null, string?];

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

export interface OutputStatus {
  name: string;
  state: string;
  destination: string;
  sampled: number;
  delivered: number;
  waiting: number;
  dropped: number;
  failure: string | null;
  falls_behind: {
    samples_per_s: number;
    text: string;
    advice: string;
  } | null;
  lost: number;
  gaps: number;
  oldest_waiting: string | null;
  oldest_waiting_ms: number | null;
  commands: number;
  commands_refused: number;
  answers_dropped: number;
  commands_unrecorded: number;
  too_large: number;
  damaged: number;
  set_aside: string | null;
  journal: OutputJournal | null;
  mqtt?: OutputMqtt;
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
  /** Of each variable; null: it has none */
  byte_orders: (string | null)[];
  f_us: number | null;
  response_dead_us: number | null;
  response_fault_us: number | null;
  read_modify_write?: boolean;
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
  goal: string;
  only_plan: boolean;
}

export interface PlannedLine {
  name: string;
  framing: string;
  baud: number | null;
  utilization: number;
  cycle_us: number;
  requests: PlannedRequest[];
  /** turnaround_us: null: it is neither written nor measured; of broadcasts 0 */
  devices: ({
    name: string;
    unit: number;
    share: number;
    turnaround_us: number | null;
  })[];
  ungrouped_requests: number;
  request_count: number;
  feasible: boolean;
  verdict: 'cannot_hold' | 'not_proved' | 'response_unknown' | 'holds';
  worst_utilization: number;
  measures: Measure[];
  compare: {
    grouped: Cost;
    ungrouped: Cost;
    strategies: {
      single: Cost & {
        saved_percent: SavedPercent;
      };
      classic: Cost & {
        saved_percent: SavedPercent;
      };
      optimal: Cost & {
        saved_percent: SavedPercent;
      };
    };
    saved_percent: SavedPercent;
  };
  client_share: number;
  relayed_share: number;
  /** The bounds are met; else they may be longer than any response */
  exact: boolean;
  feasible_edf: boolean;
  in_flight: number;
  measures_complete: boolean;
  response_source: 'written' | 'measured' | 'time_out';
  learnt?: LearntGaps[];
  response_times?: ({
    device: string;
    unit: number;
    turnaround: ResponseTimes | null;
    late_responses: LateResponses | null;
  })[];
}

/** When the requests of a line occupy it: request, start and end in microseconds, whether it is late. */
export interface Course {
  length_ms: number;
  /** [request, start in us, end in us, whether it ends after its deadline] */
  bars: [number, number, number, boolean][];
}

/** A node of the project document: scalars are the raw texts of the file. */
export type Node = string | Node[] | Mapping | null;

/** A part that comes from a table or a template. */
export interface FilePart {
  path: string;
  file: string;
  rows: Record<string, string>[];
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
  unit?: string;
}

export interface FieldTable {
  [key: string]: Record<string, FieldRule>;
}

export interface Cells {
  [key: string]: string;
}

/** A row; that of a device may have the `variables` below its window. */
export interface ImportedRow {
  [key: string]: string | Cells[];
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
  refused: (ItemRange & {
    exception: number;
    since_s: number;
    checked_s: number;
  })[];
  untried: ItemRange[];
  most_items: number | null;
}

/** docs/commands/scan.md describes the other keys. The nodes are those of a project document */
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
  /** the device of the project with this endpoint and address */
  known_as: string | null;
  line_node: Mapping | null;
  device_node: Mapping | null;
  framing: 'rtu' | 'ascii' | 'tcp';
  baud: number | null;
  parity: string | null;
  stop_bits: number | null;
  function: number;
  late: boolean;
  vendor: string | null;
  product: string | null;
  revision: string | null;
  url: string | null;
  product_name: string | null;
  model: string | null;
  application: string | null;
  /** hexadecimal */
  server_id: string | null;
}

/** docs/commands/probe.md describes the other keys. `keys` are those of the device in a project document */
export interface ProbedDevice {
  target: string;
  unit: number;
  text: string;
  summary: string;
  line: string | null;
  known_as: string | null;
  keys: Mapping;
  areas: ProbedArea[];
  readable: Record<string, string>;
  exceptions: Record<string, number>;
  requests: number;
  transmissions: number;
  duration_ms: number;
  complete: boolean;
}

export interface Hop {
  hop: 'device' | 'line' | 'queue' | 'back_off' | 'trigger' | 'period' | 'enable';
  state: 'ok' | 'wait' | 'trouble';
  text: string;
  ms?: number;
}

export type LinePart = 'wire' | 'turnaround' | 'host';

export interface LineRequests {
  name: string;
  utilization: number;
  cycle_us: number;
  measured_cycle_us: number | null;
  /** Where the time of the line goes; null: not measured */
  times: {
    wire: LineTimes | null;
    turnaround: LineTimes | null;
    host: LineTimes | null;
  };
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
  bad: {
    from: string;
    to: string;
    quality: Quality;
    reason?: string;
    /** The code of the reason in status variables */
    status?: number;
  }[];
  damaged_chunks: number;
  /** The newest sample before the end of the range */
  last?: {
    time: string;
    value: Scalar;
    quality: Quality;
    reason?: string;
    status?: number;
  };
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
  /** Milliseconds since 1970 */
  time: number;
  kind: 'message' | 'command';
  severity: 'info' | 'warning' | 'error';
  text: string;
  /** Of a command */
  outcome?: 'done' | 'waiting' | 'refused' | 'unknown' | 'expired';
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

/** Negative: it is more */
export interface SavedPercent {
  requests: number;
  bytes: number;
  bus_time: number;
  cycle: number;
  utilization: number;
  requests_per_second: number;
  bytes_per_second: number;
}

export interface ResponseTimes {
  exchanges: number;
  longest_ms: number;
  p999_ms: number | null;
  learnt: boolean;
  advised: string | null;
  text?: string;
}

export interface LateResponses {
  count: number;
  requests: number;
  longest_ms: number;
  text?: string;
}

export interface ProbedArea {
  area: 'coil' | 'discrete_input' | 'input_register' | 'holding_register';
  function: number;
  end: 'complete' | 'out_of_requests' | 'stopped' | 'no_function' | 'no_answer' | 'fell_silent';
  ranges: [number, number][];
  items: number;
  refused: (ItemRange & {
    exception: number;
  })[];
  longest_read: number;
  limited: boolean;
  step: number;
  requests: number;
  next: number | null;
  addresses: number;
  tested: number;
  tested_ranges: [number, number][];
  longest_gap: [number, number] | null;
}

export interface OutputJournal {
  epoch: number;
  disk_bytes: number;
  buffer_bytes: number;
  buffer_samples: number;
  samples_lost: number;
  dropped_segments: number;
  torn_bytes: number;
  set_aside: string | null;
  disk_waits_ms: number;
  failure: {
    code: string;
    text: string;
  } | null;
}

export interface OutputMqtt {
  state: string;
  window: number;
  round_trip_ms: number | null;
  in_flight: number;
  published: number;
  acknowledged: number;
  repeated: number;
  no_subscribers: number;
  unproved: number;
  refused: number;
  connects: number;
  lost_connections: number;
  oversized: number;
  version?: string;
  last_oversized?: {
    topic: string;
    bytes: number;
  };
}
