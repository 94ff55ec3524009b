#!/usr/bin/env python3
"""Means per condition and paired differences of a study's results (docs/usability.md).

    means.py RESULTS_FOLDER

Tables of participants who finished count, and no others."""

import csv
import statistics
import sys
from collections import Counter, defaultdict
from pathlib import Path


def is_number(text):
    try:
        float(text)
        return True
    except ValueError:
        return False


def main(folder):
    values = defaultdict(dict)  # of what is measured: (participant, condition) -> number
    counts = defaultdict(Counter)  # of choices: answer -> people
    conditions, people = [], 0
    for table in sorted(Path(folder).glob("participant-*[0-9].csv")):
        people += 1
        for row in csv.DictReader(table.open(newline="", encoding="utf-8")):
            who, condition = row["participant"], row["condition"]
            if row["question"] and not is_number(row["answer"]):
                counts[row["question"]][row["answer"]] += 1
            if not condition:
                continue
            if condition not in conditions:
                conditions.append(condition)
            if row["question"] and is_number(row["answer"]):
                values[row["question"]][who, condition] = float(row["answer"])
            for measure in ("seconds", "contact_s", "touches", "mean_force_n", "max_force_n"):
                if row["touches"]:
                    values[f"{row['step']} {measure}"][who, condition] = float(row[measure])
    print(f"{people} participants finished")
    if people == 0:
        return
    if len(conditions) == 2:
        a, b = sorted(conditions, reverse=True)  # force-on, force-off
        print(f"\n{'':24}{a:>12}{b:>12}{'difference':>12}{'sd':>8}{'n':>5}")
        for name, of in values.items():
            pairs = [(of[who, a], of[who, b]) for who, c in of if c == a and (who, b) in of]
            if not pairs:
                continue
            differences = [x - y for x, y in pairs]
            sd = statistics.stdev(differences) if len(pairs) > 1 else float("nan")
            means = [statistics.mean(column) for column in zip(*pairs)]
            print(f"{name:24}{means[0]:12.2f}{means[1]:12.2f}{statistics.mean(differences):12.2f}{sd:8.2f}{len(pairs):5}")
    print()
    for question, answers in counts.items():
        print(f"{question:24}" + ", ".join(f"{answer} {count} of {answers.total()}" for answer, count in answers.most_common()))


if len(sys.argv) != 2:
    sys.exit("means.py: say the folder of results: means.py RESULTS_FOLDER")
main(sys.argv[1])
