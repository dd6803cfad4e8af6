// The cells of the live table. Each subscribes to what it shows: a change draws a cell, not the table.
import type { Signal } from '@preact/signals';
import type { LiveValue } from '../../api/types';
import { formatClock, formatDuration, t } from '../../i18n';
import { second, tick } from '../../store/clock';
import { recent } from '../../store/live';
import { type Format, formatValue, sparkline } from './format';
import { itemsText, wireItems } from './wire';

export type Row = Signal<LiveValue>;

export const typeClass = (type: string) =>
  type === 'bool'
    ? 'type-bool'
    : type === 'float' || type === 'double'
      ? 'type-float'
      : type === 'string'
        ? 'type-string'
        : 'type-int';

/** As received; a value keeps its last registers when its device stops answering. */
function WireCell({ name }: { name: string }) {
  const texts = t.value.live.wire;
  const its = wireItems.value.get(name);
  if (!its?.items) return <span class="muted">{texts.waiting}</span>;
  const title = texts.from(
    `0x${(its.function ?? 0).toString(16).toUpperCase().padStart(2, '0')}`,
    String(its.start),
    String(its.quantity),
    formatClock(its.received_at ?? 0, true),
  );
  return (
    <span class="value mono" title={title}>
      {itemsText(its)}
    </span>
  );
}

export function ValueCell({ row, format }: { row: Row; format: Format }) {
  const its = row.value;
  if (format === 'registers' && its.line !== undefined) return <WireCell name={its.name} />;
  if (its.value === null) return <span class="muted">–</span>;
  const text =
    its.type === 'bool' && format === 'normal' && !its.words
      ? t.value.live.boolean[its.value ? 'on' : 'off']
      : (format === 'normal' && its.words) || formatValue(its, format);
  const stale = its.quality === 'good' ? '' : 'stale';
  return (
    <span class={`value ${typeClass(its.type)} ${stale} ${format === 'normal' ? '' : 'mono'}`} title={text}>
      {text}
    </span>
  );
}

const DOTS = { good: 'good', uncertain: 'warn', bad: 'bad', never_read: '' } as const;

export function QualityCell({ row }: { row: Row }) {
  const { quality, reason, cause } = row.value;
  const word = t.value.quality[quality];
  const words = [reason, cause].filter((its): its is string => Boolean(its)).map(t.value.devices.cause);
  // In a narrow table the dot says that the value is bad, and there is space for the last reason only.
  return (
    <>
      <span class="quality" title={words.join(', ') || word}>
        <i class={`dot ${DOTS[quality]}`} /> <span class="word">{word}</span>
        {words.length > 0 && (
          <span class="muted">
            {words.length > 1 && <span class="first">{words[0]}, </span>}
            {words.at(-1)}
          </span>
        )}
      </span>
      <span class="folded-age">
        <AgeCell row={row} />
      </span>
    </>
  );
}

export function AgeCell({ row }: { row: Row }) {
  const { sampled_at, proved_age_ms, local, quality } = row.value;
  const now = tick.value;
  // A good read in the future means that the program's clock was set: the next exchange corrects it.
  if (sampled_at === null || local || now === null || sampled_at > now) return <span class="muted">–</span>;
  const age = now - sampled_at;
  // The program judges the age: a value that is older than proved is not good any more.
  const late = quality !== 'good' && typeof proved_age_ms === 'number' && age > proved_age_ms;
  return <span class={late ? 'late' : ''}>{formatDuration(age)}</span>;
}

const WIDTH = 110;
const HEIGHT = 20;

export function SparkCell({ row }: { row: Row }) {
  const now = second.value;
  const path = sparkline(recent.get(row.peek().name) ?? [], WIDTH, HEIGHT, now);
  return (
    <svg class="spark" width={WIDTH} height={HEIGHT} viewBox={`0 0 ${WIDTH} ${HEIGHT}`} aria-hidden="true">
      {path && <path d={path} />}
    </svg>
  );
}
