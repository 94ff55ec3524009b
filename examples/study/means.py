#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Means per condition and paired differences of a study's results (docs/exhibit.md).

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
    counts, asked = defaultdict(Counter), Counter()  # of choices: answer -> people; who was asked
    people = 0
    if not Path(folder).is_dir():
        sys.exit(f"means.py: {folder} is no folder; must be the one of --results")
    for table in sorted(Path(folder).glob("participant-*[0-9].csv")):
        people += 1
        for row in csv.DictReader(table.open(newline="", encoding="utf-8")):
            who, condition = row["participant"], row["condition"]
            if row["question"] and not is_number(row["answer"]):
                counts[row["question"]][row["answer"]] += 1
                asked[row["question"]] += 1
            if row["question"] and is_number(row["answer"]):
                values[row["question"]][who, condition or "outside"] = float(row["answer"])
            for measure in ("seconds", "contact_s", "touches", "mean_force_n", "max_force_n"):
                if condition and row["touches"]:
                    values[f"{row['step']} {measure}"][who, condition] = float(row[measure])
    print(f"participants finished: {people}")
    if people == 0:
        return
    conditions = sorted({condition for of in values.values() for _, condition in of}, reverse=True)
    compared = [condition for condition in conditions if condition != "outside"]
    heads = "".join(f"{condition:>12}" for condition in conditions)
    print(f"\n{'':24}{heads}" + (f"{'difference':>12}{'sd':>8}{'n':>5}" if len(compared) == 2 else ""))
    for name, of in values.items():
        line = f"{name:24}"
        for condition in conditions:
            column = [value for (_, of_condition), value in of.items() if of_condition == condition]
            line += f"{statistics.mean(column):12.2f}" if column else f"{'':12}"
        if len(compared) == 2:
            a, b = compared  # force-on, force-off
            differences = [of[who, a] - of[who, b] for who, c in of if c == a and (who, b) in of]
            if differences:
                sd = f"{statistics.stdev(differences):.2f}" if len(differences) > 1 else "-"
                line += f"{statistics.mean(differences):12.2f}{sd:>8}{len(differences):5}"
        print(line)
    print()
    for question, answers in counts.items():
        if set(answers) <= {"yes", "no"}:
            answers = {"yes": answers["yes"]}
        told = (f"{answer} {count} of {asked[question]}" for answer, count in sorted(answers.items()))
        print(f"{question:24}" + ", ".join(told))


if len(sys.argv) != 2:
    sys.exit("means.py: say the folder of results: means.py RESULTS_FOLDER")
main(sys.argv[1])
