// SPDX-License-Identifier: Apache-2.0
// What a chart shows, as a table, CSV, PNG or SVG: what is visible, and no more.
import {dialog, h} from '/dom.js';

const kMostTableRows = 200;

// [x, y...] of what is visible, in the units of the axes.
function visibleRows(chart) {
  const {data, rows} = chart.spec;
  const all = rows ? rows() : data[0].map((_, i) => data.map((column) => column[i]));
  const [low, high] = chart.shownRange();
  return all.filter(([x]) => x >= low && x <= high);
}

const withUnit = (name, unit) => (unit ? `${name} (${unit})` : name);
const headings = ({x, y, series}) => [x.label, ...series.map((one) => withUnit(one.name, y.unit))];

export function showTable(chart) {
  const visible = visibleRows(chart);
  const step = Math.max(1, Math.ceil(visible.length / kMostTableRows));
  const rows = visible.filter((_, i) => i % step === 0);
  return dialog(chart.spec.title, h('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Values'},
    h('table', {}, h('caption', {}, step > 1 ? `Every ${step}th of the ${visible.length} visible points; CSV has all` : `${visible.length} visible points`),
      h('thead', {}, h('tr', {}, headings(chart.spec).map((text) => h('th', {scope: 'col'}, text)))),
      h('tbody', {}, rows.map((row) => h('tr', {}, row.map((value) => h('td', {}, readout(value)))))))));
}

export function csvOf(chart) {
  const lines = [headings(chart.spec).join(','), ...visibleRows(chart).map((row) => row.map((value) => value ?? '').join(','))];
  return new Blob([lines.join('\n') + '\n'], {type: 'text/csv'});
}

export function pngOf(chart, background) {
  const from = chart.box.querySelector('canvas');
  const canvas = document.createElement('canvas');
  canvas.width = from.width;
  canvas.height = from.height;
  const context = canvas.getContext('2d');
  context.fillStyle = background;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(from, 0, 0);
  return new Promise((done) => canvas.toBlob(done, 'image/png'));
}

const escaped = (text) => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

// The lines as vectors, with axes and their ends. `colour` gives the colour of a role.
export function svgOf(chart, colour) {
  const {spec, u} = chart;
  const {width} = u;
  const {height} = spec;
  const box = {left: 60, top: 10, width: width - 80, height: height - 50};
  const {min: x0, max: x1} = u.scales.x;
  const {min: y0, max: y1} = u.scales.y;
  const share = (value, low, high, log) => (log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
  const px = (x) => (box.left + box.width * share(x, x0, x1, spec.x.log)).toFixed(2);
  const py = (y) => (box.top + box.height * (1 - share(y, y0, y1, spec.y.log))).toFixed(2);
  const rows = visibleRows(chart);
  const path = (column) => {
    let text = '';
    let down = false;
    for (const row of rows) {
      const y = row[column];
      if (y === null || y === undefined || Number.isNaN(y)) { down = false; continue; }
      text += `${down ? 'L' : 'M'}${px(row[0])} ${py(y)}`;
      down = true;
    }
    return text;
  };
  const lines = spec.series.map((one, i) => (u.series[i + 1].show
    ? `<path d="${path(i + 1)}" fill="none" stroke="${colour(one.role)}" stroke-width="${one.width ?? 1.25}"${one.dash ? ` stroke-dasharray="${one.dash.join(' ')}"` : ''}><title>${escaped(one.name)}</title></path>` : '')).join('\n');
  const text = (x, y, anchor, what) => `<text x="${x}" y="${y}" text-anchor="${anchor}">${escaped(what)}</text>`;
  return new Blob([`<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" font-family="Arial, sans-serif" font-size="11" fill="${colour('ink')}">
<title>${escaped(spec.title)}</title><rect width="100%" height="100%" fill="${colour('page')}"/>
<clipPath id="plot"><rect x="${box.left}" y="${box.top}" width="${box.width}" height="${box.height}"/></clipPath>
<rect x="${box.left}" y="${box.top}" width="${box.width}" height="${box.height}" fill="none" stroke="${colour('rule')}"/>
<g clip-path="url(#plot)">${lines}</g>
${text(box.left, height - 26, 'middle', readout(x0))}${text(box.left + box.width, height - 26, 'middle', readout(x1))}
${text(box.left + box.width / 2, height - 10, 'middle', spec.x.label)}
${text(box.left - 6, box.top + box.height, 'end', readout(y0))}${text(box.left - 6, box.top + 10, 'end', readout(y1))}
<text transform="translate(14 ${box.top + box.height / 2}) rotate(-90)" text-anchor="middle">${escaped(spec.y.label)}</text>
</svg>
`], {type: 'image/svg+xml'});
}
