# SPDX-License-Identifier: Apache-2.0
"""Fingers on a surface: goals in, forces out, for a tick or for many of them in one call."""

from __future__ import annotations

import ctypes
import dataclasses
import enum
import functools
import os
import sys
import threading
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _clip, _library, _planes
from ._library import Closable, Contact, SolverStruct, Tick, call, flag, made, number, of_kind, whole
from ._scene import Scene
from ._surface import Surface, metres_of
from .errors import Status, error_of

_tick_ns = 1_000_000
_contact = numpy.dtype([
    ("struct_size", "u4"), ("guard", "u4"), ("force_n", "f8", 3), ("goal", "f8", 3), ("proxy", "f8", 3),
    ("pixel", "f8", 2), ("stiffness_n_per_m", "f8"), ("static_friction", "f8"), ("dynamic_friction", "f8"),
    ("touching", "i4"), ("in_hole", "i4"), ("error_degrees", "f8"), ("error_newtons", "f8")])  # touch_contact
assert _contact.itemsize == ctypes.sizeof(Contact)


class Guard(enum.IntFlag):
    """Why a force is not simply the solver's: the bits of Touched.guard. No bit: it is. Numbers without a unit.

    STIFFNESS: stiffness limited to max_stiffness_n_per_m.
    FORCE: force limited to max_force_n.
    RAMP: ramping in.
    FAULT: a goal or a surface was missing or impossible: ramping to zero.
    RISE: stiffness not yet risen to the map's; it rises by at most 4 N/mm per second.
    DAMPING: a damper's force added.
    PASSIVITY: the passivity controller's force added.
    JUMP: the surface jumped: the change of force comes on over 100 ms.
    WAITING: no force until the finger has been free.
    GAP: the hand had been left alone.
    STALE: the surface is too old, or was.
    UNSTEADY: of forces_at alone: the force still changes after 500 ticks.
    """

    STIFFNESS = 1
    FORCE = 2
    RAMP = 4
    FAULT = 8
    RISE = 16
    DAMPING = 32
    PASSIVITY = 64
    JUMP = 128
    WAITING = 256
    GAP = 512
    STALE = 1024
    UNSTEADY = 2048


@dataclasses.dataclass(frozen=True)
class SolverSettings:
    """How fingers touch. Every member is one number; Solver and touch take them by name. What is left out is as stated.

    metres_per_scene_unit: of the hand, metres: force = stiffness * this * (proxy - goal). As
        Surface.hand_metres_per_scene_unit says; 1.0 where hand and scene are of one size, as in simulators.
    max_force_n: per finger, newtons, 1e-6 to 1e9; no force is ever longer; 10.
    max_stiffness_n_per_m: 1e-3 to 1e12 N/m; 10000.
    damping_n_s_per_m: of a damper added in contact, N s/m; 0.
    passivity_n_s_per_m: largest damping of the passivity controller, N s/m; 0: it is off.
    stribeck_m_per_s: friction falls with speed (Stribeck), m/s; 0: Coulomb's.
    stale_after_ns: a surface whose newest picture is older ramps away, nanoseconds; 0: never.
    ramp_in_ticks: from the first tick, and after a fault, milliseconds; 100.
    ramp_out_ticks: after a goal that is no number, milliseconds; 100.
    waits_to_be_free: True: no force in a finger that begins inside the surface until it has been free, as a hand wants it;
        False.

    Raises UsageError (a ValueError) in Solver and touch where a member is out of its range.
    """

    metres_per_scene_unit: float | None = None
    max_force_n: float = 10.0
    max_stiffness_n_per_m: float = 10000.0
    damping_n_s_per_m: float = 0.0
    passivity_n_s_per_m: float = 0.0
    stribeck_m_per_s: float = 0.0
    stale_after_ns: int = 0
    ramp_in_ticks: int = 100
    ramp_out_ticks: int = 100
    waits_to_be_free: bool = False

    def _struct(self, fingers: int) -> _library.Struct:
        members = dataclasses.asdict(self)
        members["waits_to_be_free"] = flag("waits_to_be_free", self.waits_to_be_free)
        if self.metres_per_scene_unit is None:
            members["metres_per_scene_unit"] = 0.0
        elif not number("metres_per_scene_unit", self.metres_per_scene_unit) > 0:
            raise _planes.refuse(f"metres_per_scene_unit is {self.metres_per_scene_unit}; must be above 0")
        return SolverStruct(fingers=fingers, **members)


_settings = [setting.name for setting in dataclasses.fields(SolverSettings)]


class _Contacts:
    """What fingers met: arrays whose first axes are those of `contacts`, with which they share memory."""

    def __init__(self, contacts: NDArray[Any], surface: Surface) -> None:
        self.contacts = contacts
        self.scene: Scene = surface.scene
        self._first = surface._first

    @property
    def force_n(self) -> NDArray[numpy.float64]:
        """(..., 3) float64: the force on each finger, newtons; never NaN, never longer than max_force_n."""
        return self.contacts["force_n"]

    @property
    def goal(self) -> NDArray[numpy.float64]:
        """(..., 3) float64, scene units: as given, or the last one that was a number."""
        return self.contacts["goal"]

    @property
    def proxy(self) -> NDArray[numpy.float64]:
        """(..., 3) float64, scene units: where the surface holds the finger; the goal itself out of contact."""
        return self.contacts["proxy"]

    @property
    def pixel(self) -> NDArray[numpy.float64]:
        """(..., 2) float64, pixels: column and row of the proxy; NaN where no pixel sees it."""
        return self.contacts["pixel"]

    @property
    def touching(self) -> NDArray[numpy.bool_]:
        """(...) bool: in contact."""
        return self.contacts["touching"] != 0

    @property
    def in_hole(self) -> NDArray[numpy.bool_]:
        """(...) bool: the proxy rests on a hole's wall or ground."""
        return self.contacts["in_hole"] != 0

    @property
    def stiffness_n_per_m(self) -> NDArray[numpy.float64]:
        """(...) float64, N/m: at the proxy; 0 out of contact."""
        return self.contacts["stiffness_n_per_m"]

    @property
    def static_friction(self) -> NDArray[numpy.float64]:
        """(...) float64, a coefficient: at the proxy; 0 out of contact."""
        return self.contacts["static_friction"]

    @property
    def dynamic_friction(self) -> NDArray[numpy.float64]:
        """(...) float64, a coefficient: at the proxy; 0 out of contact."""
        return self.contacts["dynamic_friction"]

    @property
    def error_degrees(self) -> NDArray[numpy.float64]:
        """(...) float64, degrees: about 95 of 100 forces err by less in direction because depth is wrong. NaN out of
        contact, and unless the Surface has error_bars. docs/measurements.md, Error bars."""
        return self.contacts["error_degrees"]

    @property
    def error_newtons(self) -> NDArray[numpy.float64]:
        """(...) float64, newtons: the same of the spring's size, before limits, and less sure."""
        return self.contacts["error_newtons"]

    @property
    def guard(self) -> NDArray[numpy.uint32]:
        """(...) uint32: bits of Guard, why the force is not simply the solver's; 0: it is."""
        return self.contacts["guard"]

    @functools.cached_property
    def surface_metres(self) -> NDArray[numpy.float32]:
        """(height, width) float32, metres: depth of the first picture that was touched; NaN: no surface there. Raises
        UsageError where none was there."""
        return metres_of(self._first, self.scene)


class Touched(_Contacts):
    """What fingers met, tick by tick: arrays whose first axes (...) are (ticks, fingers). They share memory with `contacts`.

    contacts: all of it, (ticks, fingers) records, as touch_contact of touchable.h has them.
    force_hash: of all forces since the solver was made, 16 hexadecimal digits, as the program prints it: equal hashes mean
        equal forces to the last bit.
    scene: the Scene that says what the touched pictures mean.
    first_tick: milliseconds of the hand's time.
    """

    def __init__(self, contacts: NDArray[Any], force_hash: str, first_tick: int, surface: Surface) -> None:
        """Of contacts (ticks, fingers); programs get it from touch and Solver.run."""
        super().__init__(contacts, surface)
        self.force_hash = force_hash
        self.first_tick = first_tick

    @property
    def time_s(self) -> NDArray[numpy.float64]:
        """(ticks,) float64: seconds of the hand's time, 1 ms a tick."""
        return (self.first_tick + numpy.arange(len(self.contacts))) * 1e-3

    def __len__(self) -> int:
        return len(self.contacts)

    def __repr__(self) -> str:
        ticks, fingers = self.contacts.shape
        return f"<touchable.Touched: {ticks} ticks, {fingers} fingers, force hash {self.force_hash}>"


class ForcesAt(_Contacts):
    """What fingers meet at places, each alone: arrays whose first axes (...) are those of the places. Surface.forces_at
    gives it.

    contacts: all of it, (...) records, as touch_contact of touchable.h has them.
    scene: the Scene that says what the touched picture means.
    """

    @property
    def steady(self) -> NDArray[numpy.bool_]:
        """(...) bool: the force is that at rest. False: it still changed after 500 ticks, or the place is no number, or far
        outside the scene."""
        return (self.guard & (Guard.UNSTEADY | Guard.FAULT)) == 0

    def __repr__(self) -> str:
        return f"<touchable.ForcesAt: {self.contacts.size} places, {int(self.touching.sum())} of them in contact>"


_places_at_a_time = 128  # at most 500 ticks each, so that Ctrl-C takes effect within tens of milliseconds


def forces_at(surface: Surface, points: ArrayLike, friction: bool, time_ns: int | None, settings: dict[str, Any]) -> ForcesAt:
    """See Surface.forces_at."""
    places = _planes.numbers("points", points)
    if places.ndim == 0 or places.shape[-1] != 3:
        raise _planes.refuse(f"points have the shape {places.shape}; must be (..., 3)")
    newest = surface.newest_ns
    if newest is None:
        raise _planes.refuse("no picture was pushed yet; push the first one before")
    moment = Tick(time_ns=newest if time_ns is None else whole("time_ns", time_ns), epoch=surface._epoch)
    struct = _settings_of(settings)._struct(1)
    contacts = numpy.zeros(places.shape[:-1], _contact)
    rows, flat = numpy.ascontiguousarray(places).reshape(-1, 3), contacts.reshape(-1)
    for k in range(0, len(rows), _places_at_a_time):
        some = rows[k : k + _places_at_a_time]
        call("surface_forces_at", surface._handle.number, struct, moment, flag("friction", friction), some.ctypes.data,
             len(some), flat[k:].ctypes.data, _contact.itemsize)
    return ForcesAt(contacts, surface)


def _settings_of(settings: dict[str, Any]) -> SolverSettings:
    for name in settings:
        if name not in _settings:
            raise _planes.refuse(f"there is no setting {name}; must be one of {', '.join(_settings)}")
    return SolverSettings(**settings)


def path_of(path: ArrayLike) -> NDArray[numpy.float64]:
    """A path as the C API takes it: (ticks, fingers, 3) float64, side by side. Raises UsageError where it cannot be."""
    goals = numpy.ascontiguousarray(_planes.numbers("the path", path))
    if goals.ndim == 2:
        goals = goals[:, None, :]
    if goals.ndim != 3 or goals.shape[2] != 3 or goals.shape[1] == 0:
        raise _planes.refuse(f"the path has the shape {numpy.shape(path)}; must be (ticks, 3) or (ticks, fingers, 3)")
    return goals


class Solver(Closable):
    """One to 256 fingers on a surface, which has one solver at a time. Use it in `with`, or close() it.

    surface: what is touched. fingers: how many, 1 to 256. settings: SolverSettings, how they touch.
    next_tick: the tick that comes next, milliseconds of the hand's time.
    contacts: what the fingers met in the last tick() (run() leaves it): (fingers,) records with the members of Touched,
        overwritten by the next one.
    """

    def __init__(self, surface: Surface, fingers: int = 1, **settings: Any) -> None:
        """Fingers on a surface, of which a picture was pushed (or metres_per_scene_unit is given).

        settings: members of SolverSettings. Raises UsageError where one cannot be, Error with Status.BUSY where the
        surface has a solver already, ClosedError.
        """
        of_kind("surface", surface, Surface, "a touchable.Surface")._check_open()
        self.surface = surface
        self.fingers = whole("fingers", fingers, 1, 256)
        self.settings = _settings_of(settings)
        struct = self.settings._struct(self.fingers)
        self._handle = made("solver_create", "solver_destroy", surface._handle.number, struct, needs=(surface._handle,))
        self.next_tick = 0
        self._lock = threading.Lock()  # guards the members below, which a tick fills
        self._tick = Tick()
        self._no_goals = numpy.full((self.fingers, 3), numpy.nan)
        self._goals = self._no_goals.copy()
        self.contacts: NDArray[Any] = numpy.zeros(self.fingers, _contact)
        self._run = _library.function("solver_run")
        self._call = (self._tick, 1, self._goals.ctypes.data, self.contacts.ctypes.data, _contact.itemsize)

    def tick(self, goals: ArrayLike | None, *, time_ns: int | None = None, tick: int | None = None, epoch: int = 0,
             epoch_start_ns: int = 0) -> NDArray[numpy.float64]:
        """One tick, a millisecond of the hand's time. Gives the forces, newtons, (fingers, 3) float64, a new array.

        goals: (fingers, 3), or (3,) of one finger, scene units: where each would be if nothing were in its way. NaN, or
            None for all: no goal is known; the force goes to zero within ramp_out_ticks.
        time_ns: the moment of the pictures' clock; None: the tick's own, 1 ms each. Does not go back within an epoch.
        tick: milliseconds of the hand's time, larger than before; None: the next. Those between were missed.
        epoch, epoch_start_ns: of the surface, and the moment at which it begins; see Surface.begin_epoch.

        `contacts` then has all of it. Raises UsageError where the shape or the tick cannot be, Error with Status.BUSY
        while another thread is in tick() or run(), and ClosedError: then nothing happened.
        """
        given = _planes.numbers("goals", self._no_goals if goals is None else goals)
        if given.shape != self._goals.shape and (given.shape != (3,) or self.fingers != 1):
            raise _planes.refuse(f"goals have the shape {given.shape}; must be ({self.fingers}, 3)")
        with self._free():
            self._goals[...] = given
            self._set_tick(tick, time_ns, epoch, epoch_start_ns)
            status = self._run(self._handle.number, *self._call)
            if status:
                self._refuse(status)
            self.next_tick = self._tick.tick + 1
            return self.contacts["force_n"].copy()

    def run(self, path: ArrayLike, *, time_ns: int | None = None, tick: int | None = None, epoch: int = 0,
            epoch_start_ns: int = 0) -> Touched:
        """Many ticks in one call, with the pictures that are there now.

        path: (ticks, fingers, 3), or (ticks, 3) of one finger, scene units; NaN: no goal. The others as of tick(), of
            the first tick; each later one is a millisecond further. Gives a Touched, and raises as tick() does.
        """
        goals = path_of(path)
        if goals.shape[1] != self.fingers:
            raise _planes.refuse(f"the path is of {goals.shape[1]} fingers, the solver of {self.fingers}")
        contacts = numpy.empty(goals.shape[:2], _contact)
        with self._free():
            first = self.next_tick if tick is None else tick
            self._run_into(goals, contacts, time_ns=time_ns, tick=first, epoch=epoch, epoch_start_ns=epoch_start_ns)
            return Touched(contacts, self.force_hash, first, self.surface)

    def _run_into(self, goals: NDArray[Any], contacts: NDArray[Any], *, time_ns: int | None = None, tick: int | None = None,
                  epoch: int = 0, epoch_start_ns: int = 0) -> None:
        self._set_tick(tick, time_ns, epoch, epoch_start_ns)
        status = self._run(self._handle.number, self._tick, len(goals), goals.ctypes.data, contacts.ctypes.data,
                           _contact.itemsize)
        if status:
            self._refuse(status)
        self.next_tick = self._tick.tick + len(goals)

    def _set_tick(self, tick: int | None, time_ns: int | None, epoch: int, epoch_start_ns: int) -> None:
        now = self._tick
        now.tick = number = self.next_tick if tick is None else whole("tick", tick)
        now.time_ns = whole("time_ns", number * _tick_ns if time_ns is None else time_ns)
        now.epoch = whole("epoch", epoch, 0, 2**64 - 1)
        now.epoch_start_ns = whole("epoch_start_ns", epoch_start_ns)

    def _free(self) -> threading.Lock:
        """The lock, to be taken without waiting: where another thread has it, raises Error with Status.BUSY."""
        if self._lock.locked():
            self._refuse(Status.BUSY)
        return self._lock

    def _refuse(self, status: int) -> None:
        self._check_open()
        if status == Status.BUSY:
            raise error_of(status, "another thread is using the solver; use one thread for each solver")
        if status == Status.USAGE:
            raise _planes.refuse(f"tick {self._tick.tick} cannot be; must be {self.next_tick} or a later one")
        raise error_of(status, _library.line_of(status, "solver"))

    def come_back(self) -> None:
        """The hand was away before the next tick, whose number does not tell (more than 50 ms after the previous one):
        its force comes back by a ramp. Raises ClosedError."""
        self._check_open()
        call("solver_come_back", self._handle.number)

    @property
    def force_hash(self) -> str:
        """Of all forces since the solver was made: 16 hexadecimal digits, as the program prints it. Raises ClosedError."""
        self._check_open()
        value = ctypes.c_uint64()
        call("solver_force_hash", self._handle.number, value)
        return f"{value.value:016x}"

    def save(self) -> bytes:
        """What the solver remembers after its last tick, without frames: another one with the same scene, settings and
        frames goes on from there with the same forces, in another process too. Raises UsageError before the first tick,
        and ClosedError."""
        self._check_open()
        return _library.bytes_of("solver_save", self._handle.number)

    def load(self, state: bytes) -> None:
        """Goes to a saved state; the next tick is the one after. The surface has the frames around its moment, and none
        that are later were met: after a jump back make another surface and push them again. Raises Error with
        Status.INPUT for other frames or settings or a damaged state (then nothing has changed), and ClosedError."""
        self._check_open()
        call("solver_load", self._handle.number, state, len(state))
        self.next_tick = int.from_bytes(state[32:40], "little", signed=True) + 1

    @property
    def state_hash(self) -> str:
        """Of what `save` gives: equal hashes mean equal forces from now on. Raises as `save` does."""
        self._check_open()
        value = ctypes.c_uint64()
        call("solver_state_hash", self._handle.number, value)
        return f"{value.value:016x}"

    def close(self) -> None:
        """Ends the solver; the surface may then have another. Raises Error with Status.BUSY while another thread is in
        tick() or run(). Closing twice does nothing."""
        self._handle.close("another thread is in tick() or run(); close the solver after that")

    def _check_open(self) -> None:
        self._handle.check_open("the solver was closed; make another one")


def touch(clip: _clip.Clip | str | os.PathLike, path: ArrayLike, *, error_bars: bool = False, **settings: Any) -> Touched:
    """Touches a clip along a path, from its first frame on, in virtual time: a tick for each millisecond, over the surface
    that the clip has then. Where the clip ends before the path, its last frame stands still.

    clip: a Clip, or the path of one (opened without colour). path: (ticks, 3) or (ticks, fingers, 3) float64, scene units
    (Scene.points gives such places; clip.scene). error_bars: as in Surface. settings: members of SolverSettings.

    Filters are those that the program chooses. The forces are those of `touchable touch CLIP --hand csv:FILE`, whose file
    states these goals (keys columns=..., space=scene), to the last bit: the force hashes are equal.
    Raises UsageError where the path or a setting cannot be, Error where a frame cannot be read.
    """
    goals = path_of(path)
    if not isinstance(clip, _clip.Clip):
        with _clip.open(clip, colour=False) as opened:
            return touch(opened, goals, error_bars=error_bars, **settings)
    ticks, fingers = goals.shape[:2]
    contacts = numpy.empty((ticks, fingers), _contact)
    with_frames = _Frames(clip, Surface(camera=clip.touched_scene, frames=8, error_bars=error_bars))
    with_frames.push_until(0)
    with Solver(with_frames.surface, fingers, **settings) as solver:
        done = 0
        while done < ticks:
            end = min(with_frames.push_until(done), ticks)
            solver._run_into(goals[done:end], contacts[done:end])
            done = end
        return Touched(contacts, solver.force_hash, 0, with_frames.surface)


class _Frames:
    """A clip's frames on their way to a surface, pushed as virtual time comes to them."""

    def __init__(self, clip: _clip.Clip, surface: Surface) -> None:
        self.surface = surface
        self._coming = iter(clip)
        self._over = False

    def push_until(self, tick: int) -> int:
        """Pushes until a frame later than the tick is there, or none is left. Gives the first tick that needs another."""
        while not self._over and (newest := self.surface.newest_ns or -1) <= tick * _tick_ns:
            frame = next(self._coming, None)
            if frame is None:
                self._over = True
            else:
                self.surface.push(frame)
        if self._over:
            return sys.maxsize
        return (newest - 1) // _tick_ns + 1
