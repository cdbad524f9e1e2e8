// A subject's visit, from the browser check to the completion code.
//
// The server holds which trials are answered; the browser holds which answers are on their way.
// Whatever is in neither is asked, so that a visit can end and go on anywhere.

import { complete } from "./completion.js";
import { declinedMessage } from "./screens.js";
import { action, paragraph, showSaving, showScreen } from "./notices.js";
import { openSession } from "./session.js";
import { Outbox } from "./outbox.js";
import { pairTrial } from "./pairs.js";
import { Pictures } from "./pictures.js";
import { questionnaireTrial } from "./questionnaire.js";
import { claimSession, Store } from "./storage.js";
import * as screens from "./screens.js";

class Visit {
  #listeners = [];
  #over = false;

  constructor(store) {
    this.store = store;
    this.pictures = new Pictures();
    this.outbox = new Outbox(store, () => {
      showSaving(this.outbox, store);
      for (const listener of this.#listeners) listener();
    });
  }

  async start() {
    const opened = await openSession(this.store, unreachable);
    if (opened.refusal) {
      showScreen("The study cannot start", paragraph(opened.refusal));
      return;
    }
    Object.assign(this, opened);
    claimSession(this.token, () => this.#leaveToOtherTab());
    this.#mark();
    if (opened.resumed) this.#tell("reload", "");
    if (!this.store.lasting) this.#tell("storage-blocked", "");
    window.addEventListener("beforeunload", (event) => this.#beforeUnload(event));
    this.outbox.retry();
    await this.#run();
    if (!this.#over) await this.#complete();
  }

  async #run() {
    document.querySelector("#study").replaceChildren();
    this.jsPsych = initJsPsych({ display_element: "study" });
    const timeline = this.session.status === "complete" ? [] : this.#timeline();
    if (timeline.length) await this.jsPsych.run(timeline);
  }

  #timeline() {
    const trials = this.#unanswered();
    const questions = this.#openQuestions();
    if (!trials.length && !questions.length) return [];
    const begin = [
      screens.browserCheck(
        this.session.settings,
        (facts) => this.#tell("display", JSON.stringify(facts)),
        () => this.#end("browser-refused"),
      ),
      screens.zoomAdvice(),
    ];
    if (this.store.get("consented") !== this.token) begin.push(this.#consent());
    return [...begin, ...this.#pairs(trials), ...questions];
  }

  #consent() {
    return screens.consentScreen(
      this.session,
      () => {
        this.store.set("consented", this.token);
        this.#tell("consent", "agreed");
      },
      () => {
        this.#end("declined");
        this.jsPsych.abortExperiment(declinedMessage);
      },
    );
  }

  #pairs(trials) {
    if (!trials.length) return [];
    const total = this.session.trials.length;
    const addresses = [...new Set(trials.flatMap(({ left, right }) => [left, right]))];
    const answered = total - trials.length;
    return [
      this.pictures.timeline(addresses),
      answered ? screens.welcomeBack(answered, total) : screens.instructionScreen(this.session),
      screens.enterFullscreen(),
      ...trials.map((trial) => this.#pair(trial, total)),
      screens.leaveFullscreen(),
    ];
  }

  #pair(trial, total) {
    return pairTrial({
      trial,
      progress: `Pair ${trial.index + 1} of ${total}`,
      settings: this.session.settings,
      pictures: this.pictures,
      onAnswer: (body) => this.#send("PUT", `trials/${trial.index}`, body),
    });
  }

  #openQuestions() {
    const { questionnaire, questionnaire_answered: answered } = this.session;
    if (!questionnaire.length || answered || this.#isWaiting("questionnaire")) return [];
    return [
      questionnaireTrial({
        questions: questionnaire,
        store: this.store,
        onAnswer: (answers) => this.#send("PUT", "questionnaire", { answers }),
      }),
    ];
  }

  #unanswered() {
    const answered = new Set(this.session.answered);
    return this.session.trials.filter(
      ({ index }) => !answered.has(index) && !this.#isWaiting(`trials/${index}`),
    );
  }

  #complete() {
    const { token, ids, outbox, store } = this;
    const onChanged = (listener) => this.#listeners.push(listener);
    return complete({ token, ids, outbox, store, onChanged });
  }

  #path(place) {
    return `api/sessions/${this.token}/${place}`;
  }

  #isWaiting(place) {
    const path = this.#path(place);
    return [...this.outbox.waiting, ...this.outbox.refused].some((entry) => entry.path === path);
  }

  #send(method, place, body) {
    this.outbox.add({ method, path: this.#path(place), body });
  }

  // What happened beside the answers; its loss would harm no result.
  #tell(event, detail) {
    const key = crypto.getRandomValues(new Uint32Array(4)).join("-");
    const path = this.#path("events");
    this.outbox.add({ method: "POST", path, body: { event, detail, key }, optional: true });
  }

  #end(event) {
    this.#over = true;
    this.#tell(event, "");
  }

  #mark() {
    const pilot = this.session.mode === "pilot";
    document.querySelector("#pilot").hidden = !pilot;
    document.title = (pilot ? "Pilot: " : "") + this.session.title;
  }

  // What is kept only here would be lost with the window.
  #beforeUnload(event) {
    if (!this.store.lasting && this.outbox.state !== "saved") event.preventDefault();
  }

  #leaveToOtherTab() {
    this.#over = true;
    this.outbox.close();
    this.jsPsych?.abortExperiment();
    document.querySelector("#notice").replaceChildren();
    // Once jsPsych has cleared its display.
    setTimeout(() => {
      showScreen(
        "The study is open in another tab",
        paragraph("Please go on there, or go on here and leave the other one."),
        action("Go on here", () => location.reload()),
      );
    });
  }
}

function unreachable(failures) {
  if (failures !== 2) return;
  showScreen(
    "The server cannot be reached",
    paragraph("Please check that you are connected to the network. This page keeps trying."),
  );
}

await new Visit(new Store()).start();
