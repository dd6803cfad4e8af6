import assert from 'node:assert/strict';
import test from 'node:test';
import { ClockEstimate } from '../src/store/clock_estimate';

const BEGIN = 1_790_000_000_000; // of the program's clock
const HOUR_MS = 3_600_000;

/** A program whose clock runs `ppm` faster than that of the browser, and an estimate of it. */
class Bench {
  readonly estimate = new ClockEstimate();
  local = 5000;
  ahead = 0;
  constructor(readonly ppm = 0) {}

  program(local = this.local): number {
    return BEGIN + this.ahead + local * (1 + this.ppm * 1e-6);
  }
  /** The program answers after `there`, and the response takes `back`. */
  exchange(there: number, back: number): void {
    const sent = this.local;
    const answered = Math.floor(this.program(sent + there));
    this.local += there + back;
    this.estimate.add(sent, answered, this.local);
  }
  get tooLate(): number {
    return (this.estimate.latest(this.local) ?? Number.NaN) - this.program();
  }
  get wrongBy(): number {
    return Math.abs((this.estimate.now(this.local) ?? Number.NaN) - this.program());
  }
}

test('without an exchange the time is unknown', () => {
  const { estimate } = new Bench();
  assert.equal(estimate.now(1000), null);
  assert.equal(estimate.latest(1000), null);
  assert.equal(estimate.contradicts(1000, BEGIN), false);
});

test('the shortest round trip counts', () => {
  const bench = new Bench();
  bench.exchange(3, 900);
  assert.ok(bench.wrongBy > 400);
  bench.exchange(2, 2);
  bench.exchange(700, 5);
  assert.ok(bench.wrongBy < 2, String(bench.wrongBy));
});

test('an age is never too short, whichever way was slow', () => {
  for (const [there, back] of [
    [0, 800],
    [800, 0],
    [1, 1],
    [0, 0],
    [400, 400],
  ] as const) {
    const bench = new Bench();
    bench.exchange(there, back);
    assert.ok(bench.tooLate >= 0, `${there} ${back}: ${bench.tooLate}`);
    assert.ok(bench.tooLate <= there + back + 5, `${there} ${back}: ${bench.tooLate}`);
  }
});

test('values that arrive 2 s late do not move the clock, and are shown at least 2 s old', () => {
  const bench = new Bench();
  bench.exchange(2, 3);
  for (let i = 0; i < 100; ++i) {
    bench.local += 100;
    const message = Math.floor(bench.program() - 2000);
    assert.equal(bench.estimate.contradicts(bench.local, message), false);
    const age = bench.estimate.latest(bench.local)! - message;
    assert.ok(age >= 2000 && age < 2030, String(age));
  }
});

test('a browser clock that is wrong by an hour is corrected', () => {
  for (const wrong of [HOUR_MS, -HOUR_MS]) {
    const bench = new Bench();
    bench.ahead = wrong;
    bench.exchange(4, 6);
    assert.ok(bench.wrongBy <= 2.5, String(bench.wrongBy));
    assert.ok(bench.tooLate >= 0);
  }
});

test('drift is followed: an exchange every 10 s keeps the time of a day, also with slow responses', () => {
  for (const ppm of [-50, 50, 300]) {
    const bench = new Bench(ppm);
    bench.exchange(1, 1);
    for (let i = 0; i < 8640; ++i) {
      bench.local += 10_000;
      assert.ok(bench.tooLate >= 0, `${ppm} ppm, ${i}: ${bench.tooLate}`);
      assert.ok(bench.tooLate < 100, `${ppm} ppm, ${i}: ${bench.tooLate}`);
      bench.exchange(1 + (i % 7), 1 + ((i * 5) % 23));
      assert.ok(bench.wrongBy < 20, `${ppm} ppm, ${i}: ${bench.wrongBy}`);
    }
  }
});

test('an old estimate gets worse, and a later exchange takes its place', () => {
  const bench = new Bench(50);
  bench.exchange(0, 0);
  bench.local += HOUR_MS;
  const before = bench.tooLate;
  assert.ok(before > 1000 && before < 3000, String(before));
  bench.exchange(50, 50);
  assert.ok(bench.tooLate >= 0 && bench.tooLate < 120, String(bench.tooLate));
});

test('a program clock that is set is followed', () => {
  for (const step of [HOUR_MS, -HOUR_MS, 3000, -3000]) {
    const bench = new Bench();
    bench.exchange(1, 1);
    bench.ahead = step;
    bench.local += 1000;
    assert.equal(bench.estimate.contradicts(bench.local, bench.program()), step > 0);
    bench.exchange(5, 5);
    assert.ok(bench.wrongBy < 6, `${step}: ${bench.wrongBy}`);
  }
});

test('after a sleep of the browser nothing is known', () => {
  const bench = new Bench();
  bench.exchange(1, 1);
  bench.estimate.forget();
  assert.equal(bench.estimate.latest(bench.local), null);
});

test('an answer without a time is no exchange', () => {
  const { estimate } = new Bench();
  estimate.add(0, Number.NaN, 1);
  assert.equal(estimate.now(1), null);
});
