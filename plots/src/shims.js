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
globalThis.draw = (text) => {
  globalThis.drawn = { svg: null, error: null };
  const spec = vegaLite.compile(JSON.parse(text)).spec;
  new vega.View(vega.parse(spec), { renderer: 'none' }).toSVG().then(
    (svg) => { globalThis.drawn.svg = svg; },
    (error) => { globalThis.drawn.error = String(error); },
  );
};
