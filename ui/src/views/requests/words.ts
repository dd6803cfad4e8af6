// Texts of requests in the current language.
import type { PlannedRequest } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';

export const hex = (code: number) => `0x${code.toString(16).toUpperCase().padStart(2, '0')}`;
export function functionName(code: number): string {
  return (t.value.requests.functions as Record<number, string>)[code] ?? hex(code);
}
export function functionsOf(its: PlannedRequest): number[] {
  return [its.function, its.write_function].filter((code): code is number => code !== null);
}
/** "0x03 0…9" */
export function requestWords(its: PlannedRequest): string {
  const last = its.start + its.quantity - 1;
  const items = its.quantity > 1 ? `${its.start}…${last}` : String(its.start);
  return `${functionsOf(its).map(hex).join(', ')} ${items}`;
}
export function whenWords(its: PlannedRequest): string {
  const texts = t.value.requests.details;
  const parts: string[] = [];
  if (its.period_ms !== null)
    parts.push(
      its.period_ms === 0
        ? texts.fast
        : formatDuration(its.period_ms) +
            (its.phase_ms ? ` +${formatNumber(its.phase_ms, 3)} ${t.value.units.ms}` : ''),
    );
  if (its.read_trigger || its.write_trigger)
    parts.push(`${texts.trigger} ${[its.read_trigger, its.write_trigger].filter(Boolean).join(', ')}`);
  if (its.write_on_change) parts.push(texts.onChange);
  return parts.join('; ') || texts.command;
}
/** With the digits of `takt check`. */
export const percent = (share: number) => `${(share * 100).toFixed(1)} %`;
export const microseconds = (us: number) => formatDuration(us / 1000);
/** Selects a request of a line, also after the plan was computed again. */
export function requestKey(its: PlannedRequest): string {
  return [
    its.device,
    its.unit,
    its.function,
    its.write_function,
    its.start,
    its.phase_ms,
    its.read_trigger,
    its.write_trigger,
  ].join('|');
}
