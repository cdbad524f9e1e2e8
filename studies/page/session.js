// Opening a session, or taking up the one that this browser has begun.

import { insist } from "./server.js";

// Where the browser keeps nothing, the address does: a reload then still finds the session.
const FRAGMENT = "#session=";

// {token, ids, session} or {refusal}, the server's own sentence. `onFailure` hears of each attempt
// that got no answer.
export async function openSession(store, onFailure) {
  const { ids, mode } = fromAddress();
  const kept = store.get("session") ?? inFragment(ids, mode);
  if (kept && kept.mode === mode && sameIds(kept.ids, ids)) {
    const answer = await insist("GET", `api/sessions/${kept.token}`, undefined, onFailure);
    if (answer.ok) return { ...kept, resumed: true, session: answer.body };
  }
  const answer = await insist("POST", "api/sessions", { ids, mode }, onFailure);
  if (!answer.ok) return { refusal: sentence(answer.body) };
  const opened = { token: answer.body.token, ids, mode };
  store.remove("consented", "drafts", "completed");
  keep(store, opened);
  return { ...opened, resumed: false, session: answer.body };
}

// Which questions of the address are ids is the server's affair; `mode` is the page's own.
function fromAddress() {
  const parameters = new URLSearchParams(location.search);
  const mode = parameters.get("mode") === "pilot" ? "pilot" : "live";
  parameters.delete("mode");
  return { ids: Object.fromEntries(parameters), mode };
}

function inFragment(ids, mode) {
  if (!location.hash.startsWith(FRAGMENT)) return null;
  return { token: location.hash.slice(FRAGMENT.length), ids, mode };
}

function keep(store, opened) {
  store.set("session", opened);
  const address = location.pathname + location.search;
  history.replaceState(null, "", store.lasting ? address : address + FRAGMENT + opened.token);
}

function sameIds(first, second) {
  const sorted = (ids) => JSON.stringify(Object.entries(ids).sort());
  return sorted(first) === sorted(second);
}

function sentence(body) {
  const detail = body?.detail;
  return typeof detail === "string" ? detail : "The server did not open a session.";
}
