// SPDX-License-Identifier: Apache-2.0
// Contrast after WCAG 2.1, and how far two colours stay apart for eyes that lack a cone type.

export const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
const linear = (channel) => (channel <= 0.04045 ? channel / 12.92 : ((channel + 0.055) / 1.055) ** 2.4);
const linearRgb = (colour) => colour.map((channel) => linear(channel / 255));
const luminance = (colour) => linearRgb(colour).reduce((sum, value, i) => sum + value * [0.2126, 0.7152, 0.0722][i], 0);

export function contrast(a, b) {
  const [high, low] = [luminance(a), luminance(b)].sort((x, y) => y - x);
  return (high + 0.05) / (low + 0.05);
}

// Full loss of one cone type, on linear RGB: Machado, Oliveira, Fernandes, IEEE TVCG 15(6), 2009, severity 1.0.
export const kVision = {
  normal: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
};

function lab(linearColour) {
  const [r, g, b] = linearColour.map((value) => Math.min(1, Math.max(0, value)));
  const f = (t) => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
  const x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047);
  const y = f(0.2126 * r + 0.7152 * g + 0.0722 * b);
  const z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

// CIE 1976 colour difference as seen with `vision`; 2.3 is just noticeable side by side.
export function difference(a, b, vision) {
  const seen = (colour) => lab(vision.map((row) => row.reduce((sum, value, i) => sum + value * linearRgb(colour)[i], 0)));
  const [p, q] = [seen(a), seen(b)];
  return Math.hypot(...p.map((value, i) => value - q[i]));
}
