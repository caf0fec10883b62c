'use strict';
// The page is whole without this script: it moves the sliders, and redraws the plots from the same
// specifications, so that they answer to the pointer and to filters.
(() => {
  const doc = JSON.parse(document.getElementById('document').textContent);
  for (const own of document.querySelectorAll('[data-slider]')) {
    const input = own.querySelector('input');
    const move = () => own.style.setProperty('--at', `${input.value}%`);
    input.addEventListener('input', move);
    move();
  }
  for (const own of document.querySelectorAll('[data-plot]')) {
    const spec = doc.plots[own.dataset.plot];
    const view = new vega.View(vega.parse(vegaLite.compile(spec).spec), { renderer: 'svg', hover: true });
    const drawn = document.createElement('div');
    view.initialize(drawn);
    view.runAsync().then(() => {
      own.replaceChildren(drawn);
      const filter = document.querySelector(`[data-filter="${own.dataset.plot}"]`);
      if (filter) {
        filter.addEventListener('change', () => view.signal('knob', filter.value).runAsync());
      }
    });
  }
  for (const own of document.querySelectorAll('[data-choice]')) {
    const show = () => {
      const picked = own.querySelector('input:checked').value;
      for (const panel of document.querySelectorAll(`[data-panel-of="${own.dataset.choice}"]`)) {
        panel.hidden = panel.dataset.panel !== picked;
      }
    };
    own.addEventListener('change', show);
    show();
  }
})();
