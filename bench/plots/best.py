# SPDX-License-Identifier: Apache-2.0
"""What is best of what the records compare: ways to do the same thing, told from each other by a part of their names."""

import re
from typing import NamedTuple

from plots.files import figures_of, is_number, measured_once
from plots.hand import noticed_degrees


class Question(NamedTuple):
    words: str
    names: str  # of a case and its metric, joined by a space
    where: str  # the groups of `names` that are the same, and `way` those that are compared
    more_is_best: bool = False
    way: str = "{way}"
    unnoticed: bool = False  # only where a hand does not notice the error of the force's direction


SIZE = r"(?P<size>\d+x\d+)"
GLOBE = f"globe-{SIZE}-(?P<bits>\\w+)-1f-(?P<mode>world|pixel|scaled)(?P<camera>-Aprime|-A|)(?P<filters>(-m\\d)?(-t)?(-lazy)?)"
FRAME = SIZE + r"-(?P<bits>\d+) (?P<way>{})(?P<side>[35])(?:_2t)?_{}ms"
QUESTIONS = [
    Question("Time of a tick of one finger, where a hand does not notice the error of the force's direction",
             GLOBE + " tick_us_mean", "globe{camera}, {size}", way="{bits}-{mode}{filters}", unnoticed=True),
    Question("Error of the force's direction, one finger, RMS",
             GLOBE + " force_angle_deg_rms", "globe{camera}, {size}", way="{bits}-{mode}{filters}"),
    Question("Distance to a moving surface, RMS",
             f"moving-{SIZE}-\\w+-1f-world(?P<way>|-hold)-follow-(?P<speed>[\\d.]+) distance_mm_rms", "{size}, {speed} m/s"),
    Question("A frame through a median, wall time (OpenCV: the median alone)",
             FRAME.format("codes|cpu_builder|opencv_median", ""), "{size}, {bits} bits, {side}x{side}"),
    Question("The same, CPU time",
             FRAME.format("codes|cpu_builder|opencv_median", "cpu_"), "{size}, {bits} bits, {side}x{side}"),
    Question("A frame with positions, CPU time",
             FRAME.format("positions|cpu_positions|opencv_positions", "cpu_"), "{size}, {bits} bits, {side}x{side}"),
    Question("A frame without terraces, CPU time",
             SIZE + r"-(?P<bits>\d+) (?P<way>terraces|cpu_builder_terraces)_cpu_ms", "{size}, {bits} bits"),
    Question("A frame in turn, wall time",
             f"turns-{SIZE}-(?P<filter>\\w+) (?P<way>cpu_builder|vulkan|flight)_ms", "{size}, {filter}"),
    Question("A second of touch at 60 frames/s, CPU time",
             f"ways-{SIZE}-(?P<filter>\\w+)-(?P<fingers>\\d+)f (?P<way>lazy|cpu|vulkan)_ms_per_s_60hz",
             "{size}, {filter}, fingers: {fingers}"),
    Question("A picture, wall time", f"pictures-{SIZE} (?P<way>[a-z]+_(cpu|vulkan))_frame_ms", "{size}"),
    Question("Force direction on real depth, RMS",
             r"real-(?P<of>cube|redwood|icl-[a-z0-9]+)-(?P<way>\S+) force_angle_deg_rms", "{of}"),
    Question("Force noise on noisy depth at rest, 20 to 500 Hz",
             r"noisy-\d+x\d+-\d+-\d+f-world-(?P<way>\S+) force_band_mn", "noisy wall"),
    Question("Force noise of a hand that scratches, 20 to 500 Hz",
             r"chest-\S+-1f-(?P<way>\S+)-scratch-n(?P<noise>[\d.]+)(?P<hand>\S*?)(?P<more>-temporal|) force_band_mn",
             "noise {noise}{hand}", way="{way}{more}"),
    Question("Stable up to this stiffness", r"(?P<scene>[a-z]+)-\S+-1f-(?P<way>world|pixel)-(?P<loop>b\S+) boundary_n_per_mm",
             "{scene}, {loop}", more_is_best=True),
]
WORDS = {"codes": "Vulkan", "positions": "Vulkan", "terraces": "Vulkan", "vulkan": "Vulkan", "flight": "Vulkan, several in flight",
         "cpu": "whole frames, CPU", "cpu_builder": "CPU builder", "cpu_positions": "CPU builder",
         "cpu_builder_terraces": "CPU builder", "opencv_median": "OpenCV", "opencv_positions": "OpenCV",
         "": "blended frames", "-hold": "earlier frame held"}


class Best(NamedTuple):
    where: str
    way: str
    record: object
    next_way: str
    next: object


def answers(records):
    """Per question that two ways or more answer: the best one and the next, wherever they were compared."""
    figures = figures_of(records)
    noticed = next(iter(noticed_degrees(figures).values()), 0)
    for question in QUESTIONS:
        found = {}
        for record in measured_once(records).values():
            match = re.fullmatch(question.names, f"{record.case} {record.metric}")
            if not match or not is_number(record.value):
                continue
            error = figures[record.case].get("force_angle_deg_rms")
            if question.unnoticed and not (is_number(error) and error < noticed):
                continue
            found.setdefault(question.where.format(**match.groupdict()), {})[question.way.format(**match.groupdict())] = record
        rows = []
        for where, ways in found.items():
            ranked = sorted(ways.items(), key=lambda way: way[1].value, reverse=question.more_is_best)[:2]
            if len(ranked) == 2:
                rows.append(Best(where, *(part for way, record in ranked for part in (WORDS.get(way, way), record))))
        if rows:
            yield question.words, rows
