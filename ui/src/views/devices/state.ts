// The state of a device in words and as a colour.
import { computed } from '@preact/signals';
import type { DeviceStatus } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { status } from '../../store/info';

export type Tone = 'good' | 'warn' | 'bad' | '';

const TONES = {
  unknown: '',
  answering: 'good',
  not_answering: 'bad',
  switched_off: '',
  link_down: 'bad',
} as const;

/** A device whose responses are damaged, late or do not fit is not called silent. */
function stateText({ state, cause }: DeviceStatus): string {
  if (state === 'not_answering' && cause === 'bad_checksum') return t.value.state.damaged;
  if (state === 'not_answering' && cause === 'unexpected_reply') return t.value.state.unfitting;
  if (state === 'not_answering' && cause === 'late') return t.value.state.late;
  return t.value.state[state];
}

/** Devices with findings, as "line/device". */
const found = computed(
  () =>
    new Set(
      status.value?.problems
        .filter((its) => its.severity !== 'note')
        .map((its) => `${its.line}/${its.device}`),
    ),
);

/** A device that answers, and has findings or values that are not good, is no good one. */
export function deviceState(line: string, device: DeviceStatus): { tone: Tone; text: string } {
  if (device.broadcast && (device.state === 'answering' || device.state === 'unknown'))
    return { tone: '', text: t.value.state.broadcast };
  const troubled =
    device.values.bad + device.values.uncertain > 0 || found.value.has(`${line}/${device.name}`);
  if (device.fails_often || (device.state === 'answering' && troubled))
    return { tone: 'warn', text: t.value.state.troubled };
  return { tone: TONES[device.state], text: stateText(device) };
}

/** "longest 12 ms, 99.9 % within 9 ms, over 1,200 exchanges" */
export const measuredText = (its: NonNullable<DeviceStatus['turnaround']>): string =>
  t.value.devices.measuredText(
    formatDuration(its.longest_ms),
    its.p999_ms === null ? null : formatDuration(its.p999_ms),
    formatNumber(its.exchanges),
  );
