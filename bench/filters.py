#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What filters lose between nodes: filters.py [SIGMA]

Of a field of kernels with that sigma (default 0.5, spacings), along a line: SNR in dB where samples are white noise, the mean over all phases;
the greatest error of an isolated sample over its peak; and of a wave of 0.1 and 0.5 cycles per spacing at the worst phase. `matched`: the weights
that err least on such fields among those exact on polynomials of degree 3 [Matheron 1969]."""
import math
import sys

PHASES = [i / 16 for i in range(17)]


def solve(rows, right):
    size = len(right)
    table = [row[:] + [value] for row, value in zip(rows, right)]
    for i in range(size):
        pivot = max(range(i, size), key=lambda r: abs(table[r][i]))
        table[i], table[pivot] = table[pivot], table[i]
        for r in range(size):
            if r != i:
                factor = table[r][i] / table[i][i]
                table[r] = [a - factor * b for a, b in zip(table[r], table[i])]
    return [table[i][size] / table[i][i] for i in range(size)]


def taps(count):
    return [k - (count // 2 - 1) for k in range(count)]


def linear(phase, *_):
    return {0: 1 - phase, 1: phase}


def keys(phase, *_):
    def weight(x):
        return (1.5 * x - 2.5) * x * x + 1 if x < 1 else ((-0.5 * x + 2.5) * x - 4) * x + 2
    return {k: weight(abs(phase - k)) for k in taps(4)}


def lagrange(phase, *_):
    return {k: math.prod((phase - m) / (k - m) for m in taps(6) if m != k) for k in taps(6)}


def matched(phase, distance, sigma):
    places = taps(6)

    def correlation(x):
        return math.exp(-(x * distance) ** 2 / (4 * sigma * sigma))
    rows = [[correlation(a - b) + (1e-9 if a == b else 0) for b in places] + [(a - 0.5) ** d for d in range(4)] for a in places]
    rows += [[(a - 0.5) ** d for a in places] + [0.0] * 4 for d in range(4)]
    right = [correlation(a - phase) for a in places] + [(phase - 0.5) ** d for d in range(4)]
    return dict(zip(places, solve(rows, right)))


def wave_error(weights, phase, distance, frequency):
    turn = 2 * math.pi * frequency * distance
    return math.hypot(sum(w * math.cos(turn * (k - phase)) for k, w in weights.items()) - 1,
                      sum(w * math.sin(turn * (k - phase)) for k, w in weights.items()))


def losses(way, distance, sigma):
    noise = signal = isolated = 0.0
    waves = {0.1: 0.0, 0.5: 0.0}
    for phase in PHASES:
        weights = way(phase, distance, sigma)
        for step in range(-60, 61):
            frequency = step / 40
            power = math.exp(-4 * (math.pi * sigma * frequency) ** 2)
            noise += power * wave_error(weights, phase, distance, frequency) ** 2
            signal += power
            center = step / 20

            def kernel(x, c=center):
                return math.exp(-(x - c) ** 2 / (2 * sigma * sigma))
            isolated = max(isolated, abs(sum(w * kernel(distance * k) for k, w in weights.items()) - kernel(distance * phase)))
        waves = {f: max(worst, wave_error(weights, phase, distance, f)) for f, worst in waves.items()}
    return 10 * math.log10(signal / noise), isolated, *waves.values()


def main():
    sigma = float(sys.argv[1]) if len(sys.argv) > 1 else 0.5
    print("| filter, taps | nodes, spacings apart | SNR, dB | isolated sample | 0.1 cycles | 0.5 cycles |\n|---|---|---|---|---|---|")
    ways = {"linear, 2": linear, "Keys, 4": keys, "Lagrange, 6": lagrange, "matched, 6": matched}
    for distance in (0.3, 0.4, 0.45, 0.5, 1.0):
        for name, way in ways.items():
            snr, isolated, slow, fast = losses(way, distance, sigma)
            print(f"| {name} | {distance} | {snr:.1f} | {isolated:.4f} | {slow:.5f} | {fast:.4f} |")


if __name__ == "__main__":
    main()
