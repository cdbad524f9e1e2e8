// Text to markup. Whatever a study or a subject wrote passes through `escaped` before a plugin
// that takes HTML sees it.

const REPLACED = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;" };

export function escaped(text) {
  return String(text ?? "").replace(/[&<>"']/g, (character) => REPLACED[character]);
}

// Empty lines part paragraphs; other line ends are only how the study's file was wrapped.
export function paragraphs(text) {
  return String(text ?? "")
    .split(/\n\s*\n/)
    .map((part) => part.trim())
    .filter(Boolean)
    .map((part) => `<p>${escaped(part)}</p>`)
    .join("");
}

// The heading of a screen, which takes the focus when the screen appears.
export function heading(text) {
  return `<h1 tabindex="-1">${escaped(text)}</h1>`;
}

export function focusHeading() {
  document.querySelector("#study h1")?.focus({ preventScroll: true });
  window.scrollTo(0, 0);
}

export function button(label) {
  return `<button type="button" class="jspsych-btn">${escaped(label)}</button>`;
}
