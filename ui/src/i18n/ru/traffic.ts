import type { Translated } from '..';
import type { traffic as source } from '../en/traffic';

export const traffic: Translated<typeof source> = {
  title: 'Обмен',
};
