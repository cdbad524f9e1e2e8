// The end: the completion code, once the server has acknowledged everything.

import { action, paragraph, showScreen } from "./notices.js";
import { insist } from "./server.js";
import { leaveSession } from "./session.js";

// Resolves when nothing of this session waits any more; never if the server refuses something.
function everythingSent(token, outbox, onChanged) {
  return new Promise((resolve) => {
    const check = () => {
      if (!outbox.unsent.some(({ path }) => path.includes(`/${token}/`))) resolve();
    };
    onChanged(check);
    check();
  });
}

export async function complete({ token, ids, outbox, store, onChanged }) {
  showScreen("Sending your answers", paragraph("Please keep this page open for a moment."));
  await everythingSent(token, outbox, onChanged);
  const answer = await insist("POST", `api/sessions/${token}/completion`, {}, (failures) => {
    if (failures === 3) {
      showScreen(
        "Sending your answers",
        paragraph(
          "All your answers are saved, but the server cannot be reached for your completion " +
            "code. The code appears here as soon as it can; please keep this page open.",
        ),
      );
    }
  });
  if (!answer.ok) {
    await askWhatIsMissing(answer, store);
    return;
  }
  store.remove("drafts", "asked-again");
  showCode(answer.body, ids, store);
}

// Where the server lacks answers, another visit asks for them, once.
async function askWhatIsMissing(answer, store) {
  if (!store.get("asked-again")) {
    store.set("asked-again", true);
    location.reload();
    return;
  }
  const { detail } = answer.body ?? {};
  showScreen(
    "The server gave no completion code",
    paragraph(typeof detail === "string" ? detail : "It did not say why."),
    paragraph("Please tell whoever invited you."),
    action("Try again", () => location.reload()),
  );
}

function showCode({ code, redirect }, ids, store) {
  const shown = document.createElement("output");
  shown.id = "code";
  shown.textContent = code;
  const content = [
    paragraph("All your answers are saved. Thank you for taking part!"),
    paragraph("Your completion code:"),
    shown,
  ];
  if (navigator.clipboard) content.push(copyButton(code));
  const link = redirectLink(redirect);
  if (link) content.push(link);
  // On a laboratory's computer the next subject sits down at the same browser.
  if (!Object.keys(ids).length) content.push(nextSubject(store));
  showScreen("Finished", ...content);
}

function copyButton(code) {
  const button = action("Copy the code", async () => {
    await navigator.clipboard.writeText(code).then(
      () => (button.textContent = "Copied"),
      () => (button.textContent = "Please copy it by hand"),
    );
  });
  return button;
}

function redirectLink(redirect) {
  if (!redirect) return null;
  const link = document.createElement("a");
  link.href = redirect;
  if (!["http:", "https:"].includes(link.protocol)) return null;
  link.id = "redirect";
  link.className = "jspsych-btn";
  link.textContent = "Finish, and go back to where you came from";
  return link;
}

function nextSubject(store) {
  const paragraphs = paragraph("");
  paragraphs.className = "aside";
  paragraphs.append(
    action("Another person takes part", () => leaveSession(store)),
  );
  return paragraphs;
}
