import type { Translated } from '..';
import type { live as source } from '../en/live';

export const live: Translated<typeof source> = {
  title: 'Значення',
};
