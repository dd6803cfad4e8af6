// The program's clock as seen from this browser, from exchanges as NTP makes them (RFC 5905, chapters 8 and
// 10): in a request and its response the program read its clock between the two. Pure.

/** How fast two clocks part: adjtime() slews by up to 500 ppm, and each crystal is off by some 50 ppm. */
const DRIFT = 600e-6;
/** The time in a response is cut to whole milliseconds. */
const PROGRAM_STEP_MS = 1;
/** Browsers round their clock, Firefox to whole milliseconds. */
const LOCAL_STEP_MS = 1;
const MOST_EXCHANGES = 8;

/** The program's time minus the local time at the instant `at`, and how wrong that can be. */
interface Offset {
  offset: number;
  error: number;
  at: number;
}

const errorAt = (its: Offset, local: number) => its.error + DRIFT * Math.max(0, local - its.at);

/**
 * Local times are milliseconds of a clock that is never set (performance.now()), those of the program are
 * milliseconds since 1970.
 */
export class ClockEstimate {
  #exchanges: Offset[] = [];

  /**
   * @param sent      local time before the request
   * @param program   the time in the response
   * @param received  local time after the response
   */
  add(sent: number, program: number, received: number): void {
    if (!Number.isFinite(program) || received < sent) return;
    const added: Offset = {
      offset: program + PROGRAM_STEP_MS / 2 - (sent + received) / 2,
      error: (received - sent + PROGRAM_STEP_MS) / 2 + LOCAL_STEP_MS,
      at: received,
    };
    const best = this.#best(received);
    // Both contain the offset, so without a common part the program's clock was set in between.
    if (best && Math.abs(best.offset - added.offset) > errorAt(best, received) + added.error) this.forget();
    this.#exchanges = [...this.#exchanges, added].slice(-MOST_EXCHANGES);
  }

  /** The local clock stood still or jumped: all exchanges before are worthless. */
  forget(): void {
    this.#exchanges = [];
  }

  /** The most probable time of the program; null: unknown. */
  now(local: number): number | null {
    const best = this.#best(local);
    return best && local + best.offset;
  }

  /** The program's clock is not beyond this. An age that ends here is never too short. */
  latest(local: number): number | null {
    const best = this.#best(local);
    return best && local + best.offset + errorAt(best, local);
  }

  /** Whether a message with this time of the program cannot have arrived yet, so that its clock was set. */
  contradicts(local: number, program: number): boolean {
    const latest = this.latest(local);
    return latest !== null && program > latest;
  }

  /** The exchange with the shortest round trip, where an old one counts as longer. */
  #best(local: number): Offset | null {
    let best: Offset | null = null;
    for (const its of this.#exchanges) if (!best || errorAt(its, local) <= errorAt(best, local)) best = its;
    return best;
  }
}
