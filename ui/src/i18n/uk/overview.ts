import type { Translated } from '..';
import { slavic } from '..';
import type { overview as source } from '../en/overview';

export const overview: Translated<typeof source> = {
  empty: 'У проєкті поки немає пристроїв.',
  lines: 'Завантаження ліній',
  planned: (load) => `за розрахунком ${load}`,
  moreLines: (n) => `і ще ${n} ${slavic('uk', n, 'лінія', 'лінії', 'ліній')}`,
  ages: 'Вік і доведена межа',
  agesHint:
    'Для кожного пристрою — значення, доведений вік якого найближчий до строку. ' +
    'Смуга заповнена, коли вік значення дорівнює доведеному; червона — старше.',
  noAges: 'Доведених віків немає: нічого не читається з періодом, або час відповіді пристрою невідомий.',
  problems: 'Що не гаразд',
};
