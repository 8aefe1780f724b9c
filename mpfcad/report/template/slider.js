// Sliders of the inputs: the luminance's curve as the traced effects of each would have it.
document.querySelectorAll(".sliders").forEach(place => {
  const data = JSON.parse(place.querySelector("script").textContent);
  const sliders = [...place.querySelectorAll("input")], words = place.querySelector("output");
  const plot = document.getElementById("plot-response");
  const contrast = curve => {
    const [high, low] = [Math.max(...curve), Math.min(...curve)];
    return (high - low) / (high + low);
  };
  const shown = (one, step) => {
    const value = one.value + step * one.sigma;
    return +value.toPrecision(5);
  };
  function set() {
    const curve = data.start.slice();
    sliders.forEach(slider => {
      const one = data.inputs[slider.dataset.number], step = +slider.value;
      for (let i = 0; i < curve.length; i++)
        curve[i] += step * (one.slope[i] ?? 0) + step ** 2 * (one.bend[i] ?? 0);
      const value = String(shown(one, step));
      slider.nextElementSibling.textContent = value;
      slider.setAttribute("aria-valuetext", value);
    });
    words.textContent = `Contrast of the curve: ${contrast(data.start).toFixed(4)} as traced, ${contrast(curve).toFixed(4)} as set`;
    if (plot.drawn) Plotly.restyle(plot, {y: [curve.map(value => 100 * value - 100)]}, [1]);
  }
  sliders.forEach(slider => slider.addEventListener("input", set));
  place.querySelector("button").addEventListener("click", () => {
    sliders.forEach(slider => { slider.value = 0; });
    set();
  });
  set();
});
