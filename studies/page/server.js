// Talking to the server: addresses relative to the page, a time limit, and no exception thrown.

const TIME_LIMIT_MS = 15_000;
const TEMPORARY = new Set([408, 425, 429]);

// {ok, status, temporary, retryAfterMs, body}; `status` is 0 where there was no answer at all.
export async function request(method, path, body) {
  const limit = new AbortController();
  const timer = setTimeout(() => limit.abort(), TIME_LIMIT_MS);
  try {
    const response = await fetch(path, {
      method,
      headers: body === undefined ? {} : { "Content-Type": "application/json" },
      body: body === undefined ? undefined : JSON.stringify(body),
      cache: "no-store",
      credentials: "same-origin",
      keepalive: method !== "GET",
      signal: limit.signal,
    });
    return await read(response);
  } catch {
    return { ok: false, status: 0, temporary: true, retryAfterMs: 0, body: null };
  } finally {
    clearTimeout(timer);
  }
}

async function read(response) {
  const content = await response.json().catch(() => null);
  // A hotel's log-in page answers 200 as well, but not with an object.
  const ok = response.ok && content !== null && typeof content === "object";
  const { status } = response;
  return {
    ok,
    status,
    temporary: !ok && (response.ok || status >= 500 || TEMPORARY.has(status)),
    retryAfterMs: 1000 * (Number(response.headers.get("Retry-After")) || 0),
    body: content,
  };
}

// As `request`, again and again while the fault is temporary; `onFailure` hears of each.
export async function insist(method, path, body, onFailure) {
  for (let failures = 0; ; failures += 1) {
    const answer = await request(method, path, body);
    if (!answer.temporary) return answer;
    onFailure(failures + 1);
    const delay = Math.max(Math.min(500 * 2 ** failures, 30_000), answer.retryAfterMs);
    await new Promise((resolve) => {
      setTimeout(resolve, delay * (0.75 + Math.random() / 2));
      window.addEventListener("online", resolve, { once: true });
    });
  }
}
