// Takes the picture of README.md: the view Project of `takt demo`, once the plan is computed.
//
//   TAKT=<program> node ui/test/measure/picture.mjs docs/images/page.png
import { spawn } from 'node:child_process';
import { browser } from '../page/program.mjs';

const demo = spawn(process.env.TAKT, ['demo', '--for', '60s']);
const chromium = await browser();
try {
  const url = await new Promise((found) => {
    let text = '';
    const look = (data) => {
      text += data;
      const match = text.match(/http:\/\/127\.0\.0\.1:\d+\//);
      if (match) found(match[0]);
    };
    demo.stdout.on('data', look);
    demo.stderr.on('data', look);
  });
  const context = await chromium.newContext({ viewport: { width: 1440, height: 760 } });
  const page = await context.newPage();
  await page.goto(`${url}?lang=en&theme=light#/project`);
  await page.getByText('Every value arrives before its deadline').waitFor();
  await page.waitForTimeout(5000);
  await page.screenshot({ path: process.argv[2] });
} finally {
  await chromium.close();
  demo.kill('SIGINT');
}
