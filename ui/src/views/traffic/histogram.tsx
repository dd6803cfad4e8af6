// Times as bars. Few slow exchanges beside thousands have a scale of their own.
import { formatDuration, formatNumber, t } from '../../i18n';
import { tailFrom } from './tail';

const WIDTH = 520;
const HEIGHT = 144;
const LEFT = 42;
const TOP = 28;
const BOTTOM = 18;
const COUNT = 14; // height of a count above a bar
const LEAST = 2; // height of a bar
const WIDEST = 56; // of a bar
const NARROWEST_LABEL = 64;
const NARROWEST_COUNT = 14;

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
  const tail = tailFrom(bars, times.p99_us);
  const rest = bars.slice(tail).map(([, count]) => count);
  const height = (count: number, i: number) => {
    if (count === 0) return 0;
    // The tail is logarithmic: it may have a hundred exchanges, and one that took very long.
    const part = i < tail ? count / most : Math.log10(count + 1) / Math.log10(Math.max(...rest) + 1);
    return Math.max(LEAST, part * (floor - TOP - (i < tail ? 4 : COUNT)));
  };
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
      {rest.length > 0 && (
        <>
          <line class="border" x1={LEFT + tail * width} x2={LEFT + tail * width} y1={TOP - 2} y2={floor} />
          <text
            class="tail"
            x={LEFT + bars.length * width}
            y={10}
            text-anchor={bars.length * width < 200 ? 'middle' : 'end'}
          >
            {t.value.traffic.tail(formatNumber(rest.reduce((sum, count) => sum + count)))}
          </text>
        </>
      )}
      {bars.map(([upper, count], i) => {
        const middle = LEFT + (i + 0.5) * width;
        const mark = percentiles.get(i);
        return (
          <g key={upper}>
            <rect
              x={middle - width / 2 + 0.5}
              class={i < tail ? undefined : 'tail'}
              y={floor - height(count, i)}
              width={Math.max(1, width - 1)}
              height={height(count, i)}
            >
              <title>{`≤ ${formatDuration(upper / 1000)}: ${formatNumber(count)}`}</title>
            </rect>
            {i >= tail && width > NARROWEST_COUNT && count > 0 && (
              <text x={middle} y={floor - height(count, i) - 3} text-anchor="middle">
                {formatNumber(count)}
              </text>
            )}
            {mark && (
              <text
                class="percentile"
                x={middle}
                y={TOP - 5}
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
