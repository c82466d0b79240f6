// Rules that each page keeps for keyboards, screen readers, narrow screens and readers who see no colours [WCAG 2.1, AA].
// Returns the faults, a sentence each.
function faultsOfPage() {
  const TEXT_CONTRAST = 4.5, LARGE_CONTRAST = 3;  // WCAG 1.4.3
  const LARGE_PX = 24, LARGE_BOLD_PX = 18.66;
  const NARROW_PX = 320;      // WCAG 1.4.10
  const LEAST_OUTLINE_PX = 2;
  const faults = [];
  const words = element => element.textContent.trim().replace(/\s+/g, " ").slice(0, 60);
  const all = selector => [...document.querySelectorAll(selector)];

  function checkHead() {
    if (!document.documentElement.lang) faults.push("the page names no language");
    if (!document.title.trim()) faults.push("the page has no title");
    if (!document.querySelector("main")) faults.push("the page has no main part");
    const ids = all("[id]").map(element => element.id);
    ids.filter((id, i) => ids.indexOf(id) < i).forEach(id => faults.push(`two elements have the id '${id}'`));
  }

  function checkHeadings() {
    let level = 0;
    for (const heading of all("h1,h2,h3,h4,h5,h6")) {
      const next = Number(heading.tagName[1]);
      if (!words(heading)) faults.push("a heading is empty");
      if (next > level + 1) faults.push(`the heading '${words(heading)}' has level ${next} below level ${level}`);
      level = next;
    }
    const titles = all("h1").length;
    if (titles !== 1) faults.push(`the page has ${titles} headings of level 1`);
  }

  function checkPictures() {
    for (const svg of all("svg")) {
      const title = svg.querySelector(":scope > title");
      if (svg.getAttribute("role") !== "img" || !title || !words(title))
        faults.push(`a figure says nothing to a screen reader: '${words(svg)}'`);
    }
    for (const image of all("img")) if (!image.alt) faults.push(`the picture ${image.src} has no alt text`);
  }

  // Series may not be told apart by colour alone: their samples in a legend differ in shape or dashes.
  function checkLegends() {
    for (const panel of all("svg > g")) {
      const samples = [...panel.querySelectorAll(".key > *")].map(mark =>
        [mark.tagName, mark.getAttribute("class"), mark.getAttribute("d"), mark.getAttribute("stroke-dasharray")].join(" "));
      if (new Set(samples).size < samples.length)
        faults.push(`series are told apart by colour alone: '${words(panel.querySelector(".title") || panel)}'`);
    }
  }

  function checkTables() {
    for (const table of all("table")) {
      const name = table.caption || document.getElementById(table.getAttribute("aria-labelledby"));
      const called = name ? words(name) : words(table);
      if (!name || !words(name)) faults.push(`a table has no caption: '${called}'`);
      const heads = [...table.querySelectorAll("th")];
      if (heads.length === 0) faults.push(`the table '${called}' has no header cells`);
      for (const head of heads) {
        if (!["col", "row", "colgroup", "rowgroup"].includes(head.scope))
          faults.push(`the table '${called}' does not say what '${words(head)}' heads`);
        if (!words(head)) faults.push(`the table '${called}' has an empty header cell`);
      }
    }
  }

  function checkLinks() {
    for (const link of all("a")) {
      const to = link.getAttribute("href");
      if (!words(link)) faults.push(`a link to ${to} has no text`);
      if (to && to.startsWith("#") && !document.getElementById(to.slice(1))) faults.push(`a link leads to ${to}, which is not there`);
    }
  }

  function checkFocus() {
    for (const element of all("a[href],summary,[tabindex]")) {
      element.focus();
      const style = getComputedStyle(element);
      const shown = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= LEAST_OUTLINE_PX;
      if (document.activeElement !== element) faults.push(`'${words(element)}' cannot be reached by the keyboard`);
      else if (!shown) faults.push(`'${words(element)}' does not show that it has the focus`);
    }
    if (document.activeElement) document.activeElement.blur();
  }

  const colorOf = text => {
    const numbers = (text.match(/[\d.]+/g) || [0, 0, 0, 0]).map(Number);
    return {rgb: numbers.slice(0, 3), alpha: numbers.length > 3 ? numbers[3] : 1};
  };
  const mixed = (over, under) => over.rgb.map((channel, i) => over.alpha * channel + (1 - over.alpha) * under[i]);
  const luminance = rgb => {
    const [r, g, b] = rgb.map(level => level / 255).map(s => s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  function backgroundOf(element) {
    const layers = [];
    for (let e = element; e; e = e.parentElement) {
      const paper = e.tagName === "svg" && e.querySelector(":scope > rect");
      const style = getComputedStyle(paper || e);
      layers.unshift(colorOf(paper ? style.fill : style.backgroundColor));
    }
    return layers.reduce((under, layer) => mixed(layer, under), [255, 255, 255]);
  }
  // Text that is painted over its own outline, as in a photograph, stands on that.
  const outlineOf = style =>
    style.paintOrder.startsWith("stroke") && parseFloat(style.strokeWidth) >= LEAST_OUTLINE_PX ? colorOf(style.stroke).rgb : null;
  function checkContrast() {
    const seen = new Set();
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const element = walker.currentNode.parentElement;
      if (!walker.currentNode.data.trim() || element.closest("script,style,title,desc")) continue;
      const style = getComputedStyle(element);
      const color = colorOf(element.closest("svg") ? style.fill : style.color), under = outlineOf(style) || backgroundOf(element);
      const px = parseFloat(style.fontSize), bold = Number(style.fontWeight) >= 700;
      const [dark, light] = [luminance(mixed(color, under)), luminance(under)].sort((a, b) => a - b);
      const contrast = (light + 0.05) / (dark + 0.05);
      const needed = px >= LARGE_PX || (bold && px >= LARGE_BOLD_PX) ? LARGE_CONTRAST : TEXT_CONTRAST;
      const fault = `the contrast of text is ${contrast.toFixed(1)} where ${needed} is needed: '${words(element)}'`;
      if (contrast < needed && !seen.has(fault)) faults.push(fault);
      seen.add(fault);
    }
  }

  // Nothing but what scrolls by itself is wider than a narrow screen.
  function checkNarrow() {
    const root = document.documentElement;
    root.style.width = `${NARROW_PX}px`;
    const wide = all("body *").filter(element => element.getBoundingClientRect().right > NARROW_PX + 1 &&
      !element.closest(".wide") && !element.closest("svg *"));
    if (wide.length) faults.push(`at ${NARROW_PX} px a <${wide[0].tagName.toLowerCase()}> does not fit: '${words(wide[0])}'`);
    root.style.width = "";
  }

  checkHead();
  checkHeadings();
  checkPictures();
  checkLegends();
  checkTables();
  checkLinks();
  checkFocus();
  checkContrast();
  checkNarrow();
  return faults;
}
