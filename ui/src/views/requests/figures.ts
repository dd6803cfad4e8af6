// Figures of formed requests that are derived from the plan. Pure.
import type { Mapping, PlannedLine, PlannedRequest, Strategy } from '../../api/types';
import { isMapping, listAt, textAt } from '../../store/document';
import { sizeOf } from '../project/rows';

const RTU_FRAME = 4; // address, function, CRC
const RTU_REQUEST = 8;
const TCP_MORE = 4; // MBAP header and function, without CRC, against RTU

/** The bytes of a PDU without its function code: of the request, and of the response. */
function bodies(code: number, quantity: number): [number, number] {
  const packed = Math.ceil(quantity / 8);
  switch (code) {
    case 1:
    case 2:
      return [4, 1 + packed];
    case 3:
    case 4:
      return [4, 1 + 2 * quantity];
    case 15:
      return [5 + packed, 4];
    case 16:
      return [5 + 2 * quantity, 4];
    case 22:
      return [6, 6];
    default:
      return [RTU_REQUEST - RTU_FRAME, RTU_REQUEST - RTU_FRAME];
  }
}

function onWire(framing: string, body: number): number {
  const rtu = RTU_FRAME + body;
  if (framing === 'ascii') return 1 + 2 * (rtu - 1) + 2; // colon, LRC instead of CRC, CR LF
  return framing === 'tcp' ? rtu + TCP_MORE : rtu;
}

/** Bytes of request and response together, of the reading and the writing transaction. */
export function bytesOf(framing: string, request: PlannedRequest): number {
  let bytes = 0;
  const add = (code: number, quantity: number) => {
    const [there, back] = bodies(code, quantity);
    bytes += onWire(framing, there) + onWire(framing, back);
  };
  if (request.function === 23 || request.write_function === 23) {
    const written = request.write_quantity ?? 0;
    return onWire(framing, 9 + 2 * written) + onWire(framing, 1 + 2 * request.quantity);
  }
  if (request.function !== null) add(request.function, request.quantity);
  else if (request.write_function !== null) add(request.write_function, request.quantity);
  return bytes;
}

/** Items that are read although no variable needs them. */
export function gapsOf(request: PlannedRequest, variables: Map<string, Mapping>): number {
  if (!request.bridged) return 0;
  const items = request.variables.map((name) => {
    const its = variables.get(name);
    return its ? sizeOf(its) : 1;
  });
  return Math.max(0, request.quantity - items.reduce((sum, its) => sum + its, 0));
}

/** The variables of a line of the document, by name. */
export function variablesOf(line: Mapping | undefined): Map<string, Mapping> {
  const map = new Map<string, Mapping>();
  for (const device of listAt(line, ['devices']))
    for (const its of listAt(device, ['variables']))
      if (isMapping(its) && typeof its.name === 'string') map.set(its.name, its);
  return map;
}

export interface Age {
  variable: string;
  request: number;
  age_us: number | null;
  /** The greatest age with which its deadline still holds; null: it has no deadline. */
  limit_us: number | null;
  holds: boolean;
  /** The turnaround of a device is not known, so there is no age yet. */
  unknown: boolean;
}

/** Devices without which the deadlines of the line cannot be computed. */
export function unmeasured(line: PlannedLine): string[] {
  if (line.verdict !== 'response_unknown') return [];
  return line.devices.filter((its) => its.turnaround_us === null).map((its) => its.name);
}

/**
 * The longest age of each variable that is read by period, the worst first. The age is the distance of two
 * reads and the response time; the deadline limits the response time.
 */
export function agesOf(line: PlannedLine): Age[] {
  const best = new Map<string, Age>();
  const unknown = unmeasured(line).length > 0;
  for (const [index, request] of line.requests.entries()) {
    if (request.function === null || request.period_ms === null) continue;
    const late =
      !unknown &&
      request.deadline_us !== null &&
      (request.response_us === null || request.response_us > request.deadline_us);
    for (const [i, variable] of request.variables.entries()) {
      const age = unknown ? null : (request.ages_us[i] ?? null);
      const distance =
        age !== null && request.response_us !== null ? age - request.response_us : request.period_ms * 1000;
      const limit = request.deadline_us === null ? null : distance + request.deadline_us;
      const before = best.get(variable);
      if (before && !(late && before.holds)) continue;
      best.set(variable, { variable, request: index, age_us: age, limit_us: limit, holds: !late, unknown });
    }
  }
  return [...best.values()].sort((a, b) => fullness(b) - fullness(a));
}
/** Age as a part of its limit; above 1 where the deadline does not hold. */
export function fullness(age: Age): number {
  if (age.age_us === null) return age.holds ? 0 : Number.POSITIVE_INFINITY;
  return age.limit_us === null ? 0 : age.age_us / age.limit_us;
}

export function strategyOf(device: Mapping, profile: string): Strategy {
  const named = textAt(device, ['strategy']) as Strategy | undefined;
  const grouped = textAt(device, ['group_requests']);
  if (grouped === 'false') return 'single';
  if (named) return named;
  if (grouped === undefined && profile === 'owen-kc1') return 'single';
  return profile === 'owen-kc1' ? 'classic' : 'optimal';
}

/** The strategy of all devices of a line; null: they differ. */
export function lineStrategy(line: Mapping | undefined, profile: string): Strategy | null {
  const all = new Set(listAt(line, ['devices']).map((device) => strategyOf(device, profile)));
  return all.size === 1 ? [...all][0]! : null;
}
