// The panel of what the newest finished picture cost, and how exact it is.
import { make } from "./controls.js";
import { rounded } from "./vectors.js";

const counts = {
  rays: "Rays", shadow_rays: "Shadow rays", occlusion_rays: "Ambient occlusion rays",
  edge_samples: "Samples for smooth edges", clear_crossings: "Transparent hits",
  rays_redone_in_double: "Rays traced again in double", rays_judged_exactly: "Rays decided exactly" };
const effects = { shadow_rays: "shadows", occlusion_rays: "ambient occlusion", edge_samples: "smooth edges",
                  clear_crossings: "transparency", slice_lookups: "slices", rays_clipped: "clipping" };

export const grouped = (n) => Number(n).toLocaleString("en");
const counted = (n, noun) => `${grouped(n)} ${noun}${Number(n) === 1 ? "" : "s"}`;

/** A sentence about the comparison of pixels with exact arithmetic. */
export function checkSentence(check) {
  if (!check) return "Pixels are compared with exact arithmetic when the picture rests.";
  if (check.why_not) return check.why_not;
  const within = Number.isFinite(check.kept_by_99)
    ? `, 99 % within ${rounded(check.kept_by_99, 1)} ${check.unit ?? ""}`.trimEnd() : "";
  return `In ${grouped(check.pixels)} pixels, many of them at edges: ` +
    `${counted(check.missed, "false negative")}, ${counted(check.false_hits, "false positive")}${within}`;
}

/** A sentence about the milliseconds that each effect costs. */
export function effectsSentence(effects) {
  if (!effects) return "Effects are timed when the picture rests.";
  if (effects.why_not) return effects.why_not;
  const times = effects.effects.map(({ effect, ms }) => `${effect} ${rounded(ms.toFixed(1))} ms`);
  return `Tracing takes ${rounded(effects.ms, 3)} ms. ` +
    (times.length ? `Cost of effects: ${times.join(", ")}.` : "No effect is used.");
}

export function showCost(panel, view) {
  panel.show([view.name], () => {
    const time = make("p", { id: "cost-time" }), table = make("dl", { id: "cost-counts", class: "pairs" });
    const [byEffect, unused, check] = ["effects", "unused", "check"].map((name) => make("p", { id: `cost-${name}` }));
    panel.onRefresh(() => {
      const { finished } = view, statistics = finished?.statistics ?? {};
      time.textContent = finished
        ? `The picture took ${rounded(finished.ms, 4)} ms. Threads: ${finished.threads}.`
        : "No picture is finished yet.";
      const used = Object.keys(counts).filter((key) => statistics[key] > 0);
      table.hidden = used.length === 0;
      table.replaceChildren(...used.flatMap((key) =>
        [make("dt", { text: counts[key] }), make("dd", { text: grouped(statistics[key]) })]));
      byEffect.textContent = effectsSentence(view.effects);
      const free = Object.keys(effects).filter((key) => statistics[key] === 0).map((key) => effects[key]);
      unused.textContent = free.length ? `Not used here, and without cost: ${free.join(", ")}.` : "";
      check.textContent = checkSentence(view.check);
    });
    return [time, byEffect, table, unused, check];
  });
}
