// The texts of the page. English defines the keys; the other languages have the same keys by type, so a
// missing translation does not compile. Texts that depend on numbers are functions.
import { computed, signal } from '@preact/signals';
import { en } from './en';
import { ru } from './ru';
import { uk } from './uk';

/** The same keys with any text. */
export type Translated<T> = {
  [K in keyof T]: T[K] extends string
    ? string
    : T[K] extends (...args: infer A) => string
      ? (...args: A) => string
      : Translated<T[K]>;
};
export type Texts = Translated<typeof en>;
export type Language = 'en' | 'ru' | 'uk';

export const LANGUAGES: { code: Language; name: string }[] = [
  { code: 'en', name: 'English' },
  { code: 'ru', name: 'Русский' },
  { code: 'uk', name: 'Українська' },
];

const KEY = 'takt.language';
const texts: Record<Language, Texts> = { en, ru, uk };

function preferred(): Language {
  const known = (code: string | null): code is Language => LANGUAGES.some((its) => its.code === code);
  const asked = new URL(location.href).searchParams.get('lang');
  if (known(asked)) return asked;
  const kept = localStorage.getItem(KEY);
  if (known(kept)) return kept;
  return navigator.languages.map((tag) => tag.slice(0, 2)).find(known) ?? 'en';
}

export const language = signal<Language>(preferred());
/** The texts of the current language. Components that read it are drawn again when it changes. */
export const t = computed<Texts>(() => texts[language.value]);

export function setLanguage(code: Language): void {
  localStorage.setItem(KEY, code);
  language.value = code;
  document.documentElement.lang = code;
}

const plurals = {
  ru: new Intl.PluralRules('ru'),
  uk: new Intl.PluralRules('uk'),
};
/** The form for a number: one (1, 21), few (2..4, 22), many (5, 11). */
export function slavic(code: 'ru' | 'uk', n: number, one: string, few: string, many: string): string {
  const rule = plurals[code].select(n);
  return rule === 'one' ? one : rule === 'few' ? few : many;
}

/** As the program, its messages and the file write numbers, in each language: 1234567.8 */
export const formatNumber = (value: number, digits = 0): string => String(Number(value.toFixed(digits)));

/** Milliseconds with the unit that people would choose. */
export function formatDuration(ms: number): string {
  const u = t.value.units;
  if (ms < 1) return `${formatNumber(ms, 3)} ${u.ms}`;
  if (ms < 1000) return `${formatNumber(ms, ms < 100 ? 1 : 0)} ${u.ms}`;
  if (ms < 60_000) return `${formatNumber(ms / 1000, 1)} ${u.s}`;
  const parts = (whole: number, large: string, rest: number, small: string) =>
    `${whole} ${large}${rest > 0 ? ` ${rest} ${small}` : ''}`;
  if (ms < 3_600_000) return parts(Math.floor(ms / 60_000), u.min, Math.floor((ms % 60_000) / 1000), u.s);
  return parts(Math.floor(ms / 3_600_000), u.h, Math.floor((ms % 3_600_000) / 60_000), u.min);
}
/** Texts of the program have the units of its tables: "12.6 ms" in each language. */
export const withUnits = (text: string): string =>
  text.replace(/(\d) (ms|s|min|h)(?!\w)/g, (_, digit: string, unit: 'ms' | 's' | 'min' | 'h') => {
    return `${digit} ${t.value.units[unit]}`;
  });
export function formatClock(ms: number, millis = false): string {
  const date = new Date(ms);
  const base = date.toLocaleTimeString(language.value, { hour12: false });
  return millis ? `${base}.${String(date.getMilliseconds()).padStart(3, '0')}` : base;
}
/** Day and time, the month as a word: the order of its numbers differs between countries. */
export const formatDate = (time: number | string): string =>
  new Date(time).toLocaleString(language.value, { dateStyle: 'medium', timeStyle: 'medium', hour12: false });
