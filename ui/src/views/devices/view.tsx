// Lines and devices: state, counters, what was learnt and measured; outputs.
import { computed, effect, signal } from '@preact/signals';
import type { DeviceStatus, LineStatus } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { narrow } from '../../shell/narrow';
import { query, view } from '../../shell/route';
import { status } from '../../store/info';
import { type Column, Grid } from '../../widgets/grid';
import { Details } from './details';
import { OutputList } from './outputs';
import { SearchPanel } from './search';
import { deviceState } from './state';
import { TryNow } from './try_now';
import '../../style/devices.css';

/** Line and device, as "line/device". */
const chosen = signal('');

// A link to a device chooses it.
effect(() => {
  const device = query.value.get('device');
  if (view.value === 'devices' && device) chosen.value = `${query.value.get('line') ?? ''}/${device}`;
});

const current = computed(() => {
  for (const line of status.value?.lines ?? [])
    for (const device of line.devices)
      if (chosen.value === `${line.name}/${device.name}`) return { line, device };
  return null;
});

/** On a narrow screen: three lines for each device. The address is in its details. */
const NARROW: Record<string, Partial<Column<DeviceStatus>> | null> = {
  device: { width: 'minmax(92px, 1fr)' },
  address: null,
  state: { width: 'minmax(126px, 1.4fr)', foldedWidth: 'minmax(126px, 1.4fr)' },
  values: { folds: 'text' },
  response: { width: '68px' },
  sent: { width: '82px', foldedWidth: '82px' },
  failed: { folds: 'figure' },
  exceptions: { folds: 'figure' },
  late_answers: { folds: 'figure', line: 3 },
  available: { line: 3 },
};

function shownColumns(line: LineStatus): Column<DeviceStatus>[] {
  if (!narrow.value) return columns(line);
  return columns(line).flatMap((its) => (NARROW[its.key] === null ? [] : [{ ...its, ...NARROW[its.key] }]));
}

function columns(line: LineStatus): Column<DeviceStatus>[] {
  const texts = t.value.devices.columns;
  const number = (key: 'sent' | 'failed' | 'exceptions' | 'late_answers', title: string, bad: boolean) => ({
    key,
    title,
    width: '98px',
    foldedWidth: '80px',
    align: 'right' as const,
    ...(key === 'late_answers' && { folds: 'figure' as const }),
    cell: (its: DeviceStatus) => (
      <span class={bad && its[key] > 0 ? 'warn' : ''}>{formatNumber(its[key])}</span>
    ),
  });
  return [
    {
      key: 'device',
      title: texts.device,
      width: 'minmax(100px, 1fr)',
      cell: (its) => <b class="text">{its.name}</b>,
    },
    { key: 'address', title: texts.address, width: '64px', align: 'right', cell: (its) => its.address },
    {
      key: 'state',
      title: texts.state,
      width: 'minmax(168px, 1.2fr)',
      foldedWidth: 'minmax(214px, 1.4fr)', // a button beside the state
      cell: (its) => {
        const { tone, text } = deviceState(line.name, its);
        return (
          <>
            <i class={`dot ${tone}`} />
            <span class="text" title={text}>
              {text}
            </span>
            {!narrow.value && <TryNow line={line} device={its} />}
          </>
        );
      },
    },
    {
      key: 'values',
      title: texts.values,
      width: 'minmax(138px, 0.8fr)',
      cell: (its) => {
        const bad = its.values.bad + its.values.uncertain;
        return bad > 0 ? (
          <span class="warn">{t.value.devices.notGood(bad)}</span>
        ) : (
          t.value.devices.allGood(its.values.good)
        );
      },
    },
    {
      key: 'response',
      title: texts.response,
      width: '92px',
      align: 'right',
      cell: (its) => (its.response_ms === null ? '–' : formatDuration(its.response_ms)),
    },
    number('sent', texts.sent, false),
    number('failed', texts.failed, true),
    number('exceptions', texts.exceptions, true),
    number('late_answers', texts.late, true),
    {
      key: 'available',
      title: texts.available,
      width: '104px',
      align: 'right',
      folds: 'figure',
      cell: (its) =>
        its.availability_percent === null ? '–' : `${formatNumber(its.availability_percent, 2)} %`,
    },
  ];
}

function LinePanel({ line }: { line: LineStatus }) {
  const texts = t.value.devices;
  const word = texts.lineState[line.state as keyof typeof texts.lineState] ?? line.state;
  return (
    <section class="panel">
      <header>
        <h2>{texts.line(line.name)}</h2>
        <span>
          <i class={`dot ${line.state === 'connected' ? 'good' : 'bad'}`} /> {word}
        </span>
        <span class="muted">
          {texts.busy} {formatNumber(100 * line.load, 1)} %
        </span>
        {line.measured_cycle_ms !== null && (
          <span class="muted">
            {texts.cycle} {formatDuration(line.measured_cycle_ms)}
          </span>
        )}
        {line.availability_percent !== null && (
          <span class="muted">
            {texts.available} {formatNumber(line.availability_percent, 2)} %
          </span>
        )}
      </header>
      <Grid
        label={texts.line(line.name)}
        columns={shownColumns(line)}
        rows={line.devices}
        rowKey={(its) => its.name}
        rowClass={(its) => (chosen.value === `${line.name}/${its.name}` ? 'selected' : '')}
        onCurrent={({ row }) => {
          const its = line.devices[row];
          if (its) chosen.value = `${line.name}/${its.name}`;
        }}
      />
    </section>
  );
}

export function DevicesView() {
  const texts = t.value.devices;
  const its = status.value;
  if (!its) return <p class="muted">{t.value.shell.loading}</p>;
  return (
    <div class="devices">
      <div class="lines">
        {its.lines.map((line) => (
          <LinePanel key={line.name} line={line} />
        ))}
        <SearchPanel lines={its.lines} />
        {its.outputs.length > 0 && <OutputList outputs={its.outputs} />}
      </div>
      <aside class="panel">
        <header>
          <h2>{current.value ? current.value.device.name : texts.details}</h2>
        </header>
        {current.value ? (
          <Details line={current.value.line} device={current.value.device} />
        ) : (
          <p class="muted pad">{texts.choose}</p>
        )}
      </aside>
    </div>
  );
}
