// The browser's storage; where it is blocked, nothing is kept and nothing fails.
const storage = (kind) => ({
  get(key) {
    try {
      return window[kind].getItem(key);
    } catch {
      return null;
    }
  },
  set(key, text) {
    try {
      window[kind].setItem(key, text);
    } catch { /* the value lasts as long as the page */ }
  },
});

export const ofTab = storage("sessionStorage"), ofBrowser = storage("localStorage");
