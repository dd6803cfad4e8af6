// What is written: the typed text as a value, the change that people see, when to ask back, and the first
// read after a write. Pure.
import type { LiveValue, Scalar } from '../../api/types';

/** From here on a mistyped digit more is likelier than a value that is meant. */
const MANY_TIMES = 10;

/**
 * The typed text as a value; the program checks range and type. A comma is a decimal comma. Text with more
 * separators, as of thousands, stays text, and the program refuses it.
 */
export function parsedValue(type: string, text: string): Scalar {
  if (type === 'bool') return text === 'true';
  if (type === 'string') return text;
  const plain = text.trim().replace(',', '.');
  const number = Number(plain);
  if (plain === '' || Number.isNaN(number)) return text.trim();
  // A number of the page has 53 bits: the program reads longer ones from the text.
  return Math.abs(number) > Number.MAX_SAFE_INTEGER ? plain : number;
}

/** A value for people. `typed` stands for numbers that the page has no exact form of. */
export function valueText(value: Scalar, words: { on: string; off: string }, typed = ''): string {
  if (value === null || value === '') return '–';
  if (typeof value === 'boolean') return value ? words.on : words.off;
  if (typeof value === 'number' && Math.abs(value) > Number.MAX_SAFE_INTEGER && typed !== '') return typed;
  return String(value);
}

export const changeText = (before: string, after: string, unit: string): string =>
  `${before} → ${after}${unit && ` ${unit}`}`;

/** Why a write is confirmed first: the value is outside its range or, without one, many times the old one. */
export type Doubt = 'range' | 'many_times';

export function doubtOf(
  its: Pick<LiveValue, 'type' | 'value' | 'enumeration' | 'trigger' | 'write_range'>,
  next: Scalar,
): Doubt | null {
  if (its.type === 'bool' || its.enumeration || its.trigger || typeof next !== 'number') return null;
  const range = its.write_range;
  if (range?.least !== undefined || range?.greatest !== undefined) {
    const outside = next < (range.least ?? next) || next > (range.greatest ?? next);
    return outside ? 'range' : null;
  }
  if (typeof its.value !== 'number' || its.value === 0) return null;
  return Math.abs(next) >= MANY_TIMES * Math.abs(its.value) ? 'many_times' : null;
}

/** How an executed write is reported. */
export type Proof = 'set' | 'verified' | 'acknowledged' | 'broadcast';

export function proofOf(its: Pick<LiveValue, 'local' | 'verify' | 'broadcast'>): Proof {
  if (its.local) return 'set';
  if (its.broadcast) return 'broadcast';
  return its.verify ? 'verified' : 'acknowledged';
}

/** A write that was acknowledged and is not read back by itself. */
export interface OpenWrite {
  written: Scalar;
  /** The program's time after the write: reads that began earlier may have the old value. */
  after: number;
}

/** What the first good read after a write had; null: there was none yet. */
export function readAfter(write: OpenWrite, its: Pick<LiveValue, 'value' | 'sampled_at'>): Scalar {
  return its.sampled_at !== null && its.sampled_at >= write.after ? its.value : null;
}
