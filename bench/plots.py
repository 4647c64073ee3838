# SPDX-License-Identifier: Apache-2.0
"""Lines over two logarithmic axes, as an SVG."""
import math

WIDTH, HEIGHT, LEFT, BOTTOM, MARGIN = 480, 300, 64, 40, 20


def log_plot(path, lines, title, x_ticks, y_ticks):
    """`lines`: (name, colour, dashed, [(x, y)]); ticks: (value, text), the first and last of which are the axes' ends."""
    def share(value, ticks):
        low, high = math.log(ticks[0][0]), math.log(ticks[-1][0])
        return (math.log(value) - low) / (high - low)

    def place(x, y):
        return (LEFT + (WIDTH - LEFT - MARGIN) * share(x, x_ticks), HEIGHT - BOTTOM - (HEIGHT - BOTTOM - MARGIN) * share(y, y_ticks))

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for value, text in x_ticks:
        x = place(value, y_ticks[0][0])[0]
        out.append(f'<path d="M{x:.1f},{MARGIN}V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                   f'<text x="{x:.1f}" y="{HEIGHT - 22}" text-anchor="middle">{text}</text>')
    for value, text in y_ticks:
        y = place(x_ticks[0][0], value)[1]
        out.append(f'<path d="M{LEFT},{y:.1f}H{WIDTH - MARGIN}" stroke="#ddd"/>'
                   f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{text}</text>')
    for name, color, is_dashed, points in lines:
        places = [place(*point) for point in points]
        dash = ' stroke-dasharray="4 4"' if is_dashed else ""
        out.append(f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in places)}" fill="none" stroke="{color}" '
                   f'stroke-width="2"{dash}/><text x="{places[-1][0] - 8:.1f}" y="{places[-1][1] - 8:.1f}" text-anchor="end" '
                   f'fill="{color}">{name}</text>')
    out.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 6}" text-anchor="middle">{title}</text></svg>')
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")
