import type { Translated } from '..';
import { slavic } from '..';
import type { overview as source } from '../en/overview';

export const overview: Translated<typeof source> = {
  empty: 'В проекте пока нет устройств.',
  lines: 'Загрузка линий',
  planned: (load) => `по расчёту ${load}`,
  moreLines: (n) => `и ещё ${n} ${slavic('ru', n, 'линия', 'линии', 'линий')}`,
  ages: 'Возраст и доказанный предел',
  agesHint:
    'Для каждого устройства — значение, доказанный возраст которого ближе всего к сроку. ' +
    'Полоса заполнена, когда возраст значения равен доказанному; красная — старше.',
  noAges: 'Доказанных возрастов нет: ничего не читается с периодом, или время ответа устройства неизвестно.',
  problems: 'Что не в порядке',
};
