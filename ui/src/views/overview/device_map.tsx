// All devices, coloured by state: by name where they are few, else as cells.
import { useRef, useState } from 'preact/hooks';
import type { DeviceStatus, LineStatus } from '../../api/types';
import { t } from '../../i18n';
import { status } from '../../store/info';
import { deviceState, type Tone } from '../devices/state';

const MOST_NAMES = 30;
/** Colours are not the only mark of a state. */
const SIGNS = { good: '', warn: '!', bad: '×', '': '' } as const;

export interface MappedDevice {
  line: string;
  device: DeviceStatus;
  tone: Tone;
  text: string;
}

export const mapped = (lines: LineStatus[]): MappedDevice[] =>
  lines.flatMap((line) =>
    line.devices.map((device) => ({ line: line.name, device, ...deviceState(line.name, device) })),
  );

/** "answering: 297", one for each state; the worst first. */
export function counted(devices: MappedDevice[]): { tone: Tone; text: string; count: number }[] {
  const counts = new Map<string, { tone: Tone; text: string; count: number }>();
  for (const { tone, text } of devices) {
    const known = counts.get(text);
    if (known) ++known.count;
    else counts.set(text, { tone, text, count: 1 });
  }
  const order = ['bad', 'warn', '', 'good'];
  return [...counts.values()].sort((a, b) => order.indexOf(a.tone) - order.indexOf(b.tone));
}

const STEPS: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1 };

export function DeviceMap() {
  const its = status.value;
  const list = useRef<HTMLUListElement>(null);
  const [current, setCurrent] = useState(0);
  const devices = mapped(its?.lines ?? []);
  const names = devices.length <= MOST_NAMES;
  // The cells are one stop of the Tab key.
  const onKeyDown = (event: KeyboardEvent) => {
    const links = list.current?.querySelectorAll<HTMLElement>('a');
    const to =
      event.key === 'Home' ? 0 : event.key === 'End' ? devices.length - 1 : current + (STEPS[event.key] ?? 0);
    if (to === current || !links?.[to]) return;
    event.preventDefault();
    setCurrent(to);
    links[to].focus();
  };
  return (
    <ul
      ref={list}
      class={`devices-map ${names ? 'names' : ''}`}
      onKeyDown={names ? undefined : onKeyDown}
      aria-label={t.value.devices.title}
    >
      {devices.map(({ line, device, tone, text }, index) => {
        const words = `${device.name}: ${text}`;
        const where = new URLSearchParams({ line, device: device.name });
        return (
          <li key={`${line}/${device.name}`}>
            <a
              href={`#/devices?${where}`}
              class={tone}
              title={words}
              aria-label={words}
              tabIndex={names || index === current ? 0 : -1}
              onFocus={() => setCurrent(index)}
            >
              {names ? (
                <>
                  <i class={`dot ${tone}`} />
                  <span>{device.name}</span>
                </>
              ) : (
                SIGNS[tone]
              )}
            </a>
          </li>
        );
      })}
    </ul>
  );
}
