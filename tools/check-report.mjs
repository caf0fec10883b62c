// Drives Chromium by its debugging protocol, over a pipe. See tools/check-report.
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const [, , chromium, axe, page, folder] = process.argv;
const WIDTHS = [390, 768, 1440];
const profile = mkdtempSync(join(tmpdir(), 'report-'));
const browser = spawn(chromium, [
  '--headless', '--no-sandbox', '--disable-gpu', '--hide-scrollbars', `--user-data-dir=${profile}`,
  '--remote-debugging-pipe',
], { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });

let last = 0;
const waiting = new Map();
const listeners = [];
let rest = '';
browser.stdio[4].setEncoding('utf8').on('data', (text) => {
  const messages = (rest + text).split('\0');
  rest = messages.pop();
  for (const message of messages.map((own) => JSON.parse(own))) {
    const done = waiting.get(message.id);
    if (done) {
      waiting.delete(message.id);
      if (message.error) done[1](new Error(message.error.message));
      else done[0](message.result);
    } else {
      listeners.forEach((own) => own(message));
    }
  }
});
const send = (method, params = {}, sessionId = undefined) => new Promise((resolve, reject) => {
  last += 1;
  waiting.set(last, [resolve, reject]);
  browser.stdio[3].write(`${JSON.stringify({ id: last, method, params, sessionId })}\0`);
});

const problems = [];
const look = async (width, theme) => {
  const at = `${width} px, ${theme}`;
  const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
  const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
  const on = (method, params) => send(method, params, sessionId);
  let loaded = () => {};
  const isLoaded = new Promise((resolve) => { loaded = resolve; });
  listeners.push((message) => {
    if (message.sessionId !== sessionId) return;
    const { method, params } = message;
    if (method === 'Page.loadEventFired') loaded();
    if (method === 'Runtime.exceptionThrown') problems.push(`${at}: ${params.exceptionDetails.text} ${params.exceptionDetails.exception?.description}`);
    if (method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(params.type)) problems.push(`${at}: console: ${params.args.map((own) => own.value).join(' ')}`);
    if (method === 'Log.entryAdded') problems.push(`${at}: ${params.entry.text} ${params.entry.url ?? ''}`);
    if (method === 'Network.requestWillBeSent' && !/^(file|data):/.test(params.request.url)) problems.push(`${at}: loads ${params.request.url}`);
  });
  for (const domain of ['Page', 'Runtime', 'Log', 'Network']) await on(`${domain}.enable`);
  await on('Emulation.setDeviceMetricsOverride', { width, height: 900, deviceScaleFactor: 1, mobile: width < 600 });
  await on('Emulation.setEmulatedMedia', { features: [{ name: 'prefers-color-scheme', value: theme }] });
  await on('Page.navigate', { url: `file://${page}` });
  await isLoaded;
  const run = async (expression) => {
    const done = await on('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
    if (done.exceptionDetails) throw new Error(`${at}: ${done.exceptionDetails.exception?.description ?? done.exceptionDetails.text}`);
    return done.result.value;
  };
  await run('new Promise((done) => setTimeout(done, 500))');
  const found = await run(`(() => {
    const count = (of) => document.querySelectorAll(of).length;
    return {
      sections: count('main > section'), plots: count('[data-plot]'), drawn: count('[data-plot] svg'),
      live: count('[data-plot] > div > svg'), pictures: [...document.images].filter((own) => own.naturalWidth > 0).length,
      images: document.images.length, wide: document.documentElement.scrollWidth, width: innerWidth,
    };
  })()`);
  const expect = (is, what) => { if (!is) problems.push(`${at}: ${what}: ${JSON.stringify(found)}`); };
  expect(found.sections === 9, 'nine sections');
  expect(found.plots > 0 && found.live === found.plots && found.drawn === found.plots, 'all plots are drawn and live');
  expect(found.pictures === found.images && found.images > 0, 'all pictures are there');
  expect(found.wide <= found.width, 'the page is not wider than the window');
  const moved = await run(`(() => {
    const own = document.querySelector('[data-slider]');
    const input = own.querySelector('input');
    input.focus();
    input.value = 20;
    input.dispatchEvent(new Event('input'));
    const at = own.style.getPropertyValue('--at');
    input.value = 50;
    input.dispatchEvent(new Event('input'));
    return at;
  })()`);
  expect(moved === '20%', 'the slider moves');
  await run(readFileSync(axe, 'utf8') + '; 0');
  const { violations } = await run(`axe.run(document, { resultTypes: ['violations'] }).then((own) => ({
    violations: own.violations.map((v) => [v.id, v.help, v.nodes.slice(0, 3).map((n) => n.html.slice(0, 160))]),
  }))`);
  violations.forEach((own) => problems.push(`${at}: axe-core: ${JSON.stringify(own)}`));
  const { cssContentSize } = await on('Page.getLayoutMetrics');
  const shot = await on('Page.captureScreenshot', {
    captureBeyondViewport: true, clip: { x: 0, y: 0, width, height: Math.min(cssContentSize.height, 15000), scale: 1 },
  });
  writeFileSync(join(folder, `${width}-${theme}.png`), Buffer.from(shot.data, 'base64'));
  if (width === 1440 && theme === 'light') {
    const { data } = await on('Page.printToPDF', { printBackground: true });
    writeFileSync(join(folder, 'print.pdf'), Buffer.from(data, 'base64'));
  }
  console.log(`${at}: ${found.live} plots, ${found.pictures} pictures, ${violations.length} findings of axe-core`);
  await send('Target.closeTarget', { targetId });
};

try {
  for (const width of WIDTHS) {
    for (const theme of ['light', 'dark']) await look(width, theme);
  }
} finally {
  const ended = new Promise((done) => browser.once('exit', done));
  browser.kill();
  await ended;
  rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
}
problems.forEach((own) => console.log(own));
process.exit(problems.length === 0 ? 0 : 1);
