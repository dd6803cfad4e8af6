// The ages of values against their proof: of each device the value with the least time left. Pure.
import type { LiveValue } from '../../api/types';

export interface DeviceAge {
  line: string;
  device: string;
  variable: string;
  age_ms: number;
  proved_ms: number;
  /** The program found the value older than proved. */
  late: boolean;
}

/** How near the proof is to the deadline: the order of rows does not change with each read. */
const nearness = (its: LiveValue) => (its.deadline_ms ? its.proved_age_ms! / its.deadline_ms : 0);

interface Candidate extends DeviceAge {
  near: number;
}
function before(a: Candidate, b: Candidate): boolean {
  if (a.late !== b.late) return a.late;
  return a.late ? a.age_ms / a.proved_ms > b.age_ms / b.proved_ms : a.near > b.near;
}

/**
 * Values of devices that are switched off, and those without a proved age, are left out.
 * @param now  the program's time
 * @returns late ones first, then those whose proof leaves the least time
 */
export function deviceAges(values: Iterable<LiveValue>, now: number): DeviceAge[] {
  const worst = new Map<string, Candidate>();
  for (const its of values) {
    const proved = its.proved_age_ms;
    if (its.local || !proved || its.sampled_at === null || its.reason === 'switched_off') continue;
    const age = Math.max(0, now - its.sampled_at);
    const late = its.quality !== 'good' && age > proved;
    const key = `${its.line}/${its.device}`;
    const one = {
      line: its.line ?? '',
      device: its.device ?? '',
      variable: its.name,
      // The program judges: the page may learn of a read later than the proof allows.
      age_ms: its.quality === 'good' ? Math.min(age, proved) : age,
      proved_ms: proved,
      late,
      near: nearness(its),
    };
    const known = worst.get(key);
    if (!known || before(one, known)) worst.set(key, one);
  }
  return [...worst.values()].sort((a, b) => (before(a, b) ? -1 : before(b, a) ? 1 : 0));
}
