#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far apart colours look (CIEDE2000 [Sharma 2005]), and the colours and opacities of a look that the program has written:
color_difference.py [OVOID].

Checks itself: the formula on the pairs that were published with it; with OVOID, the colours of looks against those that the program draws."""
import array
import json
import math
import os
import struct
import subprocess
import sys
import tempfile

TO_XYZ = ((0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505))
FROM_XYZ = ((3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570))
WHITE = (0.9505, 1.0, 1.089)  # D65


def lab_of(rgb):
    """L*a*b* of sRGB numbers in [0, 1]."""
    linear = [((v + 0.055) / 1.055) ** 2.4 if v > 0.04045 else v / 12.92 for v in rgb]
    xyz = [sum(m * v for m, v in zip(row, linear)) / white for row, white in zip(TO_XYZ, WHITE)]
    x, y, z = (v ** (1 / 3) if v > 0.008856 else 7.787 * v + 16 / 116 for v in xyz)
    return 116 * y - 16, 500 * (x - y), 200 * (y - z)


def rgb_of(lab):
    y = (lab[0] + 16) / 116
    f = (y + lab[1] / 500, y, y - lab[2] / 200)
    xyz = [white * (v ** 3 if v ** 3 > 0.008856 else (v - 16 / 116) / 7.787) for v, white in zip(f, WHITE)]
    linear = [sum(m * v for m, v in zip(row, xyz)) for row in FROM_XYZ]
    rgb = [1.055 * v ** (1 / 2.4) - 0.055 if v > 0.0031308 else 12.92 * v for v in linear]
    greatest = max(*rgb, 1)
    return tuple(max(v / greatest, 0) for v in rgb)


def difference(one, other):
    """CIEDE2000 of two colours in L*a*b*, all weights 1. The names are the paper's."""
    (l1, a1, b1), (l2, a2, b2) = one, other
    c_mean = (math.hypot(a1, b1) + math.hypot(a2, b2)) / 2
    g = 0.5 * (1 - math.sqrt(c_mean ** 7 / (c_mean ** 7 + 25 ** 7)))
    a1, a2 = a1 * (1 + g), a2 * (1 + g)
    c1, c2 = math.hypot(a1, b1), math.hypot(a2, b2)
    h1 = math.degrees(math.atan2(b1, a1)) % 360 if c1 else 0
    h2 = math.degrees(math.atan2(b2, a2)) % 360 if c2 else 0
    dh = h2 - h1 if c1 * c2 else 0
    dh -= 360 * ((dh > 180) - (dh < -180))
    big_dh = 2 * math.sqrt(c1 * c2) * math.sin(math.radians(dh / 2))
    l, c, h = (l1 + l2) / 2, (c1 + c2) / 2, h1 + h2
    if c1 * c2:
        if abs(h1 - h2) > 180:
            h += 360 if h < 360 else -360
        h /= 2

    def cos(degrees):
        return math.cos(math.radians(degrees))

    t = 1 - 0.17 * cos(h - 30) + 0.24 * cos(2 * h) + 0.32 * cos(3 * h + 6) - 0.20 * cos(4 * h - 63)
    s_l = 1 + 0.015 * (l - 50) ** 2 / math.sqrt(20 + (l - 50) ** 2)
    s_c = 1 + 0.045 * c
    s_h = 1 + 0.015 * c * t
    r_t = -2 * math.sqrt(c ** 7 / (c ** 7 + 25 ** 7)) * math.sin(math.radians(60 * math.exp(-((h - 275) / 25) ** 2)))
    x, y, z = (l2 - l1) / s_l, (c2 - c1) / s_c, big_dh / s_h
    return math.sqrt(max(0, x * x + y * y + z * z + r_t * y * z))


def msh_of(rgb):
    lab = lab_of(rgb)
    m = math.hypot(*lab)
    s = math.acos(min(lab[0] / m, 1)) if m > 0.001 else 0
    return [m, s, math.atan2(lab[2], lab[1]) if s > 0.001 else 0]


def mixed(a, b, s):
    return [(1 - s) * x + s * y for x, y in zip(a, b)]


def diverging(one, other, s):
    """[Moreland 2009] between colours of which at least one is saturated and the other gray, or of one hue, or with white between."""
    def spun(saturated, m):
        if saturated[0] >= m - 0.1:
            return saturated[2]
        spin = saturated[1] * math.sqrt(m * m - saturated[0] ** 2) / (saturated[0] * math.sin(saturated[1]))
        return saturated[2] + (spin if saturated[2] > -0.3 * math.pi else -spin)

    a, b = msh_of(one), msh_of(other)
    apart = abs(a[2] - b[2]) % (2 * math.pi)
    if a[1] > 0.05 and b[1] > 0.05 and min(apart, 2 * math.pi - apart) > 0.33 * math.pi:
        white = [max(a[0], b[0], 88), 0, 0]
        a, b, s = (a, white, 2 * s) if s < 0.5 else (white, b, 2 * s - 1)
    if a[1] < 0.05 < b[1]:
        a[2] = spun(b, a[0])
    elif b[1] < 0.05 < a[1]:
        b[2] = spun(a, b[0])
    m, s, h = mixed(a, b, s)
    return rgb_of((m * math.cos(s), m * math.sin(s) * math.cos(h), m * math.sin(s) * math.sin(h)))


BETWEEN = {"RGB": mixed, "Lab": lambda a, b, s: rgb_of(mixed(lab_of(a), lab_of(b), s)), "Diverging": diverging}


class WrittenLook:
    """A look as `ovoid render --save-look` writes it: colours straight in RGB, L*a*b* or Msh, opacities straight (a default look has no
    others), along values or their logarithms."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            look = json.load(file)
        look = look[0] if isinstance(look, list) else look
        self.between = BETWEEN[look.get("ColorSpace", "RGB")]
        self.is_log = bool(look.get("UseLogScale"))
        numbers = look["RGBPoints"]
        self.colors = [(numbers[i], numbers[i + 1:i + 4]) for i in range(0, len(numbers), 4)]
        numbers = look["Points"]
        self.opacities = [(numbers[i], numbers[i + 1:i + 2]) for i in range(0, len(numbers), 4)]

    def at(self, points, value, between):
        if value < points[0][0]:
            return points[0][1]
        for (x1, y1), (x2, y2) in zip(points, points[1:]):
            if value < x2:
                x, a, b = (math.log10(v) for v in (value, x1, x2)) if self.is_log else (value, x1, x2)
                return between(y1, y2, (x - a) / (b - a))
        return points[-1][1]

    def color(self, value):
        """sRGB numbers."""
        return self.at(self.colors, value, self.between)

    def opacity(self, value):
        return self.at(self.opacities, value, mixed)[0]


# The data published with [Sharma 2005]: L*a*b* of both, the difference to four digits.
PUBLISHED = """50 2.6772 -79.7751 50 0 -82.7485 2.0425; 50 3.1571 -77.2803 50 0 -82.7485 2.8615; 50 2.8361 -74.02 50 0 -82.7485 3.4412;
50 -1.3802 -84.2814 50 0 -82.7485 1; 50 -1.1848 -84.8006 50 0 -82.7485 1; 50 -0.9009 -85.5211 50 0 -82.7485 1; 50 0 0 50 -1 2 2.3669;
50 -1 2 50 0 0 2.3669; 50 2.49 -0.001 50 -2.49 0.0009 7.1792; 50 2.49 -0.001 50 -2.49 0.001 7.1792; 50 2.49 -0.001 50 -2.49 0.0011 7.2195;
50 2.49 -0.001 50 -2.49 0.0012 7.2195; 50 -0.001 2.49 50 0.0009 -2.49 4.8045; 50 -0.001 2.49 50 0.001 -2.49 4.8045;
50 -0.001 2.49 50 0.0011 -2.49 4.7461; 50 2.5 0 50 0 -2.5 4.3065; 50 2.5 0 73 25 -18 27.1492; 50 2.5 0 61 -5 29 22.8977;
50 2.5 0 56 -27 -3 31.903; 50 2.5 0 58 24 15 19.4535; 50 2.5 0 50 3.1736 0.5854 1; 50 2.5 0 50 3.2972 0 1; 50 2.5 0 50 1.8634 0.5757 1;
50 2.5 0 50 3.2592 0.335 1; 60.2574 -34.0099 36.2677 60.4626 -34.1751 39.4387 1.2644; 63.0109 -31.0961 -5.8663 62.8187 -29.7946 -4.0864 1.263;
61.2901 3.7196 -5.3901 61.4292 2.248 -4.962 1.8731; 35.0831 -44.1164 3.7933 35.0232 -40.0716 1.5901 1.8645;
22.7233 20.0904 -46.694 23.0331 14.973 -42.5619 2.0373; 36.4612 47.858 18.3852 36.2715 50.5065 21.2231 1.4146;
90.8027 -2.0831 1.441 91.1528 -1.6435 0.0447 1.4441; 90.9257 -0.5406 -0.9208 88.6381 -0.8985 -0.7239 1.5381;
6.7747 -0.2908 -2.4247 5.8714 -0.0985 -2.2286 0.6377; 2.0776 0.0795 -1.135 0.9033 -0.0636 -0.5514 0.9082"""


def check_formula():
    rows = [[float(word) for word in row.split()] for row in PUBLISHED.split(";")]
    assert len(rows) == 34
    for row in rows:
        for one, other in ((row[:3], row[3:6]), (row[3:6], row[:3])):
            assert abs(difference(one, other) - row[6]) < 5.1e-5, row


def check_looks(ovoid):
    """A plane through values that rise along x, seen squarely, has a look's colours, to the rounding of samples and pixels."""
    side, width = 64, 256
    with tempfile.TemporaryDirectory() as folder:
        ramp, look, picture, camera = (os.path.join(folder, name) for name in ("ramp.nrrd", "look.json", "picture.npy", "camera.json"))
        with open(ramp, "wb") as file:
            file.write(f"NRRD0004\ntype: float\ndimension: 3\nsizes: {side} 8 8\nendian: little\nencoding: raw\n\n".encode())
            array.array("f", [1 + x for _ in range(64) for x in range(side)]).tofile(file)
        with open(camera, "w", encoding="utf-8") as file:
            json.dump({"position": [(side - 1) / 2, 3.5, 100], "focal_point": [(side - 1) / 2, 3.5, 3.5], "view_up": [0, 1, 0],
                       "parallel_projection": True, "parallel_scale": 2}, file)
        for flags in (["--colormap", "cool-to-warm"], ["--colormap", "inferno"], [], ["--log"]):
            subprocess.run([ovoid, "render", ramp, "-o", picture, "--size", f"{width}x16", "--camera", camera, "--value-plane", "0,0,1,3.5",
                            "--save-look", look, *flags], check=True, stderr=subprocess.DEVNULL)
            written = WrittenLook(look)
            with open(picture, "rb") as file:
                data = file.read()
            length, = struct.unpack_from("<H", data, 8)
            rgba = array.array("f", data[10 + length:])
            num_seen = 0
            for i in range(width):
                pixel = rgba[4 * (8 * width + i):][:4]
                value = 1 + (side - 1) / 2 + (i + 0.5 - width / 2) * 4 / 16
                if not 4 < value < side - 3:  # samples end, and the spline's slope with them
                    continue
                num_seen += 1
                assert pixel[3] > 0.99, (flags, value, pixel)
                assert difference(lab_of(pixel[:3]), lab_of(written.color(value))) < 0.5, (flags, value, pixel, written.color(value))
            assert num_seen > 200


if __name__ == "__main__":
    check_formula()
    if len(sys.argv) > 1:
        check_looks(sys.argv[1])
