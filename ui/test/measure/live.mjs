// What a view costs with 1,000 values that change ten times a second: processor time of the page, memory of
// the page (after garbage collection) and of the program, once a minute.
//
//   TAKT=<program> node ui/test/measure/live.mjs [MINUTES] [live|trends|traffic] [VARIABLES]
import { browser } from '../page/program.mjs';
import { Field, processorTime, residentMemory } from './field.mjs';

const MINUTES = Number(process.argv[2] ?? 2);
const VIEW = process.argv[3] ?? 'live';
const COUNT = Number(process.argv[4] ?? 1000);
const HASHES = {
  live: ['#/live', '[role="row"]'],
  trends: ['#/trends?pens=D1.V1%1FD1.V2%1FD2.V1%1FD3.V1&span=60', '.chart canvas'],
  traffic: ['#/traffic', '[role="row"]'],
};
const [hash, wanted] = HASHES[VIEW];
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

const field = await Field.start(COUNT);
const chromium = await browser();
try {
  const context = await chromium.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  await page.goto(`${field.url}?lang=en&theme=light${hash}`);
  await page.locator(wanted).first().waitFor();
  await pause(5000);
  const changes = await page.evaluate(async () => {
    const response = await fetch('api/v1/stream');
    const reader = response.body.getReader();
    const decoder = new TextDecoder();
    let text = '';
    const end = performance.now() + 5000;
    while (performance.now() < end) text += decoder.decode((await reader.read()).value, { stream: true });
    await reader.cancel();
    const batches = [...text.matchAll(/event: values\ndata: (.*)\n/g)].map((its) => JSON.parse(its[1]));
    const seconds = (batches.at(-1).time - batches[0].time) / 1000;
    return batches.slice(1).reduce((sum, its) => sum + its.values.length, 0) / seconds;
  });
  console.log(`${COUNT} variables, ${Math.round(changes)} changes a second`);
  const root = await chromium.newBrowserCDPSession();
  const devtools = await context.newCDPSession(page);
  await devtools.send('Performance.enable');
  const processes = async () => (await root.send('SystemInfo.getProcessInfo')).processInfo;
  const times = async () => ({
    at: Date.now() / 1000,
    program: processorTime(field.program.pid),
    each: (await processes()).map(({ id, type }) => ({ id, type, time: processorTime(id) })),
  });
  const renderers = (its) => its.each.filter((one) => one.type === 'renderer');
  const used = (before, after, pick) =>
    pick(after).reduce((sum, one) => {
      const earlier = before.each.find((its) => its.id === one.id);
      return sum + (earlier ? one.time - earlier.time : 0);
    }, 0);
  console.log('minute  page %  browser %  program %  heap MB  nodes  program MB');
  const percent = (seconds, wall) => ((100 * seconds) / wall).toFixed(1).padStart(6);
  for (let minute = 1; minute <= MINUTES; ++minute) {
    const before = await times();
    await pause(60_000);
    const after = await times();
    const wall = after.at - before.at;
    // A forced collection, so that only what is reachable counts. It is outside the measured time.
    await devtools.send('HeapProfiler.collectGarbage');
    const { metrics } = await devtools.send('Performance.getMetrics');
    const metric = (name) => metrics.find((its) => its.name === name)?.value ?? 0;
    console.log(
      [
        String(minute).padStart(6),
        percent(used(before, after, renderers), wall),
        percent(
          used(before, after, (its) => its.each),
          wall,
        ).padStart(9),
        percent(after.program - before.program, wall).padStart(9),
        (metric('JSHeapUsedSize') / 1e6).toFixed(2).padStart(8),
        String(metric('Nodes')).padStart(6),
        residentMemory(field.program.pid).toFixed(1).padStart(10),
      ].join('  '),
    );
  }
} finally {
  await chromium.close();
  await field.stop();
}
