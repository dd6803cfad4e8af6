import { of } from './plural';

export const overview = {
  empty: 'The project has no device yet. Search for devices, paste a table, or begin with the example:',
  noDevice: 'No device yet',
  lines: 'Load of the lines',
  now: (load: string) => `now ${load}`,
  planned: (load: string) => `planned ${load}`,
  moreLines: (n: number) => `and ${of(n, 'more line')}`,
  ages: 'Ages and their proof, with failures',
  agesHint:
    'Of each device the value whose proved age leaves the least time before its deadline. ' +
    'The bar is full where the value is as old as proved; red: older. ' +
    'The proof of the running project includes the failures that it assumes, and one device that fails.',
  noAges: 'No age is proved: no value is read by period, or the turnaround of a device is not known.',
  problems: 'What is wrong',
};
