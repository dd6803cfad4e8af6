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

/** Nanoseconds as a number of units with that many decimals; halves are rounded up. */
const decimal = (ns: number, unit: number, digits: number) =>
  (Math.floor((ns * 10 ** digits + unit / 2) / unit) / 10 ** digits).toFixed(digits);

/** Milliseconds with their unit, as the program writes them (src/text/duration.cpp). */
export function formatDuration(ms: number): string {
  const u = t.value.units;
  const ns = Math.round(ms * 1e6);
  const digits = (unit: number, name: string) =>
    `${decimal(ns, unit, [0.9995, 9.995, 99.95].filter((its) => ns < unit * its).length)} ${name}`;
  const parts = (whole: number, large: string, rest: number, small: string) =>
    `${whole} ${large}${rest > 0 ? ` ${rest} ${small}` : ''}`;
  if (ns < 0) return `-${formatDuration(-ms)}`;
  if (ns === 0) return `0 ${u.ms}`;
  if (ns < 1e5) return digits(1e3, u.us);
  const seconds = Math.floor(ns / 1e9);
  if (ns >= 36e11) return parts(Math.floor(seconds / 3600), u.h, Math.floor((seconds % 3600) / 60), u.min);
  if (ns >= 6e10) return parts(Math.floor(seconds / 60), u.min, seconds % 60, u.s);
  if (ns % 1e9 === 0) return `${seconds} ${u.s}`;
  return ns >= 1e10 ? digits(1e9, u.s) : digits(1e6, u.ms);
}
/** A proved bound, rounded up (src/text/duration.cpp, rounded_up()). */
export function formatBound(ms: number): string {
  const ns = Math.round(ms * 1e6);
  const unit = ns < 1e5 ? 1e3 : 1e6;
  const small = ns <= unit ? unit / 1000 : ns <= 10 * unit ? unit / 100 : ns <= 100 * unit ? unit / 10 : unit;
  const step = ns > 36e11 ? 6e10 : ns > 6e10 ? 1e9 : ns > 1e10 ? 1e8 : small;
  return formatDuration((Math.ceil(ns / step) * step) / 1e6);
}
export function formatClock(ms: number, millis = false): string {
  const date = new Date(ms);
  const base = date.toLocaleTimeString(language.value, { hour12: false });
  return millis ? `${base}.${String(date.getMilliseconds()).padStart(3, '0')}` : base;
}
/** Day and time, the month as a word: the order of its numbers differs between countries. */
export const formatDate = (time: number | string): string =>
  new Date(time).toLocaleString(language.value, { dateStyle: 'medium', timeStyle: 'medium', hour12: false });
