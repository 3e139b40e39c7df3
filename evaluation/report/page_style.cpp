#include "evaluation/report/page_style.h"

namespace dualpixel::evaluation {

const char* const kPageStyle = R"css(
:root {
  color-scheme: light dark;
  --paper: #fcfcfa; --ink: #1c1d20; --soft: #63666e; --line: #d9dade; --panel: #f2f2ef; --accent: #9a4a10;
}
@media (prefers-color-scheme: dark) {
  :root { --paper: #16171a; --ink: #e8e8e6; --soft: #9da0a8; --line: #34363c; --panel: #1f2125; --accent: #f0a367; }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 1.5rem clamp(.8rem, 3vw, 2.5rem) 4rem; max-width: 1500px;
  background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif;
}
h1, h2, h3, h4 { line-height: 1.2; overflow-wrap: anywhere; }
h1 { font-size: 1.7rem; margin: 0 0 1rem; }
h2 { font-size: 1.3rem; margin: 2.5rem 0 .3rem; }
h3 { font-size: 1.3rem; margin: 3rem 0 .8rem; padding-top: 1rem; border-top: 1px solid var(--line); }
h4 { font-size: 1rem; margin: 1.6rem 0 .5rem; }
p { margin: .2rem 0 .8rem; max-width: 75ch; }
.soft, figcaption, summary { color: var(--soft); font-size: .9rem; }
.mode { font-weight: 400; color: var(--accent); }
figure { margin: 0; min-width: 0; }
figcaption b { color: var(--ink); font-weight: 600; }
img { display: block; width: 100%; height: auto; background: var(--panel); }
.pair { max-width: 1000px; }
.maps { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 380px), 1fr)); gap: 1.4rem; }
.maps .wide { grid-column: 1 / -1; }
.maps figure > img { cursor: zoom-in; }
.maps .wide > img { cursor: zoom-out; }
.bar { display: grid; grid-template-columns: auto 1fr auto; gap: .6rem; align-items: center; margin-top: .3rem; }
.bar img { height: .8rem; border: 1px solid var(--line); }
.stack img + img { margin-top: .5rem; }
.live .stack { position: relative; display: grid; overflow: hidden; }
.live .stack img { grid-area: 1 / 1; margin: 0; }
.live .off { visibility: hidden; }
.live .compare .stack { cursor: ew-resize; touch-action: pan-y; user-select: none; }
.divider {
  position: absolute; inset: 0 auto 0 50%; width: 2px; background: #fff; box-shadow: 0 0 3px #000;
  pointer-events: none;
}
.controls { display: flex; flex-wrap: wrap; gap: .5rem 1rem; align-items: center; margin: .5rem 0; }
html:not(.live) .controls { display: none; }
.controls input[type=range] { flex: 1 1 12rem; min-width: 0; }
button, select {
  font: inherit; color: inherit; background: var(--panel); border: 1px solid var(--line); border-radius: 6px;
  padding: .3rem .7rem;
}
:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .3rem .8rem .3rem 0; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: var(--paper); }
th { font-weight: 600; }
details { margin: 1rem 0; }
summary { cursor: pointer; }
pre {
  overflow: auto; max-height: 30rem; padding: .8rem; background: var(--panel); font-size: .8rem;
  white-space: pre-wrap; overflow-wrap: anywhere;
}
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(260px, 1fr)); gap: 1rem; }
svg { width: 100%; max-width: 420px; height: auto; }
svg text { fill: var(--soft); font-size: 12px; }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 420px), 1fr)); gap: 1.6rem; }
.plots svg { max-width: 520px; background: none; }
.plot .frame { stroke: var(--line); fill: none; }
.plot .grid { stroke: var(--line); stroke-width: .6; }
.plot polyline { fill: none; stroke-width: 1.8; stroke-linejoin: round; }
.plot .dashed { stroke-dasharray: 6 4; }
.plot .c0 { --c: #2f6fb0; } .plot .c1 { --c: #c2571a; } .plot .c2 { --c: #2a8a57; }
.plot .c3 { --c: #8a4fae; } .plot .c4 { --c: #9a7d0a; } .plot .c5 { --c: #b03060; }
@media (prefers-color-scheme: dark) {
  .plot .c0 { --c: #7fb2e8; } .plot .c1 { --c: #f0a367; } .plot .c2 { --c: #74cf9d; }
  .plot .c3 { --c: #cb9be6; } .plot .c4 { --c: #e0c652; } .plot .c5 { --c: #f08aac; }
}
.plot polyline, .plot line.key { stroke: var(--c); }
.plot circle { fill: var(--c); }
.plot .legend { width: 22px; height: 9px; }
.plot .name { white-space: nowrap; }
.wide-plot { grid-template-columns: minmax(0, 900px); }
.wide-plot .plot > svg { max-width: 900px; }
)css";

const char* const kReportScript = R"js(
'use strict';
document.documentElement.classList.add('live');

for (const figure of document.querySelectorAll('.flicker')) {
  const images = figure.querySelectorAll('.stack img');
  const name = figure.querySelector('output');
  let shown = 0;
  const show = () => {
    images.forEach((image, i) => image.classList.toggle('off', i !== shown));
    name.textContent = images[shown].alt;
  };
  const flip = () => { shown = (shown + 1) % images.length; show(); };
  let timer = 0;
  figure.querySelector('button').addEventListener('click', flip);
  figure.querySelector('.stack').addEventListener('click', flip);
  figure.querySelector('input').addEventListener('change', event => {
    clearInterval(timer);
    if (event.target.checked) timer = setInterval(flip, 400);
  });
  show();
}

for (const figure of document.querySelectorAll('.compare')) {
  const stack = figure.querySelector('.stack');
  const images = figure.querySelectorAll('.stack img');
  const [left, right] = figure.querySelectorAll('select');
  const split = figure.querySelector('input');
  const divider = document.createElement('div');
  divider.className = 'divider';
  stack.append(divider);
  const show = () => {
    images.forEach((image, i) => {
      const isLeft = i === left.selectedIndex;
      image.classList.toggle('off', !isLeft && i !== right.selectedIndex);
      image.style.zIndex = isLeft ? 1 : 0;
      image.style.clipPath = isLeft ? `inset(0 ${100 - split.value}% 0 0)` : 'none';
    });
    divider.style.left = split.value + '%';
    divider.style.zIndex = 2;
  };
  const drag = event => {
    if (event.buttons !== 1) return;
    const box = stack.getBoundingClientRect();
    split.value = 100 * (event.clientX - box.left) / box.width;
    show();
  };
  stack.addEventListener('pointerdown', event => { stack.setPointerCapture(event.pointerId); drag(event); });
  stack.addEventListener('pointermove', drag);
  stack.addEventListener('dragstart', event => event.preventDefault());
  for (const control of [left, right, split]) control.addEventListener('input', show);
  show();
}

for (const image of document.querySelectorAll('.maps figure > img')) {
  image.addEventListener('click', () => image.parentElement.classList.toggle('wide'));
}
)js";

}  // namespace dualpixel::evaluation
