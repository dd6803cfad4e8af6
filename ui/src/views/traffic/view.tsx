import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { openUrl } from '../../api/client';
import { formatClock, t } from '../../i18n';
import { status } from '../../store/info';
import { type Column, Grid } from '../../widgets/grid';
import { Icon } from '../../widgets/icon';
import * as frames from './frames';
import { Requests } from './requests';
import { frameWords } from './words';
import '../../style/traffic.css';

/** No frame comes through a line without a connection: that line's problem. */
const noFrames = () =>
  status.value?.problems.find((its) => its.line && !its.device && its.severity === 'error')?.text ??
  t.value.traffic.waiting;

const TABS = ['frames', 'requests'] as const;
const tab = signal<(typeof TABS)[number]>('frames');

function columns(): Column<frames.NumberedFrame>[] {
  const texts = t.value.traffic;
  return [
    {
      key: 'time',
      title: texts.columns.time,
      width: '108px',
      cell: (its) => <time class="mono">{formatClock(its.t, true)}</time>,
    },
    {
      key: 'direction',
      title: texts.columns.direction,
      width: '58px',
      foldedWidth: '48px',
      cell: (its) =>
        its.direction && (
          <span class={`direction ${its.direction}`} title={texts[its.direction]}>
            {its.direction === 'tx' ? '→' : '←'}
            <span class="visually-hidden">{texts[its.direction]}</span>
          </span>
        ),
    },
    {
      key: 'device',
      title: texts.columns.device,
      width: '140px',
      foldedWidth: 'minmax(90px, 1fr)',
      cell: (its) => <span class="text">{its.device ?? its.line}</span>,
    },
    { key: 'unit', title: texts.columns.unit, width: '72px', align: 'right', cell: (its) => its.unit || '' },
    {
      key: 'words',
      title: texts.columns.words,
      width: 'minmax(330px, 1fr)',
      folds: 'text',
      wraps: true,
      cell: (its) => (
        <span class={`text ${frames.isError(its) ? 'bad' : ''}`} title={frameWords(its)}>
          {frameWords(its)}
        </span>
      ),
    },
    {
      key: 'raw',
      title: texts.columns.raw,
      width: '204px',
      folds: 'hidden',
      cell: (its) => its.raw && <code title={its.raw}>{its.raw}</code>,
    },
  ];
}

function Frames() {
  const texts = t.value.traffic;
  useEffect(() => {
    const stream = frames.openFrames();
    return () => stream.close();
  }, []);
  return (
    <>
      <div class="tools">
        <button type="button" class="button" aria-pressed={frames.paused.value} onClick={frames.togglePause}>
          <Icon name={frames.paused.value ? 'play' : 'pause'} />
          {frames.paused.value ? texts.resume : texts.pause}
        </button>
        <button type="button" class="button" onClick={frames.clearFrames}>
          {texts.clear}
        </button>
        <a class="button" href={openUrl('traffic/capture')} download>
          <Icon name="download" />
          {texts.download}
        </a>
        <select
          aria-label={texts.columns.device}
          value={frames.device.value}
          onChange={(event) => {
            frames.device.value = event.currentTarget.value;
          }}
        >
          <option value="">{texts.allDevices}</option>
          {frames.devices.value.map((name) => (
            <option key={name} value={name}>
              {name}
            </option>
          ))}
        </select>
        <select
          aria-label={texts.allFunctions}
          value={frames.functionCode.value}
          onChange={(event) => {
            frames.functionCode.value = event.currentTarget.value;
          }}
        >
          <option value="">{texts.allFunctions}</option>
          {frames.functionCodes.value.map((code) => (
            <option key={code} value={String(code)}>
              {texts.functionName(`0x${code.toString(16).toUpperCase().padStart(2, '0')}`)}
            </option>
          ))}
        </select>
        <label class="check">
          <input
            type="checkbox"
            checked={frames.errorsOnly.value}
            onChange={(event) => {
              frames.errorsOnly.value = event.currentTarget.checked;
            }}
          />
          {texts.errorsOnly}
        </label>
        <input
          type="search"
          placeholder={texts.filter}
          aria-label={texts.filter}
          value={frames.text.value}
          onInput={(event) => {
            frames.text.value = event.currentTarget.value;
          }}
        />
        <span class="muted small">{texts.shown(frames.shownFrames.value.length)}</span>
        {frames.missed.value > 0 && <span class="small bad">{texts.missed(frames.missed.value)}</span>}
      </div>
      <Grid
        label={texts.frames}
        columns={columns()}
        rows={frames.shownFrames.value}
        rowKey={(its) => its.number}
        empty={noFrames()}
      />
    </>
  );
}

export function TrafficView() {
  const texts = t.value.traffic;
  return (
    <section class="panel traffic">
      <div class="tabs" role="tablist" aria-label={texts.title}>
        {TABS.map((name) => (
          <button
            key={name}
            type="button"
            role="tab"
            id={`traffic-${name}`}
            aria-selected={tab.value === name}
            aria-controls="traffic-panel"
            onClick={() => {
              tab.value = name;
            }}
          >
            {texts[name]}
          </button>
        ))}
      </div>
      <div class="body" id="traffic-panel" role="tabpanel" aria-labelledby={`traffic-${tab.value}`}>
        {tab.value === 'frames' ? <Frames /> : <Requests />}
      </div>
    </section>
  );
}
