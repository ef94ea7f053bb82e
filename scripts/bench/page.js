"use strict";
document.documentElement.classList.add("js");

/* tables: a short one is in the page; of a long one the page has the first rows, and all of them packed beside. Rows are
 * arrays of cells [text, mark, title, sort]; as many as the page has are drawn at a time. */
const unpack = async id => {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent.trim()), c => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
};
const button = (text, act) => {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.addEventListener("click", act);
  return made;
};
const copied = async (node, text) => {
  const before = node.textContent;
  try { await navigator.clipboard.writeText(text); node.textContent = "copied"; } catch { node.textContent = "select and copy"; }
  setTimeout(() => { node.textContent = before; }, 1200);
};
document.addEventListener("click", e => {
  if (e.target.matches("button.copy")) copied(e.target, e.target.nextElementSibling.textContent);
});
const withCopy = td => {
  const code = td.querySelector("code");
  if (!code || td.querySelector("button.copy")) return;
  const made = button("copy", () => {});
  made.className = "copy";
  td.prepend(made);
};

class Rows {
  constructor(table) {
    this.table = table;
    this.body = table.tBodies[0];
    this.heads = [...table.querySelectorAll("thead th")];
    this.code = table.dataset.code === undefined ? -1 : Number(table.dataset.code);
    this.nodes = [...this.body.rows];
    this.step = this.nodes.length;
    this.all = this.nodes.map(r => [...r.cells].map(c => [c.textContent, c.className, c.title, c.dataset.sort]));
    this.order = this.all.map((_, i) => i);
    this.packed = document.getElementById("rows-" + table.id.slice(6));
    this.keep = () => true;
    this.shown = this.all.length;
    this.more = button("", () => { this.shown += this.step; this.draw(); });
    this.more.hidden = true;
    table.parentElement.after(this.more, button("CSV", () => this.load().then(() => this.save())));
    if (this.packed) this.more.hidden = false, this.more.textContent = "all rows";
    if (this.packed) this.more.onclick = () => this.load();
    table.parentElement.addEventListener("scroll", e => {
      const box = e.target;
      if (this.loaded && this.shown < this.order.length && box.scrollTop + box.clientHeight > box.scrollHeight - 300) {
        this.shown += this.step;
        this.draw();
      }
    });
    this.heads.forEach((th, column) => {
      th.tabIndex = 0;
      const act = () => this.load().then(() => this.sort(th, column));
      th.addEventListener("click", act);
      th.addEventListener("keydown", e => { if (e.key === "Enter") act(); });
    });
    for (const td of this.body.querySelectorAll("td:has(>code)")) withCopy(td);
  }
  async load() {
    if (this.loaded) return;
    if (this.packed) {
      const cell = c => Array.isArray(c) ? [c[0], c[1], c[2], c[3] ?? undefined] : [c, "", "", undefined];
      this.all = JSON.parse(await unpack(this.packed.id)).map(r => r.map(cell));
      this.order = this.all.map((_, i) => i);
      this.nodes = null;
      this.shown = this.step;
      this.more.onclick = null;
    }
    this.loaded = true;
    if (this.packed) this.draw();
  }
  node(i) {
    if (this.nodes) return this.nodes[i];
    const tr = document.createElement("tr");
    this.all[i].forEach(([text, mark, title], column) => {
      const td = tr.insertCell();
      if (mark) td.className = mark;
      if (title) td.title = title;
      if (column === this.code && text) {
        td.append(document.createElement("code"));
        td.lastChild.textContent = text;
        withCopy(td);
      } else text.split("\n").forEach((part, k) => td.append(...(k ? [document.createElement("br"), part] : [part])));
    });
    return tr;
  }
  draw() {
    const some = this.order.slice(0, this.shown);
    this.body.replaceChildren(...some.map(i => this.node(i)));
    this.more.hidden = this.shown >= this.order.length;
    this.more.textContent = `${Math.min(this.step, this.order.length - this.shown)} more of ${this.order.length}`;
  }
  filter(keep) {
    this.order = this.all.map((_, i) => i).filter(i => keep(this.all[i]));
    this.shown = this.nodes ? this.all.length : this.step;
    if (this.sorted) this.arrange(); else this.draw();
    return this.order.length;
  }
  sort(th, column) {
    const up = th.getAttribute("aria-sort") !== "ascending";
    this.heads.forEach(h => h.removeAttribute("aria-sort"));
    th.setAttribute("aria-sort", up ? "ascending" : "descending");
    this.sorted = [column, up];
    this.arrange();
  }
  arrange() {
    const [column, up] = this.sorted;
    const key = i => {
      const [text, , , sort] = this.all[i][column], plain = text.trim();
      const number = sort !== undefined ? Number(sort) : (plain === "" ? NaN : Number(plain));
      return Number.isNaN(number) ? plain : number;
    };
    const compare = (a, b) => {
      if (a === "" || b === "") return (a === "") - (b === "");
      const d = typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
      return up ? d : -d;
    };
    this.order = this.order.map(i => [key(i), i]).sort((a, b) => compare(a[0], b[0])).map(p => p[1]);
    this.draw();
  }
  save() {
    const quoted = text => /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    const lines = [this.heads.map(h => h.textContent), ...this.order.map(i => this.all[i].map(c => c[0]))];
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([lines.map(l => l.map(quoted).join(",") + "\n").join("")], {type: "text/csv"}));
    link.download = this.table.id.slice(6) + ".csv";
    link.click();
    URL.revokeObjectURL(link.href);
  }
}
const tables = new Map([...document.querySelectorAll("table.sortable")].map(t => [t.id, new Rows(t)]));

/* the table of all cells: one menu per column named in data-column, and a text filter */
const cells = tables.get("table-cells");
if (cells) {
  const menus = [...document.querySelectorAll(".filters select")];
  const text = document.getElementById("find"), shown = document.getElementById("shown");
  const apply = () => {
    const words = text.value.toLowerCase().split(/\s+/).filter(Boolean);
    const count = cells.filter(row => menus.every(m => m.selectedIndex === 0 || row[m.dataset.column][0] === m.value) &&
      words.every(w => row.some(c => c[0].toLowerCase().includes(w))));
    shown.textContent = `${count} of ${cells.all.length} cells`;
  };
  const begin = async () => {
    await cells.load();
    for (const menu of menus) {
      const values = [...new Set(cells.all.map(r => r[menu.dataset.column][0]))].sort();
      for (const value of values) menu.append(new Option(value === "" ? "(none)" : value, value));
    }
    [...menus, text].forEach(m => m.addEventListener("input", apply));
    /* a link can carry the filter: #cells:A;B sets the words A and B */
    if (location.hash.startsWith("#cells:")) text.value = decodeURIComponent(location.hash.slice(7)).replaceAll(";", " ");
    apply();
  };
  begin();
}

/* charts: the pictures in the page are replaced by interactive ones when the browser can unpack the library */
const dark = matchMedia("(prefers-color-scheme: dark)").matches;
const darken = layout => {
  layout.paper_bgcolor = layout.plot_bgcolor = "#14181f";
  layout.font = {...layout.font, color: "#e3e7ee"};
  for (const [name, axis] of Object.entries(layout)) {
    if (/^[xy]axis/.test(name)) Object.assign(axis, {gridcolor: "#2a313c", linecolor: "#8a92a0"});
  }
};
async function charts() {
  if (!("DecompressionStream" in window) || window.innerWidth < 700) return; /* on a phone panels side by side are too small: the picture scrolls */
  const source = await unpack("plotly");
  const script = document.createElement("script");
  script.textContent = source;
  document.head.append(script);
  const draw = async div => {
    const spec = JSON.parse(document.getElementById("data-" + div.dataset.chart).textContent);
    if (dark) darken(spec.layout);
    const target = document.createElement("div");
    div.append(target);
    await Plotly.newPlot(target, spec.data, spec.layout, {responsive: true, displaylogo: false,
      toImageButtonOptions: {format: "svg", filename: "lcpbench-" + div.dataset.chart}});
    div.querySelector("img").remove();
    div.dataset.drawn = "yes";
  };
  const seen = new IntersectionObserver(found => found.forEach(f => {
    if (f.isIntersecting) { seen.unobserve(f.target); draw(f.target); }
  }), {rootMargin: "600px"});
  document.querySelectorAll(".chart[data-chart]").forEach(d => seen.observe(d));
}
charts();
