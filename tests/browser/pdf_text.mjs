// SPDX-License-Identifier: Apache-2.0
// Reads where text stands on the pages of a PDF that Chromium printed. Enough of PDF 1.4 for that, and no more:
// classic objects, Flate streams, Type 0 fonts with a ToUnicode map, forms.
import zlib from 'node:zlib';

function parseObjects(bytes) {
  const latin = bytes.toString('latin1');
  const objects = new Map();
  for (const match of latin.matchAll(/(?:^|\n)(\d+) 0 obj\s*/g)) {
    const start = match.index + match[0].length;
    const body = latin.slice(start, latin.indexOf('endobj', start));
    const stream = body.indexOf('stream');
    const dictionary = stream < 0 ? body : body.slice(0, stream);
    const object = {dictionary, content: null};
    if (stream >= 0) {
      const from = start + stream + (latin.startsWith('stream\r\n', start + stream) ? 8 : 7);
      const length = Number(/\/Length (\d+)/.exec(dictionary)?.[1] ?? 0);
      const raw = bytes.subarray(from, from + length);
      object.content = dictionary.includes('/FlateDecode') ? () => zlib.inflateSync(raw).toString('latin1') : () => raw.toString('latin1');
    }
    objects.set(Number(match[1]), object);
  }
  return objects;
}

// Glyph code → character, from a ToUnicode map.
function glyphMap(text) {
  const map = new Map();
  const character = (hex) => String.fromCharCode(...hex.match(/.{4}/g).map((unit) => parseInt(unit, 16)));
  for (const [, block] of text.matchAll(/beginbfchar(.*?)endbfchar/gs)) {
    for (const [, code, to] of block.matchAll(/<(\w+)> <(\w+)>/g)) map.set(parseInt(code, 16), character(to));
  }
  for (const [, block] of text.matchAll(/beginbfrange(.*?)endbfrange/gs)) {
    for (const [, first, last, to] of block.matchAll(/<(\w+)> <(\w+)> <(\w+)>/g)) {
      for (let code = parseInt(first, 16), k = 0; code <= parseInt(last, 16); ++code, ++k) {
        map.set(code, String.fromCharCode(parseInt(to, 16) + k));
      }
    }
  }
  return map;
}

const times = ([a, b, c, d, e, f], [A, B, C, D, E, F]) =>
  [a * A + b * C, a * B + b * D, c * A + d * C, c * B + d * D, e * A + f * C + E, e * B + f * D + F];

// Pages as {width, height, runs: [{text, x, y}]}: one run per text object, x and y in points from the top left.
export function pdfPages(bytes) {
  const objects = parseObjects(bytes);
  const glyphMaps = new Map();
  const reference = (dictionary, name) => Number(new RegExp(`/${name} (\\d+) 0 R`).exec(dictionary)?.[1]);
  const mapOf = (font) => {
    if (!glyphMaps.has(font)) {
      const to = objects.get(reference(objects.get(font).dictionary, 'ToUnicode'));
      glyphMaps.set(font, to ? glyphMap(to.content()) : new Map());
    }
    return glyphMaps.get(font);
  };

  const read = (object, matrix, runs) => {
    const stack = [];
    let current = matrix;
    let map = new Map();
    let run = null;
    let operands = [];
    for (const [token] of object.content().matchAll(/<[0-9A-Fa-f]*>|\[[^\]]*\]|[^\s<>[\]]+/g)) {
      const numbers = () => operands.slice(-6).map(Number);
      switch (token) {
        case 'q': stack.push(current); break;
        case 'Q': current = stack.pop() ?? matrix; break;
        case 'cm': current = times(numbers(), current); break;
        case 'Tf': map = mapOf(reference(object.dictionary, operands.at(-2).slice(1))); break;
        case 'BT': run = {text: '', x: 0, y: 0}; break;
        case 'Tm': [, , , , run.x, run.y] = times(numbers(), current); break;
        case 'Tj': run.text += (operands.at(-1).slice(1, -1).match(/.{4}/g) ?? []).map((code) => map.get(parseInt(code, 16)) ?? '?').join(''); break;
        case 'ET': runs.push(run); break;
        case 'Do': {
          const form = objects.get(reference(object.dictionary, operands.at(-1).slice(1)));
          if (form?.dictionary.includes('/Subtype /Form')) {
            const own = /\/Matrix \[([^\]]+)\]/.exec(form.dictionary)?.[1].trim().split(/\s+/).map(Number) ?? [1, 0, 0, 1, 0, 0];
            read(form, times(own, current), runs);
          }
          break;
        }
        default: operands.push(token); continue;
      }
      operands = [];
    }
  };

  const kids = [...objects.values()].filter(({dictionary}) => /\/Type \/Page\b(?!s)/.test(dictionary));
  return kids.map(({dictionary}) => {
    const [, , width, height] = /\/MediaBox \[([^\]]+)\]/.exec(dictionary)[1].trim().split(/\s+/).map(Number);
    const runs = [];
    const content = objects.get(reference(dictionary, 'Contents')).content;
    read({dictionary, content}, [1, 0, 0, 1, 0, 0], runs);
    return {width, height, runs: runs.map(({text, x, y}) => ({text, x, y: height - y}))};
  });
}
