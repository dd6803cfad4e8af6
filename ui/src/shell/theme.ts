import { signal } from '@preact/signals';

export type Theme = 'light' | 'dark';
const KEY = 'takt.theme';
const system = matchMedia('(prefers-color-scheme: dark)');

function chosen(): Theme | null {
  const asked = new URL(location.href).searchParams.get('theme') ?? localStorage.getItem(KEY);
  return asked === 'light' || asked === 'dark' ? asked : null;
}

export const theme = signal<Theme>(chosen() ?? (system.matches ? 'dark' : 'light'));
system.addEventListener('change', () => {
  if (!chosen()) theme.value = system.matches ? 'dark' : 'light';
});
theme.subscribe((its) => {
  document.documentElement.dataset.theme = its;
});

export function toggleTheme(): void {
  theme.value = theme.peek() === 'dark' ? 'light' : 'dark';
  localStorage.setItem(KEY, theme.peek());
}
