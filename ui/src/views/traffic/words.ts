import type { Frame } from '../../api/types';

const UNIT = /^\S+ \d+ /; // it has a column of its own

/** The words of a frame without its unit. */
export const withoutUnit = (words: string) => words.replace(UNIT, '');

/** What a frame says, what is wrong with it, or what happened. */
export const frameWords = (frame: Frame) =>
  frame.incident ? frame.words.charAt(0).toUpperCase() + frame.words.slice(1) : withoutUnit(frame.words);
