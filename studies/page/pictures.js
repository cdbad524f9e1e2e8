// The pictures of a session: loaded before the first trial, and kept, so that trials need no
// network; shown both at one scale, never larger than they are.

import { button, escaped, focusHeading, heading } from "./markup.js";

const MINIMUM_HEIGHT = 120;

export class Pictures {
  #images = new Map();

  // A timeline that ends when every picture is here.
  timeline(addresses) {
    const missing = () => addresses.filter((address) => !this.#images.has(address));
    return {
      timeline: [
        this.#preload(addresses, missing),
        { timeline: [retryScreen()], conditional_function: () => missing().length > 0 },
      ],
      loop_function: () => missing().length > 0,
    };
  }

  of(address) {
    return this.#images.get(address);
  }

  #preload(addresses, missing) {
    return {
      type: jsPsychPreload,
      images: missing,
      message: () =>
        heading("Loading the pictures") +
        `<progress max="${addresses.length}" value="${this.#images.size}" ` +
        'aria-label="Pictures loaded"></progress>',
      show_progress_bar: false,
      continue_after_error: true,
      max_load_time: 120_000,
      on_success: (address) => this.#keep(address),
      on_load: focusHeading,
      on_finish: async () => {
        await Promise.allSettled([...this.#images.values()].map((image) => image.decode()));
      },
    };
  }

  // The document has this picture already: a second image of it costs no second request.
  #keep(address) {
    const image = new Image();
    image.src = address;
    image.alt = "";
    image.draggable = false;
    this.#images.set(address, image);
    const progress = document.querySelector("#study progress");
    if (progress) progress.value += 1;
  }
}

// Give all images one scale at which each fits its share of the row and all fit the window.
export function fit(images, row) {
  const gap = parseFloat(getComputedStyle(row).columnGap) || 0;
  const frame = images[0].parentElement;
  const border = frame.offsetWidth - frame.clientWidth + padding(frame);
  const width = (row.clientWidth - gap * (images.length - 1)) / images.length - border;
  resize(images, 0);
  const notice = document.querySelector("#notice").offsetHeight;
  const { bottom } = document.querySelector("#study").getBoundingClientRect();
  const used = bottom + window.scrollY + notice;
  const height = Math.max(window.innerHeight - used, MINIMUM_HEIGHT);
  const largest = (side) => Math.max(...images.map((image) => image[side]));
  resize(
    images,
    Math.min(1, width / largest("naturalWidth"), height / largest("naturalHeight")),
  );
}

function resize(images, scale) {
  for (const image of images) {
    image.style.width = `${image.naturalWidth * scale}px`;
    image.style.height = `${image.naturalHeight * scale}px`;
  }
}

function padding(element) {
  const style = getComputedStyle(element);
  return parseFloat(style.paddingLeft) + parseFloat(style.paddingRight);
}

function retryScreen() {
  return {
    type: jsPsychHtmlButtonResponse,
    stimulus:
      heading("Some pictures did not load") +
      `<p>${escaped("Please check that you are connected to the network, then try again.")}</p>`,
    choices: ["Try again"],
    button_html: button,
    on_load: focusHeading,
  };
}
