// What this browser keeps from one visit to the next; nothing where it keeps nothing of pages.

export const kept = {
  get(name) {
    try {
      return JSON.parse(localStorage.getItem(`midway ${name}`));
    } catch {
      return null;
    }
  },

  /** Whether it is kept. */
  set(name, value) {
    try {
      localStorage.setItem(`midway ${name}`, JSON.stringify(value));
      return true;
    } catch {
      return false;
    }
  },
};
