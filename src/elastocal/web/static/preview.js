// The robot at each measured pose, drawn by plotly from what the server tells.
"use strict";

const UNIT = 1e4; // lengths come in 0.1 mm

function columns(flat) {
  const x = [], y = [], z = [];
  for (let i = 0; i < flat.length; i += 3) { x.push(flat[i] / UNIT); y.push(flat[i + 1] / UNIT); z.push(flat[i + 2] / UNIT); }
  return { x, y, z };
}

function load(source) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = source;
    script.onload = resolve;
    script.onerror = reject;
    document.head.append(script);
  });
}

function picked(at, which) {
  return { x: which.map((i) => at.x[i]), y: which.map((i) => at.y[i]), z: which.map((i) => at.z[i]) };
}

class Preview {
  constructor(box, data) {
    this.box = box;
    this.data = data;
    this.scene = box.querySelector(".scene");
    this.slider = box.querySelector("input");
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.dark.addEventListener("change", () => this.draw());
    this.slider.addEventListener("input", () => requestAnimationFrame(() => this.move()));
  }

  at(row) {
    const line = columns(this.data.poses[row]);
    const joints = Array.isArray(this.data.joints[0]) ? this.data.joints[row] : this.data.joints;
    const here = this.data.points[row];
    return { line, joints: picked(line, joints), here: here ? columns(here) : { x: [], y: [], z: [] } };
  }

  cloud() {
    const measured = this.data.points.map((point, i) => [point, i]).filter(([point]) => point);
    const every = Math.max(1, Math.ceil(measured.length / 2000));
    const kept = measured.filter((_, i) => i % every === 0);
    this.thinned = kept.length < measured.length ? ` ${kept.length} of ${measured.length} points drawn.` : "";
    const errors = this.data.errors;
    return { ...columns(kept.flatMap(([point]) => point)), customdata: kept.map(([, i]) => i), errors: errors && kept.map(([, i]) => errors[i]) };
  }

  draw() {
    const style = this.data.style[this.dark.matches ? "dark" : "light"];
    const cloud = this.cloud(), now = this.at(+this.slider.value);
    const marker = cloud.errors
      ? { size: 3, color: cloud.errors, colorscale: "Cividis", cmin: 0, colorbar: { title: { text: "error [mm]", side: "top" }, orientation: "h", thickness: 8, len: 0.7, x: 0.5, y: 1, yanchor: "top" } }
      : { size: 3, color: style.link };
    const traces = [
      { type: "scatter3d", mode: "markers", name: "measured points", x: cloud.x, y: cloud.y, z: cloud.z, customdata: cloud.customdata, marker: { ...marker, opacity: 0.75 }, hovertemplate: cloud.errors ? "%{marker.color:.2f} mm<extra></extra>" : "<extra></extra>" },
      { type: "scatter3d", mode: "lines", ...now.line, line: { color: style.link, width: 9 }, hoverinfo: "skip" },
      { type: "scatter3d", mode: "markers", ...now.joints, marker: { size: 5, color: style.joint }, hoverinfo: "skip" },
      { type: "scatter3d", mode: "markers", ...now.here, marker: { size: 7, color: style.here, symbol: "diamond" }, hoverinfo: "skip" },
    ];
    const axis = (title) => ({ title: { text: title }, nticks: 6 });
    const layout = { template: style.template, showlegend: false, uirevision: "stays", margin: { l: 0, r: 0, t: 0, b: 0 },
      scene: { domain: { x: [0, 1], y: [0, 0.88] }, aspectmode: "data", xaxis: axis("x [m]"), yaxis: axis("y [m]"), zaxis: axis("z [m]"), camera: { eye: { x: 1.75, y: -1.75, z: 0.75 }, center: { x: 0, y: 0, z: -0.12 } } } };
    const first = !this.scene.classList.contains("js-plotly-plot");
    Plotly.react(this.scene, traces, layout, { responsive: true, displaylogo: false, displayModeBar: false });
    if (first) {
      this.scene.on("plotly_click", (event) => {
        const row = event.points[0].customdata;
        if (row !== undefined) { this.slider.value = row; this.move(); }
      });
    }
    this.tell();
  }

  move() {
    const now = this.at(+this.slider.value);
    const of = (axis) => [now.line[axis], now.joints[axis], now.here[axis]];
    Plotly.restyle(this.scene, { x: of("x"), y: of("y"), z: of("z") }, [1, 2, 3]);
    this.tell();
  }

  tell() {
    const row = +this.slider.value, data = this.data;
    this.box.querySelector("output").textContent = `${row + 1} of ${data.poses.length}`;
    const missed = data.errors ? ` The nominal robot, put where it stands, is ${data.errors[row].toFixed(2)} mm from this point.` : "";
    const joints = data.q[row].map((q) => q.toFixed(1)).join(", ");
    this.box.querySelector(".caption").textContent = `${data.names[row]}: joints ${joints}.${missed}${this.thinned}`;
  }
}

document.addEventListener("DOMContentLoaded", async () => {
  const box = document.getElementById("preview");
  if (!box) return;
  const caption = box.querySelector(".caption");
  try {
    const [answer] = await Promise.all([fetch(box.dataset.url), load("/plotly.min.js")]);
    if (!answer.ok) throw new Error(await answer.text());
    new Preview(box, await answer.json()).draw();
    box.classList.add("drawn");
  } catch (error) {
    caption.textContent = `The preview cannot be drawn: ${error.message || "its files did not load"}`;
  }
});
