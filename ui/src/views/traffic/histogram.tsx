// The times of one request as bars. The count is logarithmic: one slow exchange in thousands must be visible.
import type { RequestCounters } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';

const WIDTH = 520;
const HEIGHT = 120;
const LEFT = 34;
const BOTTOM = 18;

export function Histogram({ request }: { request: RequestCounters }) {
  const bars = request.histogram;
  if (bars.length === 0) return <p class="muted">{t.value.traffic.noTimes}</p>;
  const most = Math.max(...bars.map(([, count]) => count));
  const scale = (count: number) => (Math.log10(count + 1) / Math.log10(most + 1)) * (HEIGHT - BOTTOM - 10);
  const width = (WIDTH - LEFT) / bars.length;
  const every = Math.max(1, Math.ceil(bars.length / 6));
  return (
    <svg
      class="histogram"
      viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
      role="img"
      aria-label={t.value.traffic.histogram}
    >
      <line x1={LEFT} y1={HEIGHT - BOTTOM} x2={WIDTH} y2={HEIGHT - BOTTOM} />
      <text x={LEFT - 6} y={14} text-anchor="end">
        {formatNumber(most)}
      </text>
      <text x={LEFT - 6} y={HEIGHT - BOTTOM} text-anchor="end">
        0
      </text>
      {bars.map(([upper, count], i) => (
        <g key={upper}>
          <rect
            x={LEFT + i * width + 0.5}
            y={HEIGHT - BOTTOM - scale(count)}
            width={Math.max(1, width - 1)}
            height={scale(count)}
          >
            <title>{`≤ ${formatDuration(upper / 1000)}: ${formatNumber(count)}`}</title>
          </rect>
          {i % every === 0 && (
            <text x={LEFT + (i + 0.5) * width} y={HEIGHT - 4} text-anchor="middle">
              {formatDuration(upper / 1000)}
            </text>
          )}
        </g>
      ))}
    </svg>
  );
}
