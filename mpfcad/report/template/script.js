// Draws each figure when it comes to be seen: a folded section has no width to draw into.
const dark = matchMedia("(prefers-color-scheme: dark)");
const axisOf = name => /^(x|y)axis\d*$/.test(name);
// Paper is white, whatever the screen.
function dress(layout, paper) {
  const night = dark.matches && !paper;
  const made = structuredClone(layout);
  made.font = {...made.font, color: night ? "#dbe2ea" : "#222"};
  for (const key of Object.keys(made)) if (axisOf(key))
    made[key].gridcolor = night ? "#3b444e" : "#e4e4e4";
  return made;
}
// Lines that are dark enough for paper are too dark for a dark screen.
const lighter = {"#0b5fa5": "#5aa9ec", "#8a6d3b": "#cba868", "#3f7f4f": "#6fc288",
  "#c03a6b": "#f07ba6", "#7a4d9f": "#b98fe0", "#b5541c": "#f0905a"};
const lit = text => dark.matches ? text.replace(/#[0-9a-f]{6}/g, colour => lighter[colour] ?? colour) : text;
// Of a page's width on paper, and of two figures beside each other.
const PAPER = 700, HALF = 342;
const isNarrow = across => across < 560;
function draw(place, width) {
  place.figure ??= JSON.parse(place.nextElementSibling.textContent);
  const layout = dress(place.figure.layout, width !== undefined);
  if (width) Object.assign(layout, {width, height: Math.max(Math.min(layout.height, 0.75 * layout.height + 40), 130)});
  place.style.height = layout.height + "px";
  const across = place.across = width ?? place.clientWidth;
  if (layout.scene) stepBack(layout.scene, across / layout.height);
  const narrow = isNarrow(across);
  const columns = Object.keys(layout).filter(key => /^xaxis\d*$/.test(key));
  if (narrow && columns.length > 1 && layout.annotations?.length) stack(layout, columns, place);
  const text = JSON.stringify(place.figure.data);
  const data = JSON.parse(width === undefined ? lit(text) : text);
  if (narrow) lieDown(data);
  // Margins of another width would stay with the plot.
  if (place.drawn) Plotly.purge(place);
  Plotly.newPlot(place, data, layout, place.figure.config);
  place.drawn = true;
}
// A place that is narrower than high shows a scene's height: from farther off its width, too.
const SQUARE = 1.3;
function stepBack(scene, shape) {
  const {eye} = scene.camera, away = Math.max(SQUARE / shape, 1);
  for (const axis of "xyz") eye[axis] *= away;
}
// A map on a phone has its scale below.
function lieDown(data) {
  const bars = data.filter(trace => trace.colorbar).map(trace => trace.colorbar);
  if (bars.length === 1) Object.assign(bars[0], {orientation: "h", thickness: 12, len: 0.9,
    x: 0.5, xanchor: "center", yref: "container", y: 0, yanchor: "bottom"});
}
// On a phone plots beside each other stand above each other.
function stack(layout, columns, place) {
  const count = columns.length, gap = 0.26 / count;
  const high = (1 - gap * (count - 1)) / count;
  columns.forEach((key, i) => {
    const upper = 1 - i * (high + gap);
    layout[key].domain = [0, 1];
    layout[key.replace("x", "y")].domain = [Math.max(upper - high, 0), upper];
    const title = layout.annotations[i];
    if (title) Object.assign(title, {x: 0.5, y: upper, xanchor: "center", yanchor: "bottom"});
    if (i < count - 1) layout[key].title = {text: ""};
  });
  layout.height *= 0.75 * count;
  layout.margin = {...layout.margin, l: 48, r: 8};
  place.style.height = layout.height + "px";
}
const plots = () => [...document.querySelectorAll(".plot")];
const seen = place => place.getClientRects().length > 0;
const drawSeen = () => plots().forEach(place => seen(place) && !place.drawn && draw(place));
// What scrolls sideways is reached by the keyboard, and only that.
const reach = () => document.querySelectorAll(".scroll, figure").forEach(part => {
  const wide = part.scrollWidth > part.clientWidth && getComputedStyle(part).overflowX === "auto";
  const names = {tabindex: 0, role: "group", "aria-label": "wider than the page: scrolls sideways"};
  for (const [name, value] of Object.entries(names))
    if (wide) part.setAttribute(name, value); else part.removeAttribute(name);
});
const unfold = () => { drawSeen(); reach(); };
document.querySelectorAll("details").forEach(part => part.addEventListener("toggle", unfold));
const turned = place => place.drawn && seen(place) && place.clientWidth !== place.across
  && (place.figure.layout.scene || isNarrow(place.clientWidth) !== isNarrow(place.across));
addEventListener("resize", () => { reach(); plots().filter(turned).forEach(place => draw(place)); });
dark.addEventListener("change", () => plots().forEach(place => place.drawn && draw(place)));
addEventListener("beforeprint", () => {
  document.querySelectorAll("details").forEach(part => { part.wasOpen = part.open; part.open = true; });
  plots().forEach(place => draw(place, place.closest(".pair") ? HALF : PAPER));
});
addEventListener("afterprint", () => {
  plots().forEach(place => draw(place));
  document.querySelectorAll("details").forEach(part => { part.open = part.wasOpen; });
});
// A link to a section opens it.
const openTarget = () => document.querySelector(`details[id="${location.hash.slice(1)}"]`)?.setAttribute("open", "");
addEventListener("hashchange", openTarget);
openTarget();
unfold();
