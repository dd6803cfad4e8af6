// All devices, coloured by state: by name where they are few, else as cells.
import { useRef, useState } from 'preact/hooks';
import type { DeviceStatus, LineStatus, Problem } from '../../api/types';
import { t } from '../../i18n';
import { status } from '../../store/info';
import { stateText } from '../devices/state';
import { DEVICE_DOTS } from '../devices/view';

const MOST_NAMES = 30;
/** Colours are not the only mark of a state. */
const SIGNS = { good: '', warn: '!', bad: '×', '': '' } as const;

export interface MappedDevice {
  line: string;
  device: DeviceStatus;
  tone: keyof typeof SIGNS;
}

/** A device that answers, and has findings or values that are not good, is no good one. */
export function mapped(lines: LineStatus[], problems: Problem[]): MappedDevice[] {
  const found = new Set(
    problems.filter((its) => its.severity !== 'note').map((its) => `${its.line}/${its.device}`),
  );
  return lines.flatMap((line) =>
    line.devices.map((device) => {
      const troubled =
        device.values.bad + device.values.uncertain > 0 || found.has(`${line.name}/${device.name}`);
      const dot = DEVICE_DOTS[device.state];
      return { line: line.name, device, tone: dot === 'good' && troubled ? 'warn' : dot };
    }),
  );
}

/** "answering: 297", one for each state and colour; the worst first. */
export function counted(devices: MappedDevice[]): { tone: string; text: string; count: number }[] {
  const counts = new Map<string, { tone: string; text: string; count: number }>();
  const { answeringWithFindings } = t.value.overview;
  for (const { device, tone } of devices) {
    const text = device.state === 'answering' && tone === 'warn' ? answeringWithFindings : stateText(device);
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
  const devices = mapped(its?.lines ?? [], its?.problems ?? []);
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
      {devices.map(({ line, device, tone }, index) => {
        const words = `${device.name}: ${stateText(device)}`;
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
