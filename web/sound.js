// SPDX-License-Identifier: Apache-2.0
// Plays what the fingers hear, and makes a gamepad or a telephone tremble.
//
//     const sound = new ContactSound();
//     sound.start();               // in a person's gesture: browsers allow no sound before
//     sound.play(state.sound);     // interleaved stereo, 48 kHz, the samples since the last state
//
// A page from https or from this computer has worklets (sound_worklet.js); elsewhere short buffers are queued.

const rate = 48000, lead_s = 0.06, most_s = 0.2;

export class ContactSound {
  muted = false;
  volume = 1;
  until = 0;  // the context's time at which queued buffers end

  start() {
    if (this.context || !globalThis.AudioContext) return this.resume();
    if (navigator.userActivation?.hasBeenActive === false) return undefined;  // a touch counts when it ends
    try {
      this.context = new AudioContext({sampleRate: rate, latencyHint: 'interactive'});
    } catch {
      return undefined;  // without a loudspeaker the page goes on in silence
    }
    this.gain = new GainNode(this.context);
    this.gain.connect(this.context.destination);
    this.set(this.volume, this.muted);
    const worklet = location.protocol === 'file:' ? null : this.context.audioWorklet;  // from a disk none loads
    worklet?.addModule(new URL('sound_worklet.js', import.meta.url)).then(() => {
      this.node = new AudioWorkletNode(this.context, 'contact', {numberOfInputs: 0, outputChannelCount: [2]});
      this.node.connect(this.gain);
    }).catch(() => {});  // buffers are queued instead
    return this.resume();
  }
  resume() { return this.context?.resume().catch(() => {}); }
  suspend() { return this.context?.suspend().catch(() => {}); }
  set(volume, muted) {
    Object.assign(this, {volume, muted});
    if (this.gain) this.gain.gain.value = muted ? 0 : volume;
  }

  play(samples) {
    const context = this.context, frames = (samples?.length ?? 0) >> 1;
    if (!frames || context?.state !== 'running') return;
    if (this.node) return this.node.port.postMessage(samples, [samples.buffer]);
    if (this.until > context.currentTime + most_s) return;  // clocks differ: leave a piece out
    const buffer = context.createBuffer(2, frames, rate);
    for (const side of [0, 1])
      buffer.copyToChannel(Float32Array.from({length: frames}, (_, k) => samples[2 * k + side]), side);
    const source = new AudioBufferSourceNode(context, {buffer});
    source.connect(this.gain);
    if (this.until < context.currentTime) this.until = context.currentTime + lead_s;
    source.start(this.until);
    this.until += frames / rate;
  }
}

// Strong and weak: 0 to 1. A telephone knows on and off alone: it ticks when a finger meets the surface.
export function tremble(pad, strong, weak, meets) {
  const effect = {duration: 60, strongMagnitude: strong, weakMagnitude: weak};
  if (pad?.vibrationActuator?.playEffect) {
    if (strong + weak > 0.01) pad.vibrationActuator.playEffect('dual-rumble', effect).catch(() => {});
  } else if (meets && navigator.userActivation?.hasBeenActive) navigator.vibrate?.(12);
}
