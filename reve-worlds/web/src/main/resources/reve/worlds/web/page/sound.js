// SPDX-License-Identifier: Apache-2.0
// Sounds of contacts and events, synthesised by Web Audio. There is no sound until the user switches
// it on, and no sound is loaded.
import { $, toast } from "./dom.js";

/** Gain of the loudest contact. */
const LOUDEST = 0.12;
/** Maximum number of tones at a time. Together they stay below full scale. */
const MOST_TONES = 8;
const TONE_SECONDS = 0.35;
const SHORTEST_PAUSE_MILLISECONDS = 120;
/** Events that happen often, or that the page also shows in another way. */
const SILENT = new Set(["acted", "heard", "spoke", "late", "away", "back", "waiting", "missed", "law-shadow"]);

export class Sound {
  constructor(app) {
    this.app = app;
    this.isOn = false;
    this.context = null;
    this.tones = 0;
    this.largest = 0;
    this.lastEvent = -Infinity;
    /** The last tones: name of the body or type of the event, force [N], gain, frequency [Hz]. */
    this.played = [];
    this.skips = false;
    $("sound").onclick = () => this.toggle();
  }

  toggle() {
    this.isOn = !this.isOn;
    $("sound").setAttribute("aria-pressed", String(this.isOn));
    if (!this.isOn) {
      this.context.suspend();
      return;
    }
    if (!this.context) {
      this.context = new AudioContext();
      this.output = new GainNode(this.context);
      this.output.connect(this.context.destination);
    }
    this.context.resume();
    this.largest = 0;
    this.app.view.forgetContacts();
    if (this.app.role === "agent") toast("The page of an agent sounds events only");
    else if (!this.app.view.measuresContacts) toast("This world does not measure contact forces, so only events sound");
  }

  /** Plays no tones for the contacts in the next frame, which have begun while the page was hidden. */
  skip() {
    this.skips = true;
  }

  /** Plays a tone for each contact that has begun since the last call. */
  contacts() {
    const begun = this.app.view.takeContacts();
    if (!this.isOn || this.skips) {
      this.skips = false;
      return;
    }
    begun.sort((a, b) => b.force - a.force);
    for (const { slot, force } of begun.slice(0, MOST_TONES)) this.#contact(slot, force);
  }

  /** The gain grows with the square root of the force, so that weak contacts remain audible beside
   *  the strongest one. Large bodies have low tones, and the tone comes from the body's side. */
  #contact(slot, force) {
    const { view, scene } = this.app;
    const item = view.items[slot];
    if (!item || !(force > 0)) return;
    this.largest = Math.max(this.largest, force);
    const gain = LOUDEST * Math.sqrt(force / this.largest);
    const size = Math.max(...view.size.subarray(3 * slot, 3 * slot + 3));
    const frequency = Math.min(1760, Math.max(110, 330 * Math.sqrt((0.1 * (scene.radius ?? 10)) / (size || 1))));
    this.#tone("triangle", frequency, gain, TONE_SECONDS, scene.side(slot));
    this.#note({ name: item.name, force, gain, frequency });
  }

  #note(tone) {
    this.played.push(tone);
    if (this.played.length > 4 * MOST_TONES) this.played.shift();
  }

  /** Plays a tone for an event of the world. */
  event(type) {
    const now = performance.now();
    if (!this.isOn || SILENT.has(type) || now - this.lastEvent < SHORTEST_PAUSE_MILLISECONDS) return;
    this.lastEvent = now;
    const [frequency, gain, seconds] = type === "fault" ? [130, LOUDEST, 2 * TONE_SECONDS] : [880, 0.4 * LOUDEST, TONE_SECONDS];
    this.#tone("sine", frequency, gain, seconds, 0);
    this.#note({ name: type, gain, frequency });
  }

  #tone(type, frequency, gain, seconds, side) {
    if (this.tones >= MOST_TONES) return;
    this.tones++;
    const now = this.context.currentTime;
    const oscillator = new OscillatorNode(this.context, { type, frequency });
    const envelope = new GainNode(this.context, { gain: 0 });
    const panner = new StereoPannerNode(this.context, { pan: side });
    envelope.gain.setValueAtTime(0, now);
    envelope.gain.linearRampToValueAtTime(gain, now + 0.004);
    envelope.gain.exponentialRampToValueAtTime(gain / 1000, now + seconds);
    oscillator.connect(envelope).connect(panner).connect(this.output);
    oscillator.onended = () => {
      this.tones--;
      panner.disconnect();
    };
    oscillator.start(now);
    oscillator.stop(now + seconds);
  }
}
