import type { Translated } from '..';
import type { trends as source } from '../en/trends';

export const trends: Translated<typeof source> = {
  title: 'Графики',
};
