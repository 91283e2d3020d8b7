// Probes of pixels: at most one is under way, and of those of a moving pointer only the newest
// waits.
const patienceMs = 1000;
const noAnswer = "The probe got no answer: its connection has ended. Try again when the picture is back.";

export class Prober {
  newest = null;    // the newest answer
  #id = 0;
  #underWay = null;
  #asked = [];      // by clicks and keys: each is answered
  #hovering = null;

  /**
   * @param send  sends an object to the server and returns whether it could
   * @param say   shows the user a sentence: that a probe waits, or why it has no answer
   */
  constructor(send, say) {
    Object.assign(this, { send, say });
  }

  /** Resolves with the answer for a pixel of the canvas, or with null if none comes. */
  ask(pixel) {
    return new Promise((then) => {
      const timer = setTimeout(() => this.say("The probe waits for an answer."), patienceMs);
      this.#asked.push({ pixel, then, timer, isAsked: true });
      this.#next();
    });
  }

  /** Calls then() with the answer, unless none comes or a later call replaces this one. */
  hover(pixel, then) {
    this.#hovering = { pixel, then };
    this.#next();
  }

  take(answer) {
    if (answer.id !== this.#underWay?.id) return;
    if (!answer.why_not) this.newest = answer;
    this.#end(answer);
  }

  /** No probe is answered any more: the connection was lost. */
  reset() {
    const lost = [this.#underWay, ...this.#asked.splice(0)].filter(Boolean);
    this.#hovering = this.#underWay = null;
    for (const probe of lost) this.#finish(probe, { why_not: noAnswer });
  }

  #next() {
    const wanted = this.#underWay ? null : this.#asked.shift() ?? this.#hovering;
    if (!wanted) return;
    if (wanted === this.#hovering) this.#hovering = null;
    const id = ++this.#id;
    this.#underWay = { ...wanted, id };
    if (!this.send({ probe: wanted.pixel, id })) this.#end({ why_not: noAnswer });
  }

  #end(answer) {
    const probe = this.#underWay;
    this.#underWay = null;
    this.#finish(probe, answer);
    this.#next();
  }

  #finish({ then, timer, isAsked }, answer) {
    clearTimeout(timer);
    if (!answer.why_not) then(answer);
    else if (isAsked) {
      this.say(answer.why_not);
      then(null);
    }
  }
}
