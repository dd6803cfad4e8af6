// Times as bars. The count is logarithmic: one slow exchange in thousands must be visible.
import { formatDuration, formatNumber, t } from '../../i18n';

const WIDTH = 520;
const HEIGHT = 132;
const LEFT = 34;
const TOP = 16;
const BOTTOM = 18;
const WIDEST = 56; // of a bar
const NARROWEST_LABEL = 64;

export interface Times {
  histogram: [number, number][];
  p50_us: number | null;
  p99_us: number | null;
}

/** The percentiles by the bar that they lie in: "p50, p99". */
function percentilesOf(times: Times): Map<number, string> {
  const found = new Map<number, string>();
  for (const [name, us] of [
    ['p50', times.p50_us],
    ['p99', times.p99_us],
  ] as const) {
    if (us === null) continue;
    const bar = times.histogram.findIndex(([upper]) => upper >= us);
    const index = bar < 0 ? times.histogram.length - 1 : bar;
    const before = found.get(index);
    found.set(index, before ? `${before}, ${name}` : name);
  }
  return found;
}

export function Histogram({ label, times }: { label: string; times: Times }) {
  const bars = times.histogram;
  if (bars.length === 0) return <p class="muted">{t.value.traffic.noTimes}</p>;
  const most = Math.max(...bars.map(([, count]) => count));
  const floor = HEIGHT - BOTTOM;
  const scale = (count: number) => (Math.log10(count + 1) / Math.log10(most + 1)) * (floor - TOP - 4);
  const width = Math.min(WIDEST, (WIDTH - LEFT) / bars.length);
  const every = Math.max(1, Math.ceil(NARROWEST_LABEL / width));
  const percentiles = percentilesOf(times);
  return (
    <svg class="histogram" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={label}>
      <line x1={LEFT} y1={floor} x2={WIDTH} y2={floor} />
      <text x={LEFT - 6} y={TOP + 8} text-anchor="end">
        {formatNumber(most)}
      </text>
      <text x={LEFT - 6} y={floor} text-anchor="end">
        0
      </text>
      {bars.map(([upper, count], i) => {
        const middle = LEFT + (i + 0.5) * width;
        const mark = percentiles.get(i);
        return (
          <g key={upper}>
            <rect
              x={middle - width / 2 + 0.5}
              y={floor - scale(count)}
              width={Math.max(1, width - 1)}
              height={scale(count)}
            >
              <title>{`≤ ${formatDuration(upper / 1000)}: ${formatNumber(count)}`}</title>
            </rect>
            {mark && (
              <text
                class="percentile"
                x={middle}
                y={11}
                text-anchor={i === bars.length - 1 && width < 30 ? 'end' : 'middle'}
              >
                {mark}
              </text>
            )}
            {mark && <line class="percentile" x1={middle} x2={middle} y1={TOP - 2} y2={floor} />}
            {i % every === 0 && (
              <text x={middle} y={HEIGHT - 4} text-anchor={width < 30 && i === 0 ? 'start' : 'middle'}>
                {formatDuration(upper / 1000)}
              </text>
            )}
          </g>
        );
      })}
    </svg>
  );
}
