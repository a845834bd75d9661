// Reads what the page holds: names as JSON, numbers and voxels, all as base64 of gzip. Nothing is drawn here.
/** The bytes that an element of the page holds. */
async function unpacked(id) {
  const letters = element(id).textContent.trim();
  const bytes = Uint8Array.from(atob(letters), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

const data = JSON.parse(new TextDecoder().decode(await unpacked("data")));
const numbers = new Float32Array(await unpacked("numbers"));
const bytes = new Uint8Array(await unpacked("cells"));

/** Classes from their runs in these bytes. */
const classes = ([begin, end], kinds, count) => decoded(bytes.subarray(begin, end), kinds, count);
