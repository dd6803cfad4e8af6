// The counters of each request that runs, and the histogram of its times.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { get } from '../../api/client';
import type { LinePart, LineRequests, RequestCounters } from '../../api/types';
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
  const range = its.quantity > 1 ? `${its.start}…${its.start + its.quantity - 1}` : `${its.start}`;
  const write = its.function === null ? ` (${t.value.traffic.write})` : '';
  return `${code === null ? '' : hex(code)} ${range}${write}`;
}
const duration = (ms: number | null) => (ms === null ? '–' : formatDuration(ms));
const time = (us: number | null) => duration(us === null ? null : us / 1000);
const percent = (part: number) => `${formatNumber(100 * part, 1)} %`;

interface Row extends RequestCounters {
  line: string;
  key: string;
}

/** In a narrow grid; what is hidden then is below the table, for the chosen request. */
const FIGURE = { folds: 'figure' } as const;
const HIDDEN = { folds: 'hidden' } as const;

function columns(): Column<Row>[] {
  const texts = t.value.traffic.columns;
  const count = (
    key: 'sent' | 'answered' | 'timeouts' | 'faults' | 'exceptions',
    bad: boolean,
    width: string,
    fold: Partial<Column<Row>>,
  ): Column<Row> => ({
    key,
    title: texts[key],
    width,
    ...fold,
    align: 'right',
    cell: (row) => <span class={bad && row[key] > 0 ? 'bad' : ''}>{formatNumber(row[key])}</span>,
  });
  const us = (
    key: string,
    title: string,
    of: (row: Row) => number | null,
    fold: Partial<Column<Row>>,
  ): Column<Row> => ({
    key,
    title,
    width: '82px',
    ...fold,
    align: 'right',
    cell: (row) => time(of(row)),
  });
  return [
    {
      key: 'device',
      title: texts.device,
      width: 'minmax(90px, 1fr)',
      foldedWidth: 'minmax(78px, 1fr)',
      cell: (row) => <span class="text">{row.device}</span>,
    },
    {
      key: 'request',
      title: texts.request,
      width: 'minmax(150px, 1.4fr)',
      foldedWidth: 'minmax(80px, 1.4fr)',
      cell: (row) => <span class="text">{name(row)}</span>,
    },
    count('sent', false, '96px', { foldedWidth: '72px' }),
    count('answered', false, '88px', HIDDEN),
    count('timeouts', true, '90px', FIGURE),
    count('faults', true, '70px', FIGURE),
    count('exceptions', true, '98px', FIGURE),
    us('mean', texts.mean, (row) => row.mean_us, HIDDEN),
    us('p50', 'p50', (row) => row.p50_us, HIDDEN),
    us('p99', 'p99', (row) => row.p99_us, { foldedWidth: '66px' }),
    us('longest', texts.longest, (row) => row.longest_us, { foldedWidth: '76px' }),
    us('planned', texts.planned, (row) => row.planned_us, HIDDEN),
    {
      key: 'period',
      title: texts.period,
      width: '140px',
      folds: 'text',
      align: 'right',
      cell: (row) =>
        row.period_ms === null ? '–' : `${duration(row.period_ms)} → ${duration(row.real_period_ms)}`,
    },
  ];
}

const PARTS: LinePart[] = ['wire', 'turnaround', 'host'];

/** Where the time of a line goes. */
function Parts({ line }: { line: LineRequests }) {
  const texts = t.value.traffic;
  return (
    <section class="times">
      <h3>{`${texts.parts.title}: ${line.name}`}</h3>
      <div class="parts">
        {PARTS.map((part) => {
          const times = line.times[part];
          return (
            times && (
              <div key={part}>
                <h4>{texts.parts[part]}</h4>
                <p class="muted small">
                  {[
                    `p50 ${time(times.p50_us)}`,
                    `p99 ${time(times.p99_us)}`,
                    `${texts.columns.longest} ${time(times.longest_us)}`,
                  ].join(' · ')}
                </p>
                <Histogram label={texts.parts[part]} times={times} />
              </div>
            )
          );
        })}
      </div>
    </section>
  );
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
  // At first one whose times are known.
  const request =
    rows.find((its) => its.key === chosen.value) ?? rows.find((its) => its.histogram.length > 0);
  const line = lines.value.find((its) => its.name === request?.line);
  return (
    <>
      <p class="loads">
        {lines.value.map((line) => (
          <span key={line.name}>
            <b>{line.name}</b>: {texts.lineBusy} {percent(line.utilization)}, {texts.cycle}{' '}
            {time(line.measured_cycle_us)} <span class="muted">({texts.plannedBy(time(line.cycle_us))})</span>
          </span>
        ))}
      </p>
      <Grid
        label={texts.requests}
        columns={columns()}
        rows={rows}
        rowKey={(row) => row.key}
        rowClass={(row) => (row.key === request?.key ? 'selected' : '')}
        onCurrent={({ row }) => {
          chosen.value = rows[row]?.key ?? '';
        }}
      />
      <section class="times">
        <h3>{request ? `${texts.histogram}: ${request.device} ${name(request)}` : texts.histogram}</h3>
        {request && request.histogram.length > 0 && (
          <p class="muted small">
            {[
              `${texts.columns.answered} ${formatNumber(request.answered)}`,
              `p50 ${time(request.p50_us)}`,
              `p99 ${time(request.p99_us)}`,
              `${texts.columns.longest} ${time(request.longest_us)}`,
              `${texts.columns.planned} ${time(request.planned_us)}`,
            ].join(' · ')}
          </p>
        )}
        {request && (request.longer_than_proved > 0 || request.late_refreshes > 0) && (
          <p class="bad small">{texts.broken(request.longer_than_proved, request.late_refreshes)}</p>
        )}
        {request ? (
          <Histogram label={texts.histogram} times={request} />
        ) : (
          <p class="muted">{texts.choose}</p>
        )}
      </section>
      {line && <Parts line={line} />}
    </>
  );
}
