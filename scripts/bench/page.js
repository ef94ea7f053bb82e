"use strict";
document.documentElement.classList.add("js");

/* tables: a click or Enter on a header sorts, by data-sort, number or text */
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.querySelectorAll("thead th")];
  const sort = (th, column) => {
    const up = th.getAttribute("aria-sort") !== "ascending";
    heads.forEach(h => h.removeAttribute("aria-sort"));
    th.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = row => {
      const cell = row.cells[column], text = cell.textContent.trim();
      const number = cell.dataset.sort !== undefined ? Number(cell.dataset.sort) : (text === "" ? NaN : Number(text));
      return Number.isNaN(number) ? text : number;
    };
    const order = (a, b) => {
      if (a === "" || b === "") return (a === "") - (b === "");
      const d = typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
      return up ? d : -d;
    };
    const body = table.tBodies[0];
    [...body.rows].map(r => [key(r), r]).sort((a, b) => order(a[0], b[0])).forEach(p => body.append(p[1]));
  };
  heads.forEach((th, column) => {
    th.tabIndex = 0;
    th.addEventListener("click", () => sort(th, column));
    th.addEventListener("keydown", e => { if (e.key === "Enter") sort(th, column); });
  });
}

/* the table of all cells: one menu per column named in data-column, and a text filter */
const cells = document.getElementById("table-cells");
if (cells) {
  const rows = [...cells.tBodies[0].rows], menus = [...document.querySelectorAll(".filters select")];
  const text = document.getElementById("find"), shown = document.getElementById("shown");
  for (const menu of menus) {
    const values = [...new Set(rows.map(r => r.cells[menu.dataset.column].textContent))].sort();
    for (const value of values) menu.append(new Option(value === "" ? "(none)" : value, value));
  }
  const apply = () => {
    let count = 0;
    const words = text.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of rows) {
      const fits = menus.every(m => m.selectedIndex === 0 || row.cells[m.dataset.column].textContent === m.value) &&
        words.every(w => row.textContent.toLowerCase().includes(w));
      row.hidden = !fits;
      count += fits;
    }
    shown.textContent = `${count} of ${rows.length} cells`;
  };
  [...menus, text].forEach(m => m.addEventListener("input", apply));
  /* a link can carry the filter: #cells:A;B sets the words A and B */
  if (location.hash.startsWith("#cells:")) text.value = decodeURIComponent(location.hash.slice(7)).replaceAll(";", " ");
  apply();
}

/* charts: the pictures in the page are replaced by interactive ones when the browser can unpack the library */
async function charts() {
  if (!("DecompressionStream" in window) || window.innerWidth < 700) return; /* on a phone panels side by side are too small: the picture scrolls */
  const packed = Uint8Array.from(atob(document.getElementById("plotly").textContent.trim()), c => c.charCodeAt(0));
  const source = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  const script = document.createElement("script");
  script.textContent = source;
  document.head.append(script);
  const draw = async div => {
    const spec = JSON.parse(document.getElementById("data-" + div.dataset.chart).textContent);
    const target = document.createElement("div");
    div.append(target);
    await Plotly.newPlot(target, spec.data, spec.layout, {responsive: true, displaylogo: false});
    div.querySelector("img").remove();
    div.dataset.drawn = "yes";
  };
  const seen = new IntersectionObserver(found => found.forEach(f => {
    if (f.isIntersecting) { seen.unobserve(f.target); draw(f.target); }
  }), {rootMargin: "600px"});
  document.querySelectorAll(".chart[data-chart]").forEach(d => seen.observe(d));
}
charts();
