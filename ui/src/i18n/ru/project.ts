import type { Translated } from '..';
import type { project as source } from '../en/project';

export const project: Translated<typeof source> = {
  title: 'Проект',
};
