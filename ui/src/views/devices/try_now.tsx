// "Try now": ends the back-off of a device that does not answer, and reports what its probe found.
import { signal } from '@preact/signals';
import { post } from '../../api/client';
import type { DeviceStatus, LineStatus } from '../../api/types';
import { formatDuration, t } from '../../i18n';
import { errorText } from '../../shell/toasts';
import { tick } from '../../store/clock';
import { mayWrite, status } from '../../store/info';

const LONGEST_MS = 20_000;

interface Attempt {
  state: 'trying' | 'answers' | 'silent' | 'open' | 'refused';
  text: string;
}
/** The last attempt of each device, by "line/device". */
const attempts = signal<Record<string, Attempt>>({});
const note = (key: string, attempt: Attempt) => {
  attempts.value = { ...attempts.peek(), [key]: attempt };
};
export const attemptOf = (key: string): Attempt | undefined => attempts.value[key];

function find(line: string, device: string): DeviceStatus | undefined {
  return status
    .peek()
    ?.lines.find((its) => its.name === line)
    ?.devices.find((its) => its.name === device);
}

/** Transactions without an answer of the device itself: a gateway answers for it with an exception. */
const ended = (its: DeviceStatus) => its.failed + its.exceptions;

/** Waits for the first status in which a transaction with the device has ended since then. */
function outcome(line: string, device: string, before: DeviceStatus): Promise<Attempt> {
  const texts = t.peek().devices.attempt;
  const begin = Date.now();
  return new Promise((done) => {
    const stop = status.subscribe(() => {
      const its = find(line, device);
      const end = (attempt: Attempt) => {
        queueMicrotask(() => stop());
        done(attempt);
      };
      if (!its) return end({ state: 'open', text: texts.open });
      if (its.state === 'answering') return end({ state: 'answers', text: texts.answers });
      if (ended(its) > ended(before))
        return end({
          state: 'silent',
          text: texts.silent(its.cause ? t.peek().devices.cause(its.cause) : ''),
        });
      if (Date.now() - begin > LONGEST_MS) end({ state: 'open', text: texts.open });
    });
  });
}

export async function tryNow(line: string, device: string): Promise<void> {
  const key = `${line}/${device}`;
  const before = find(line, device);
  if (!before || attempts.peek()[key]?.state === 'trying') return;
  note(key, { state: 'trying', text: t.peek().devices.attempt.trying });
  try {
    const answer = await post<{ outcome: string; text: string }>('devices/probe', { line, device });
    if (answer.outcome === 'done') note(key, await outcome(line, device, before));
    else note(key, { state: 'refused', text: answer.text });
  } catch (failure) {
    note(key, { state: 'refused', text: errorText(failure) });
  }
}

const DOTS = { trying: 'warn', answers: 'good', silent: 'bad', open: '', refused: 'bad' } as const;

export function TryNow({ line, device }: { line: LineStatus; device: DeviceStatus }) {
  const attempt = attemptOf(`${line.name}/${device.name}`);
  if (device.state !== 'not_answering' && attempt?.state !== 'trying') return null;
  return (
    <button
      type="button"
      class="button small"
      disabled={!mayWrite.value || attempt?.state === 'trying'}
      title={mayWrite.value ? undefined : t.value.shell.readOnlyHint}
      onClick={(event) => {
        event.stopPropagation();
        void tryNow(line.name, device.name);
      }}
    >
      {attempt?.state === 'trying' ? t.value.devices.attempt.trying : t.value.devices.tryNow}
    </button>
  );
}

export function AttemptText({ line, device }: { line: LineStatus; device: DeviceStatus }) {
  const attempt = attemptOf(`${line.name}/${device.name}`);
  if (!attempt) return null;
  return (
    <p role="status">
      <i class={`dot ${DOTS[attempt.state]}`} /> {attempt.text}
    </p>
  );
}

/** The time to the end of the back-off, which runs between two states of the program. */
export function NextProbe({ device }: { device: DeviceStatus }) {
  const texts = t.value.devices;
  const at = Date.parse(status.value?.time ?? '') + (device.back_off?.next_probe_ms ?? 0);
  const now = tick.value;
  if (!device.back_off || Number.isNaN(at) || now === null) return null;
  const left = at - now;
  return (
    <>
      {left > 0 ? texts.nextProbe(formatDuration(Math.ceil(left / 1000) * 1000)) : texts.probeDue}
      <span class="muted"> {texts.pause(formatDuration(device.back_off.pause_ms))}</span>
    </>
  );
}
