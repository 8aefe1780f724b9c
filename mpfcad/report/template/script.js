// Curves are drawn anew for the width of a sheet of paper, and for the window afterwards.
for (const place of document.querySelectorAll(".plot")) {
  const figure = JSON.parse(place.nextElementSibling.textContent);
  Plotly.newPlot(place, figure.data, figure.layout, figure.config);
}
const plots = () => document.querySelectorAll(".plot");
addEventListener("beforeprint", () => plots().forEach(p => Plotly.relayout(p, {width: 680})));
addEventListener("afterprint", () => plots().forEach(p => Plotly.relayout(p, {width: null,
  autosize: true})));
