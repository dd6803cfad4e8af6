// Icons on a grid of 16 by 16, drawn with lines.
const PATHS = {
  overview: 'M2 2h5v7H2zM9 2h5v4H9zM9 8h5v6H9zM2 11h5v3H2z',
  project: 'M2 3h5v4H2zM9 9h5v4H9zM4.5 7v4H9',
  live: 'M1 8h3l2-5 4 10 2-5h3',
  trends: 'M2 2v12h12M4 10l3-4 3 3 4-6',
  traffic: 'M2 5h10l-3-3M14 11H4l3 3',
  devices: 'M3 3h10v7H3zM6 13h4M8 10v3',
  close: 'M4 4l8 8M12 4l-8 8',
  undo: 'M5 3L2 6l3 3M2 6h7a4 4 0 010 8H6',
  redo: 'M11 3l3 3-3 3M14 6H7a4 4 0 000 8h3',
  add: 'M8 3v10M3 8h10',
  remove: 'M3 8h10',
  copy: 'M5 5V2h9v9h-3M2 5h9v9H2z',
  delete: 'M3 4h10M6 4V2h4v2M4 4l1 10h6l1-10',
  search: 'M7 2a5 5 0 100 10A5 5 0 007 2zM11 11l3 3',
  up: 'M4 10l4-4 4 4',
  down: 'M4 6l4 4 4-4',
  right: 'M6 4l4 4-4 4',
  pause: 'M5 3v10M11 3v10',
  play: 'M5 3l8 5-8 5z',
  download: 'M8 2v8M4 7l4 4 4-4M2 14h12',
  link: 'M7 9a3 3 0 004 0l2-2a3 3 0 00-4-4L8 4M9 7a3 3 0 00-4 0L3 9a3 3 0 004 4l1-1',
  write: 'M3 13l1-4 7-7 3 3-7 7zM9 4l3 3',
  why: 'M8 14A6 6 0 108 2a6 6 0 000 12zM6.3 6.2a1.8 1.8 0 113 1.3c-.8.6-1.3.9-1.3 1.8M8 11.6v.1',
  theme: 'M8 2v12a6 6 0 000-12zM8 14A6 6 0 018 2',
  refresh: 'M13 5a6 6 0 10.5 5M13 2v3h-3',
  paste: 'M5 3H3v11h10V3h-2M5 2h6v3H5z',
  fill: 'M8 2v9M4 8l4 4 4-4M3 14h10',
  more: 'M3 8h.1M8 8h.1M13 8h.1',
  check: 'M3 8l4 4 7-8',
} as const;
export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg
      width="16"
      height="16"
      viewBox="0 0 16 16"
      fill="none"
      stroke="currentColor"
      stroke-width="1.5"
      stroke-linecap="round"
      stroke-linejoin="round"
      aria-hidden="true"
    >
      <path d={PATHS[name]} />
    </svg>
  );
}
