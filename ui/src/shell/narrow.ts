import { signal } from '@preact/signals';

const query = matchMedia('(max-width: 1400px)');
/** There is space for a few columns only. */
export const narrow = signal(query.matches);
query.addEventListener('change', () => {
  narrow.value = query.matches;
});
