// A bool of coils or discrete inputs with a register and no bit: `register: 17` is coil 272, bit 0 of that
// register, but tables of other tools mean coil 17. Pure.
import type { Mapping } from '../../api/types';
import { plainType } from './cells';
import { numberOf } from './rows';

/** What the register of such rows means: the coil of that number, or bit 0 of that register. */
export type CoilChoice = 'coil' | 'bit';

const BITS_OF_REGISTER = 16;
const BIT_FUNCTIONS = new Set([0x01, 0x02, 0x05, 0x0f]);

function isOfBits(row: Mapping): boolean {
  if (row.area !== undefined) return row.area === 'coil' || row.area === 'discrete_input';
  const functions = [row.read, row.write].map(numberOf).filter((its) => its !== null);
  return functions.length > 0 && BIT_FUNCTIONS.has(functions[0]!);
}

const isOpen = (row: Mapping) =>
  plainType(String(row.type ?? '')) === 'bool' &&
  [row.bit, row.coil, row.reference].every((its) => its === undefined || its === '') &&
  (numberOf(row.register) ?? 0) > 0 &&
  isOfBits(row);

/** The rows of a list that leave open which coil they mean, and did not do so before a paste. */
export function openRows(list: Mapping[], before: Mapping[]): Mapping[] {
  const registers = new Map(before.filter(isOpen).map((row) => [row.name, row.register]));
  return list.filter((row) => isOpen(row) && registers.get(row.name) !== row.register);
}

/** The coils that a register can mean. */
export const coilsOf = (row: Mapping): Record<CoilChoice, number> => {
  const register = numberOf(row.register) ?? 0;
  return { coil: register, bit: register * BITS_OF_REGISTER };
};

/** The list with that meaning written in the given rows of it. */
export function withChoice(list: Mapping[], open: Mapping[], choice: CoilChoice): Mapping[] {
  const rows = new Set(open);
  return list.map((row) => {
    if (!rows.has(row)) return row;
    if (choice === 'bit') return { ...row, bit: '0' };
    const { register, ...rest } = row;
    return { ...rest, coil: register! };
  });
}
