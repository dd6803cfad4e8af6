// The order of bytes on the wire. Bytes are numbered from the least significant one, as in the IDE. Pure.
import type { Mapping } from '../../api/types';
import { isYes } from './cells';

export interface ByteOrder {
  highByteFirst: boolean;
  highRegisterFirst: boolean;
}

export const ORDERS: ByteOrder[] = [
  { highByteFirst: true, highRegisterFirst: false },
  { highByteFirst: true, highRegisterFirst: true },
  { highByteFirst: false, highRegisterFirst: false },
  { highByteFirst: false, highRegisterFirst: true },
];

/** "2143": the bytes of a value in the order of the wire. */
export function permutation(order: ByteOrder, registers = 2): string {
  const places = [...Array(registers).keys()];
  if (order.highRegisterFirst) places.reverse();
  return places
    .flatMap((place) => {
      const [low, high] = [2 * place + 1, 2 * place + 2];
      return order.highByteFirst ? [high, low] : [low, high];
    })
    .join('');
}
/** "2 1 4 3", as the IDE shows it. */
export const spaced = (digits: string) => [...digits].join(' ');

const LETTERS: Record<string, string> = { ABCD: '4321', CDAB: '2143', BADC: '3412', DCBA: '1234' };
/** The order that a `byte_order` names: "2143", "2 1 4 3", "Float: 2 1 4 3", "CDAB"; undefined: none. */
export function orderOf(text: string): ByteOrder | undefined {
  const plain = text.replace(/^.*:/, '').replace(/\s/g, '').toUpperCase();
  const digits = LETTERS[plain] ?? plain;
  return ORDERS.find((order) => permutation(order) === digits || permutation(order, 4) === digits);
}

/** The order that an object has; what it leaves open comes from the default. */
export function effectiveOrder(node: Mapping, inherited: ByteOrder): ByteOrder {
  const named = typeof node.byte_order === 'string' ? orderOf(node.byte_order) : undefined;
  if (named) return named;
  const flag = (key: string, otherwise: boolean) =>
    typeof node[key] === 'string' ? isYes(node[key] as string) : otherwise;
  return {
    highByteFirst: flag('high_byte_first', inherited.highByteFirst),
    highRegisterFirst: flag('high_register_first', inherited.highRegisterFirst),
  };
}
export const DEFAULT_ORDER: ByteOrder = { highByteFirst: true, highRegisterFirst: false };

export interface Decoded {
  order: ByteOrder;
  digits: string;
  float: number;
  int32: number;
  uint32: number;
}

/** The same four bytes of the wire in every order. */
export function decodeAll(wire: number[]): Decoded[] {
  return ORDERS.map((order) => {
    const digits = permutation(order);
    const view = new DataView(new ArrayBuffer(4));
    for (const [i, digit] of [...digits].entries()) view.setUint8(4 - Number(digit), wire[i] ?? 0);
    return { order, digits, float: view.getFloat32(0), int32: view.getInt32(0), uint32: view.getUint32(0) };
  });
}

/** The bytes of "00 00 3F 80"; undefined where they are not four. */
export function parseBytes(text: string): number[] | undefined {
  const plain = text.replace(/0x/gi, '').replace(/[\s,.:-]/g, '');
  if (!/^[0-9a-f]{8}$/i.test(plain)) return undefined;
  return plain.match(/../g)!.map((pair) => Number.parseInt(pair, 16));
}

/** A float for people: as many digits as it has. */
export function floatText(value: number): string {
  if (!Number.isFinite(value)) return String(value);
  return String(Number(value.toPrecision(7)));
}
