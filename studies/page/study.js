// A subject's visit, from the browser check to the completion code.
//
// The server holds which trials are answered; the browser holds which answers are on their way.
// Whatever is in neither is asked, so that a visit can end and go on anywhere. Nothing is sent to
// the server before the subject has agreed.

import { complete } from "./completion.js";
import { action, paragraph, showSaving, showScreen } from "./notices.js";
import { Outbox, randomId } from "./outbox.js";
import { pairTrial } from "./pairs.js";
import { Pictures } from "./pictures.js";
import { questionnaireTrial } from "./questionnaire.js";
import * as screens from "./screens.js";
import { keptSession, leaveSession, openSession, readStudy } from "./session.js";
import { claimSession, Store } from "./storage.js";

class Visit {
  #listeners = [];
  // Set once the visit has ended otherwise than by its completion.
  #over = false;

  constructor(store) {
    this.store = store;
    this.outbox = new Outbox(store, () => {
      showSaving(this.outbox, store);
      for (const listener of this.#listeners) listener();
    });
  }

  async start() {
    this.outbox.retry();
    const { study, refusal } = await readStudy(unreachable);
    if (refusal) return cannotStart(refusal);
    this.#mark(study);
    const kept = await keptSession(this.store, study, unreachable);
    await this.#enter(study, kept);
    if (this.#over) return undefined;
    const opened = kept ?? (await openSession(this.store, study, unreachable));
    if (opened.refusal) return cannotStart(opened.refusal);
    return this.#goOn(opened, Boolean(kept));
  }

  // Browser check and, but for who comes back, consent.
  async #enter(study, kept) {
    if (kept?.session.status === "complete") return;
    const refused = () => (this.#over = true);
    const timeline = [
      screens.browserCheck(study.settings, (facts) => (this.facts = facts), refused),
      screens.zoomAdvice(),
    ];
    if (!kept) {
      const declined = () => {
        this.#over = true;
        this.jsPsych.abortExperiment(screens.declinedMessage);
      };
      timeline.push(screens.consentScreen(study, declined));
    }
    await this.#run(timeline);
  }

  async #goOn(opened, resumed) {
    Object.assign(this, opened);
    claimSession(this.token, () => this.#leaveToOtherTab());
    window.addEventListener("beforeunload", (event) => this.#beforeUnload(event));
    if (this.session.status !== "complete") {
      if (this.facts) this.#tell("display", JSON.stringify(this.facts));
      this.#tell(resumed ? "reload" : "consent", "");
      if (!this.store.lasting) this.#tell("storage-blocked", "");
      const timeline = [...this.#pairs(), ...this.#questions()];
      if (timeline.length) await this.#run(timeline);
    }
    if (!this.#over) await this.#complete();
  }

  async #run(timeline) {
    document.querySelector("#study").replaceChildren();
    this.jsPsych = initJsPsych({ display_element: "study" });
    await this.jsPsych.run(timeline);
  }

  #pairs() {
    const trials = this.#unanswered();
    if (!trials.length) return [];
    const pictures = new Pictures();
    const { study, schedule } = this.session;
    const answered = schedule.length - trials.length;
    return [
      pictures.timeline([...new Set(trials.flatMap(({ left, right }) => [left, right]))]),
      answered
        ? screens.welcomeBack(answered, schedule.length, this.#otherPerson())
        : screens.instructionScreen(study),
      screens.enterFullscreen(),
      ...trials.map((trial) =>
        pairTrial({
          trial,
          progress: `Pair ${trial.index + 1} of ${schedule.length}`,
          settings: study.settings,
          pictures,
          onAnswer: (body) => this.#send(`trials/${trial.index}`, body),
        }),
      ),
      screens.leaveFullscreen(),
    ];
  }

  // On a laboratory's computer, the one before may have left in the middle.
  #otherPerson() {
    if (Object.keys(this.ids).length) return undefined;
    return () => {
      this.#over = true;
      this.jsPsych.abortExperiment();
      leaveSession(this.store);
    };
  }

  #unanswered() {
    const answered = new Set(this.session.answered);
    return this.session.schedule.filter(
      ({ index }) => !answered.has(index) && !this.#isWaiting(`trials/${index}`),
    );
  }

  #questions() {
    const { study, schedule, questionnaire_answered: answered } = this.session;
    if (answered || this.#isWaiting("questionnaire")) return [];
    // Another person must not see what this one has typed so far.
    const other = this.#unanswered().length ? undefined : this.#otherPerson();
    return [
      ...(other ? [screens.welcomeBack(schedule.length, schedule.length, other)] : []),
      questionnaireTrial({
        questions: study.questionnaire,
        store: this.store,
        onAnswer: (answers) => this.#send("questionnaire", { answers }),
      }),
    ];
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
    return this.outbox.unsent.some((entry) => entry.path === path);
  }

  #send(place, body) {
    this.outbox.add({ method: "PUT", path: this.#path(place), body });
  }

  // What happened beside the answers; its loss would harm no result.
  #tell(event, detail) {
    const body = { event, detail, key: randomId(), client_time: new Date().toISOString() };
    this.outbox.add({ method: "POST", path: this.#path("events"), body, optional: true });
  }

  #mark({ mode, title }) {
    const pilot = mode === "pilot";
    document.querySelector("#pilot").hidden = !pilot;
    document.title = (pilot ? "Pilot: " : "") + title;
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

function cannotStart(refusal) {
  showScreen("The study cannot start", paragraph(refusal));
}

function unreachable(failures) {
  if (failures !== 2) return;
  showScreen(
    "The server cannot be reached",
    paragraph("Please check that you are connected to the network. This page keeps trying."),
  );
}

if (typeof initJsPsych === "undefined") {
  showScreen(
    "The study did not load whole",
    paragraph("Please check that you are connected to the network, and load this page again."),
    action("Load again", () => location.reload()),
  );
} else {
  await new Visit(new Store()).start();
}
