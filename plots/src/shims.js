// What the libraries ask of their surroundings, beyond the language. Nothing is loaded, and nothing
// happens later.
globalThis.console = {
  log() {}, info() {}, debug() {},
  warn(...said) { throw new Error(said.join(' ')); },
  error(...said) { throw new Error(said.join(' ')); },
};
globalThis.setTimeout = () => 0;
globalThis.clearTimeout = () => {};
globalThis.structuredClone = (value) => JSON.parse(JSON.stringify(value));
globalThis.drawn = { svg: null, error: null };
// Widths of letters in em, above those of usual sans-serif fonts: without a canvas the library takes 0.8, and
// leaves a third of a picture empty beside a long line.
const width = (item, text) => {
  const isBold = item.fontWeight === 'bold' || item.fontWeight >= 600;
  const size = item.fontSize == null ? 11 : item.fontSize;
  return Math.ceil((isBold ? 0.68 : 0.6) * String(text ?? '').length * size);
};
globalThis.draw = (text) => {
  vega.textMetrics.width = width;
  globalThis.drawn = { svg: null, error: null };
  const spec = vegaLite.compile(JSON.parse(text)).spec;
  new vega.View(vega.parse(spec), { renderer: 'none' }).toSVG().then(
    (svg) => { globalThis.drawn.svg = svg; },
    (error) => { globalThis.drawn.error = String(error); },
  );
};
