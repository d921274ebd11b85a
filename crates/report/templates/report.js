"use strict";
(() => {
  const superscripts = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const plain = (text) => [...text].map((c) => (c === "⁻" ? "-" : superscripts.indexOf(c))).join("");

  // The number that a cell begins with: 0.5, −3, 1.2·10⁻⁷, 10⁴, (10⁴); null where there is none.
  const number = (text) => {
    const found = text.replaceAll("−", "-").match(/^\(?(-?\d+(?:\.\d+)?(?:e-?\d+)?)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)|([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/);
    if (!found) return null;
    if (found[3]) return Number(found[1]) ** Number(plain(found[3]));
    return Number(found[1]) * 10 ** (found[2] ? Number(plain(found[2])) : 0);
  };

  // Numbers by size, then words by the alphabet; what is equal stays in order.
  const compare = (a, b) => {
    const [x, y] = [number(a), number(b)];
    if (x !== null && y !== null) return x - y;
    if (x !== null || y !== null) return x !== null ? -1 : 1;
    return a.localeCompare(b, "en");
  };

  const sort = (table, column, button) => {
    const head = button.closest("th");
    const falling = head.getAttribute("aria-sort") === "ascending";
    for (const other of table.tHead.rows[0].cells) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", falling ? "descending" : "ascending");
    const body = table.tBodies[0];
    const rows = [...body.rows].map((row) => [row.cells[column].textContent.trim(), row]);
    rows.sort((a, b) => (falling ? compare(b[0], a[0]) : compare(a[0], b[0])));
    body.append(...rows.map((pair) => pair[1]));
  };

  for (const table of document.querySelectorAll("main table")) {
    if (table.tBodies[0].rows.length < 2) continue;
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      button.addEventListener("click", () => sort(table, column, button));
      head.append(button);
      head.setAttribute("aria-sort", "none");
    });
  }

  const large = document.getElementById("large");
  const place = large.querySelector("div");
  for (const figure of document.querySelectorAll("main figure")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "enlarge";
    button.textContent = "Enlarge";
    button.setAttribute("aria-label", "Enlarge: " + figure.querySelector("figcaption strong").textContent);
    button.addEventListener("click", () => {
      const copy = figure.querySelector(".drawing").cloneNode(true);
      // The ids of the copy would be there twice.
      for (const marked of copy.querySelectorAll("[id]")) marked.removeAttribute("id");
      place.replaceChildren(copy);
      large.showModal();
    });
    figure.querySelector(".drawing").after(button);
  }
  large.addEventListener("click", (event) => {
    if (event.target === large) large.close();
  });

  // On a narrow screen the contents are closed, and close again when one is chosen.
  const contents = document.getElementById("contents");
  const narrow = matchMedia("(max-width: 62rem)");
  const fit = () => { contents.open = !narrow.matches; };
  narrow.addEventListener("change", fit);
  fit();
  contents.addEventListener("click", (event) => {
    if (narrow.matches && event.target.closest("a")) contents.open = false;
  });

  const links = new Map([...contents.querySelectorAll("a")].map((a) => [a.hash.slice(1), a]));
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      for (const link of links.values()) link.removeAttribute("aria-current");
      links.get(entry.target.id).setAttribute("aria-current", "true");
    }
  }, { rootMargin: "-10% 0px -80% 0px" });
  for (const id of links.keys()) seen.observe(document.getElementById(id));

  // What is printed is printed whole.
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...document.querySelectorAll("main details:not([open])")];
    for (const details of closed) details.open = true;
  });
  addEventListener("afterprint", () => {
    for (const details of closed) details.open = false;
  });
})();
