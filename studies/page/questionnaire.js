// The closing questionnaire, as a form whose half-filled fields survive a reload.

import { escaped, focusHeading, heading } from "./markup.js";

// The jsPsych trial; `onAnswer` gets {question name: answer} without the questions left open.
export function questionnaireTrial({ questions, store, onAnswer }) {
  const draft = store.get("drafts", {});
  return {
    type: jsPsychSurveyHtmlForm,
    css_classes: ["form"],
    preamble: heading("A few questions") + "<p>Questions without a star may be left open.</p>",
    html: questions.map(field).join(""),
    button_label: "Send answers",
    on_load: () => {
      const form = document.querySelector("#jspsych-survey-html-form");
      restore(form, draft);
      form.addEventListener("input", () => store.set("drafts", filled(form)));
      focusHeading();
    },
    on_finish: (data) => {
      if (data.response) onAnswer(answers(questions, data.response));
    },
  };
}

// Fields are named by their place, so that no name a study gives can be one of the page's own.
function field(question, index) {
  const name = `q${index}`;
  const required = question.required ? " required" : "";
  const text = escaped(question.text) + (question.required ? ' <span aria-hidden="true">*</span>' : "");
  if (question.kind === "choice") {
    const options = question.options.map(
      (option) =>
        `<label class="option"><input type="radio" name="${name}" value="${escaped(option)}"${required}> ` +
        `<span>${escaped(option)}</span></label>`,
    );
    return `<fieldset><legend>${text}</legend>${options.join("")}</fieldset>`;
  }
  const label = `<label for="${name}">${text}</label>`;
  return `<div class="field">${label}${entry(question, name, required)}</div>`;
}

function entry(question, name, required) {
  const common = `id="${name}" name="${name}"${required}`;
  if (question.kind === "text") {
    const longest = Number(question.maximum_length) || 2000;
    return `<textarea ${common} rows="4" maxlength="${longest}"></textarea>`;
  }
  const bound = (side, value) => (Number.isFinite(value) ? ` ${side}="${value}"` : "");
  const bounds = bound("min", question.minimum) + bound("max", question.maximum);
  return `<input type="number" ${common} step="any" inputmode="decimal"${bounds}>`;
}

function filled(form) {
  return Object.fromEntries(new FormData(form));
}

function restore(form, draft) {
  for (const [name, value] of Object.entries(draft)) {
    const control = form.elements.namedItem(name);
    if (control) control.value = value;
  }
}

function answers(questions, response) {
  const given = questions.map(({ name, kind }, index) => {
    const text = (response[`q${index}`] ?? "").trim();
    return [name, kind === "number" && text !== "" ? Number(text) : text];
  });
  return Object.fromEntries(given.filter(([, answer]) => answer !== ""));
}
