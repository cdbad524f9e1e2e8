// What the browser keeps between visits, and which of several tabs goes on with the study.

const PREFIX = `relightlab-study:${location.pathname}:`;

// Values as JSON in localStorage; where that is blocked or full, in memory for this visit only.
export class Store {
  #memory = new Map();
  lasting = true;

  constructor() {
    try {
      localStorage.setItem(`${PREFIX}probe`, "1");
      localStorage.removeItem(`${PREFIX}probe`);
    } catch {
      this.lasting = false;
    }
  }

  get(name, missing = null) {
    if (this.#memory.has(name)) return this.#memory.get(name);
    try {
      const text = localStorage.getItem(PREFIX + name);
      return text === null ? missing : JSON.parse(text);
    } catch {
      return missing;
    }
  }

  set(name, value) {
    try {
      localStorage.setItem(PREFIX + name, JSON.stringify(value));
      this.#memory.delete(name);
    } catch {
      this.lasting = false;
      this.#memory.set(name, value);
    }
  }

  remove(...names) {
    for (const name of names) {
      this.#memory.delete(name);
      try {
        localStorage.removeItem(PREFIX + name);
      } catch {
        // Blocked: there is nothing to remove.
      }
    }
  }
}

// The tab opened last goes on with a session; the others are told so through `onLost`.
export function claimSession(token, onLost) {
  if (typeof BroadcastChannel === "undefined") return;
  const channel = new BroadcastChannel(PREFIX + token);
  channel.onmessage = () => {
    channel.close();
    onLost();
  };
  channel.postMessage("claimed");
}
