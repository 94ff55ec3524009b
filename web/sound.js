// Plays what the fingers hear, and makes a gamepad or a telephone tremble.
//
//     const sound = new ContactSound();
//     sound.start();               // in a person's gesture: browsers allow no sound before
//     sound.play(state.sound);     // interleaved stereo, 48 kHz, the samples since the last state
//
// Where the page is served by https or from this computer, a worklet (sound_worklet.js) plays the samples.
// Elsewhere there is no AudioWorklet, and short buffers are queued one after another.

const rate = 48000, lead_s = 0.06, most_s = 0.2;

export class ContactSound {
    constructor() {
        this.muted = false;
        this.volume = 1;
        this.context = this.node = null;
        this.until = 0;  // the context's time at which the queued buffers end
    }

    start() {
        if (this.context || !globalThis.AudioContext) return this.resume();
        if (navigator.userActivation?.hasBeenActive === false) return undefined;  // a touch counts when it ends
        try {
            this.context = new AudioContext({sampleRate: rate, latencyHint: 'interactive'});
        } catch {
            return undefined;  // no loudspeaker; the page goes on in silence
        }
        this.gain = this.context.createGain();
        this.gain.connect(this.context.destination);
        this.set(this.volume, this.muted);
        const module = this.context.audioWorklet?.addModule(new URL('sound_worklet.js', import.meta.url));
        module?.then(() => {
            this.node = new AudioWorkletNode(this.context, 'contact', {numberOfInputs: 0, outputChannelCount: [2]});
            this.node.connect(this.gain);
        }).catch(() => {});  // buffers are queued instead
        return this.resume();
    }

    resume() {
        return this.context?.resume().catch(() => {});
    }
    suspend() {
        this.context?.suspend().catch(() => {});
    }
    set(volume, muted) {
        Object.assign(this, {volume, muted});
        if (this.gain) this.gain.gain.value = muted ? 0 : volume;
    }

    play(samples) {
        const context = this.context, frames = samples ? samples.length >> 1 : 0;
        if (!frames || context?.state !== 'running') return;
        if (this.node) return this.node.port.postMessage(samples, [samples.buffer]);
        const now = context.currentTime, late = this.until < now;
        if (this.until > now + most_s) return;  // the queue only grows if clocks differ: leave a piece out
        const buffer = context.createBuffer(2, frames, rate), source = context.createBufferSource();
        for (const channel of [0, 1]) {
            const plane = buffer.getChannelData(channel);
            for (let k = 0; k < frames; ++k) plane[k] = samples[2 * k + channel];
        }
        source.buffer = buffer;
        source.connect(this.gain);
        const at = late ? now + lead_s : this.until;
        source.start(at);
        this.until = at + frames / rate;
    }
}

// Strong and weak: 0 to 1. A telephone only knows on and off: it ticks when a finger meets the surface.
export function tremble(pad, [strong, weak], meets) {
    const actuator = pad?.vibrationActuator;
    if (actuator?.playEffect) {
        if (strong > 0.01 || weak > 0.01)
            actuator.playEffect('dual-rumble', {duration: 60, strongMagnitude: strong, weakMagnitude: weak})
                .catch(() => {});
    } else if (meets && navigator.userActivation?.hasBeenActive) navigator.vibrate?.(12);
}
