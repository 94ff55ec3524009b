// The plot, the table and the CSV file of the lab hour.

/** Draws panels side by side: {title, x, y, lines}. An axis is {name, from, to, log, ticks, words}, a line {points,
 *  colour, words, width, dashes}. What colours mean is written below, by the first panel's lines. */
export function plot(canvas, panels) {
  canvas.hidden = false;
  const scale = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  const top = 46, bottom = height - (width < 640 ? 100 : 66);
  Object.assign(canvas, {width: width * scale, height: height * scale});
  const c = canvas.getContext('2d');
  c.scale(scale, scale);
  c.font = '13px system-ui, sans-serif';
  const write = (words, x, y, textAlign, fillStyle = '#a9b0bc') =>
    Object.assign(c, {textAlign, fillStyle}).fillText(words, x, y);
  const share = ({log, from, to}, v) => (log ? Math.log(v / from) / Math.log(to / from) : (v - from) / (to - from));
  for (const [n, {title, x, y, lines}] of panels.entries()) {
    const left = n * width / panels.length + 56, right = (n + 1) * width / panels.length - 14;
    const at = ([a, b]) =>
      [left + share(x, a) * (right - left), bottom - share(y, Math.max(b, y.from)) * (bottom - top)];
    const draw = ({points, colour, width: lineWidth = 1.8, dashes = []}) => {
      Object.assign(c, {strokeStyle: colour, lineWidth}).setLineDash(dashes);
      c.beginPath();
      for (const point of points) c.lineTo(...at(point));
      c.stroke();
    };
    x.ticks.forEach((v, k) => write(x.words?.[k] ?? v, at([v, 0])[0], bottom + 18, 'center'));
    for (const v of y.ticks) {
      draw({points: [[x.from, v], [x.to, v]], colour: '#2c3038', width: 1});
      write(y.log && v < 0.01 ? v.toExponential(0) : v, left - 8, at([x.from, v])[1] + 4, 'right');
    }
    write(title, left, 16, 'left', '#eef0f4');
    write(x.name, right, bottom + 36, 'right');
    write(y.name, left - 50, 34, 'left');
    lines.forEach(draw);
  }
  let begin = 6, row = bottom + 58;
  for (const {words, colour} of panels[0].lines.filter((line) => line.words)) {
    const wide = c.measureText(words).width;
    if (begin + wide > width) [begin, row] = [6, row + 18];
    write(words, begin, row, 'left', colour);
    begin += wide + 22;
  }
}

/** A table, whose first row is its heading; numbers have four digits, as the program prints them. */
export function show(table, rows) {
  table.replaceChildren(...rows.map((cells, k) => {
    const line = document.createElement('tr');
    for (const value of cells) {
      const cell = line.appendChild(document.createElement(k > 0 ? 'td' : 'th'));
      cell.textContent = typeof value === 'number' ? Number(value.toPrecision(4)) : value;
      if (typeof value === 'string') cell.className = {equal: 'equal', not: 'other'}[value.split(' ')[0]] ?? 'word';
    }
    return line;
  }));
}

export function save(name, rows) {
  const text = rows.map((row) => row.map((value) => `"${value}"`).join(',')).join('\n');
  const href = URL.createObjectURL(new Blob([text, '\n'], {type: 'text/csv'}));
  Object.assign(document.createElement('a'), {href, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(href), 10_000);
}
