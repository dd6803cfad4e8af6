import type { Translated } from '..';
import type { requests as source } from '../en/requests';

export const requests: Translated<typeof source> = {
  title: 'Запросы',
};
