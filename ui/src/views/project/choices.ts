// The variables that the picker offers: standard, service, network. Pure.
import type { Mapping } from '../../api/types';
import { listAt, textAt } from '../../store/document';
import { isYes, plainType } from './cells';

export type ChoiceKind = 'standard' | 'service' | 'network';
export interface Choice {
  name: string;
  type: string;
  comment: string;
  retain: boolean;
  /** The value until one is read or set; '' for none. */
  initial: string;
  used: boolean;
  /** The device of a network variable, or what a service variable is about; '' for the program. */
  group: string;
}
/** A tab of the picker. Network variables have one for each line. */
export interface ChoiceTab {
  kind: ChoiceKind;
  slot: number;
  line: string;
  choices: Choice[];
}

// docs/service-variables.md
const PROGRAM: [string, string][] = [
  ['time', 'uint32'],
  ['uptime', 'uint32'],
  ['first_cycle', 'bool'],
  ['pulse_1s', 'bool'],
  ['pulse_1min', 'bool'],
];
const LINE: [string, string][] = [
  ['up', 'bool'],
  ['load', 'float'],
  ['cycle', 'float'],
  ['requests', 'uint32'],
  ['errors', 'uint32'],
];
const DEVICE: [string, string][] = [
  ['state', 'uint16'],
  ['answering', 'bool'],
  ['response_time', 'float'],
  ['requests', 'uint32'],
  ['errors', 'uint32'],
  ['timeouts', 'uint32'],
  ['checksum_errors', 'uint32'],
  ['exceptions', 'uint32'],
  ['outages', 'uint32'],
];

/** The names of devices in service variables: with the line or the address where a name is not unique. */
function deviceNames(lines: Mapping[]): string[] {
  const all = lines.flatMap((line) =>
    listAt(line, ['devices']).map((device) => ({
      line: textAt(line, ['name']) ?? '',
      name: textAt(device, ['name']) ?? '',
      address: textAt(device, ['address']) ?? '',
    })),
  );
  const count = (fits: (its: (typeof all)[0]) => boolean) => all.filter(fits).length;
  return all.map((its) => {
    if (count((one) => one.name === its.name) === 1) return its.name;
    const onLine = count((one) => one.name === its.name && one.line === its.line);
    return `${its.line}/${onLine === 1 ? its.name : its.address}`;
  });
}

export function choicesOf(document: Mapping): ChoiceTab[] {
  const lines = listAt(document, ['lines']);
  const choice = (its: Mapping, group: string): Choice => ({
    name: textAt(its, ['name']) ?? '',
    type: plainType(textAt(its, ['type']) ?? ''),
    comment: textAt(its, ['comment']) ?? '',
    retain: isYes(textAt(its, ['retain'])),
    initial: textAt(its, ['default']) ?? '',
    used: its.used === undefined || isYes(textAt(its, ['used'])),
    group,
  });
  const service = (prefix: string, group: string, words: [string, string][]) =>
    words.map(([word, type]) => ({
      name: `system.${prefix}${word}`,
      type,
      comment: '',
      retain: false,
      initial: '',
      used: true,
      group,
    }));
  return [
    {
      kind: 'standard',
      slot: 0,
      line: '',
      choices: listAt(document, ['locals']).map((its) => choice(its, '')),
    },
    {
      kind: 'service',
      slot: 0,
      line: '',
      choices: [
        ...service('', '', PROGRAM),
        ...lines.flatMap((line) => {
          const name = textAt(line, ['name']) ?? '';
          return service(`line.${name}.`, name, LINE);
        }),
        ...deviceNames(lines).flatMap((name) => service(`device.${name}.`, name, DEVICE)),
      ],
    },
    ...lines.map((line, i) => ({
      kind: 'network' as const,
      slot: i + 1,
      line: textAt(line, ['name']) ?? '',
      choices: listAt(line, ['devices']).flatMap((device) => {
        const group = [textAt(device, ['name']), textAt(device, ['address'])].filter(Boolean).join(', ');
        return listAt(device, ['variables']).map((its) => choice(its, group));
      }),
    })),
  ];
}

export type Wanted = 'bool' | 'int' | 'any';
export function fitsType(type: string, wanted: Wanted): boolean {
  if (wanted === 'any') return true;
  return wanted === 'bool' ? type === 'bool' : /^u?int(16|32|64)$/.test(type);
}
export function searched(choices: Choice[], search: string): Choice[] {
  const text = search.trim().toLowerCase();
  if (!text) return choices;
  return choices.filter((its) => `${its.name}\n${its.comment}\n${its.group}`.toLowerCase().includes(text));
}
