// Frames in words, in the language of the page. The program describes frames in English, as in its logs.
import type { Frame } from '../../api/types';
import { formatDuration, t } from '../../i18n';

// Longest first: "read coils" before "read".
const PHRASES = Object.keys(t.peek().traffic.phrases).sort((a, b) => b.length - a.length);
const PHRASE = new RegExp(
  `(?<![\\w/"])(?:${PHRASES.map((its) => its.replace('/', '\\/')).join('|')})(?![\\w/"])`,
  'g',
);
const UNIT = /^unit \d+ /; // it has a column of its own
const VALUES = /(\d+) values?:/g;

/** Texts in quotes come from devices and stay as they are. */
export function translated(words: string): string {
  const { phrases, values } = t.value.traffic;
  return words
    .replace(UNIT, '')
    .split(/("[^"]*")/)
    .map((part) =>
      part.startsWith('"')
        ? part
        : part
            .replace(VALUES, (_, count) => values(Number(count)))
            .replace(PHRASE, (its) => phrases[its as keyof typeof phrases]),
    )
    .join('');
}

/** What a frame says, what is wrong with it, or what happened. */
export function frameWords(frame: Frame): string {
  if (frame.instead)
    return t.value.traffic.instead[frame.instead.part](frame.instead.came, frame.instead.asked);
  if (frame.incident) return t.value.traffic.incidents[frame.incident](formatDuration(frame.after_ms ?? 0));
  const fault = (t.value.traffic.faults as Record<string, string>)[frame.fault ?? ''];
  return fault ?? translated(frame.words);
}
