import type { Translated } from '..';
import type { devices as source } from '../en/devices';

export const devices: Translated<typeof source> = {
  title: 'Пристрої',
};
