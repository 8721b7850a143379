// Uploads, drops, confirmations: all that the page does beside htmx.
"use strict";

const LIMIT = 200 * 1024 * 1024;

function line(list, text, failed) {
  const row = document.createElement("div");
  row.className = failed ? "failed" : "";
  row.append(text);
  list.append(row);
  return row;
}

function send(run, file, bar) {
  return new Promise((resolve) => {
    const request = new XMLHttpRequest();
    request.open("PUT", `/runs/${run}/files/${encodeURIComponent(file.name)}`);
    request.upload.onprogress = (event) => { bar.max = event.total; bar.value = event.loaded; };
    request.onload = () => resolve(request.status === 201 ? "" : request.responseText || `refused (${request.status})`);
    request.onerror = () => resolve("could not be sent: is the page's program still running?");
    request.send(file);
  });
}

async function take(zone, files) {
  const list = zone.querySelector("[data-uploads]");
  list.replaceChildren();
  const sound = [];
  for (const file of files) {
    if (file.size > LIMIT) line(list, `${file.name}: ${Math.ceil(file.size / 1048576)} MB; a file may have 200 MB at most.`, true);
    else sound.push(file);
  }
  if (!sound.length) return;
  let run = zone.dataset.run;
  if (!run) {
    const made = await fetch("/runs", { method: "POST", headers: { accept: "text/plain" } });
    if (!made.ok) { line(list, await made.text(), true); return; }
    run = made.headers.get("location").split("/").pop();
  }
  let failed = list.childElementCount;
  for (const file of sound) {
    const row = line(list, file.name);
    const bar = document.createElement("progress");
    row.append(bar);
    const fault = await send(run, file, bar);
    if (fault) { failed += 1; row.className = "failed"; row.replaceChildren(`${file.name}: ${fault}`); } else row.remove();
  }
  if (!failed) location.assign(`/runs/${run}`);
  else {
    const on = document.createElement("a");
    on.href = `/runs/${run}`;
    on.textContent = "Go on without";
    line(list, on);
  }
}

document.addEventListener("DOMContentLoaded", () => {
  for (const zone of document.querySelectorAll("[data-drop]")) {
    zone.querySelector("[data-files]").addEventListener("change", (event) => take(zone, event.target.files));
  }
  const zone = document.querySelector("[data-drop]");
  for (const name of ["dragover", "dragleave", "drop"]) {
    document.addEventListener(name, (event) => {
      if (!event.dataTransfer || !event.dataTransfer.types.includes("Files")) return;
      event.preventDefault(); // a file dropped beside the zone must not take the page's place
      if (zone) zone.classList.toggle("over", name === "dragover");
      if (zone && name === "drop") take(zone, event.dataTransfer.files);
    });
  }
});

document.addEventListener("change", (event) => {
  const form = event.target.closest("[data-submit-on-change]");
  if (form) form.requestSubmit();
});

document.addEventListener("click", (event) => {
  const button = event.target.closest("[data-confirm]");
  if (button && !confirm(button.dataset.confirm)) event.preventDefault();
});
