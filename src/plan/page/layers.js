// What the 3D view shows, each of it to be switched off.
const LAYERS = [
  { name: "UF", word: "Blind space", what: "free, and not known", colour: "UF", isOn: true, opacity: 0.13, outcome: true },
  { name: "UO", word: "Not seen", what: "occupied, and not known", colour: "UO", isOn: true, opacity: 0.6, outcome: true },
  { name: "FN", word: "Called free", what: "occupied, so missed", colour: "FN", isOn: true, outcome: true },
  { name: "FP", word: "False", what: "free, but called occupied", colour: "FP", isOn: true, opacity: 0.35, outcome: true },
  { name: "TP", word: "Seen", what: "occupied, and called so", colour: "TP", isOn: false, outcome: true },
  { name: "view", word: "Fields of view", what: "cut by what they hit first", colour: "sensors", isOn: true },
  { name: "pose", word: "Listed poses", what: "a click places a sensor", colour: "mount", isOn: true },
  { name: "region", word: "Regions and entries", what: "what is counted, ways in", colour: "approaches", isOn: true },
  { name: "name", word: "Names", what: "of furniture and robots", colour: "soft", isOn: true },
];
const layerOf = name => LAYERS.find(layer => layer.name === name);

function makeLayers(changed) {
  element("layers").replaceChildren(...LAYERS.map(layer => {
    const box = made("input", { type: "checkbox", id: `layer-${layer.name}` }), swatch = made("i", {});
    box.checked = layer.isOn;
    swatch.style.background = hue(layer.colour);
    box.addEventListener("change", () => { layer.isOn = box.checked; changed(layer); });
    return made("label", {}, box, swatch, made("span", {}, layer.word), made("small", {}, layer.what));
  }));
}
