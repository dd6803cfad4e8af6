// Values in other formats: the bits of a number as its type has them. Pure.
import type { LiveValue } from '../../api/types';

export type Format = 'normal' | 'hex' | 'binary' | 'registers';
export const FORMATS: Format[] = ['normal', 'hex', 'binary', 'registers'];

const BITS: Record<string, number> = {
  bool: 1,
  int16: 16,
  uint16: 16,
  int32: 32,
  uint32: 32,
  float: 32,
  int64: 64,
  uint64: 64,
  double: 64,
};

/** The bits of a value; null where the value is not that of the registers: a text, or scaled. */
export function bitsOf(type: string, value: number | boolean): bigint | null {
  const size = BITS[type];
  if (!size) return null;
  if (typeof value === 'boolean') return value ? 1n : 0n;
  const view = new DataView(new ArrayBuffer(8));
  if (type === 'float') {
    view.setFloat32(0, value);
    return BigInt(view.getUint32(0));
  }
  if (type === 'double') {
    view.setFloat64(0, value);
    return view.getBigUint64(0);
  }
  if (!Number.isInteger(value)) return null;
  return BigInt.asUintN(size, BigInt(value));
}

const grouped = (digits: string, size: number) =>
  (digits.match(new RegExp(`.{1,${size}}(?=(.{${size}})*$)`, 'g')) ?? []).join(' ');

/** Without its default where none was ever read: it is no value of the device. */
export const withoutDefault = (its: LiveValue): LiveValue =>
  !its.local && its.sampled_at === null && (its.quality === 'bad' || its.quality === 'never_read')
    ? { ...its, value: null, text: '' }
    : its;

/** Whether the other formats make sense for a value. */
export function hasBits(value: LiveValue): boolean {
  const its = value.value;
  return (typeof its === 'number' || typeof its === 'boolean') && bitsOf(value.type, its) !== null;
}

export function formatValue(value: LiveValue, format: Format): string {
  const its = value.value;
  if (format === 'normal' || format === 'registers' || (typeof its !== 'number' && typeof its !== 'boolean'))
    return value.text;
  const bits = bitsOf(value.type, its);
  const size = BITS[value.type];
  if (bits === null || !size) return value.text;
  const hex = bits
    .toString(16)
    .toUpperCase()
    .padStart(Math.ceil(size / 4), '0');
  if (format === 'hex') return `0x${hex}`;
  return grouped(bits.toString(2).padStart(size, '0'), 4);
}

/** A number as the program prints it: the shortest digits that are this value of its type. */
export function shortest(value: number, type: string): string {
  for (let digits = 1; type === 'float' && digits < 9; ++digits) {
    const its = Number(value.toPrecision(digits));
    if (Math.fround(its) === Math.fround(value)) return String(its);
  }
  return String(value);
}
/** The digits after the point. */
export function decimalsOf(value: number, type: string): number {
  const [, fraction = '', exponent = '0'] =
    /^-?\d+(?:\.(\d+))?(?:e-(\d+))?$/.exec(shortest(value, type)) ?? [];
  return Math.min(100, fraction.length + Number(exponent));
}

/**
 * A sparkline in a box; empty with fewer than two points.
 * @param points  [second, value]; NaN: the value was not good from then on
 */
export function sparkline(points: [number, number][], width: number, height: number, now: number): string {
  const span = 60;
  const shown = points.filter(([time]) => time >= now - span);
  if (shown.length < 2) return '';
  const numbers = shown.map(([, value]) => value).filter((its) => !Number.isNaN(its));
  const least = Math.min(...numbers);
  const range = Math.max(...numbers) - least;
  const x = (time: number) => (((time - (now - span)) / span) * width).toFixed(1);
  const y = (value: number) =>
    (range === 0 ? height / 2 : height - 1.5 - ((value - least) / range) * (height - 3)).toFixed(1);
  // A polled value holds until the next one: steps.
  let path = '';
  let before = Number.NaN;
  for (const [time, value] of shown) {
    if (!Number.isNaN(before)) path += `H${x(time)}`;
    else if (!Number.isNaN(value)) path += `M${x(time)} ${y(value)}`;
    if (!Number.isNaN(before) && !Number.isNaN(value) && value !== before) path += `V${y(value)}`;
    before = value;
  }
  return Number.isNaN(before) ? path : `${path}H${width}`;
}
