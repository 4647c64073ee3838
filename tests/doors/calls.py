# SPDX-License-Identifier: Apache-2.0
"""Pictures by Python, whose numbers are compared between two commits (scripts/same_pictures.py): calls.py FOLDER, run where the data are."""
import os
import sys

import numpy as np

import ovoid

SIZE = dict(size=(160, 120), threads=2)


def calls():
    """Names and pictures."""
    samples = np.indices((20, 24, 28)).sum(axis=0).astype(np.float32)
    yield "array", ovoid.render(samples, **SIZE)
    yield "lattice", ovoid.render(ovoid.lattice(samples, spacing=(1, 2, 1.5)), colormap="viridis", **SIZE)
    yield "file", ovoid.render("head.nrrd", **SIZE)
    yield "preset", ovoid.render("head.nrrd", preset="ct-skin", azimuth=30, **SIZE)
    yield "mode", ovoid.render("head.nrrd", mode="maximum", **SIZE)
    yield "iso", ovoid.render("head.nrrd", mode="isosurface", iso=300, **SIZE)
    yield "crop", ovoid.render("head.nrrd", crop="4:30,0:39,8:36", **SIZE)
    yield "clip", ovoid.render("head.nrrd", clip=[(1, 0, 0, 0)], **SIZE)
    yield "light", ovoid.render("head.nrrd", occlusion=0.5, shadows=0.5, **SIZE)
    yield "labels", ovoid.render("head.nrrd", labels="labels.nrrd", **SIZE)
    yield "over", ovoid.render("head.nrrd", over="orbital.nii.gz", **SIZE)
    yield "channels", ovoid.render("cells.nrrd", channels="all", **SIZE)
    yield "slices", ovoid.render("head.nrrd", slice=["x", "y"], **SIZE)
    yield "added", ovoid.render("head.nrrd", add="fin.vtu", **SIZE)
    yield "step", ovoid.render("wind.h5", step=2, **SIZE)
    yield "time", ovoid.render("wind.h5", time=1.4, **SIZE)
    yield "mesh", ovoid.render("fin.vtu", array="pressure", **SIZE)
    yield "particles", ovoid.render("galaxy.npz", quantity="density", **SIZE)
    yield "points", ovoid.render("galaxy.npz", points=True, **SIZE)
    yield "kernels", ovoid.render("blobs.ply", **SIZE)


for name, picture in calls():
    np.save(os.path.join(sys.argv[1], f"{name}.npy"), np.asarray(picture))
