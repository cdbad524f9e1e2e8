// What the page says beside the study: trouble with saving, and the file that then helps.

export function paragraph(text) {
  const element = document.createElement("p");
  element.textContent = text;
  return element;
}

export function action(label, onClick) {
  const element = document.createElement("button");
  element.type = "button";
  element.className = "jspsych-btn";
  element.textContent = label;
  element.addEventListener("click", onClick);
  return element;
}

// Replace the content of the page by a heading and other elements.
export function showScreen(title, ...content) {
  const heading = document.createElement("h1");
  heading.textContent = title;
  heading.tabIndex = -1;
  const screen = document.createElement("div");
  screen.className = "screen";
  screen.append(heading, ...content);
  document.querySelector("#study").replaceChildren(screen);
  heading.focus({ preventScroll: true });
}

// Say how saving goes, if there is anything to say.
export function showSaving(outbox, store) {
  const notice = document.querySelector("#notice");
  const { state } = outbox;
  if (notice.dataset.state === state) return;
  notice.dataset.state = state;
  if (state === "failing") notice.replaceChildren(...failing(outbox, store));
  else if (state === "refused") notice.replaceChildren(...refused(outbox));
  else notice.replaceChildren();
}

function failing(outbox, store) {
  const where = store.lasting
    ? "They are kept in this browser"
    : "They are kept in this window only, so please do not close it";
  return [
    paragraph(
      "Your answers cannot be sent to the server at the moment. " +
        `${where}. You can go on: sending is tried again by itself.`,
    ),
    action("Try now", () => outbox.retry()),
    action("Save my answers as a file", () => download(outbox)),
  ];
}

function refused(outbox) {
  return [
    paragraph(
      "The server did not accept some of your answers. They are kept in this browser. " +
        "Please save them as a file and send it to whoever invited you.",
    ),
    action("Save my answers as a file", (event) => {
      download(outbox);
      const { parentElement } = event.target;
      if (parentElement.childElementCount > 2) return;
      parentElement.append(action("I have sent the file", () => outbox.forgetRefused()));
    }),
  ];
}

// All that the server has not acknowledged, with the requests that would bring it there.
function download(outbox) {
  const unsent = { unsent: outbox.unsent };
  const file = new Blob([JSON.stringify(unsent, null, 2)], { type: "application/json" });
  const link = document.createElement("a");
  link.href = URL.createObjectURL(file);
  link.download = "study-answers.json";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
