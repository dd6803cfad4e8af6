// The counters of each request that runs, and the histogram of its times.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { get } from '../../api/client';
import type { LineRequests, RequestCounters } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { type Column, Grid } from '../../widgets/grid';
import { Histogram } from './histogram';

const AGAIN_MS = 2000;

const lines = signal<LineRequests[]>([]);
const chosen = signal('');

const hex = (code: number) => `0x${code.toString(16).toUpperCase().padStart(2, '0')}`;
const keyOf = (line: string, its: RequestCounters) =>
  [line, its.unit, its.function, its.write_function, its.start, its.quantity].join('/');

function name(its: RequestCounters): string {
  const code = its.function ?? its.write_function;
  const range = its.quantity > 1 ? `${its.start}..${its.start + its.quantity - 1}` : `${its.start}`;
  const write = its.function === null ? ` (${t.value.traffic.write})` : '';
  return `${code === null ? '' : hex(code)} ${range}${write}`;
}
const time = (us: number | null) => (us === null ? '–' : formatDuration(us / 1000));

interface Row extends RequestCounters {
  line: string;
  key: string;
}

function columns(): Column<Row>[] {
  const texts = t.value.traffic.columns;
  const count = (
    key: 'sent' | 'answered' | 'timeouts' | 'faults' | 'exceptions',
    bad: boolean,
  ): Column<Row> => ({
    key,
    title: texts[key],
    width: '92px',
    align: 'right',
    cell: (row) => <span class={bad && row[key] > 0 ? 'bad' : ''}>{formatNumber(row[key])}</span>,
  });
  const us = (
    key: string,
    title: string,
    of: (row: Row) => number | null,
    late?: (row: Row) => boolean,
  ): Column<Row> => ({
    key,
    title,
    width: '92px',
    align: 'right',
    cell: (row) => <span class={late?.(row) ? 'bad' : ''}>{time(of(row))}</span>,
  });
  return [
    { key: 'device', title: texts.device, width: 'minmax(90px, 1fr)', cell: (row) => row.device },
    { key: 'request', title: texts.request, width: 'minmax(130px, 1fr)', cell: (row) => name(row) },
    count('sent', false),
    count('answered', false),
    count('timeouts', true),
    count('faults', true),
    count('exceptions', true),
    us('mean', texts.mean, (row) => row.mean_us),
    us('p50', 'p50', (row) => row.p50_us),
    us('p99', 'p99', (row) => row.p99_us),
    us('longest', texts.longest, (row) => row.longest_us),
    us('planned', texts.planned, (row) => row.planned_us),
    {
      key: 'period',
      title: texts.period,
      width: '150px',
      align: 'right',
      cell: (row) =>
        row.period_ms === null
          ? '–'
          : `${formatDuration(row.period_ms)} → ${row.real_period_ms === null ? '–' : formatDuration(row.real_period_ms)}`,
    },
  ];
}

export function Requests() {
  useEffect(() => {
    const ask = () =>
      get<{ lines: LineRequests[] }>('requests')
        .then((its) => {
          lines.value = its.lines;
        })
        .catch(() => {});
    void ask();
    const timer = setInterval(ask, AGAIN_MS);
    return () => clearInterval(timer);
  }, []);
  const texts = t.value.traffic;
  const rows = lines.value.flatMap((line) =>
    line.requests.map((its): Row => ({ ...its, line: line.name, key: keyOf(line.name, its) })),
  );
  const request = rows.find((its) => its.key === chosen.value);
  return (
    <>
      <p class="loads">
        {lines.value.map((line) => (
          <span key={line.name}>
            <b>{line.name}</b>: {texts.lineBusy} {formatNumber(100 * line.utilization, 1)} %, {texts.cycle}{' '}
            {time(line.measured_cycle_us)} <span class="muted">({texts.plannedBy(time(line.cycle_us))})</span>
          </span>
        ))}
      </p>
      <Grid
        label={texts.requests}
        columns={columns()}
        rows={rows}
        rowKey={(row) => row.key}
        rowClass={(row) => (row.key === chosen.value ? 'selected' : '')}
        onCurrent={({ row }) => {
          chosen.value = rows[row]?.key ?? '';
        }}
      />
      <section class="times">
        <h3>{request ? `${texts.histogram}: ${request.device} ${name(request)}` : texts.histogram}</h3>
        {request ? <Histogram request={request} /> : <p class="muted">{texts.choose}</p>}
      </section>
    </>
  );
}
