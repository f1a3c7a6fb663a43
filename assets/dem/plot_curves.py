#!/usr/bin/env python3
"""Draws the curves of `compress` into curves.svg and prints their main values as a table.

    assets/dem/plot_curves.py out/dem
"""

import csv
import json
import os
import sys

PROGRAMS = (("lammps.csv", "LAMMPS", "#c4501b"), ("yade.csv", "YADE", "#1b6ca8"))
WIDTH, HEIGHT = 460, 380  # of a panel's picture
LEFT, RIGHT, TOP, BOTTOM = 62, 14, 34, 48


def fail(message):
    sys.exit(f"plot_curves: {message}")


def read_curve(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    if len(rows) < 3:
        fail(f"{path}: {len(rows)} records, expected 3 or more; did the run end early?")
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def modulus(curve):
    """Slope of stress against strain, least squares through 0 over the first strains up to 0.5 %, Pa."""
    points = [p for p in zip(curve["strain"], curve["stress_Pa"]) if 0 < p[0] <= 0.005]
    if len(points) < 2:
        fail("fewer than two records up to a strain of 0.5 %; raise --records")
    return sum(e * s for e, s in points) / sum(e * e for e, _ in points)


def figures(curve, setup):
    """The main values of a curve: name, value as text."""
    strain, stress = curve["strain"], curve["stress_Pa"]
    peak = max(range(len(stress)), key=stress.__getitem__)
    force = [(t + b) / 2 for t, b in zip(curve["top_N"], curve["bottom_N"])]
    apart = max(abs(t - b) for t, b in zip(curve["top_N"], curve["bottom_N"])) / max(force)
    work = 0.0
    for i in range(1, len(strain)):
        work += (force[i] + force[i - 1]) / 2 * (curve["closed_m"][i] - curve["closed_m"][i - 1])
    slope = modulus(curve)
    yield "apparent modulus (up to 0.5 %)", f"{slope / 1e6:.4g} MPa"
    yield "divided by that of vdb_pack stiffness", f"{slope / setup['modulus']:.3f}"
    yield "largest stress", f"{stress[peak] / 1e6:.3g} MPa at {100 * strain[peak]:.2f} %"
    yield "largest force", f"{force[peak]:.4g} N"
    yield "force at the end", f"{100 * force[-1] / force[peak]:.0f} % of the largest"
    yield "bonds broken", f"{curve['bonds'][0] - curve['bonds'][-1]:.0f} of {curve['bonds'][0]:.0f}"
    yield "largest difference between the forces at both ends", f"{100 * apart:.1f} % of the largest force"
    yield "largest kinetic energy", f"{100 * max(curve['kinetic_J']) / work:.2f} % of the work"


def ticks(top):
    """Round steps from 0 to a little above `top`, 4 to 8 of them."""
    step = 10.0 ** -12
    while top / step > 8:
        step *= 2.5 if f"{step:e}"[0] == "2" else 2
    return [i * step for i in range(int(top / step) + 2)]


def panel(x0, title, x_label, y_label, x_ticks, y_ticks, lines):
    """One diagram; lines: (xs, ys, color, dash)."""
    right, low = x0 + WIDTH - RIGHT, HEIGHT - BOTTOM
    left = x0 + LEFT
    x_of = lambda v: left + (right - left) * v / x_ticks[-1]
    y_of = lambda v: low - (low - TOP) * v / y_ticks[-1]
    out = [f'<text x="{left}" y="20" font-weight="bold">{title}</text>']
    for v in x_ticks:
        out.append(f'<path d="M{x_of(v):.1f} {TOP}V{low}" stroke="#e4e4e4"/>')
        out.append(f'<text x="{x_of(v):.1f}" y="{low + 17}" text-anchor="middle">{v:g}</text>')
    for v in y_ticks:
        out.append(f'<path d="M{left} {y_of(v):.1f}H{right}" stroke="#e4e4e4"/>')
        out.append(f'<text x="{left - 7}" y="{y_of(v) + 4:.1f}" text-anchor="end">{v:g}</text>')
    out.append(f'<path d="M{left} {TOP}V{low}H{right}" fill="none" stroke="#555"/>')
    middle = (left + right) / 2
    out.append(f'<text x="{middle}" y="{low + 38}" text-anchor="middle">{x_label}</text>')
    out.append(
        f'<text transform="translate({x0 + 16} {(TOP + low) / 2}) rotate(-90)" '
        f'text-anchor="middle">{y_label}</text>'
    )
    for xs, ys, color, dash in lines:
        path = "L".join(f"{x_of(x):.1f} {y_of(max(y, 0)):.1f}" for x, y in zip(xs, ys))
        out.append(
            f'<path d="M{path}" fill="none" stroke="{color}" stroke-width="1.8" '
            f'stroke-dasharray="{dash}"/>'
        )
    return out


def key(x, y, entries):
    out = []
    for i, (color, dash, label) in enumerate(entries):
        at = y + 17 * i
        out.append(
            f'<path d="M{x} {at}h26" stroke="{color}" stroke-width="1.8" '
            f'stroke-dasharray="{dash}"/>'
            f'<text x="{x + 32}" y="{at + 4}">{label}</text>'
        )
    return out


def draw(curves, setup, path):
    last = max(100 * c["strain"][-1] for _, _, c in curves)
    x_ticks = ticks(last * 0.97)
    force, bonds = [], []
    for _, color, c in curves:
        xs = [100 * e for e in c["strain"]]
        force.append((xs, [(t + b) / 2000 for t, b in zip(c["top_N"], c["bottom_N"])], color, ""))
        bonds.append((xs, [100 * n / c["bonds"][0] for n in c["bonds"]], color, ""))
    y_ticks = ticks(max(max(line[1]) for line in force))
    # N by mm of vdb_pack stiffness, as far as the diagram reaches.
    per_percent = setup["stiffness"] * setup["gauge"] / 1e5
    end = min(x_ticks[-1], y_ticks[-1] / per_percent)
    force.append(([0, end], [0, per_percent * end], "#555", "7 4"))
    body = panel(0, "Force", "strain, %", "force, kN", x_ticks, y_ticks, force)
    body += panel(WIDTH, "Bonds left", "strain, %", "share of all, %", x_ticks, [0, 20, 40, 60, 80, 100], bonds)
    base = HEIGHT + 12
    body += key(LEFT, base, [(color, "", name) for name, color, _ in curves])
    body += key(LEFT + 110, base, [("#555", "7 4", "vdb_pack stiffness --press")])
    with open(path, "w") as file:
        file.write(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * WIDTH} {HEIGHT + 48}" '
            f'width="{2 * WIDTH}" height="{HEIGHT + 48}" font-family="sans-serif" font-size="12">\n'
            f'<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(body) + "\n</svg>\n"
        )


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = sys.argv[1]
    curves = []
    for file, name, color in PROGRAMS:
        path = os.path.join(folder, file)
        if os.path.exists(path):
            curves.append((name, color, read_curve(path)))
    if not curves:
        fail(f"{folder}: neither lammps.csv nor yade.csv; run compress first")
    with open(os.path.join(folder, "setup.json")) as file:
        setup = json.load(file)
    draw(curves, setup, os.path.join(folder, "curves.svg"))

    columns = [list(figures(curve, setup)) for _, _, curve in curves]
    print("| | " + " | ".join(name for name, _, _ in curves) + " |")
    print("|---" * (1 + len(curves)) + "|")
    for rows in zip(*columns):
        print(f"| {rows[0][0]} | " + " | ".join(value for _, value in rows) + " |")


if __name__ == "__main__":
    main()
