// Formats numbers for people.

export const count = (n) => Math.round(n).toLocaleString('en-US');

/// 68601 -> "68,601", 1234567 -> "1.23 M".
export const many = (n) => (n < 1e6 ? count(n) : `${(n / 1e6).toFixed(2)} M`);

export function bytes(n) {
  if (n < 1000) { return `${n} B`; }
  const unit = n < 1e6 ? 'kB' : n < 1e9 ? 'MB' : 'GB';
  const value = n / { kB: 1e3, MB: 1e6, GB: 1e9 }[unit];
  return `${value.toFixed(value < 10 ? 1 : 0)} ${unit}`;
}

/// The sizes of a box: in millimetres below a metre, else in metres.
export function extent(metres) {
  const isLarge = Math.max(...metres) >= 1;
  return `${metres.map((m) => (isLarge ? m.toFixed(2) : (1000 * m).toFixed(0))).join(' × ')} ${isLarge ? 'm' : 'mm'}`;
}

export function length(metres) {
  return Math.abs(metres) >= 1 ? `${metres.toFixed(2)} m` : `${(1000 * metres).toFixed(0)} mm`;
}
