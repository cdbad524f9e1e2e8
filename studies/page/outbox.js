// Answers on their way to the server: written down first, then sent in order until acknowledged.

import { request } from "./server.js";

const FIRST_DELAY_MS = 500;
const LONGEST_DELAY_MS = 30_000;
const FAILURES_BEFORE_NOTICE = 3;
// The server has another answer to the same trial, from another tab or an earlier attempt: the
// first one counts, and this one is as good as sent.
const CONFLICT = 409;

export function randomId() {
  return crypto.getRandomValues(new Uint32Array(4)).join("-");
}

export class Outbox {
  #store;
  #onChange;
  #sending = false;
  #closed = false;
  #failures = 0;
  #wake = () => {};

  // `onChange` is called with no argument whenever `state` or `waiting` may have changed.
  constructor(store, onChange) {
    this.#store = store;
    this.#onChange = onChange;
    // What the server refused on an earlier visit may have been its fault, so it is tried again.
    this.#store.set("outbox", this.unsent);
    this.#store.remove("refused");
    window.addEventListener("online", () => this.retry());
    document.addEventListener("visibilitychange", () => {
      if (!document.hidden) this.retry();
    });
  }

  get waiting() {
    return this.#store.get("outbox", []);
  }

  // All that the server has not acknowledged.
  get unsent() {
    return [...this.refused, ...this.waiting];
  }

  get refused() {
    return this.#store.get("refused", []);
  }

  // "saved", "saving", "failing" (still trying) or "refused" (the server will not have it).
  get state() {
    if (this.refused.length) return "refused";
    if (!this.waiting.length) return "saved";
    return this.#failures >= FAILURES_BEFORE_NOTICE ? "failing" : "saving";
  }

  // An entry is {method, path, body}, and `optional` where its loss would harm no result.
  add(entry) {
    this.#store.set("outbox", [...this.waiting, { id: randomId(), ...entry }]);
    this.#send();
  }

  retry() {
    this.#failures = Math.min(this.#failures, FAILURES_BEFORE_NOTICE);
    this.#wake();
    this.#send();
  }

  // Once the file with them is in someone's hands.
  forgetRefused() {
    this.#store.remove("refused");
    this.#onChange();
  }

  // Another tab has taken over what is written down here.
  close() {
    this.#closed = true;
    this.#wake();
  }

  async #send() {
    if (this.#sending) return;
    this.#sending = true;
    this.#onChange();
    while (this.waiting.length && !this.#closed) await this.#sendFirst();
    this.#sending = false;
    this.#onChange();
  }

  async #sendFirst() {
    const [entry] = this.waiting;
    const answer = await request(entry.method, entry.path, entry.body);
    if (this.#closed) return;
    if (answer.ok || answer.status === CONFLICT) {
      this.#failures = 0;
      this.#remove(entry);
    } else if (answer.temporary) {
      this.#failures += 1;
      this.#onChange();
      await this.#pause(answer.retryAfterMs);
    } else {
      if (!entry.optional) this.#store.set("refused", [...this.refused, entry]);
      this.#remove(entry);
    }
  }

  // By its id: another tab may have sent, and removed, the same entry meanwhile.
  #remove({ id }) {
    this.#store.set("outbox", this.waiting.filter((entry) => entry.id !== id));
    this.#onChange();
  }

  // Twice as long after each failure, and never the same for all subjects at once.
  #pause(atLeastMs) {
    const growing = FIRST_DELAY_MS * 2 ** (this.#failures - 1);
    const delay = Math.min(growing, LONGEST_DELAY_MS) * (0.75 + Math.random() / 2);
    return new Promise((resolve) => {
      const timer = setTimeout(resolve, Math.max(delay, atLeastMs));
      this.#wake = () => {
        clearTimeout(timer);
        resolve();
      };
    });
  }
}
