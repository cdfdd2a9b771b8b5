// Packed numbers: 16-bit steps over a range, the lowest for "none".
function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

function unpacked({ low, step, steps }) {
  const whole = new Int16Array(bytes(steps).buffer);
  return Float32Array.from(whole, (k) => (k === -32767 ? NaN : low + step * (k + 32766)));
}

// Colours of a map at a share of its range.
function colourMap(text) {
  const table = bytes(text);
  return (share) => {
    const k = 3 * Math.round(255 * Math.min(Math.max(share, 0), 1));
    return [table[k] / 255, table[k + 1] / 255, table[k + 2] / 255];
  };
}
