// SPDX-License-Identifier: Apache-2.0
// A queue of stereo samples on the audio thread. It begins when 30 ms wait, since pieces come in bursts, and skips
// ahead when more than 150 ms do. An empty queue fades out: a sudden end would click.

class Contact extends AudioWorkletProcessor {
  pieces = [];
  at = 0;
  waiting = 0;
  plays = false;
  last = [0, 0];
  constructor() {
    super();
    this.port.onmessage = ({data}) => {
      this.pieces.push(data);
      this.waiting += data.length;
      while (this.waiting > 0.3 * sampleRate && this.pieces.length > 1) this.drop();
      this.plays ||= this.waiting >= 0.06 * sampleRate;
    };
  }
  drop() {
    this.waiting -= this.pieces.shift().length - this.at;
    this.at = 0;
  }
  process(_, [[left, right]]) {
    for (let k = 0; k < left.length; ++k) {
      const piece = this.pieces[0];
      this.plays &&= piece !== undefined;
      this.last = this.plays ? [piece[this.at++], piece[this.at++]] : this.last.map((value) => 0.98 * value);
      if (this.plays) this.waiting -= 2;
      if (this.plays && this.at >= piece.length) this.drop();
      [left[k], right[k]] = this.last;
    }
    return true;
  }
}
registerProcessor('contact', Contact);
