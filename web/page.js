// The page of touchable: it connects the worker, which holds the clip, the solver and the view, with pointer, keys,
// gamepad, picture and sound. The messages between both are listed at the head of worker.js.
//
// Once per animation frame the page sends 'due'; the worker runs the ticks that have elapsed and answers by one
// 'state', which is drawn at once. Nothing runs while the page is hidden. All waiting goes through `clock`, which
// tests move by window.touchable.advance(ms). `?clip=URL` names the clip, `?kiosk` makes an unattended exhibit.

import {SurfacePicture, paint_fingers, ramp_colours} from './draw.js';
import {ContactSound, tremble} from './sound.js';
import {keys} from './words.js';

const $ = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search), kiosk = query.has('kiosk');
const calm = matchMedia('(prefers-reduced-motion: reduce)').matches;
const one_file = globalThis.touchable_one_file;  // touch.html: {worker: URL, clip: {json, files}}
const canvas = $('picture'), stage = $('stage'), invitation = $('invitation');
const sound = new ContactSound();
const invited_again_ms = 20000, reset_ms = 60000;

const clock = {
    ahead: 0, waiting: [],
    now() { return performance.now() + this.ahead; },
    later(ms, call) {
        this.waiting.push({at: this.now() + ms, call});
        setTimeout(() => this.run(this.now()), ms);
    },
    // Calls what is due until `end`, in order of time.
    run(end) {
        for (;;) {
            const next = this.waiting.reduce((a, b) => (a && a.at <= b.at ? a : b), null);
            if (!next || next.at > end) return;
            this.waiting.splice(this.waiting.indexOf(next), 1);
            this.ahead += Math.max(0, next.at - this.now());
            next.call();
        }
    },
    advance(ms) {
        const end = this.now() + ms;
        this.run(end);
        this.ahead += Math.max(0, end - this.now());
    }
};

// For tests: see above and `verify`.
const touchable = globalThis.touchable = {
    worker: null, clip: null, state: null, frames_drawn: 0, pictures_drawn: 0, errors: [], clock,
    advance: (ms) => clock.advance(ms),
    // Resolves to the worker's 'verified', whose frames are drawn as they are met.
    verify: (goals, fingers, ticks, commands = []) => new Promise((resolve) => {
        verified = resolve;
        post({do: 'verify', goals, fingers, ticks, commands});
    })
};
let picture = null, verified = null;
let unit = 1;                          // canvas pixels of a CSS pixel
let answered = false, settled = false; // the last 'due'; whether playing and looping are as a page begins
let new_frame = false, drawn_key = '', drawn_fingers = '';
let pointer = null;                    // where the values are shown, canvas pixels
let enter_held = false, pad_presses = false, used_keys = false, seeking = false;
let last_input = clock.now(), last_tick = 0, touched = false;
const held = new Map();                // pointers that are down, and the buttons of each

// A build in one file replaces the worker's address.
function make_worker() {
    return new Worker(one_file ? one_file.worker : new URL('worker.js', import.meta.url), {type: 'module'});
}
function post(message, transfer = []) {
    touchable.worker.postMessage(message, transfer);
}
function command(name, number = 0) {
    post({do: 'command', name, number});
}
function put(element, text) {
    if (element.textContent !== text) element.textContent = text;
}

// ---- What is said: a sentence in place of the picture, a notice above it, words for a screen reader

function show_message(text, stops = false) {
    $('message').hidden = !text;
    $('message').classList.remove('start');
    $('message').classList.toggle('stop', stops);
    $('message').querySelector('progress').hidden = true;
    put($('message').firstElementChild, text);
    if (stops) invitation.hidden = true;
}
function show_fault(text, fatal) {
    touchable.errors.push(text);
    if (fatal) return show_message(text, true);
    put($('notice').firstElementChild, text);
    $('notice').hidden = false;
}
function stop(text) {
    show_fault(text, true);
    $('bar').hidden = true;
}
function say(text) {
    $('said').textContent = '';
    clock.later(60, () => put($('said'), text));  // or the same words would not be read again
}
function say_finger() {
    const finger = touchable.state?.fingers.find((one) => one.at);
    if (!finger) return say('No finger is on the picture.');
    const mm = finger.depth_mm, where = mm < 0 ? `${(-mm).toFixed(1)} millimetres above the surface`
                                               : `${mm.toFixed(1)} millimetres deep`;
    return say([finger.label, touchable.state.pick?.valid === false ? 'nothing to touch' : where,
                `${finger.newtons.toFixed(1)} newtons`].filter(Boolean).join(', '));
}

// ---- Messages of the worker

const answers = {
    clip(clip) {
        touchable.clip = clip;
        picture.begin(clip);
        document.title = (clip.name ? clip.name + ' · ' : '') + 'touchable';
        show_message('');
        const still = !clip.live && !(clip.frames > 1), globe = /globe/i.test(clip.name);
        for (const id of ['play', 'time', 'seek', 'speed', 'loop']) $(id).hidden = still;
        for (const id of ['seek', 'speed', 'loop']) $(id).hidden ||= clip.live;
        $('seek').max = clip.seconds || 1;
        for (const option of $('overlay').options) {
            const plane = {stiffness: 'haptic', friction: 'haptic', height: 'height'}[option.value];
            option.disabled = plane !== undefined && !clip.has[plane];
            if (option.value === 'colour') option.label = clip.has.colour ? 'colour' : 'shape';
        }
        show_overlay('colour');
        put($('invite'), kiosk ? `Touch the ${globe ? 'globe' : 'picture'}`
                               : `Move over the ${globe ? 'globe' : 'picture'}. Hold to press.`);
        put($('hint'), matchMedia('(pointer: coarse)').matches ? 'One finger touches, two turn it.'
                     : kiosk ? 'Move, hold the button, and feel.' : 'The ring and the number show the force.');
        invite(true);
        $('lock').hidden = !kiosk;
        $('bar').classList.remove('empty');
        $('bar').hidden = $('force').hidden = false;
        settled = false;
        answered = true;
    },
    progress({loaded, total, what}) {
        if (touchable.clip && $('message').hidden) return;
        show_message(`Loading ${what || 'the clip'} …`);
        $('message').querySelector('progress').hidden = !(total > 0);
        $('message').querySelector('progress').value = total > 0 ? loaded / total : 0;
    },
    frame(frame) {
        picture.show(frame);
        ++touchable.frames_drawn;
        new_frame = true;
        if (verified && touchable.state) draw(touchable.state);
    },
    state(state) {
        answered = true;
        touchable.state = state;
        if (!settled && touchable.clip) settle(state);
        const began = performance.now();
        draw(state);
        show_state(state);
        pace.own_ms = performance.now() - began;
        sound.play(state.sound);
        const meets = state.fingers.some((finger) => finger.touching);
        tremble(gamepad(), state.rumble || [0, 0], meets && !touched);
        touched = meets;
    },
    verified(result) {
        verified?.(result);
        verified = null;
        answered = true;
    },
    fault({text, fatal}) { show_fault(String(text), fatal); }
};

// A page plays and loops from the start, unless the person asked for less motion.
function settle(state) {
    settled = true;
    const {frames, live} = touchable.clip;
    if (live || frames < 2) return;
    if (state.playing === calm) command('play-pause');
    if (!state.loops) command('loop');
}

function draw(state) {
    const overlay = $('overlay').value, key = `${overlay} ${state.own_view} ${canvas.width} ${picture.stride} ` +
        `${canvas.height} ${state.matrix}`;
    if (new_frame || key !== drawn_key) {
        if (picture.draw(state.matrix, state.own_view, overlay)) ++touchable.pictures_drawn;
        pace.drew = true;
        new_frame = false;
        drawn_key = key;
    }
    const fingers = JSON.stringify(state.fingers) + $('fingers').width;
    if (fingers !== drawn_fingers) paint_fingers($('fingers'), unit, state.fingers);
    drawn_fingers = fingers;
}

// ---- What controls and panels show

function show_state(state) {
    const tenths = Math.floor(10 * state.time + 0.05), [time, frame] = $('time').children;
    put(time, touchable.clip.live ? 'live' : `${Math.floor(tenths / 600)}:` +
        `${String(Math.floor(tenths / 10) % 60).padStart(2, '0')}.${tenths % 10}`);
    put(frame, ` frame ${state.frame}`);
    if (!seeking) $('seek').value = state.time;
    $('seek').setAttribute('aria-valuetext', `${time.textContent}, frame ${state.frame}`);
    put($('speed'), `${+state.speed.toFixed(2)}×`);
    $('speed').setAttribute('aria-label', `Speed: ${+state.speed.toFixed(2)} times`);
    $('play').toggleAttribute('data-on', state.playing);
    $('play').setAttribute('aria-label', state.playing ? 'Pause' : 'Play');
    $('loop').setAttribute('aria-pressed', state.loops);
    $('turning').setAttribute('aria-pressed', state.turning);
    $('home').disabled = state.own_view;
    put($('force').firstElementChild, state.force_on === false ? 'off' : state.newtons.toFixed(1));
    put($('force').children[1], state.force_on === false ? '' : ' N');
    const share = Math.max(0, ...state.fingers.map((finger) => finger.share || 0));
    $('force').lastElementChild.firstElementChild.style.transform = `scaleX(${Math.min(share, 1).toFixed(3)})`;
    show_values(state.pick);
    show_legend();
}

function show_values(pick) {
    $('values').hidden = !pick || !invitation.hidden && !invitation.classList.contains('away');
    if (!pick) return;
    const given = (words, value, digits, after = '') =>
        Number.isFinite(value) ? `${words} ${value.toFixed(digits)}${after}` : null;
    put($('values'), !pick.valid ? 'nothing to touch' : [
        given('distance', pick.depth_m, 4, ' m'), given('stiffness', pick.stiffness, 2, ' N/mm'),
        given('friction', pick.friction_static, 2, given(', sliding', pick.friction_dynamic, 2) ?? ''),
        touchable.clip.has.height ? given('height', pick.height_mm, 2, ' mm') : null].filter(Boolean).join('\n'));
}

function show_overlay(value) {
    $('overlay').value = value;
    $('legend').hidden = value === 'colour';
    const ramp = value === 'depth' ? [...ramp_colours].reverse() : ramp_colours;
    $('legend').children[1].style.background = value === 'missing'
        ? 'linear-gradient(90deg, #57b5e8 50%, #555 50%)' : `linear-gradient(90deg, ${ramp})`;
}
function show_legend() {
    const value = $('overlay').value, {clip} = touchable;
    if (value === 'colour') return;
    const length = (units) => (units * clip.unit < 0.1 ? `${(1000 * units * clip.unit).toPrecision(3)} mm`
                                                       : `${(units * clip.unit).toPrecision(3)} m`);
    const range = clip.ranges?.[value];  // the least and greatest value of the clip's maps, if it says so
    const ends = value === 'depth' ? picture.range.map(length) : value === 'height' ? ['0', length(picture.highest || 0)]
               : value === 'missing' ? ['measured', 'missing'] : value === 'friction' ? range ?? ['slippery', 'sticky']
               : range ?? ['soft', 'hard'];
    put($('legend').children[0], value === 'missing' ? 'missing depth' : value);
    put($('least'), String(ends[0]));
    put($('greatest'), String(ends[1]));
}

// ---- Sizes: the finer the picture, the slower; 30 pictures a second shall hold

// Share of the canvas's pixels a side, and the stride of drawn vertices.
const levels = [[1, 1], [0.75, 1], [0.75, 2], [0.5, 2], [0.5, 3], [0.35, 4]];
const pace = {
    level: 0, slow: 0, quick: 0, own_ms: 0, drew: false,
    note(ms) {
        if (!this.drew || ms > 500) return;
        this.drew = false;
        const is_slow = ms > 34 && this.own_ms < 0.7 * ms;  // a page that is itself busy gains nothing
        this.slow = is_slow ? this.slow + 1 : Math.max(0, this.slow - 0.5);
        this.quick = ms < 20 ? this.quick + 1 : 0;
        const change = this.slow > 12 ? 1 : this.quick > 600 ? -1 : 0;
        if (!change || !levels[this.level + change]) return;
        Object.assign(this, {level: this.level + change, slow: 0, quick: 0});
        resize();
    }
};

function resize() {
    const {clientWidth: width, clientHeight: height} = stage, share = levels[pace.level][0];
    unit = Math.min(devicePixelRatio || 1, 3);
    Object.assign($('fingers'), {width: Math.round(width * unit), height: Math.round(height * unit)});
    const most = Math.min(1, Math.sqrt(3e6 / Math.max(1, width * height * unit * unit)));
    Object.assign(canvas, {width: Math.max(1, Math.round(width * unit * most * share)),
                           height: Math.max(1, Math.round(height * unit * most * share))});
    picture.stride = levels[pace.level][1];
    drawn_key = drawn_fingers = '';
    post({do: 'size', width: $('fingers').width, height: $('fingers').height});
}

// ---- Pointers: mouse, pen and touches become the window's events

const buttons = [[1, 'left'], [2, 'right'], [4, 'middle']];
function send(kind, event, more = {}) {
    const [x, y] = [event.clientX * unit, event.clientY * unit];  // the stage begins in the page's corner
    pointer = [x, y];
    post({do: 'event', kind, x, y, word: '', control: event.ctrlKey, shift: event.shiftKey, touch: event.pointerId ?? 0,
          seconds: event.timeStamp / 1000, press: event.pointerType === 'pen' ? event.pressure : 0, ...more});
}
function leave() {
    pointer = null;
    enter_held = false;
    held.clear();
    post({do: 'event', kind: 'left_window', x: 0, y: 0, word: '', control: false, shift: false, touch: 0,
          seconds: performance.now() / 1000, press: 0});
}
function on_pointer(event) {
    const {type, pointerId: id, pointerType} = event, down = type === 'pointerdown';
    note_input(down);
    if (down) canvas.setPointerCapture(id);
    if (pointerType === 'touch') {
        if (down) send('touch_began', event);
        else if (type === 'pointermove') for (const part of parts_of(event)) send('touch_moved', part);
        else if (held.has(id)) send('touch_ended', event);
        if (down) held.set(id, 1);
        else if (type !== 'pointermove') held.delete(id);
        if (!held.size) pointer = null;
        return;
    }
    invitation.classList.add('over');
    for (const part of parts_of(event)) send('moved', part);
    // A second button comes as a movement, so the buttons are compared.
    const before = held.get(id) ?? 0, now = type === 'pointercancel' ? 0 : event.buttons;
    for (const [bit, word] of buttons)
        if ((before ^ now) & bit) send(now & bit ? 'pressed' : 'released', event, {word});
    if (now) held.set(id, now);
    else held.delete(id);
}
function parts_of(event) {
    const parts = event.type === 'pointermove' ? event.getCoalescedEvents?.() : null;
    return parts?.length ? parts : [event];
}
function on_wheel(event) {
    event.preventDefault();
    note_input();
    send('wheel', event, {y: -event.deltaY / (event.deltaMode ? 3 : 100)});
}

// ---- Keys and gamepad

const key_names = {' ': 'space', ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'up', ArrowDown: 'down'};
const worker_commands = new Set(['home', 'fingers', 'deeper', 'point-down', 'point-right', 'force', 'turning', 'turn',
                                 'tilt', 'nearer', 'play-pause', 'seek-by', 'step', 'faster', 'loop']);
const page_commands = {
    mute: () => set_sound(sound.volume, !sound.muted),
    louder: (number) => set_sound(Math.min(Math.max(sound.volume + number / 100, 0), 1), false),
    overlay() {
        const free = [...$('overlay').options].filter((option) => !option.disabled);
        show_overlay(free[(free.findIndex((option) => option.selected) + 1) % free.length].value);
    },
    help: () => show_help(),
    fullscreen: () => (document.fullscreenElement ? document.exitFullscreen() : document.body.requestFullscreen())
        .catch(() => {})
};
const held_keys_repeat = new Set(['deeper', 'point-down', 'point-right', 'turn', 'tilt', 'nearer', 'seek-by', 'step']);
const not_for_visitors = new Set(['help', 'fullscreen', 'loop', 'turning']);
const is_handled = (name) => (worker_commands.has(name) || name in page_commands) && !(kiosk && not_for_visitors.has(name));

function set_sound(volume, muted) {
    sound.set(volume, muted);
    $('mute').toggleAttribute('data-on', !muted);
    $('mute').setAttribute('aria-pressed', !muted);
}
function do_command(name, number) {
    if (name in page_commands) page_commands[name](number);
    else command(name, name.startsWith('point-') ? number * unit : number);
}
function binding_of(event) {
    let key = key_names[event.key] ?? event.key.toLowerCase();
    if (key.length === 1 && key > '~' && event.code.startsWith('Key')) key = event.code[3].toLowerCase();
    const is_sign = key.length === 1 && !/[a-z]/.test(key);  // Shift only serves to type it
    return keys.find((one) => one.key === key && !!one.control === event.ctrlKey && is_handled(one.command) &&
                              (is_sign || !!one.shift === event.shiftKey));
}
function on_key(event) {
    const target = event.target, over_picture = target === canvas || target === document.body;
    if (event.altKey || event.metaKey || !touchable.clip || document.querySelector('dialog[open]')) return;
    used_keys = true;
    if (target.matches('select, input[type=number]')) return;
    if (!over_picture && ['Enter', ' '].includes(event.key)) return;
    if (target === $('seek') && /^(Arrow|Home|End|Page)/.test(event.key)) return;
    if (event.key === 'Escape') $('notice').hidden = true;
    const arrow = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
    const found = binding_of(event);
    if (event.key === 'Enter') enter_held = true;
    else if (event.key === 'i' && !event.ctrlKey) say_finger();
    else if (arrow && over_picture && !event.ctrlKey) {
        // On the picture arrows lead the finger, or turn the view while dragging does.
        const turns = touchable.state?.turning, [right, down] = arrow;
        if (right) do_command(turns ? 'turn' : 'point-right', right * (turns ? 5 : 8));
        else do_command(turns ? 'tilt' : 'point-down', down * (turns ? -5 : 8));
    } else if (!found) return;
    else if (!event.repeat || held_keys_repeat.has(found.command)) do_command(found.command, found.number ?? 0);
    event.preventDefault();
    note_input(true);
}

function gamepad() {
    return [...(navigator.getGamepads?.() ?? [])].find((pad) => pad?.connected && pad.axes.length >= 2);
}
function read_gamepad(seconds) {
    const pad = gamepad();
    pad_presses = pad?.buttons[7]?.value > 0.15;
    const [x, y, turn, tilt] = (pad?.axes ?? []).map((value) => (Math.abs(value) < 0.15 ? 0 : value));
    if (x) command('point-right', 420 * unit * seconds * x);
    if (y) command('point-down', 420 * unit * seconds * y);
    if (turn) command('turn', 90 * seconds * turn);
    if (tilt) command('tilt', -90 * seconds * tilt);
    if (pad_presses || x || y || turn || tilt) note_input(true);
}

// ---- The invitation, and the exhibit's reset

function invite(shown) {
    invitation.hidden = false;
    invitation.classList.toggle('away', !shown);
}
function note_input(pressed = false) {
    last_input = clock.now();
    if (!pressed) return;
    invite(false);
    sound.start();
}
function watch_visitors() {
    clock.later(1000, watch_visitors);
    if (held.size || !touchable.clip) return;
    const idle_ms = clock.now() - last_input;
    if (idle_ms >= invited_again_ms) invite(true);
    if (idle_ms < reset_ms) return;
    last_input = Infinity;  // once, until the next visitor
    post({do: 'reset'});
    show_overlay('colour');
    set_sound(1, false);
    $('lock').hidden = $('notice').hidden = true;
    settled = false;
}

// ---- Pictures of one's own, and help

async function ask_picture(file) {
    if (!file || kiosk) return;
    if (file.size > 2e8) return show_fault(`${file.name} is larger than 200 MB.`, false);
    put($('ask-name'), file.name);
    $('ask').returnValue = '';
    $('ask').showModal();
    await new Promise((resolve) => $('ask').addEventListener('close', resolve, {once: true}));
    if ($('ask').returnValue !== 'open') return;
    const metres = Number($('unit').value) || $('level').valueAsNumber / 1000, fov = $('fov').valueAsNumber;
    try {
        const bytes = await file.arrayBuffer();
        show_message('Reading the picture …');
        post({do: 'picture', bytes, name: file.name, unit: metres, fov}, [bytes]);
    } catch {
        show_fault(`${file.name} cannot be read.`, false);
    }
}

const by_hand = {
    'Mouse and pen': [['move', 'the finger follows'], ['left button, pen', 'press; the pen by its pressure'],
                      ['wheel', 'press deeper or less deep'], ['middle button, Ctrl and left', 'drag: turn'],
                      ['Ctrl and wheel', 'nearer or farther']],
    'Touch screen': [['one finger', 'touches; up to five'], ['two fingers', 'turn; apart or together: nearer, farther']],
    Gamepad: [['left stick', 'moves the finger'], ['right trigger', 'presses'], ['right stick', 'turns the view']],
    'On the picture': [['arrows', 'move the finger'], ['Enter', 'held: press'], ['I', 'say label, distance and force']]
};
const topics = {begin: 'First keys', touch: 'Touch', view: 'View', play: 'Play', data: 'Data', window: 'Page'};
function show_help() {
    const sections = Object.entries(by_hand).map(([title, rows]) => [title, rows]);
    let what = '';
    for (const {key, control, shift, command: name, what: words, topic} of keys) {
        what = words ?? what;
        if (!is_handled(name)) continue;
        const title = topics[topic] ?? topic, label = `${control ? 'Ctrl ' : ''}${shift ? 'Shift ' : ''}` +
            (key.length > 1 ? key[0].toUpperCase() + key.slice(1) : key.toUpperCase());
        if (!sections.some(([other]) => other === title)) sections.push([title, []]);
        const rows = sections.find(([other]) => other === title)[1], last = rows.at(-1);
        if (last?.[1] === what) last[0] += '  ' + label;
        else rows.push([label, what]);
    }
    const made = (tag, text) => Object.assign(document.createElement(tag), {textContent: text});
    const {clip} = touchable, parts = [];
    for (const [title, rows] of sections) {
        const list = document.createElement('dl');
        for (const row of rows) list.append(made('dt', row[0]), made('dd', row[1]));
        parts.push(made('h3', title), list);
    }
    if (clip) {
        parts.push(made('h3', 'This clip'), made('p', `${clip.name}: ${clip.width} x ${clip.height} pixels` +
            (clip.frames > 1 ? `, ${clip.frames} frames, ${clip.seconds.toFixed(1)} s` : '')));
        parts.push(...(clip.remarks ?? []).map((remark) => made('p', remark)));
    }
    $('about-text').replaceChildren(...parts);
    $('about').showModal();
}

// ---- Start

function tick(now) {
    requestAnimationFrame(tick);
    const ms = now - last_tick;
    last_tick = now;
    pace.note(ms);
    if (!touchable.clip || !answered || verified) return;
    read_gamepad(Math.min(ms, 100) / 1000);
    const place = pointer ?? touchable.state?.fingers[0]?.at;
    if (place) post({do: 'pick', x: place[0], y: place[1]});
    post({do: 'due', pressed: enter_held || pad_presses});
    answered = false;
}

function connect_controls() {
    for (const type of ['pointerdown', 'pointermove', 'pointerup', 'pointercancel'])
        canvas.addEventListener(type, on_pointer);
    canvas.addEventListener('pointerleave', (event) => {
        invitation.classList.remove('over');
        if (event.pointerType !== 'touch') leave();
    });
    canvas.addEventListener('wheel', on_wheel, {passive: false});
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('dblclick', () => { if (!kiosk) page_commands.fullscreen(); });
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => {
        picture.prepare();
        drawn_key = '';
    });
    addEventListener('keydown', on_key);
    addEventListener('keyup', (event) => { if (event.key === 'Enter') enter_held = false; });
    addEventListener('blur', leave);
    addEventListener('pointerdown', () => { used_keys = false; }, true);
    document.addEventListener('visibilitychange', () => {
        if (document.hidden) leave();
        if (document.hidden) sound.suspend();
        else sound.resume();
    });
    new ResizeObserver(resize).observe(stage);
    const press = {play: 'play-pause', loop: 'loop', turning: 'turning', home: 'home', mute: 'mute', help: 'help',
                   fullscreen: 'fullscreen'};
    for (const [id, name] of Object.entries(press)) $(id).addEventListener('click', () => do_command(name, 0));
    $('speed').addEventListener('click', () => {
        const now = touchable.state.speed, next = {1: 0.5, 0.5: 0.25, 0.25: 2}[now] ?? 1;
        command('faster', next / now);
    });
    $('seek').addEventListener('input', () => {
        seeking = true;
        command('seek', $('seek').valueAsNumber);
    });
    $('seek').addEventListener('change', () => { seeking = false; });
    $('overlay').addEventListener('change', () => show_overlay($('overlay').value));
    // After a click, keys belong to the picture again.
    $('bar').addEventListener('click', (event) => {
        note_input(true);
        if (!used_keys && event.target.closest('button')) canvas.focus({preventScroll: true});
    });
    $('notice').lastElementChild.addEventListener('click', () => { $('notice').hidden = true; });
    $('open').addEventListener('click', () => $('file').click());
    $('file').addEventListener('change', () => {
        ask_picture($('file').files[0]);
        $('file').value = '';
    });
    $('unit').addEventListener('change', () => { $('own-unit').hidden = $('unit').value !== ''; });
    for (const type of ['dragover', 'dragleave', 'drop'])
        addEventListener(type, (event) => {
            event.preventDefault();
            $('drop').hidden = kiosk || type !== 'dragover';
            if (type === 'drop') ask_picture(event.dataTransfer.files[0]);
        });
}

function start() {
    addEventListener('error', (event) => touchable.errors.push(event.message));
    addEventListener('unhandledrejection', (event) => touchable.errors.push(String(event.reason)));
    document.body.classList.toggle('kiosk', kiosk);
    $('fullscreen').hidden = !document.fullscreenEnabled;
    for (const [there, what] of [[globalThis.WebAssembly, 'WebAssembly'], [globalThis.Worker, 'workers'],
                                 [globalThis.DecompressionStream, 'DecompressionStream']])
        if (!there) return stop(`This page needs ${what}, which this browser does not offer. A newer one will do.`);
    try {
        picture = new SurfacePicture(canvas);
        touchable.worker = make_worker();
    } catch (error) {
        return stop(error.message);
    }
    touchable.worker.onmessage = ({data}) => answers[data.is]?.(data);
    touchable.worker.onerror = (event) => stop('The worker stopped: ' + (event.message || 'it cannot be loaded') + '.');
    set_sound(1, false);
    connect_controls();
    resize();
    show_message('Loading the clip …');
    const files = one_file ? {...one_file.clip.files, 'clip.json': new Blob([JSON.stringify(one_file.clip.json)])} : null;
    post({do: 'open', url: new URL(query.get('clip') || 'clip.json', location.href).href, files});
    if (kiosk) watch_visitors();
    requestAnimationFrame(tick);
}
start();
