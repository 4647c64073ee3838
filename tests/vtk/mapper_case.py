# SPDX-License-Identifier: Apache-2.0
"""What tests of the mappers compare, and within which bounds."""
import unittest

import numpy as np
from scene import BACKGROUND, HEIGHT, WIDTH, bumps, image_of, over, rendered

SIDE = 25
# Bytes, of both pictures in 8 bits: rounding; blending in 8 bits rounds what is behind once more.
EXACT = 1.0
TRANSLUCENT = 2.0


def vtks_picture(make_scene):
    """What two of three scenes with VTK's own mapper show: of the same arguments a vtkFixedPointVolumeRayCastMapper of VTK 9.1 shows something
    else one time in ten, in all of its frames."""
    scenes = [make_scene() for _ in range(3)]
    for scene in scenes:
        scene.mapper.SetAutoAdjustSampleDistances(0)
        scene.mapper.SetSampleDistance(0.25)
    first, second, third = (scene.draw() for scene in scenes)
    return first if min(np.abs(first - second).max(), np.abs(first - third).max()) <= EXACT else second


class MapperCase(unittest.TestCase):
    def setUp(self):
        self.values = bumps(SIDE)
        self.image, self.array = image_of(self.values)

    def assert_like(self, drawn, expected, bound):
        difference = np.abs(drawn - expected)
        place = np.unravel_index(difference.argmax(), difference.shape)
        self.assertLessEqual(difference.max(), bound, f"at row, column, channel {place}: {drawn[place]} and {expected[place]}")

    def assert_shows(self, picture):
        """Something is there, and not everywhere."""
        shown = np.abs(picture - 255 * np.array(BACKGROUND)).max(axis=2) > 20
        self.assertGreater(shown.mean(), 0.02)
        self.assertLess(shown.mean(), 0.98)

    def assert_like_program(self, scene, *flags, data=None, bound=EXACT, **named):
        drawn = scene.draw()
        self.assertEqual(scene.errors, [])
        self.assert_shows(drawn)
        self.assert_like(drawn, over(rendered(self.image if data is None else data, scene, *flags, **named), BACKGROUND), bound)

    def assert_parts_join(self, scene, sides):
        """Boxes that meet where one axis is `sides`, blended from the farthest to the nearest, are the whole."""
        scene.draw()
        whole, endless = scene.floats(), float("inf")
        picture = np.zeros_like(whole)
        for lo, hi in zip((-endless, *sides), (*sides, endless)):  # the camera looks along -z
            scene.mapper.SetOwnedBounds(-endless, endless, -endless, endless, lo, hi)
            scene.draw()
            part = scene.floats()
            self.assertGreater(part[..., 3].max(), 0.1)
            picture = part + (1 - part[..., 3:]) * picture
        self.assertEqual(scene.errors, [])
        self.assert_like(255 * picture, 255 * whole, EXACT)

    def assert_error(self, scene, *words):
        background = np.broadcast_to(255 * np.array(BACKGROUND), (HEIGHT, WIDTH, 3))
        self.assert_like(scene.draw(), background, EXACT)
        self.assertEqual(len(scene.errors), 1, scene.errors)
        for word in words:
            self.assertIn(word, scene.errors[0])
