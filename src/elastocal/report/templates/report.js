"use strict";
(() => {
  const settings = JSON.parse(document.getElementById("figure-settings").textContent);
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const memory = {
    read() { try { return localStorage.getItem("elastocal-theme"); } catch { return null; } },
    write(theme) { try { localStorage.setItem("elastocal-theme", theme); } catch { /* a page of its own may not */ } },
  };
  let chosen = memory.read();
  const theme = () => (chosen === "light" || chosen === "dark" ? chosen : system.matches ? "dark" : "light");

  // figures: drawn as they come near, anew when the theme changes; zoom and camera stay
  const drawn = new Map();
  const config = {
    responsive: true, displaylogo: false,
    modeBarButtonsToRemove: ["sendDataToCloud", "select2d", "lasso2d", "autoScale2d"],
  };
  function described(figure, look) {
    let text = document.querySelector(`script[data-figure="${figure.id}"]`).textContent;
    if (look === "dark") for (const [light, dark] of Object.entries(settings.colors)) text = text.replaceAll(light, dark);
    const found = JSON.parse(text);
    found.layout.template = settings[look];
    found.layout.uirevision = "kept";
    return found;
  }
  function draw(figure, look) {
    if (!window.Plotly || drawn.get(figure) === look) return Promise.resolve();
    const first = !drawn.has(figure), found = described(figure, look);
    drawn.set(figure, look);
    if (!first) keepShown(figure, found);
    return Plotly[first ? "newPlot" : "react"](figure, found.data, found.layout, config).catch((error) => {
      drawn.delete(figure);
      console.error(`${figure.id}: ${error}`);
    });
  }
  function keepShown(figure, found) {
    (figure.data || []).forEach((trace, i) => { if (trace.visible !== undefined) found.data[i].visible = trace.visible; });
    (figure.layout.updatemenus || []).forEach((menu, i) => { found.layout.updatemenus[i].active = menu.active; });
  }
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      entry.target.dataset.near = entry.isIntersecting ? "yes" : "";
      if (entry.isIntersecting) draw(entry.target, theme());
    }
  }, { rootMargin: "600px 0px" });
  const all = () => document.querySelectorAll(".figure");
  function drawAll(look) { return Promise.all([...all()].map((figure) => draw(figure, look || theme()))); }

  const button = document.getElementById("theme");
  function show() {
    root.dataset.theme = theme();
    if (button) button.textContent = theme() === "dark" ? "☀ Light" : "☾ Dark";
    for (const figure of all()) if (figure.dataset.near) draw(figure, theme());
  }
  if (button) {
    button.hidden = false;
    button.addEventListener("click", () => { chosen = theme() === "dark" ? "light" : "dark"; memory.write(chosen); show(); });
  }
  system.addEventListener("change", show);

  // paper is light, and has all figures
  addEventListener("beforeprint", () => { root.dataset.theme = "light"; drawAll("light"); });
  addEventListener("afterprint", show);

  // tables: numbers by size, words by alphabet, empty cells last
  const number = (text) => { const value = parseFloat(text.replace("−", "-")); return Number.isNaN(value) ? null : value; };
  function compare(one, other) {
    const [a, b] = [number(one), number(other)];
    return a !== null && b !== null ? a - b : one.localeCompare(other, "en", { numeric: true });
  }
  function sort(head) {
    const rising = head.getAttribute("aria-sort") !== "ascending", column = head.cellIndex;
    const body = head.closest("table").tBodies[0];
    const text = (row) => row.cells[column].textContent.trim();
    const rows = [...body.rows].sort((one, other) => {
      const [a, b] = [text(one), text(other)];
      if (!a || !b) return (a ? 0 : 1) - (b ? 0 : 1);
      return rising ? compare(a, b) : compare(b, a);
    });
    for (const cell of head.parentNode.cells) cell.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", rising ? "ascending" : "descending");
    body.append(...rows);
  }
  document.addEventListener("click", (event) => {
    const head = event.target.closest("table.sortable thead th");
    if (head && event.target.closest("button")) sort(head);
  });

  // contents: where the reader is; folded on narrow pages
  const links = new Map([...document.querySelectorAll("nav a")].map((link) => [link.hash.slice(1), link]));
  const place = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) {
      for (const link of links.values()) link.classList.remove("current");
      links.get(entry.target.id)?.classList.add("current");
    }
  }, { rootMargin: "-10% 0px -80% 0px" });
  const contents = document.querySelector("nav details");
  if (contents && matchMedia("(max-width: 900px)").matches) contents.open = false;

  function start() {
    for (const figure of all()) near.observe(figure);
    for (const section of document.querySelectorAll("main section")) place.observe(section);
  }
  show();
  start();
  window.elastocalReport = { drawAll, start, show };
})();
