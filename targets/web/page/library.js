// Calls of a worker as promises.

export class Library {
  #worker;
  #waiting = new Map();
  #count = 0;

  constructor(progress = () => {}, stopped = () => {}) {
    this.progress = progress;
    this.stopped = stopped;
    this.#start();
  }

  #start() {
    this.#worker = new Worker('worker.js');
    this.#worker.onmessage = ({ data }) => {
      if ('progress' in data) return this.progress(data.progress);
      const { resolve, reject } = this.#waiting.get(data.id);
      this.#waiting.delete(data.id);
      if (data.json?.stopped) this.stopped();
      if (data.json?.error) reject(new Error(data.json.error));
      else resolve(data);
    };
    this.#worker.onerror = event => this.#fail(event.message || 'the worker could not be started');
  }

  #fail(what) {
    const waiting = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const { reject } of waiting) reject(new Error(what));
    this.stopped();
  }

  /** The reply {json, bytes} of a call. */
  call(json, bytes) {
    const id = ++this.#count;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, json, bytes }, bytes ? [bytes.buffer] : []);
    });
  }

  /** Ends the worker, whatever it does, and starts another without plan, site and frames. */
  restart() {
    this.#worker.terminate();
    this.#start();
    this.#fail('stopped');
  }
}

/** Lends a file under its name. */
export const lend = async (library, file) =>
  library.call({ call: 'lend', name: file.name }, new Uint8Array(await file.arrayBuffer()));
