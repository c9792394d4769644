// Runs the module away from the page: a message {id, json, bytes} is answered by {id, json, bytes}.

let library;

const start = async () => {
  const imports = { page: { progress: percent => postMessage({ progress: percent }) } };
  const response = await fetch('compass.wasm');
  if (!response.ok) throw new Error(`compass.wasm: ${response.status} ${response.statusText}; build it with targets/web/build`);
  const { instance } = await WebAssembly.instantiate(await response.arrayBuffer(), imports);
  return instance.exports;
};

const call = (exports, json, bytes) => {
  const text = new TextEncoder().encode(JSON.stringify(json));
  const length = 4 + text.length + (bytes?.length ?? 0);
  const at = exports.compass_request(length) >>> 0;
  // The view is made after the call: memory that grew is another buffer.
  const request = new Uint8Array(exports.memory.buffer, at, length);
  new DataView(exports.memory.buffer).setUint32(at, text.length, true);
  request.set(text, 4);
  if (bytes) request.set(bytes, 4 + text.length);
  const size = exports.compass_answer() >>> 0;
  const reply = new Uint8Array(exports.memory.buffer, exports.compass_reply() >>> 0, size).slice();
  const end = 4 + new DataView(reply.buffer).getUint32(0, true);
  return { json: JSON.parse(new TextDecoder().decode(reply.subarray(4, end))), bytes: reply.slice(end) };
};

onmessage = async ({ data: { id, json, bytes } }) => {
  try {
    library ??= start();
    const reply = call(await library, json, bytes);
    postMessage({ id, ...reply }, [reply.bytes.buffer]);
  } catch (error) {
    // After a trap the memory of the module is not to be trusted.
    const stopped = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
    library = undefined;
    postMessage({ id, json: { error: stopped ? `the library stopped (${error.message})` : error.message, stopped: true } });
  }
};
