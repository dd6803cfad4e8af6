// The tail of a histogram: few exchanges beside thousands. Pure.

/** Counts this much smaller than the largest one are not readable on its scale. */
const SMALLER = 20;

/**
 * @param bars  upper bound of each bar in microseconds, and its count
 * @returns the first bar of the tail, which begins after the 99th percentile and has a scale of its own;
 *   the number of bars: there is none
 */
export function tailFrom(bars: [number, number][], p99_us: number | null): number {
  if (p99_us === null) return bars.length;
  const most = Math.max(...bars.map(([, count]) => count));
  const at = bars.findIndex(([upper]) => upper >= p99_us);
  const first = at < 0 ? bars.length : at + 1;
  return bars.slice(first).every(([, count]) => count * SMALLER <= most) ? first : bars.length;
}
