// A queue of stereo samples on the audio thread. It begins 30 ms after the first piece, so that pieces may come
// in bursts, and skips ahead if more than 150 ms wait. An empty queue fades out: a sudden end would click.

class Contact extends AudioWorkletProcessor {
    constructor() {
        super();
        Object.assign(this, {pieces: [], at: 0, waiting: 0, plays: false, last: [0, 0]});
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
            if (this.plays && this.pieces.length) {
                this.last = [this.pieces[0][this.at++], this.pieces[0][this.at++]];
                this.waiting -= 2;
                if (this.at >= this.pieces[0].length) this.drop();
            } else {
                this.plays = false;
                this.last = this.last.map((value) => 0.98 * value);
            }
            [left[k], right[k]] = this.last;
        }
        return true;
    }
}
registerProcessor('contact', Contact);
