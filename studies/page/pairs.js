// One trial: two pictures side by side, answered by pointer or by key.

import { escaped, focusHeading, heading } from "./markup.js";
import { fit } from "./pictures.js";

const LEFT = { response: "left", label: "Left picture", keys: ["ArrowLeft", "1"] };
const RIGHT = { response: "right", label: "Right picture", keys: ["ArrowRight", "2"] };
const TIE = { response: "tie", label: "No difference", keys: ["ArrowDown", "3"] };

// The jsPsych trial of one pair. `trial` is {left, right, question}, the addresses of its pictures
// and what is asked; `onAnswer` gets the body for the server.
export function pairTrial({ trial, progress, settings, pictures, onAnswer }) {
  const choices = settings.allow_tie ? [LEFT, RIGHT, TIE] : [LEFT, RIGHT];
  const watch = new Watch();
  let stop = () => {};
  return {
    type: jsPsychHtmlButtonResponse,
    css_classes: ["pair"],
    stimulus: `<p class="progress">${escaped(progress)}</p>${heading(trial.question)}`,
    choices: choices.map((choice) => choice.response),
    button_html: (_, index) => choiceMarkup(choices[index]),
    button_layout: "flex",
    enable_button_after: settings.minimum_view_ms,
    prompt: hint(choices),
    on_load: () => {
      stop = show(trial, choices, pictures);
      focusHeading();
      watch.start();
    },
    on_finish: (data) => {
      const seen = watch.stop();
      stop();
      // Without a response the trial was ended from outside, and there is no answer.
      if (Number.isInteger(data.response)) {
        onAnswer({ response: choices[data.response].response, ...seen, ...display() });
      }
    },
  };
}

function choiceMarkup({ response, label }) {
  if (response === "tie") return `<button type="button" class="jspsych-btn tie">${label}</button>`;
  return `<button type="button" class="picture ${response}" aria-label="${label}"></button>`;
}

function hint(choices) {
  const names = { ArrowLeft: "←", ArrowRight: "→", ArrowDown: "↓" };
  const keys = choices.map(
    ({ label, keys: [arrow, digit] }) =>
      `<span>${label}: <kbd>${names[arrow]}</kbd> or <kbd>${digit}</kbd></span>`,
  );
  return `<p class="hint">${keys.join(" ")}</p>`;
}

// Put the pictures in place, and listen to keys; returns what undoes both.
function show(trial, choices, pictures) {
  const row = document.querySelector("#jspsych-html-button-response-btngroup");
  const buttons = [...row.children];
  const images = [trial.left, trial.right].map((address) => pictures.of(address));
  images.forEach((image, index) => buttons[index].append(image));
  const refit = () => fit(images, row);
  const press = (event) => {
    if (event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
    const index = choices.findIndex(({ keys }) => keys.includes(event.key));
    if (index < 0) return;
    event.preventDefault();
    buttons[index].click(); // which does nothing before the minimum view time
  };
  refit();
  window.addEventListener("resize", refit);
  document.addEventListener("keydown", press);
  return () => {
    window.removeEventListener("resize", refit);
    document.removeEventListener("keydown", press);
  };
}

function display() {
  return {
    display_width: window.innerWidth,
    display_height: window.innerHeight,
    client_time: new Date().toISOString(),
  };
}

// How long the pair was in view, how long the answer took, and how often the subject left.
class Watch {
  #started = 0;
  #hiddenSince = null;
  #hiddenMs = 0;
  #away = false;
  #departures = 0;
  #listeners = new AbortController();

  start() {
    const { signal } = this.#listeners;
    this.#started = performance.now();
    // The pictures are painted with the next frame, or once the tab is looked at.
    requestAnimationFrame((now) => {
      this.#started = Math.max(this.#started, now);
      this.#hiddenMs = 0;
    });
    if (document.hidden) this.#hiddenSince = this.#started;
    window.addEventListener("blur", () => this.#leave(), { signal });
    window.addEventListener("focus", () => this.#return(), { signal });
    document.addEventListener("visibilitychange", () => this.#turn(), { signal });
  }

  stop() {
    this.#listeners.abort();
    const reaction = performance.now() - this.#started;
    return {
      shown_ms: round(Math.max(reaction - this.#hiddenMs, 0)),
      reaction_ms: round(reaction),
      blur_events: this.#departures,
    };
  }

  #turn() {
    if (document.hidden) {
      this.#hiddenSince = performance.now();
      this.#leave();
    } else {
      if (this.#hiddenSince !== null) this.#hiddenMs += performance.now() - this.#hiddenSince;
      this.#hiddenSince = null;
      this.#return();
    }
  }

  // A change of tab both blurs and hides, but is one departure.
  #leave() {
    this.#departures += this.#away ? 0 : 1;
    this.#away = true;
  }

  #return() {
    this.#away = false;
  }
}

function round(milliseconds) {
  return Math.round(milliseconds * 10) / 10;
}
