// Measures as text: for the page, the clipboard and CSV.

import { kStated } from './uncertainty.js';

/// How many of each are a metre.
export const kUnits = { mm: 1000, cm: 100, m: 1, in: 1 / 0.0254 };
const kSigns = { length: (unit) => unit, area: (unit) => `${unit}²`, angle: () => '°' };
const kFactors = { length: (unit) => kUnits[unit], area: (unit) => kUnits[unit] ** 2, angle: () => 180 / Math.PI };
const kTitles = { distance: 'Distance', angle: 'Angle', section: 'Section', diameter: 'Diameter' };

/// {value, spread, sign}: the uncertainty to two digits, the value to the same place, in that unit. A `spread` of '' is not known.
export function stated({ value, sigma, dimension }, unit) {
  const factor = kFactors[dimension](unit);
  const spread = kStated * sigma * factor;
  const sign = kSigns[dimension](unit);
  if (!(spread > 0 && Number.isFinite(spread))) { return { value: String(Number((factor * value).toPrecision(5))), spread: '', sign }; }
  const digits = Math.min(Math.max(1 - Math.floor(Math.log10(spread)), 0), 9);
  return { value: (factor * value).toFixed(digits), spread: spread.toFixed(digits), sign };
}

export function inWords(value, unit) {
  const { value: number, spread, sign } = stated(value, unit);
  const gap = sign === '°' ? '' : ' ';
  return spread === '' ? `${number}${gap}${sign} ± ?` : `${number} ± ${spread}${gap}${sign}`;
}

/// Lines of a measure besides its first value.
export function details({ values, words, rmsM, from }, unit) {
  const factor = kUnits[unit];
  return [
    ...values.slice(1).map((value) => `${value.name.toLowerCase()} ${inWords(value, unit)}`), ...words,
    rmsM === undefined ? '' : `rms ${Number((factor * rmsM).toPrecision(2))} ${unit}`, from === 'unknown' ? 'noise not known' : '',
  ].filter(Boolean);
}

export const title = ({ kind }) => kTitles[kind];

/// One line a measure.
export const asText = (measures, { unit, mesh }) => [mesh, ...measures.map((one, i) =>
  [`${i + 1} ${title(one)} ${inWords(one.values[0], unit)}`, ...details(one, unit)].join(', ')), ''].join('\n');

/// One row a value; the points in the unit. RFC 4180.
export function asCsv(measures, { unit, mesh }) {
  const rows = [['number', 'measure', 'value', 'uncertainty', 'unit', 'uncertainty_from', 'points', 'mesh']];
  measures.forEach((one, i) => {
    const points = one.picks.map(({ p }) => p.map((x) => Number((kUnits[unit] * x).toPrecision(7))).join(' ')).join('; ');
    for (const value of one.values) {
      const { value: number, spread, sign } = stated(value, unit);
      const name = value.name === title(one) ? value.name : `${title(one)}: ${value.name.toLowerCase()}`;
      rows.push([i + 1, name, number, spread, sign === '°' ? 'degree' : sign.replace('²', '2'), one.from, points, mesh]);
    }
  });
  return rows.map((row) => row.map(cell).join(',') + '\r\n').join('');
}

const cell = (value) => (/[",\r\n]/.test(String(value)) ? `"${String(value).replace(/"/g, '""')}"` : String(value));
