// Probes of pixels: at most one is under way, and of those of a moving pointer only the newest
// waits.
const patienceMs = 3000;

export class Prober {
  newest = null;    // the newest answer
  #id = 0;
  #underWay = null;
  #asked = [];      // by clicks and keys: each is answered
  #hovering = null;

  /** @param send  sends an object to the server and returns whether it could */
  constructor(send) {
    this.send = send;
  }

  /** Resolves with the answer for a pixel of the canvas, or with null if none comes. */
  ask(pixel) {
    return new Promise((then) => {
      this.#asked.push({ pixel, then });
      this.#next();
    });
  }

  /** As ask(), but a later call replaces one that still waits. */
  hover(pixel, then) {
    this.#hovering = { pixel, then };
    this.#next();
  }

  take(answer) {
    if (answer.id === this.#underWay?.id) this.#end(this.newest = answer);
  }

  reset() {
    this.#hovering = null;
    for (const { then } of this.#asked.splice(0)) then(null);
    if (this.#underWay) this.#end(null);
  }

  #next() {
    const wanted = this.#underWay ? null : this.#asked.shift() ?? this.#hovering;
    if (!wanted) return;
    if (wanted === this.#hovering) this.#hovering = null;
    const id = ++this.#id;
    this.#underWay = { ...wanted, id, timer: setTimeout(() => this.#end(null), patienceMs) };
    if (!this.send({ probe: wanted.pixel, id })) this.#end(null);
  }

  #end(answer) {
    const { then, timer } = this.#underWay;
    clearTimeout(timer);
    this.#underWay = null;
    then(answer);
    this.#next();
  }
}
