// The screens around the trials: browser check, consent, instructions, full screen.

import { button, escaped, focusHeading, heading, paragraphs } from "./markup.js";

function textScreen(title, markup, choices) {
  return {
    type: jsPsychHtmlButtonResponse,
    css_classes: ["text"],
    stimulus: heading(title) + markup,
    choices,
    button_html: button,
    on_load: focusHeading,
  };
}

export function browserCheck(settings, onMeasured, onRefused) {
  const { minimum_width: width, minimum_height: height } = settings;
  return {
    type: jsPsychBrowserCheck,
    features: ["width", "height", "mobile", "fullscreen"],
    minimum_width: width,
    minimum_height: height,
    window_resize_message:
      heading("This window is too small") +
      "<p>Please make it larger; the study then goes on by itself.</p>" +
      `<p>It is <span id="browser-check-actual-width"></span> by ` +
      `<span id="browser-check-actual-height"></span> pixels, and at least ` +
      `<span id="browser-check-min-width"></span> by ` +
      `<span id="browser-check-min-height"></span> are needed.</p>`,
    resize_fail_button_text: "I cannot make it larger",
    inclusion_function: () => settings.allow_touch || !touchOnly(),
    exclusion_message: () => {
      onRefused();
      return (
        heading("This device does not fit the study") +
        `<p>The study needs a window of at least ${Number(width)} by ${Number(height)} pixels` +
        `${settings.allow_touch ? "" : " and a mouse or another pointer"}. ` +
        "You can come back to this address on another device.</p>"
      );
    },
    on_finish: ({ mobile, fullscreen }) => onMeasured({ ...screenFacts(), mobile, fullscreen }),
  };
}

// Shown only where the browser enlarges or shrinks the page.
export function zoomAdvice() {
  const advice = textScreen(
    "Please check the zoom",
    `<p>${escaped(
      "Your browser seems to enlarge or shrink this page. Please set its zoom to 100% " +
        "(Ctrl and 0, or Cmd and 0), so that pictures are shown as they are. " +
        "If you need the zoom to read, leave it as it is.",
    )}</p>`,
    ["Continue"],
  );
  return { timeline: [advice], conditional_function: () => Math.abs(zoom() - 1) > 0.1 };
}

export function consentScreen(study, onDeclined) {
  return {
    ...textScreen(study.title, paragraphs(study.consent), [
      "I agree and take part",
      "I do not agree",
    ]),
    on_finish: (data) => {
      if (data.response !== 0) onDeclined();
    },
  };
}

export const declinedMessage =
  heading("Thank you") + "<p>You do not take part, and nothing was kept. You can close this page.</p>";

export function instructionScreen(study) {
  return textScreen("Instructions", paragraphs(study.instructions), ["Start"]);
}

// With `onOther`, which a link without ids needs: it may be another person at the same computer.
export function welcomeBack(answered, total, onOther) {
  return {
    ...textScreen(
      "Welcome back",
      `<p>You have answered ${answered} of ${total} pairs. The study goes on where you were.</p>`,
      onOther ? ["Continue", "I am another person"] : ["Continue"],
    ),
    on_finish: (data) => {
      if (data.response === 1) onOther();
    },
  };
}

// Offered where there is a pointer; on a telephone the page fills the screen anyway.
export function enterFullscreen() {
  const screen = {
    type: jsPsychFullscreen,
    css_classes: ["text"],
    fullscreen_mode: true,
    message:
      heading("Full screen") +
      "<p>The pictures are best seen on the whole screen. The Esc key leaves it at any time.</p>",
    button_label: "Continue on the full screen",
    delay_after: 300,
    on_load: focusHeading,
  };
  const possible = () => document.fullscreenEnabled && !touchOnly() && !document.fullscreenElement;
  return { timeline: [screen], conditional_function: possible };
}

export function leaveFullscreen() {
  const screen = { type: jsPsychFullscreen, fullscreen_mode: false, delay_after: 0 };
  return { timeline: [screen], conditional_function: () => Boolean(document.fullscreenElement) };
}

function touchOnly() {
  return matchMedia("(pointer: coarse)").matches && !matchMedia("(any-pointer: fine)").matches;
}

// Of the browser's own zoom, where it can be told from the density of the screen; and of two
// fingers.
function zoom() {
  const windowZoom = window.outerWidth ? window.outerWidth / window.innerWidth : 1;
  const pinch = window.visualViewport?.scale ?? 1;
  return touchOnly() ? pinch : windowZoom * pinch;
}

function screenFacts() {
  return {
    width: window.innerWidth,
    height: window.innerHeight,
    pixel_ratio: window.devicePixelRatio,
    touch: navigator.maxTouchPoints > 0,
    zoom: Math.round(zoom() * 100) / 100,
  };
}
