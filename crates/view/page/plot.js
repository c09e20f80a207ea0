// Error against seconds, both logarithmic.

const PAD = { left: 46, right: 8, top: 8, bottom: 22 };

export function plot(canvas, points) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  const style = getComputedStyle(document.body);
  const colour = (name) => style.getPropertyValue(name).trim();
  context.font = "11px system-ui, sans-serif";
  if (points.length < 2) return;
  const logs = points.map(([seconds, error]) => [Math.log10(Math.max(seconds, 1e-3)), Math.log10(error)]);
  const range = (axis) => {
    const values = logs.map((point) => point[axis]);
    const [least, most] = [Math.floor(Math.min(...values)), Math.ceil(Math.max(...values))];
    return [least, Math.max(most, least + 1)];
  };
  const [xs, ys] = [range(0), range(1)];
  const x = (v) => PAD.left + ((v - xs[0]) / (xs[1] - xs[0])) * (width - PAD.left - PAD.right);
  const y = (v) => height - PAD.bottom - ((v - ys[0]) / (ys[1] - ys[0])) * (height - PAD.top - PAD.bottom);
  context.strokeStyle = colour("--line");
  context.fillStyle = colour("--soft");
  for (let v = xs[0]; v <= xs[1]; v++) {
    line(context, [[x(v), PAD.top], [x(v), height - PAD.bottom]]);
    context.textAlign = "center";
    context.fillText(`${Number((10 ** v).toPrecision(1))} s`, Math.min(x(v), width - 16), height - 6);
  }
  for (let v = ys[0]; v <= ys[1]; v++) {
    line(context, [[PAD.left, y(v)], [width - PAD.right, y(v)]]);
    context.textAlign = "right";
    context.fillText(`1e${v}`, PAD.left - 6, y(v) + 4);
  }
  context.strokeStyle = colour("--accent");
  context.lineWidth = 2;
  line(context, logs.map(([a, b]) => [x(a), y(b)]));
}

function line(context, points) {
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
}
