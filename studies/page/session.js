// Opening a session, or taking up the one that this browser has begun.

import { insist } from "./server.js";

// Where the browser keeps nothing, the address does: a reload then still finds the session.
const FRAGMENT = "#session=";

// {study} as every subject may know it, or {refusal}, the server's own sentence. `onFailure` hears
// of each attempt that got no answer.
export async function readStudy(onFailure) {
  const answer = await insist("GET", "api/study", undefined, onFailure);
  if (!answer.ok) return { refusal: sentence(answer.body) };
  const study = answer.body;
  return { study: asksForPilot() ? { ...study, mode: "pilot" } : study };
}

// {token, ids, session} if this browser, or the address, has a session that goes on; or null.
export async function keptSession(store, study, onFailure) {
  const wanted = described(study);
  const kept = store.get("session") ?? inFragment(wanted);
  if (!kept || fingerprint(kept) !== fingerprint(wanted)) return null;
  const answer = await insist("GET", `api/sessions/${kept.token}`, undefined, onFailure);
  // Who declined, or came by another link since, begins anew.
  if (!answer.ok || answer.body.status === "returned") return null;
  return { token: kept.token, ids: kept.ids, session: answer.body };
}

// {token, ids, session} or {refusal}.
export async function openSession(store, study, onFailure) {
  const wanted = described(study);
  const display = {
    width: window.innerWidth,
    height: window.innerHeight,
    pixel_ratio: window.devicePixelRatio,
  };
  const body = { ids: wanted.ids, mode: asksForPilot() ? "pilot" : null, display };
  const answer = await insist("POST", "api/sessions", body, onFailure);
  if (!answer.ok) return { refusal: sentence(answer.body) };
  const { token } = answer.body;
  store.remove("drafts", "asked-again");
  store.set("session", { token, ...wanted });
  const address = location.pathname + location.search;
  history.replaceState(null, "", store.lasting ? address : address + FRAGMENT + token);
  return { token, ids: wanted.ids, session: answer.body };
}

// Begin anew at the same address, as another person; what is on its way still goes to the server.
export function leaveSession(store) {
  store.remove("session", "drafts");
  location.assign(location.pathname + location.search);
}

function asksForPilot() {
  return new URLSearchParams(location.search).get("mode") === "pilot";
}

// Whose session it is: what the panel put into the address, and whether it counts.
function described(study) {
  const parameters = new URLSearchParams(location.search);
  const given = study.id_parameters.filter((name) => parameters.has(name));
  const ids = Object.fromEntries(given.map((name) => [name, parameters.get(name).slice(0, 256)]));
  return { name: study.name, ids, mode: study.mode };
}

function fingerprint({ name, ids, mode }) {
  return JSON.stringify([name, mode, Object.entries(ids).sort()]);
}

function inFragment(wanted) {
  if (!location.hash.startsWith(FRAGMENT)) return null;
  return { token: location.hash.slice(FRAGMENT.length), ...wanted };
}

function sentence(body) {
  const detail = body?.detail;
  return typeof detail === "string" ? detail : "The server did not say why.";
}
